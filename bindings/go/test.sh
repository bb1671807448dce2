#!/usr/bin/env bash
# Tests the Go binding, then the module as it is published. Needs Debian's package manager; CYLFUSE_LIBRARY names the
# native library, with libcylfuse.a beside it, else they are built.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
repository=$(cd "$here/../.." && pwd)

missing=()
command -v go >/dev/null || missing+=(golang-go)
command -v cc >/dev/null || missing+=(build-essential)
command -v strip >/dev/null || missing+=(binutils)
command -v python3 >/dev/null || missing+=(python3)
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

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
failed=0
# Names what a sum of "N passed, N failed" counts, and keeps it for the whole sum.
name() { sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$1: &/" | tee -a "$build/log"; }
# The sum of what `go test -v` printed.
count() { awk '1; /^--- PASS/ { passed++ } /^--- FAIL/ { failed++ } END { printf "%d passed, %d failed\n", passed, failed }'; }

# The linker looks for libcylfuse.so, the loader for the name that is written in it.
soname=$(readelf -d "$CYLFUSE_LIBRARY" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')
mkdir "$build/lib"
ln -s "$CYLFUSE_LIBRARY" "$build/lib/libcylfuse.so"
[ -e "$build/lib/${soname:=libcylfuse.so}" ] || ln -s "$CYLFUSE_LIBRARY" "$build/lib/$soname"

cd "$here"
unformatted=$(gofmt -l .)
[ -z "$unformatted" ] || { echo "gofmt would change: $unformatted"; failed=1; }
./package.sh "$(dirname "$CYLFUSE_LIBRARY")/libcylfuse.a" "$build/module"

export CGO_LDFLAGS="-L$build/lib -Wl,-rpath,$build/lib" GOFLAGS=-tags=cylfuse_system
go vet ./... || failed=1
CYLFUSE_GO_MODULE=$build/module CYLFUSE_CONFORMANCE_OUTPUT=$build/results.txt go test -count=1 -v ./... 2>&1 |
    count | name Tests || failed=1

# The golden cases: the bits of C in the same job.
if [ -z "${CYLFUSE_CONFORMANCE_RESULTS:-}" ]; then
    export CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt
    "$repository/bindings/conformance/test.sh" >&2
fi
conformance=$repository/bindings/conformance
python3 "$conformance/check.py" "$build/results.txt" "$CYLFUSE_CONFORMANCE_RESULTS" | name Golden-cases || failed=1
python3 "$conformance/coverage.py" "$here"/*.go "$here"/bridge.c | name Functions-bound || failed=1

# A program that broke off has printed no sum, but failed all the same.
awk -v broken=$failed '
    / passed, [0-9]+ failed$/ { passed += $2; failed += $4 }
    END { if (broken && !failed) failed = 1; printf "%d passed, %d failed\n", passed, failed }' "$build/log"
exit $failed
