#!/usr/bin/env bash
# Licences, sources and known vulnerabilities of the dependencies, by cargo-deny and deny.toml. Installs cargo-deny in
# target/tools where it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
version=0.20.2
export PATH=$PWD/target/tools/bin:$PATH
if ! cargo deny --version >/dev/null 2>&1; then
    # Without optimisation: it is built in a third of the time, and runs for a second.
    CARGO_TARGET_DIR=target/tools/build cargo install --locked --debug --version "$version" --root target/tools cargo-deny
    rm -rf target/tools/build
fi
cargo deny --all-features --locked check licenses bans sources
# The database of advisories is fetched from its repository.
if git ls-remote --exit-code https://github.com/RustSec/advisory-db HEAD >/dev/null 2>&1; then
    cargo deny --all-features --locked check advisories
else
    echo "skipped: advisories, for https://github.com/RustSec/advisory-db cannot be reached"
fi
