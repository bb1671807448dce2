"""Prints the structs of the wheel as ctypes lays them out, with size, and their fields, with offset and size:
wheel_layout.py _structs.py"""

import ctypes
import re
import runpy
import sys

for name, struct in sorted(runpy.run_path(sys.argv[1]).items()):
    if isinstance(struct, type) and issubclass(struct, ctypes.Structure) and hasattr(struct, "_fields_"):
        print("cylfuse_" + re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower(), ctypes.sizeof(struct))
        for field, *_ in struct._fields_:
            place = getattr(struct, field)
            print("   ", field, place.offset, place.size)
