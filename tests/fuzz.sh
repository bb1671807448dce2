#!/usr/bin/env bash
# tests/fuzz.sh [CALLS [FILES [FIRST]]]: many calls and damaged files, each kind in a process of its own, with AddressSanitizer
# over the library too. 10,000,000 calls and 1,000,000 files by default; cases are numbered from FIRST. What fails is printed
# with the number of its case: tests/fuzz/main.rs says how to run that one alone.
set -euo pipefail
cd "$(dirname "$0")/.."
export CYLFUSE_FUZZ_CALLS=${1:-10000000} CYLFUSE_FUZZ_FILES=${2:-1000000} CYLFUSE_FUZZ_FIRST=${3:-0}
triple=$(rustc -vV | sed -n 's/^host: //p')
# The sanitizers come with the stable compiler too, which only takes the flag like this.
export RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Zsanitizer=address -Cforce-frame-pointers=yes"
export ASAN_OPTIONS=allocator_may_return_null=1:abort_on_error=1:detect_leaks=1
export CARGO_PROFILE_RELEASE_DEBUG=line-tables-only
build=(--locked --release --features cli --test fuzz --target "$triple" --target-dir target/sanitized)
cargo test "${build[@]}" --no-run
status=0
for kind in calls detector files found; do
    cargo test --quiet "${build[@]}" "$kind::" -- --nocapture || status=1
done
exit $status
