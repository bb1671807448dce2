#!/usr/bin/env bash
# tests/fuzz.sh [CALLS [FILES [FIRST]]]: many calls and damaged files, each kind in processes of its own, one for each core,
# with AddressSanitizer over the library too. 10,000,000 calls and 1,000,000 files by default; cases are numbered from FIRST.
# What fails is printed with the number of its case: tests/fuzz/main.rs says how to run that one alone.
set -euo pipefail
cd "$(dirname "$0")/.."
calls=${1:-10000000} files=${2:-1000000} first=${3:-0} processes=$(nproc)
triple=$(rustc -vV | sed -n 's/^host: //p')
# The sanitizers come with the stable compiler too, which only takes the flag like this.
export RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Zsanitizer=address -Cforce-frame-pointers=yes"
export ASAN_OPTIONS=allocator_may_return_null=1:abort_on_error=1:detect_leaks=1
export CARGO_PROFILE_RELEASE_DEBUG=line-tables-only
build=(--locked --release --features cli --test fuzz --target "$triple" --target-dir target/sanitized)
cargo test "${build[@]}" --no-run
status=0
for kind in calls detector files found; do
    count=$calls
    [ $kind != files ] || count=$files
    # A case makes one call at least, so that the cases of two processes are not the same.
    share=$(((count + processes - 1) / processes)) running=()
    for ((k = 0; k < processes; k++)); do
        CYLFUSE_FUZZ_CALLS=$share CYLFUSE_FUZZ_FILES=$share CYLFUSE_FUZZ_FIRST=$((first + k * share)) \
            cargo test --quiet "${build[@]}" "$kind::" -- --nocapture &
        running+=($!)
    done
    for process in "${running[@]}"; do wait "$process" || status=1; done
done
exit $status
