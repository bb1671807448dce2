#!/usr/bin/env bash
# Builds the source distribution and the wheel from it, installs that in a virtual environment and runs every test; ends
# with `N passed, N failed`.
# CYLFUSE_LIBRARY: the shared library for the wheel; CYLFUSE_CONFORMANCE_RESULTS: what the C runner printed.
set -euo pipefail
[ -z "${CYLFUSE_LIBRARY:-}" ] || CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
: "${CYLFUSE_LIBRARY:=$root/target/release/libcylfuse.so}"
export CYLFUSE_LIBRARY
export CYLFUSE_CONFORMANCE_RESULTS=${CYLFUSE_CONFORMANCE_RESULTS:-$root/target/conformance/c.txt}

if ! python3 -c 'import ensurepip, venv' 2>/dev/null; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends python3-venv
fi
[ -e "$CYLFUSE_LIBRARY" ] || cargo build --release --locked --lib --manifest-path "$root/Cargo.toml"
[ -e "$CYLFUSE_CONFORMANCE_RESULTS" ] || ../conformance/test.sh

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
python3 -m venv "$build/environment"
python=$build/environment/bin/python
"$python" -m pip install -q build
"$python" -m build -o "$build" . >"$build/log" || { cat "$build/log"; exit 1; }
"$python" -m pip install -q "$(echo "$build"/cylfuse-*-py3-none-*.whl)[test]"
# From here on the library inside the wheel.
unset CYLFUSE_LIBRARY
status=0
"$python" -m pytest -q -p no:cacheprovider | tee "$build/log" || status=$?
tail -1 "$build/log" | awk '{
    for (i = 2; i <= NF; i++) {
        if ($i ~ /^passed/) passed = $(i - 1)
        if ($i ~ /^(failed|error)/) failed += $(i - 1)
    }
    printf "%d passed, %d failed\n", passed, failed
}'
exit "$status"
