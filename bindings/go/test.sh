#!/usr/bin/env bash
# Tests the Go binding against the shared library at CYLFUSE_LIBRARY, then the module as it is published, with the
# archive beside that library inside. Needs golang-go and a C compiler; bindings/test.sh installs them.
set -euo pipefail
cd "$(dirname "$0")"
: "${CYLFUSE_LIBRARY:?set it to the path of libcylfuse.so}"

work=$(mktemp -d)
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT

# The linker looks for libcylfuse.so, the loader for the name that is written in it.
library=$(realpath "$CYLFUSE_LIBRARY")
soname=$(readelf -d "$library" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')
mkdir "$work/lib"
ln -s "$library" "$work/lib/libcylfuse.so"
ln -sf "$library" "$work/lib/${soname:-libcylfuse.so}"

unformatted=$(gofmt -l .)
[ -z "$unformatted" ] || { echo "gofmt would change: $unformatted" >&2; exit 1; }

log=$work/log
status=0
(
    export CGO_LDFLAGS="-L$work/lib -Wl,-rpath,$work/lib" GOFLAGS="-tags=cylfuse_system"
    go vet ./...
    go test -count=1 -v ./...
) 2>&1 | tee "$log" || status=1

./package.sh "$(dirname "$library")/libcylfuse.a" "$work/module"
CYLFUSE_GO_MODULE=$work/module CYLFUSE_GO_RUN=bundled \
    CGO_LDFLAGS="-L$work/lib -Wl,-rpath,$work/lib" \
    go test -tags cylfuse_system -count=1 -v -run TestReadme 2>&1 | tee -a "$log" || status=1

passed=$(grep -c '^--- PASS' "$log" || true)
failed=$(grep -c '^--- FAIL' "$log" || true)
# A build that broke names no test.
[ "$status" = 0 ] || [ "$failed" != 0 ] || failed=1
printf '\ngo: %s passed, %s failed\n' "$passed" "$failed"
exit "$status"
