#!/usr/bin/env bash
# Tests the Node binding against the shared library at CYLFUSE_LIBRARY, then the package as it is published, with that
# library inside. Needs nodejs 18 or later and npm; bindings/test.sh installs them.
set -euo pipefail
cd "$(dirname "$0")"
: "${CYLFUSE_LIBRARY:?set it to the path of libcylfuse.so}"
CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
export CYLFUSE_LIBRARY

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

npm install --no-audit --no-fund --no-package-lock --loglevel=error
npx --no-install tsc --noEmit --strict --target es2022 --module nodenext --moduleResolution nodenext --types node \
    test/types.ts

# The package, installed as a program of its own would do it.
./package.sh "$CYLFUSE_LIBRARY" "$work/package"
mkdir "$work/program"
(cd "$work/program" && npm init -y >/dev/null \
    && npm install --no-audit --no-fund --loglevel=error "$(npm pack --silent --pack-destination "$work" "$work/package" | sed "s#^#$work/#")")

status=0
CYLFUSE_NODE_PROGRAM=$work/program \
    node --expose-gc --test --test-reporter=tap test/*.test.js 2>&1 | tee "$work/log" || status=1

count() { sed -n "s/^# $1 \([0-9]*\)$/\1/p" "$work/log"; }
printf '\nnode: %s passed, %s failed\n' "$(count pass)" "$(count fail)"
exit "$status"
