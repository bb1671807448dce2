#!/usr/bin/env bash
# Compiles the assembly with Mono: build.sh FOLDER leaves Cylfuse.dll and its documentation in FOLDER.
set -euo pipefail
folder=$(realpath "$1")
cd "$(dirname "$0")"
mcs -langversion:7 -unsafe -optimize -warnaserror -target:library -r:System.Core.dll \
    -doc:"$folder/Cylfuse.xml" -out:"$folder/Cylfuse.dll" src/*.cs
