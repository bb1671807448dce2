#!/usr/bin/env bash
# Every check there is, with its own set-up. Needs a Rust toolchain and Debian's package manager.
set -euo pipefail
cd "$(dirname "$0")/.."

step() { printf '\n== %s\n' "$*"; }

step "set-up"
missing=()
command -v cc >/dev/null && command -v c++ >/dev/null || missing+=(build-essential)
command -v nm >/dev/null || missing+=(binutils)
command -v valgrind >/dev/null || missing+=(valgrind)
if [ ${#missing[@]} -gt 0 ]; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"
fi
for component in rustfmt clippy; do
    cargo "${component/rust/}" --version >/dev/null 2>&1 || rustup component add "$component"
done

step "format"
cargo fmt --check

step "lints"
cargo clippy --locked --release --all-targets --all-features -- -D warnings

step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --locked --release --no-deps --lib

step "tests: Rust, header, ABI, C with sanitizers and valgrind, command line"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cargo test --locked --release --features cli --no-fail-fast 2>&1 | tee "$log"

step "demo"
demo=$(mktemp -d)
cargo run --locked --release --features cli -- demo --out "$demo"
for file in result.json overlay.png completed.ply completed.pcd; do test -s "$demo/$file"; done
rm -rf "$demo"

sum() { awk -v word="$1" '/^test result:/ { for (i = 2; i <= NF; i++) if ($i ~ "^" word) total += $(i - 1) } END { print total + 0 }' "$log"; }
printf '\n%s passed, %s failed\n' "$(sum passed)" "$(sum failed)"
