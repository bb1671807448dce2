#!/usr/bin/env bash
# Builds and tests the C# binding. Needs Debian's package manager; CYLFUSE_LIBRARY names the native library, else it is
# built.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)

if ! command -v mcs >/dev/null || ! command -v mono >/dev/null; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends \
        mono-mcs mono-runtime libmono-system-core4.0-cil
fi
if [ -z "${CYLFUSE_LIBRARY:-}" ]; then
    (cd "$repository" && cargo build --locked --release)
    CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-$repository/target}/release/libcylfuse.so
fi
CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
export CYLFUSE_LIBRARY CYLFUSE_REPOSITORY=$repository

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
"$here/build.sh" "$build"
compile() { mcs -langversion:7 -warnaserror -r:"$build/Cylfuse.dll" -r:System.Core.dll "$@"; }

# The program of the README compiles, and finds the library where a package has it: without CYLFUSE_LIBRARY.
{
    echo 'using System; using System.Collections.Generic; static class Smallest { static void Main() {'
    awk '/^```csharp$/ { inside = 1; next } /^```$/ { exit } inside' "$here/README.md"
    echo '} }'
} >"$build/smallest.cs"
compile -out:"$build/smallest.exe" "$build/smallest.cs"
mkdir -p "$build/runtimes/linux-x64/native"
ln -s "$CYLFUSE_LIBRARY" "$build/runtimes/linux-x64/native/libcylfuse.so"
printed=$(env -u CYLFUSE_LIBRARY mono "$build/smallest.exe")
if [ "$printed" != "radius 0.500000, doubts None" ]; then
    echo "the program of the README printed: $printed"
    exit 1
fi
rm -r "$build/runtimes"

compile -out:"$build/tests.exe" "$here"/tests/*.cs
mono "$build/tests.exe" "$@"
