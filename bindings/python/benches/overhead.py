"""What Python adds to the calls of the library for a 640 x 480 frame: benches/overhead.py

The calls go to a library with the same functions that do nothing, compiled here with cc: what is measured is Python
alone. The least time of many is what the machine's other work leaves untouched.
"""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import tempfile
import timeit

ROOT = pathlib.Path(__file__).resolve().parents[3]
OWN = {
    "cylfuse_abi_version": "unsigned cylfuse_abi_version(void) { return 1; }",
    "cylfuse_version_string": 'const char *cylfuse_version_string(void) { return "0.0.0"; }',
    "cylfuse_fitter_create": "int cylfuse_fitter_create(unsigned v, void **f) { *f = f; return 0; }",
}


def measure() -> None:
    import numpy as np

    import cylfuse

    frame = {
        "depth": np.zeros((480, 640), np.uint16),
        "depth_scale": 0.001,
        "mask": np.zeros((480, 640), np.uint8),
        "image": np.zeros((480, 640), np.uint8),
        "edges": np.zeros((2, 4)),
        "intrinsics": cylfuse.Intrinsics(640, 480, 570.0, 570.0, 319.5, 239.5),
    }
    few = {name: frame[name] for name in ("depth", "depth_scale", "mask", "intrinsics")}
    with cylfuse.Fitter(frame["intrinsics"]) as fitter:
        statements = {
            "cylfuse.fit, everything": lambda: cylfuse.fit(**frame),
            "cylfuse.fit, depth and mask": lambda: cylfuse.fit(**few),
            "Fitter: clear, push_depth, fit": lambda: (
                fitter.clear(), fitter.push_depth(frame["depth"], frame["mask"], 0.001), fitter.fit()
            ),
            "result.model": lambda: cylfuse.Cylinder._from_struct(_model),
        }  # fmt: skip
        _model = cylfuse._structs.Cylinder()
        for name, statement in statements.items():
            seconds = min(timeit.repeat(statement, number=100, repeat=50)) / 100
            print(f"{name:32s} {seconds * 1e6:6.1f} µs")


def main() -> None:
    if len(sys.argv) == 2:
        measure()
        return
    symbols = (ROOT / "tests/data/symbols.txt").read_text().split()
    with tempfile.TemporaryDirectory() as folder:
        source, library = pathlib.Path(folder, "nothing.c"), pathlib.Path(folder, "nothing.so")
        source.write_text("\n".join(OWN.get(name, f"int {name}() {{ return 0; }}") for name in symbols) + "\n")
        subprocess.run(["cc", "-O2", "-shared", "-fPIC", source, "-o", library], check=True)
        environment = {**os.environ, "CYLFUSE_LIBRARY": str(library)}
        subprocess.run([sys.executable, __file__, "measure"], env=environment, check=True)


if __name__ == "__main__":
    main()
