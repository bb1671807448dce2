#!/usr/bin/env bash
# Tests the Go binding, then the module as it is published. Needs Debian's package manager; CYLFUSE_LIBRARY names the
# native library, with libcylfuse.a beside it, else they are built.
source "$(dirname "$0")/../test_functions.sh"
require go golang-go cc build-essential strip binutils python3 python3

# The linker looks for libcylfuse.so, the loader for the name that is written in it.
soname=$(readelf -d "$CYLFUSE_LIBRARY" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')
mkdir "$build/lib"
ln -s "$CYLFUSE_LIBRARY" "$build/lib/libcylfuse.so"
[ -e "$build/lib/${soname:=libcylfuse.so}" ] || ln -s "$CYLFUSE_LIBRARY" "$build/lib/$soname"

cd "$repository/bindings/go"
unformatted=$(gofmt -l .)
[ -z "$unformatted" ] || { echo "gofmt would change: $unformatted"; failed=1; }
./package.sh "$(dirname "$CYLFUSE_LIBRARY")/libcylfuse.a" "$build/module"

export CGO_LDFLAGS="-L$build/lib -Wl,-rpath,$build/lib" GOFLAGS=-tags=cylfuse_system
library_without_extents
export CYLFUSE_GO_MODULE=$build/module CYLFUSE_CONFORMANCE_OUTPUT=$build/results.txt
go vet ./... || failed=1
# tests OPTION...: runs tests, and sums up what they print.
tests() {
    go test -count=1 -timeout=60m -v "$@" . 2>&1 | awk '
        1; /^--- PASS/ { passed++ } /^--- FAIL/ { failed++ }
        END { printf "%d passed, %d failed\n", passed, failed }'
}
counted Tests tests
# With the race detector, all checks of pointers that go to C, and the collector at work all the time.
GOGC=1 GODEBUG=cgocheck=2 counted Under-strain tests -short -race

golden_cases "$build/results.txt" ./*.go bridge.c
finish
