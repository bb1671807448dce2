#!/usr/bin/env bash
# Builds and tests the C# binding. Needs Debian's package manager; CYLFUSE_LIBRARY names the native library, else it is
# built.
source "$(dirname "$0")/../test_functions.sh"
here=$repository/bindings/csharp
export CYLFUSE_REPOSITORY=$repository
assemblies=/usr/lib/mono/4.5
require mcs mono-mcs mono mono-runtime nuget nuget strip binutils $assemblies/System.Core.dll libmono-system-core4.0-cil \
    $assemblies/System.Json.dll libmono-system-json4.0-cil cc build-essential python3 python3

"$here/build.sh" "$build"
compile() { mcs -langversion:7 -warnaserror -r:"$build/Cylfuse.dll" -r:System.Core.dll "$@"; }

# The program of the README in an empty project with the package installed: assembly and native library lie beside the
# program, as a build puts them there, and it finds the library without CYLFUSE_LIBRARY.
"$here/package.sh" "$CYLFUSE_LIBRARY" "$build" >/dev/null
project="$build/an empty project é"
mkdir "$project"
nuget install Cylfuse -Source "$build" -OutputDirectory "$project/packages" >"$build/nuget.log" || { cat "$build/nuget.log"; exit 1; }
cp -r "$project"/packages/Cylfuse.*/lib/net45/Cylfuse.dll "$project"/packages/Cylfuse.*/runtimes "$project"
block() { awk -v number="$1" '/^```/ { inside = /csharp/ && ++count == number; next } inside' "$here/README.md"; }
{
    echo 'using System; using System.Collections.Generic; static class Smallest { static void Main() {'
    block 1
    echo '} }'
} >"$project/smallest.cs"
mcs -langversion:7 -warnaserror -r:"$project/Cylfuse.dll" -r:System.Core.dll -out:"$project/smallest.exe" "$project/smallest.cs"
# The ones with a camera and with views compile.
{
    echo 'using Cylfuse; static class WithCamera {'
    echo 'static void Use(Fitter fitter, ushort[,] depth, byte[,] mask, byte[,,] image) {'
    block 2
    echo '} static void Views(Fitter fitter, Fitter[] fitters, ushort[,] depth, byte[,] mask, double[,] rotation) {'
    block 3
    echo '} static void Scene(Frame frame) {'
    block 4
    echo '} }'
} >"$project/camera.cs"
compile -nowarn:219 -target:library -out:"$project/camera.dll" "$project/camera.cs"
printed=$(env -u CYLFUSE_LIBRARY mono "$project/smallest.exe")
if [ "$printed" != "radius 0.500000, warnings None" ]; then
    echo "the program of the README printed: $printed"
    exit 1
fi

echo 'unsigned cylfuse_abi_version(void) { return 2; }' | cc -shared -fPIC -x c - -o "$build/other_abi.so"
export CYLFUSE_OTHER_ABI=$build/other_abi.so
library_without_extents
compile -r:System.dll -out:"$build/tests.exe" "$here"/tests/*.cs
counted Tests mono "$build/tests.exe"

compile -r:System.Json.dll -out:"$build/conformance.exe" "$here"/conformance/*.cs
mono "$build/conformance.exe" "$conformance/cases.json" >"$build/results.txt" || failed=1
golden_cases "$build/results.txt" "$here"/src/*.cs
finish
