#!/usr/bin/env bash
# Runs the golden cases by C and by Rust, compares both, and leaves the results of C for the bindings.
# CYLFUSE_LIBRARY: the shared library; CYLFUSE_CONFORMANCE_RESULTS: where the results of C go.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
: "${CYLFUSE_LIBRARY:=$root/target/release/libcylfuse.so}"
: "${CYLFUSE_CONFORMANCE_RESULTS:=$root/target/conformance/c.txt}"

source "$root/packaging/debian.sh"
require cc build-essential python3 python3 /usr/include/cjson/cJSON.h libcjson-dev

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
mkdir -p "$(dirname "$CYLFUSE_CONFORMANCE_RESULTS")"
# The loader looks for the soname, which is not the name of the file in the folder of the build.
soname=$(objdump -p "$CYLFUSE_LIBRARY" | awk '$1 == "SONAME" { print $2 }')
ln -s "$CYLFUSE_LIBRARY" "$build/$soname"
cc -std=c11 -O1 -Wall -Wextra -Werror -I"$root/include" c/*.c -o "$build/runner" "$build/$soname" \
    -Wl,-rpath,"$build" -lcjson -lm
env -u LD_LIBRARY_PATH "$build/runner" cases.json >"$CYLFUSE_CONFORMANCE_RESULTS"
# With the features of the tests, so that after them nothing is compiled again.
cargo run --quiet --locked --features bench --release --manifest-path "$root/Cargo.toml" --example conformance >"$build/rust.txt"

failed=0
c=$(python3 check.py "$CYLFUSE_CONFORMANCE_RESULTS") || failed=1
rust=$(python3 check.py "$build/rust.txt" "$CYLFUSE_CONFORMANCE_RESULTS") || failed=1
printf 'C: %s\nRust: %s\n' "$c" "$rust"
printf '%s\n' "$c" "$rust" | awk '/ passed, / { p += $1; f += $3 } END { printf "%d passed, %d failed\n", p, f }'
exit $failed
