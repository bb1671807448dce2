#!/usr/bin/env bash
# sbom.sh FILE: writes what the shared library is made of, with versions and licences, as a CycloneDX bill of materials, by
# cargo-cyclonedx. Installs that in target/tools where it is missing.
set -euo pipefail
file=$(realpath -m "$1")
cd "$(dirname "$0")/.."
source packaging/cargo_tool.sh
cargo_tool cyclonedx 0.5.9
# No time and no random number: the same sources give the same file.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 0)}
export SOURCE_DATE_EPOCH
triple=$(rustc -vV | sed -n 's/^host: //p')
# It only writes beside Cargo.toml.
name=cylfuse-sbom.$$
trap 'rm -f "$name.json"' EXIT
cargo cyclonedx --quiet --no-build-deps --target "$triple" --format json --spec-version 1.5 --override-filename "$name"
mkdir -p "$(dirname "$file")"
# The place of this checkout is nobody's business.
sed "s|$PWD|.|g" "$name.json" > "$file"
