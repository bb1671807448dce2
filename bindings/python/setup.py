"""Puts the shared library into the wheel: that of CYLFUSE_LIBRARY, else one built by cargo from the checkout."""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py
from setuptools.dist import Distribution

ROOT = pathlib.Path(__file__).resolve().parents[2]
NAME = {"win32": "cylfuse.dll", "darwin": "libcylfuse.dylib"}.get(sys.platform, "libcylfuse.so")


def native_library() -> pathlib.Path:
    given = os.environ.get("CYLFUSE_LIBRARY")
    if given:
        return pathlib.Path(given)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    subprocess.run(["cargo", "build", "--release", "--locked", "--lib"], cwd=ROOT, check=True)
    return target / "release" / NAME


class BuildWithLibrary(build_py):
    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            shutil.copy2(native_library(), pathlib.Path(self.build_lib, "cylfuse", NAME))


class AnyPython(bdist_wheel):
    """One wheel for all versions of Python on a platform: the library knows nothing of Python."""

    def get_tag(self) -> tuple[str, str, str]:
        return "py3", "none", super().get_tag()[2]


class WithLibrary(Distribution):
    def has_ext_modules(self) -> bool:
        return True


VERSION = re.search(r'^version = "(.+)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)
assert VERSION, "Cargo.toml has no version"
setup(
    version=VERSION[1],
    cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": AnyPython},
    distclass=WithLibrary,
)
