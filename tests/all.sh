#!/usr/bin/env bash
# Every check there is, with its own set-up. Needs a Rust toolchain and Debian's package manager.
set -euo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$*"; }

step "set-up"
tests/packages.sh
for component in rustfmt clippy; do
    cargo "${component/rust/}" --version >/dev/null 2>&1 || rustup component add "$component"
done

step "format"
cargo fmt --check

step "lints"
cargo clippy --locked --release --all-targets --all-features -- -D warnings

step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --locked --release --no-deps --lib

step "dependencies: licences, sources, known vulnerabilities"
tests/deny.sh

step "tests: Rust, header, ABI, hostile calls and damaged files, C with sanitizers and valgrind, command line"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cargo test --locked --release --features bench --no-fail-fast 2>&1 | tee "$log"

step "report: pages in a browser at desktop and phone width"
tests/report.sh 2>&1 | tee -a "$log"

step "tests: matrices of OpenCV"
cargo test --locked --release --features cli,opencv --lib opencv:: 2>&1 | tee -a "$log"

step "demo"
demo=$(mktemp -d)
cargo run --locked --release --features cli -- demo --out "$demo"
for file in result.json overlay.png completed.ply completed.pcd scene/overlay.png scene/labels.png scene/completed.ply; do test -s "$demo/$file"; done
rm -rf "$demo"

step "C++: installation, packages, headers, examples, OpenCV, PCL, reference"
tests/cpp.sh 2>&1 | tee -a "$log"

step "documents: site, links, programs of the first pages"
tests/docs.sh 2>&1 | tee -a "$log"

step "bindings"
# With the library that is there already.
CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-target}/release/libcylfuse.so bindings/test.sh 2>&1 | tee -a "$log"

# Of the lines "test result: ok. 3 passed; 0 failed" and "cpp: 3 passed, 0 failed" and so on.
sum() { awk -v word="$1" '/^(test result|report|cpp|docs|bindings):/ { for (i = 2; i <= NF; i++) if ($i ~ "^" word) total += $(i - 1) } END { print total + 0 }' "$log"; }
printf '\n%s passed, %s failed\n' "$(sum passed)" "$(sum failed)"
