#!/usr/bin/env bash
# Installs the Debian packages that the checks need, those that are missing.
set -euo pipefail
missing=()
for package in build-essential valgrind cmake clang doxygen pkg-config libclang-dev libopencv-dev libpcl-dev \
    abigail-tools lintian; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"
fi
