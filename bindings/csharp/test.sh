#!/usr/bin/env bash
# Builds and tests the C# binding. Needs Debian's package manager; CYLFUSE_LIBRARY names the native library, else it is
# built.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)

if ! command -v mcs >/dev/null || ! command -v mono >/dev/null || ! command -v python3 >/dev/null ||
    ! command -v cc >/dev/null ||
    [ ! -e /usr/lib/mono/4.5/System.Json.dll ]; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends \
        mono-mcs mono-runtime libmono-system-core4.0-cil libmono-system-json4.0-cil python3 gcc libc6-dev
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

# The program of the README in an empty folder with what the package brings: it finds the library without CYLFUSE_LIBRARY.
project="$build/an empty project é"
native=$project/runtimes/linux-$([ "$(uname -m)" = aarch64 ] && echo arm64 || echo x64)/native
mkdir -p "$native"
cp "$CYLFUSE_LIBRARY" "$native/libcylfuse.so"
cp "$build/Cylfuse.dll" "$project"
block() { awk -v number="$1" '/^```/ { inside = /csharp/ && ++count == number; next } inside' "$here/README.md"; }
{
    echo 'using System; using System.Collections.Generic; static class Smallest { static void Main() {'
    block 1
    echo '} }'
} >"$project/smallest.cs"
compile -out:"$project/smallest.exe" "$project/smallest.cs"
# The one with a camera compiles.
{
    echo 'using Cylfuse; static class WithCamera {'
    echo 'static void Use(Fitter fitter, ushort[,] depth, byte[,] mask, double[,] edges, byte[,] image) {'
    block 2
    echo '} }'
} >"$project/camera.cs"
compile -nowarn:219 -target:library -out:"$project/camera.dll" "$project/camera.cs"
printed=$(env -u CYLFUSE_LIBRARY mono "$project/smallest.exe")
if [ "$printed" != "radius 0.500000, doubts None" ]; then
    echo "the program of the README printed: $printed"
    exit 1
fi

echo 'unsigned cylfuse_abi_version(void) { return 2; }' | cc -shared -fPIC -x c - -o "$build/other_abi.so"
export CYLFUSE_OTHER_ABI=$build/other_abi.so
compile -r:System.dll -out:"$build/tests.exe" "$here"/tests/*.cs
failed=0
# Names what a sum of "N passed, N failed" counts, and keeps it for the whole sum.
name() { sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$1: &/" | tee -a "$build/log"; }
mono "$build/tests.exe" | name Tests || failed=1

# The golden cases: the bits of C in the same job.
if [ -z "${CYLFUSE_CONFORMANCE_RESULTS:-}" ]; then
    export CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt
    "$repository/bindings/conformance/test.sh" >&2
fi
conformance=$repository/bindings/conformance
compile -r:System.Json.dll -out:"$build/conformance.exe" "$here"/conformance/*.cs
mono "$build/conformance.exe" "$conformance/cases.json" >"$build/results.txt" || failed=1
python3 "$conformance/check.py" "$build/results.txt" "$CYLFUSE_CONFORMANCE_RESULTS" | name Golden-cases || failed=1
python3 "$conformance/coverage.py" "$here"/src/*.cs | name Functions-bound || failed=1

# A program that broke off has printed no sum, but failed all the same.
awk -v broken=$failed '
    / passed, [0-9]+ failed$/ { passed += $2; failed += $4 }
    END { if (broken && !failed) failed = 1; printf "%d passed, %d failed\n", passed, failed }' "$build/log"
exit $failed
