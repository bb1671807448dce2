#!/usr/bin/env bash
# Licences, sources and known vulnerabilities of the dependencies, by cargo-deny and deny.toml. Installs cargo-deny in
# target/tools where it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
source packaging/cargo_tool.sh
cargo_tool deny 0.20.2
cargo deny --all-features --locked check licenses bans sources
# The database of advisories is fetched from its repository.
if git ls-remote --exit-code https://github.com/RustSec/advisory-db HEAD >/dev/null 2>&1; then
    cargo deny --all-features --locked check advisories
else
    echo "skipped: advisories, for https://github.com/RustSec/advisory-db cannot be reached"
fi
