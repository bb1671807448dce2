#!/usr/bin/env bash
# Tests the Node binding, then the package as it is published. Needs Debian's package manager; CYLFUSE_LIBRARY names the
# native library, else it is built.
source "$(dirname "$0")/../test_functions.sh"
require node nodejs npm npm strip binutils cc build-essential python3 python3

cd "$repository/bindings/node"
npm install --no-audit --no-fund --no-package-lock --loglevel=error
./package.sh "$CYLFUSE_LIBRARY" "$build/package"

# tests: runs the tests, and sums up what they print.
tests() {
    CYLFUSE_NODE_PACKAGE=$build/package node --expose-gc --test --test-reporter=tap test/*.test.js | awk '
        1; /^# pass / { passed = $3 } /^# fail / { failed = $3 }
        END { printf "%d passed, %d failed\n", passed, failed }'
}
counted Tests tests

node test/conformance.js >"$build/results.txt" || failed=1
golden_cases "$build/results.txt" lib/*.js
finish
