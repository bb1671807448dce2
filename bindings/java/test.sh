#!/usr/bin/env bash
# Builds and tests the Java binding. Needs Debian's package manager; CYLFUSE_LIBRARY names the native library, else it is
# built.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)

missing=()
command -v javac >/dev/null && command -v javadoc >/dev/null || missing+=(openjdk-17-jdk-headless)
[ -e /usr/share/java/jna.jar ] || missing+=(libjna-java)
[ -e /usr/share/java/junit4.jar ] || missing+=(junit4)
[ -e /usr/share/java/hamcrest-core.jar ] || missing+=(libhamcrest-java)
command -v strip >/dev/null || missing+=(binutils)
if [ ${#missing[@]} -gt 0 ]; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"
fi
if [ -z "${CYLFUSE_LIBRARY:-}" ]; then
    (cd "$repository" && cargo build --locked --release)
    CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-$repository/target}/release/libcylfuse.so
fi
CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
export CYLFUSE_LIBRARY CYLFUSE_REPOSITORY=$repository

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
"$here/build.sh" "$build" "$CYLFUSE_LIBRARY"
javadoc -Xdoclint:all,-missing -Werror -quiet -encoding UTF-8 -cp /usr/share/java/jna.jar -d "$build/documentation" \
    "$here"/src/main/java/org/cylfuse/*.java
packages=$build/cylfuse.jar:/usr/share/java/jna.jar

# The program of the README compiles, and finds the library in the jar: without CYLFUSE_LIBRARY.
{
    echo 'import java.util.Locale; import org.cylfuse.*; class Smallest { public static void main(String[] arguments) {'
    awk '/^```java$/ { inside = 1; next } /^```$/ { exit } inside' "$here/README.md"
    echo '} }'
} >"$build/Smallest.java"
javac -Xlint:all -Werror -cp "$packages" -d "$build" "$build/Smallest.java"
printed=$(env -u CYLFUSE_LIBRARY java -cp "$build:$packages" Smallest)
if [ "$printed" != "radius 0.500000, doubts []" ]; then
    echo "the program of the README printed: $printed"
    exit 1
fi

packages=$packages:/usr/share/java/junit4.jar:/usr/share/java/hamcrest-core.jar
javac -Xlint:all -Werror -encoding UTF-8 --release 17 -cp "$packages" -d "$build/tests" "$here"/src/test/java/org/cylfuse/*.java
classes=()
for file in "$here"/src/test/java/org/cylfuse/*Test.java; do
    classes+=("org.cylfuse.$(basename "$file" .java)")
done
# A small heap, so that what grows in the tests of memory is native.
java -Xmx64m -cp "$build/tests:$packages" org.cylfuse.RunTests "${classes[@]}"
