#!/usr/bin/env bash
# Makes the NuGet package with Debian's nuget and Mono, the native library inside; what it says of itself is in Cylfuse.csproj.
# Usage: package.sh LIBRARY FOLDER
#   LIBRARY  libcylfuse.so of this machine's kind, from `cargo build --release`
#   FOLDER   where Cylfuse.VERSION.nupkg goes
set -euo pipefail
library=$(realpath "$1") folder=$(realpath "$2")
cd "$(dirname "$0")"

layout=$(mktemp -d)
trap 'rm -rf "$layout"' EXIT
mkdir "$layout/lib"
./build.sh "$layout/lib"
# Nobody debugs the library in a package, and the debug information is most of it.
strip --strip-debug -o "$layout/libcylfuse.so" "$library"
cp README.md ../../LICENSE-* "$layout"
property() { sed -n "s|.*<$1>\(.*\)</$1>.*|\1|p" Cylfuse.csproj; }
runtime=linux-$([ "$(uname -m)" = aarch64 ] && echo arm64 || echo x64)
cat >"$layout/Cylfuse.nuspec" <<NUSPEC
<package>
  <metadata>
    <id>$(property PackageId)</id>
    <version>$(property Version)</version>
    <authors>cylfuse</authors>
    <description>$(property Description)</description>
    <tags>$(property PackageTags | tr ';' ' ')</tags>
  </metadata>
  <files>
    <file src="lib/*" target="lib/net45" />
    <file src="libcylfuse.so" target="runtimes/$runtime/native" />
    <file src="README.md" />
    <file src="LICENSE-*" />
  </files>
</package>
NUSPEC
nuget pack "$layout/Cylfuse.nuspec" -BasePath "$layout" -OutputDirectory "$folder"
