#!/usr/bin/env bash
# ThreadSanitizer over all that synchronises threads: the lock of the handles, src/ffi/access.rs, and src/workers.rs. They need
# nothing else of the crate, so that they and the standard library are all that is compiled. Needs a nightly toolchain:
# rustup toolchain install nightly --component rust-src
set -euo pipefail
cd "$(dirname "$0")/.."
sources=$(rustc +nightly --print sysroot 2>/dev/null)/lib/rustlib/src/rust/library
if [ ! -e "$sources" ]; then
    echo "skipped: there is no nightly toolchain with the sources of the standard library"
    exit
fi
package=target/thread-sanitizer
mkdir -p "$package"
cat > "$package/Cargo.toml" <<'TOML'
[package]
name = "synchronised"
edition = "2024"
[lib]
path = "lib.rs"
[workspace]
TOML
cat > "$package/lib.rs" <<RUST
#[path = "$PWD/src/workers.rs"]
mod workers;
#[path = "$PWD/src/ffi/access.rs"]
mod access;
RUST
triple=$(rustc -vV | sed -n 's/^host: //p')
export RUSTFLAGS="-Zsanitizer=thread -Adead_code" TSAN_OPTIONS=halt_on_error=1
cd "$package"
cargo +nightly test -Zbuild-std --release --target "$triple" --lib
