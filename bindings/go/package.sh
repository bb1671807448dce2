#!/usr/bin/env bash
# Lays out the module as it is published, with the native library inside.
# Usage: package.sh ARCHIVE FOLDER
#   ARCHIVE  libcylfuse.a of this machine's kind, from `cargo build --release`
#   FOLDER   where the module goes; run once for each kind of machine, with the same folder
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
archive=$1 folder=$2

mkdir -p "$folder"
cp "$here"/*.go "$here"/bridge.[ch] "$here"/go.mod "$here"/README.md "$here"/../../LICENSE-* \
    "$here"/../../include/cylfuse/cylfuse.h "$folder"
rm "$folder"/*_test.go
# Nobody debugs the library in a module, and the debug information is most of the archive.
strip --strip-debug -o "$folder/libcylfuse_$(go env GOOS)_$(go env GOARCH).a" "$archive"
