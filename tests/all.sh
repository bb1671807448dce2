#!/usr/bin/env bash
# Every check there is, with its own set-up. Needs a Rust toolchain and Debian's package manager.
# What is compiled first uses all processors. Then two lanes run side by side: most checks wait for one processor, or for a
# server.
set -euo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

step() { printf '\n== %s\n' "$*"; }

# All checks take the library and the program of this build, so that nothing is compiled again for one of them.
features=(--locked --release --features bench)
# The lints have compiled the examples.
targets=(--lib --bins --tests)

# Rust: each check goes on where one before it failed.
rust() {
    local status=0
    step "tests: Rust, header, ABI, hostile calls and damaged files, C with sanitizers and valgrind, command line"
    cargo test "${features[@]}" "${targets[@]}" --no-fail-fast || status=1
    cargo test "${features[@]}" --doc || status=1

    step "report: pages in a browser at desktop and phone width"
    tests/report.sh || status=1

    step "demo"
    demo || status=1

    step "tests: matrices of OpenCV"
    # Nobody waits for the compiler to optimise them.
    cargo test --locked --release --features opencv --lib --config profile.release.package.cylfuse.opt-level=0 opencv:: || status=1

    step "dependencies: licences, sources, known vulnerabilities"
    tests/deny.sh || status=1
    return $status
}

demo() {
    "${CARGO_TARGET_DIR:-target}/release/cylfuse" demo --out "$work/demo" || return 1
    for file in result.json overlay.png completed.ply completed.pcd scene/overlay.png scene/labels.png scene/completed.ply; do
        test -s "$work/demo/$file" || { echo "the demo has not written $file"; return 1; }
    done
}

others() {
    local status=0
    step "C++: installation, packages, headers, examples, OpenCV, PCL, reference"
    tests/cpp.sh || status=1

    step "documents: site, links, programs of the first pages"
    tests/docs.sh || status=1

    step "bindings"
    CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-target}/release/libcylfuse.so bindings/test.sh || status=1
    return $status
}

step "set-up"
tests/packages.sh
for component in rustfmt clippy; do
    cargo "${component/rust/}" --version >/dev/null 2>&1 || rustup component add "$component"
done

step "format"
cargo fmt --check

step "lints"
cargo clippy --locked --release --all-targets --all-features -- -D warnings
# What a user of the program compiles.
cargo clippy --locked --release --features cli -- -D warnings

step "library, program and tests of Rust"
# `cargo test` takes what this has built, and would leave the library where only tests find it.
cargo build "${features[@]}" "${targets[@]}"

rust > "$work/rust" 2>&1 &
rust=$!
failed=0
others 2>&1 | tee "$work/others" || failed=1
wait $rust || failed=1
cat "$work/rust"

# Of the lines "test result: ok. 3 passed; 0 failed" and "cpp: 3 passed, 0 failed" and so on.
sum() { awk -v word="$1" '/^(test result|report|cpp|docs|bindings):/ { for (i = 2; i <= NF; i++) if ($i ~ "^" word) total += $(i - 1) } END { print total + 0 }' "$work"/{rust,others}; }
[ $failed = 0 ] || printf '\na check has failed: see above\n'
printf '\n%s passed, %s failed\n' "$(sum passed)" "$(sum failed)"
exit $failed
