#!/usr/bin/env bash
# Compiles the jar: build.sh FOLDER [LIBRARY] leaves cylfuse.jar in FOLDER, with the native library inside when it is named.
set -euo pipefail
folder=$(realpath "$1")
library=${2:-}
[ -z "$library" ] || library=$(realpath "$library")
cd "$(dirname "$0")"
rm -rf "$folder/classes"
javac -Xlint:all -Werror -encoding UTF-8 --release 17 -cp /usr/share/java/jna.jar -d "$folder/classes" \
    src/main/java/org/cylfuse/*.java
if [ -n "$library" ]; then
    # The name of the folder is JNA's.
    native=$folder/classes/linux-$([ "$(uname -m)" = aarch64 ] && echo aarch64 || echo x86-64)
    mkdir -p "$native"
    strip --strip-debug -o "$native/libcylfuse.so" "$library"
fi
printf 'Automatic-Module-Name: org.cylfuse\n' >"$folder/manifest"
jar --create --file "$folder/cylfuse.jar" --manifest "$folder/manifest" -C "$folder/classes" .
