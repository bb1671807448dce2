#!/usr/bin/env bash
# Builds and tests the Java binding with Maven and its plugins from Debian. Needs Debian's package manager;
# CYLFUSE_LIBRARY names the native library, else it is built.
source "$(dirname "$0")/../test_functions.sh"
here=$repository/bindings/java
plugins=/usr/share/maven-repo/org/apache/maven/plugins
require javac openjdk-17-jdk-headless javadoc openjdk-17-jdk-headless mvn maven strip binutils cc build-essential \
    python3 python3 /usr/share/java/jna.jar libjna-java /usr/share/java/junit4.jar junit4 \
    /usr/share/java/gson.jar libgoogle-gson-java $plugins/maven-surefire-plugin libsurefire-java \
    $plugins/maven-resources-plugin libmaven-resources-plugin-java \
    $plugins/maven-compiler-plugin libmaven-compiler-plugin-java \
    $plugins/maven-jar-plugin libmaven-jar-plugin-java $plugins/maven-install-plugin libmaven-install-plugin-java

javadoc -Xdoclint:all -Werror -quiet -encoding UTF-8 -cp /usr/share/java/jna.jar -d "$build/documentation" \
    "$here"/src/main/java/org/cylfuse/*.java

# A copy, so that nothing is left beside the sources; the name of the folder of the native library is JNA's.
cp -r "$here/pom.xml" "$here/src" "$build"
native=$build/native/linux-$([ "$(uname -m)" = aarch64 ] && echo aarch64 || echo x86-64)
mkdir -p "$native"
strip --strip-debug -o "$native/libcylfuse.so" "$CYLFUSE_LIBRARY"
echo 'unsigned cylfuse_abi_version(void) { return 2; }' | cc -shared -fPIC -x c - -o "$build/other_abi.so"
export CYLFUSE_OTHER_ABI=$build/other_abi.so
library_without_extents
# What Debian has installed, in the versions that it has.
cp -rs /usr/share/maven-repo "$build/packages"
maven() {
    mvn --offline --batch-mode --quiet -Dmaven.repo.local="$build/packages" \
        -Djna.version=debian -Djunit.version=4.x -Dgson.version=debian "$@"
}
(cd "$build" && maven install -Dcylfuse.repository="$repository" -Dmaven.test.failure.ignore)
counted Tests awk '1; /^Tests run:/ { gsub(",", ""); passed += $3 - $5 - $7 - $9; failed += $5 + $7 + $9 }
    END { printf "%d passed, %d failed\n", passed, failed; exit !passed || failed }' \
    "$build"/target/surefire-reports/*.txt

# The program of the README, in an empty project that depends on the package; it finds the library in the jar.
project="$build/an empty project é"
mkdir -p "$project/src/main/java"
block() { awk -v number="$1" '/^```/ { inside = /java/ && ++count == number; next } inside' "$here/README.md"; }
{
    echo 'import java.util.Locale; import org.cylfuse.*; class Smallest { public static void main(String[] arguments) {'
    block 1
    echo '} }'
} >"$project/src/main/java/Smallest.java"
# The ones with a camera and with views compile.
{
    echo 'import java.util.List; import org.cylfuse.*; class WithCamera {'
    echo 'static void use(Fitter fitter, short[] depth, byte[] mask, byte[] image) {'
    block 2
    echo '} static void views(Fitter fitter, Fitter[] fitters, Intrinsics camera, short[] depth, byte[] mask,'
    echo 'double[][] rotation) {'
    block 3
    echo '} static void scene(Frame frame) {'
    block 4
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
    <dependency><groupId>org.cylfuse</groupId><artifactId>cylfuse</artifactId><version>0.2.0</version></dependency>
  </dependencies>
</project>
POM
(cd "$project" && maven compile)
packages=$(echo "$build"/packages/org/cylfuse/cylfuse/*/*.jar):/usr/share/java/jna.jar
printed=$(env -u CYLFUSE_LIBRARY java -cp "$project/target/classes:$packages" Smallest)
if [ "$printed" != "radius 0.500000, warnings []" ]; then
    echo "the program of the README printed: $printed"
    failed=1
fi

java -cp "$build/target/test-classes:$packages:/usr/share/java/gson.jar" org.cylfuse.ConformanceResults \
    "$conformance/cases.json" >"$build/results.txt" || failed=1
golden_cases "$build/results.txt" "$here"/src/main/java/org/cylfuse/*.java
finish
