#!/usr/bin/env bash
# The package of the crate, as `cargo package` makes it, compiles away from the repository.
set -euo pipefail
cd "$(dirname "$0")/.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo package --locked --no-verify --allow-dirty
tar -xf "$target"/package/cylfuse-*.crate -C "$work"
# In the folder of this build, whose dependencies are compiled already.
cargo build --locked --release --lib --manifest-path "$work"/cylfuse-*/Cargo.toml --target-dir "$target"
