#!/usr/bin/env bash
# Builds the library once and tests all bindings with it: the golden cases by C and Rust, whose results the languages
# must meet bit by bit, then each language. Each installs what it needs from Debian, PyPI and npm.
# bindings/test.sh [LANGUAGE...]: only these.
set -euo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/.." && pwd)

languages=("$@")
[ $# -gt 0 ] || languages=(python csharp java go node)

if [ -z "${CYLFUSE_LIBRARY:-}" ]; then
    (cd "$repository" && cargo build --locked --release)
    CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-$repository/target}/release/libcylfuse.so
fi
CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
export CYLFUSE_LIBRARY CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt

passed=0 failed=0 summary=
# Runs a test.sh and adds up its last "N passed, N failed". One that breaks off, or prints no such line, has failed.
run() {
    local status=0 own
    printf '\n== %s\n' "$1"
    # Its sum is named, so that only the sum of all stands alone on a line.
    "$here/$1/test.sh" 2>&1 | tee "$build/log" | sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$1: &/" || status=1
    own=$(grep -E '^[0-9]+ passed, [0-9]+ failed$' "$build/log" | tail -n 1) || own="0 passed, 1 failed"
    local own_failed
    own_failed=$(awk '{ print $3 }' <<<"$own")
    [ "$status" = 0 ] || [ "$own_failed" != 0 ] || own_failed=1
    passed=$((passed + $(awk '{ print $1 }' <<<"$own")))
    failed=$((failed + own_failed))
    summary+=$(printf '%-12s %s passed, %s failed' "$1" "$(awk '{ print $1 }' <<<"$own")" "$own_failed")$'\n'
}

for part in conformance "${languages[@]}"; do run "$part"; done

printf '\n%sbindings: %s passed, %s failed\n' "$summary" "$passed" "$failed"
[ "$failed" = 0 ]
