#!/usr/bin/env bash
# Installs the Debian packages that the checks need, those that are missing.
set -euo pipefail
source "$(dirname "$0")/../packaging/debian.sh"
missing=()
for package in build-essential valgrind cmake clang doxygen pkg-config libclang-dev libopencv-dev libpcl-dev \
    abigail-tools lintian; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} = 0 ] || install "${missing[@]}"
