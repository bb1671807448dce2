#!/usr/bin/env bash
# The package of the crate, as `cargo package` makes it, compiles away from the repository.
set -euo pipefail
cd "$(dirname "$0")/.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
rm -f "$target"/package/cylfuse-*.crate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo package --locked --no-verify --allow-dirty
tar -xf "$target"/package/cylfuse-*.crate -C "$work"
# In a folder of its own: the library of the other tests has other features.
cargo build --locked --release --lib --manifest-path "$work"/cylfuse-*/Cargo.toml --target-dir "$target/package/compiled"
