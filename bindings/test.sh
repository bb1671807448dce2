#!/usr/bin/env bash
# Builds and tests every binding against one native library: CYLFUSE_LIBRARY, else a release build. Installs what
# they need from Debian's and their languages' packages.
set -euo pipefail
cd "$(dirname "$0")"

missing=()
command -v go >/dev/null || missing+=(golang-go)
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)
if [ ${#missing[@]} -gt 0 ]; then
    as_root=()
    [ "$(id -u)" = 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -q
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"
fi
if [ -z "${CYLFUSE_LIBRARY:-}" ]; then
    # Whatever features were built before.
    (cd .. && cargo build --locked --release)
    CYLFUSE_LIBRARY=$(cd .. && pwd)/target/release/libcylfuse.so
fi
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
mkdir "$results/logs"
export CYLFUSE_LIBRARY CYLFUSE_CONFORMANCE_RESULTS=$results/c.txt

failed=0
# The conformance cases come first: the bindings compare with the results of C.
for part in conformance */; do
    part=${part%/}
    [ -x "$part/test.sh" ] || continue
    [ "$part" != conformance ] || [ ! -e "$results/logs/conformance" ] || continue
    printf '\n-- %s\n' "$part"
    "$part/test.sh" 2>&1 | tee "$results/logs/$part" || failed=1
done

# Of each its last line, such as "node: 3 passed, 0 failed". A part that broke off has no such line, but failed all the
# same.
for part in "$results/logs"/*; do tail -n 1 "$part"; done | awk -v broken=$failed '
    / passed, [0-9]+ failed$/ { passed += $(NF - 3); failed += $(NF - 1) }
    END { if (broken && !failed) failed = 1; printf "bindings: %d passed, %d failed\n", passed, failed }'
exit $failed
