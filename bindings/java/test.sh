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
[ -e /usr/share/java/gson.jar ] || missing+=(libgoogle-gson-java)
command -v python3 >/dev/null || missing+=(python3)
command -v strip >/dev/null || missing+=(binutils)
command -v cc >/dev/null || missing+=(gcc libc6-dev)
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
javadoc -Xdoclint:all -Werror -quiet -encoding UTF-8 -cp /usr/share/java/jna.jar -d "$build/documentation" \
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

echo 'unsigned cylfuse_abi_version(void) { return 2; }' | cc -shared -fPIC -x c - -o "$build/other_abi.so"
export CYLFUSE_OTHER_ABI=$build/other_abi.so
packages=$build/tests:$packages
for name in junit4 hamcrest-core gson; do packages=$packages:/usr/share/java/$name.jar; done
mkdir "$build/tests"
javac -Xlint:all -Werror -encoding UTF-8 --release 17 -cp "$packages" -d "$build/tests" "$here"/src/test/java/org/cylfuse/*.java
classes=()
for file in "$here"/src/test/java/org/cylfuse/*Test.java; do
    classes+=("org.cylfuse.$(basename "$file" .java)")
done
failed=0
# Names what a sum of "N passed, N failed" counts, and keeps it for the whole sum.
name() { sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$1: &/" | tee -a "$build/log"; }
# A small heap, so that what grows in the tests of memory is native.
java -Xmx64m -cp "$packages" org.cylfuse.RunTests "${classes[@]}" | name Tests || failed=1

# The golden cases: the bits of C in the same job.
if [ -z "${CYLFUSE_CONFORMANCE_RESULTS:-}" ]; then
    export CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt
    "$repository/bindings/conformance/test.sh" >&2
fi
conformance=$repository/bindings/conformance
java -cp "$packages" org.cylfuse.ConformanceResults "$conformance/cases.json" >"$build/results.txt" || failed=1
python3 "$conformance/check.py" "$build/results.txt" "$CYLFUSE_CONFORMANCE_RESULTS" | name Golden-cases || failed=1
python3 "$conformance/coverage.py" "$here"/src/main/java/org/cylfuse/*.java | name Functions-bound || failed=1

# A program that broke off has printed no sum, but failed all the same.
awk -v broken=$failed '
    / passed, [0-9]+ failed$/ { passed += $2; failed += $4 }
    END { if (broken && !failed) failed = 1; printf "%d passed, %d failed\n", passed, failed }' "$build/log"
exit $failed
