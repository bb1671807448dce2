"""The declarations against the header, and the golden cases."""

from __future__ import annotations

import ctypes
import os
import pathlib
import re
import subprocess
import sys

import conformance
import pytest
from conftest import ROOT

import cylfuse
from cylfuse import _native, _structs, enums, errors

CONFORMANCE = ROOT / "bindings/conformance"


def test_golden_cases(tmp_path: pathlib.Path) -> None:
    results = tmp_path / "python.txt"
    results.write_text("".join(f"{line}\n" for line in conformance.lines()))
    of_c = os.environ.get("CYLFUSE_CONFORMANCE_RESULTS")
    command = [sys.executable, CONFORMANCE / "check.py", results, *([of_c] if of_c else [])]
    checked = subprocess.run(command, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_every_function_is_bound() -> None:
    command = [sys.executable, CONFORMANCE / "coverage.py", _native.__file__]
    checked = subprocess.run(command, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout


def test_structs_have_the_layout_of_the_library() -> None:
    layout: dict[str, tuple[int, dict[str, int]]] = {}
    for line in (ROOT / "tests/data/abi_layout.txt").read_text().splitlines():
        name, number = line.split()
        if line.startswith(" "):
            fields[name] = int(number)
        else:
            fields: dict[str, int] = {}
            layout["".join(word.capitalize() for word in name.split("_")[1:])] = (int(number), fields)
    assert len(layout) > 15
    for name, (size, fields) in layout.items():
        struct = getattr(_structs, name)
        assert ctypes.sizeof(struct) == size, name
        assert {field: getattr(struct, field).offset for field, *_ in struct._fields_} == fields, name


def constants(prefix: str) -> dict[str, int]:
    header = (ROOT / "include/cylfuse/cylfuse.h").read_text()
    return {name: int(value) for name, value in re.findall(rf"#define CYLFUSE_{prefix}_(\w+) (-?\d+)$", header, re.M)}


@pytest.mark.parametrize("name", [name for name in enums.__all__])
def test_choices_are_those_of_the_header(name: str) -> None:
    kind = getattr(enums, name)
    expected = constants(re.sub(r"(?<!^)([A-Z])", r"_\1", name).upper())
    if name == "ResultFlags":
        expected["NONE"] = 0
    assert {choice.name: choice.value for choice in kind.__members__.values()} == expected


def test_every_status_that_a_call_can_return_has_its_exception() -> None:
    statuses = constants("STATUS")
    # These cannot happen: the binding passes no NULL, knows the sizes and gives large enough buffers.
    impossible = {"OK", "NULL_POINTER", "STRUCT_SIZE", "ABI_MISMATCH", "BUFFER_TOO_SMALL", "PANIC"}
    kinds = {errors.from_status(statuses[name], "").__class__ for name in set(statuses) - impossible}
    assert len(kinds) == len(statuses) - len(impossible)
    assert cylfuse.DefectError not in kinds
    assert errors.from_status(-99, "text").name == "PANIC"
    assert errors.from_status(-1, "text").name == "INVALID_ARGUMENT"


def test_defaults_are_those_of_the_library() -> None:
    with cylfuse.Fitter() as fitter:
        assert fitter.options == cylfuse.Options()


def test_version() -> None:
    major, minor, patch = (int(x) for x in cylfuse.version().split("."))
    assert cylfuse.version_number() == major << 16 | minor << 8 | patch
    assert cylfuse.version() in cylfuse.build_info()


def test_a_library_that_is_not_there_is_said() -> None:
    code = "import cylfuse"
    environment = {**os.environ, "CYLFUSE_LIBRARY": "/nowhere/libcylfuse.so"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert run.returncode != 0 and "/nowhere/libcylfuse.so" in run.stderr


def test_the_types_hold() -> None:
    pytest.importorskip("mypy")
    folder = ROOT / "bindings/python"
    command = [sys.executable, "-m", "mypy", "--cache-dir", os.devnull]
    checked = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
