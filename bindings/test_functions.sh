# What the test.sh of a language needs; it sources this file. CYLFUSE_LIBRARY names the native library, else it is
# built.
set -euo pipefail
# Messages and numbers of tools as they are read here.
export LC_ALL=C.UTF-8
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
conformance=$repository/bindings/conformance

source "$repository/packaging/debian.sh"

if [ -z "${CYLFUSE_LIBRARY:-}" ]; then
    (cd "$repository" && cargo build --locked --release)
    CYLFUSE_LIBRARY=${CARGO_TARGET_DIR:-$repository/target}/release/libcylfuse.so
fi
CYLFUSE_LIBRARY=$(realpath "$CYLFUSE_LIBRARY")
export CYLFUSE_LIBRARY

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
failed=0

# counted NAME COMMAND...: runs what prints a sum "N passed, N failed", and names and keeps that sum.
counted() {
    local name=$1
    shift
    "$@" 2>&1 | sed -E "s/^[0-9]+ passed, [0-9]+ failed$/$name: &/" | tee -a "$build/log" || failed=1
}

# Lets C run the golden cases, unless CYLFUSE_CONFORMANCE_RESULTS names its results already.
results_of_c() {
    [ -z "${CYLFUSE_CONFORMANCE_RESULTS:-}" ] || return 0
    export CYLFUSE_CONFORMANCE_RESULTS=$build/c.txt
    "$conformance/test.sh" >&2
}

# Makes CYLFUSE_WITHOUT_EXTENTS, which is the native library, but that no detection has an extent.
library_without_extents() {
    local soname
    soname=$(readelf -d "$CYLFUSE_LIBRARY" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')
    mkdir -p "$build/without_extents"
    ln -sf "$CYLFUSE_LIBRARY" "$build/without_extents/${soname:=libcylfuse.so}"
    export CYLFUSE_WITHOUT_EXTENTS=$build/without_extents/without_extents.so
    cc -shared -fPIC -x c - -x none -o "$CYLFUSE_WITHOUT_EXTENTS" -Wl,--no-as-needed "$build/without_extents/$soname" \
        -Wl,-rpath,"$build/without_extents" <<'C'
int cylfuse_detector_get_extent(void *detector, unsigned long index, void *extent) { return -26; }
const char *cylfuse_detector_last_error(void *detector) { return "EDGE_GEOMETRY: made up"; }
C
}

# golden_cases RESULTS SOURCE...: compares the results of the golden cases with the bits of C in the same job, and checks
# that the sources name every function of the C interface.
golden_cases() {
    local results=$1
    shift
    results_of_c
    counted Golden-cases python3 "$conformance/check.py" "$results" "$CYLFUSE_CONFORMANCE_RESULTS"
    counted Functions-bound python3 "$conformance/coverage.py" "$@"
}

# Prints the sum of what was counted; a program that broke off has printed none, but failed all the same.
finish() {
    awk -v broken=$failed '
        / passed, [0-9]+ failed$/ { passed += $2; failed += $4 }
        END { if (broken && !failed) failed = 1; printf "%d passed, %d failed\n", passed, failed }' "$build/log"
    exit $failed
}
