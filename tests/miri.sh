#!/usr/bin/env bash
# tests/miri.sh [SEEDS]: Miri over the unsafe code of the library: the views of slices, the C interface by its unit tests, which
# have a fitter that several threads call, and the threads of src/workers.rs. It finds undefined behaviour, data races and leaks.
# Each test runs with so many seeds, 1 by default, which choose who of the threads comes first. By the rules of Tree Borrows: those
# of Stacked Borrows nalgebra breaks, in its product of a matrix and a vector. Needs a nightly toolchain:
# rustup toolchain install nightly --component miri rust-src
set -euo pipefail
cd "$(dirname "$0")/.."
if ! cargo +nightly miri --version >/dev/null 2>&1; then
    echo "skipped: there is no nightly toolchain with Miri"
    exit
fi
export MIRIFLAGS="-Zmiri-tree-borrows -Zmiri-many-seeds=0..${1:-1}"
cargo +nightly miri test --locked --target-dir target/miri --lib -- ffi:: workers:: strided::
