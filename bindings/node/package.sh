#!/usr/bin/env bash
# Lays out the package as it is published, with the native library inside.
# Usage: package.sh LIBRARY FOLDER
#   LIBRARY  libcylfuse.so of this machine's kind, from `cargo build --release`
#   FOLDER   where the package goes; run once for each kind of machine, with the same folder, then `npm publish` there
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
library=$1 folder=$2

platform=$(node -p '`${process.platform}-${process.arch}`')
mkdir -p "$folder/lib" "$folder/native/$platform"
cp "$here"/lib/* "$folder/lib"
cp "$here"/package.json "$here"/README.md "$here"/../../LICENSE-* "$folder"
# Nobody debugs the library in a package, and the debug information is most of it.
strip --strip-debug -o "$folder/native/$platform/libcylfuse.so" "$library"
