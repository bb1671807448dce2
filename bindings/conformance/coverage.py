#!/usr/bin/env python3
"""Checks that the sources of a binding name every function of the C interface.

    coverage.py SOURCE...

The list of the functions is tests/data/symbols.txt, which a test holds equal to what the library exports.
"""
import pathlib
import re
import sys


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    symbols = pathlib.Path(__file__).resolve().parents[2] / "tests/data/symbols.txt"
    words = set()
    for path in sys.argv[1:]:
        words.update(re.findall(r"\bcylfuse_\w+", pathlib.Path(path).read_text(encoding="utf-8")))
    functions = symbols.read_text().split()
    missing = [name for name in functions if name not in words]
    for name in missing:
        print(f"{name} is not bound")
    print(f"{len(functions) - len(missing)} passed, {len(missing)} failed")
    return bool(missing)


if __name__ == "__main__":
    sys.exit(main())
