#!/usr/bin/env bash
# Tests the Node binding, then the package as it is published. Needs Debian's package manager; CYLFUSE_LIBRARY names the
# native library, else it is built.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)

missing=()
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)
command -v strip >/dev/null || missing+=(binutils)
command -v python3 >/dev/null || missing+=(python3)
if [ ${#missing[@]} -gt 0 ]; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"
fi
if [ -z "${CYLFUSE_LIBRARY:-}" ]; then
    (cd "$repository" && cargo build --locked --release)
    CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-$repository/target}/release/libcylfuse.so
fi
CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
export CYLFUSE_LIBRARY

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
failed=0
# Names what a sum of "N passed, N failed" counts, and keeps it for the whole sum.
name() { sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$1: &/" | tee -a "$build/log"; }
# The sum of what the test runner printed.
count() { awk '1; /^# pass / { passed = $3 } /^# fail / { failed = $3 } END { printf "%d passed, %d failed\n", passed, failed }'; }

cd "$here"
npm install --no-audit --no-fund --no-package-lock --loglevel=error
npx --no-install tsc --noEmit --strict --target es2022 --module nodenext --moduleResolution nodenext --types node \
    test/types.ts || failed=1

# The package, installed by a program of its own.
./package.sh "$CYLFUSE_LIBRARY" "$build/package"
archive=$(npm pack --silent --pack-destination "$build" "$build/package")
mkdir "$build/program"
(cd "$build/program" && npm init -y >/dev/null && npm install --no-audit --no-fund --loglevel=error "$build/$archive")

CYLFUSE_NODE_PROGRAM=$build/program node --expose-gc --test --test-reporter=tap test/*.test.js 2>&1 |
    count | name Tests || failed=1

# The golden cases: the bits of C in the same job.
if [ -z "${CYLFUSE_CONFORMANCE_RESULTS:-}" ]; then
    export CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt
    "$repository/bindings/conformance/test.sh" >&2
fi
conformance=$repository/bindings/conformance
node test/conformance.js >"$build/results.txt" || failed=1
python3 "$conformance/check.py" "$build/results.txt" "$CYLFUSE_CONFORMANCE_RESULTS" | name Golden-cases || failed=1
python3 "$conformance/coverage.py" "$here"/lib/*.js | name Functions-bound || failed=1

# A program that broke off has printed no sum, but failed all the same.
awk -v broken=$failed '
    / passed, [0-9]+ failed$/ { passed += $2; failed += $4 }
    END { if (broken && !failed) failed = 1; printf "%d passed, %d failed\n", passed, failed }' "$build/log"
exit $failed
