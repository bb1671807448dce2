"""Puts the shared library into the wheel: that of CYLFUSE_LIBRARY, else one built by cargo. A source distribution
carries what cargo builds it from, in the folder ``crate``."""

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
from setuptools.command.sdist import sdist
from setuptools.dist import Distribution

HERE = pathlib.Path(__file__).resolve().parent
# In a source distribution, else in the repository.
CRATE = next(folder for folder in (HERE / "crate", HERE.parents[1]) if (folder / "Cargo.toml").is_file())
# What `cargo build --lib` reads; of benches and examples it only wants to see that they are there.
SOURCES = ["Cargo.toml", "Cargo.lock", "build.rs", "src", "benches", "bindings/conformance/rust"]
LICENSES = ["LICENSE-APACHE", "LICENSE-MIT"]
NAME = {"win32": "cylfuse.dll", "darwin": "libcylfuse.dylib"}.get(sys.platform, "libcylfuse.so")


def native_library() -> pathlib.Path:
    given = os.environ.get("CYLFUSE_LIBRARY")
    if given:
        library = pathlib.Path(given)
        if not library.is_absolute() or not library.is_file():
            raise SystemExit(f"CYLFUSE_LIBRARY is {given}; it must be the absolute path of the shared library")
        return library
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", CRATE / "target"))
    subprocess.run(["cargo", "build", "--profile", "dist", "--locked", "--lib"], cwd=CRATE, check=True)
    return target / "dist" / NAME


class BuildWithLibrary(build_py):
    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        library = pathlib.Path(self.build_lib, "cylfuse", NAME)
        shutil.copy2(native_library(), library)
        if sys.platform == "linux" and shutil.which("strip"):
            # Nobody debugs the library in a package, and the debug information is most of it.
            subprocess.run(["strip", "--strip-debug", library], check=True)


class AnyPython(bdist_wheel):
    """One wheel for all versions of Python on a platform: the library knows nothing of Python."""

    def get_tag(self) -> tuple[str, str, str]:
        return "py3", "none", super().get_tag()[2]


class WithCrate(sdist):
    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        super().make_release_tree(base_dir, files)
        for name in SOURCES:
            source, target = CRATE / name, pathlib.Path(base_dir, "crate", name)
            target.parent.mkdir(parents=True, exist_ok=True)
            (shutil.copytree if source.is_dir() else shutil.copy2)(source, target)


class WithLibrary(Distribution):
    def has_ext_modules(self) -> bool:
        return True


# A license file must lie beside this one; those of the repository do not.
for name in LICENSES:
    if (CRATE / name).is_file():
        shutil.copy2(CRATE / name, HERE)

VERSION = re.search(r'^version = "(.+)"', (CRATE / "Cargo.toml").read_text("utf-8"), re.MULTILINE)
assert VERSION, "Cargo.toml has no version"
setup(
    version=VERSION[1],
    license_files=LICENSES,
    cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": AnyPython, "sdist": WithCrate},
    distclass=WithLibrary,
)
