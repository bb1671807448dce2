#!/usr/bin/env bash
# Builds and tests the Java binding with Maven and its plugins from Debian. Needs Debian's package manager;
# CYLFUSE_LIBRARY names the native library, else it is built.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)

missing=()
command -v javac >/dev/null && command -v javadoc >/dev/null || missing+=(openjdk-17-jdk-headless)
command -v mvn >/dev/null || missing+=(maven)
for plugin in resources compiler jar install; do
    [ -e "/usr/share/maven-repo/org/apache/maven/plugins/maven-$plugin-plugin" ] ||
        missing+=("libmaven-$plugin-plugin-java")
done
[ -e /usr/share/maven-repo/org/apache/maven/plugins/maven-surefire-plugin ] || missing+=(libsurefire-java)
[ -e /usr/share/java/jna.jar ] || missing+=(libjna-java)
[ -e /usr/share/java/junit4.jar ] || missing+=(junit4)
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
export CYLFUSE_LIBRARY
# Java takes the encoding of the names of files from it.
export LC_ALL=C.UTF-8

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
javadoc -Xdoclint:all -Werror -quiet -encoding UTF-8 -cp /usr/share/java/jna.jar -d "$build/documentation" \
    "$here"/src/main/java/org/cylfuse/*.java

# A copy, so that nothing is left beside the sources; the name of the folder of the native library is JNA's.
cp -r "$here/pom.xml" "$here/src" "$build"
native=$build/native/linux-$([ "$(uname -m)" = aarch64 ] && echo aarch64 || echo x86-64)
mkdir -p "$native"
strip --strip-debug -o "$native/libcylfuse.so" "$CYLFUSE_LIBRARY"
echo 'unsigned cylfuse_abi_version(void) { return 2; }' | cc -shared -fPIC -x c - -o "$build/other_abi.so"
export CYLFUSE_OTHER_ABI=$build/other_abi.so
# What Debian has installed, in the versions that it has.
cp -rs /usr/share/maven-repo "$build/packages"
maven() {
    mvn --offline --batch-mode --quiet -Dmaven.repo.local="$build/packages" \
        -Djna.version=debian -Djunit.version=4.x -Dgson.version=debian "$@"
}
# Names what a sum of "N passed, N failed" counts, and keeps it for the whole sum.
name() { sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$1: &/" | tee -a "$build/log"; }
failed=0
(cd "$build" && maven install -Dcylfuse.repository="$repository" -Dmaven.test.failure.ignore)
cat "$build"/target/surefire-reports/*.txt
awk '/^Tests run:/ { gsub(",", ""); passed += $3 - $5 - $7 - $9; failed += $5 + $7 + $9 }
    END { printf "%d passed, %d failed\n", passed, failed; exit !passed || failed }' \
    "$build"/target/surefire-reports/*.txt | name Tests || failed=1

# The program of the README, in an empty project that depends on the package; it finds the library in the jar.
project="$build/an empty project é"
mkdir -p "$project/src/main/java"
block() { awk -v number="$1" '/^```/ { inside = /java/ && ++count == number; next } inside' "$here/README.md"; }
{
    echo 'import java.util.Locale; import org.cylfuse.*; class Smallest { public static void main(String[] arguments) {'
    block 1
    echo '} }'
} >"$project/src/main/java/Smallest.java"
# The one with a camera compiles.
{
    echo 'import org.cylfuse.*; class WithCamera {'
    echo 'static void use(Fitter fitter, short[] depth, byte[] mask, double[] first, double[] second, byte[] image) {'
    block 2
    echo '} }'
} >"$project/src/main/java/WithCamera.java"
cat >"$project/pom.xml" <<'POM'
<project xmlns="http://maven.apache.org/POM/4.0.0">
  <modelVersion>4.0.0</modelVersion>
  <groupId>example</groupId>
  <artifactId>smallest</artifactId>
  <version>1</version>
  <properties>
    <maven.compiler.source>17</maven.compiler.source>
    <maven.compiler.target>17</maven.compiler.target>
    <project.build.sourceEncoding>UTF-8</project.build.sourceEncoding>
  </properties>
  <dependencies>
    <dependency><groupId>org.cylfuse</groupId><artifactId>cylfuse</artifactId><version>0.1.0</version></dependency>
  </dependencies>
</project>
POM
(cd "$project" && maven compile)
packages=$(echo "$build"/packages/org/cylfuse/cylfuse/*/*.jar):/usr/share/java/jna.jar
printed=$(env -u CYLFUSE_LIBRARY java -cp "$project/target/classes:$packages" Smallest)
if [ "$printed" != "radius 0.500000, doubts []" ]; then
    echo "the program of the README printed: $printed"
    failed=1
fi

# The golden cases: the bits of C in the same job.
if [ -z "${CYLFUSE_CONFORMANCE_RESULTS:-}" ]; then
    export CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt
    "$repository/bindings/conformance/test.sh" >&2
fi
conformance=$repository/bindings/conformance
java -cp "$build/target/test-classes:$packages:/usr/share/java/gson.jar" org.cylfuse.ConformanceResults \
    "$conformance/cases.json" >"$build/results.txt" || failed=1
python3 "$conformance/check.py" "$build/results.txt" "$CYLFUSE_CONFORMANCE_RESULTS" | name Golden-cases || failed=1
python3 "$conformance/coverage.py" "$here"/src/main/java/org/cylfuse/*.java | name Functions-bound || failed=1

# A program that broke off has printed no sum, but failed all the same.
awk -v broken=$failed '
    / passed, [0-9]+ failed$/ { passed += $2; failed += $4 }
    END { if (broken && !failed) failed = 1; printf "%d passed, %d failed\n", passed, failed }' "$build/log"
exit $failed
