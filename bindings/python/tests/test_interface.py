"""The declarations against the header, and the golden cases."""

from __future__ import annotations

import ctypes
import importlib.metadata
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import sys
from typing import Any

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
    return {name: int(value) for name, value in re.findall(rf"#define CYLFUSE_{prefix}_(\w+) \(?(-?\d+)\)?$", header, re.M)}


@pytest.mark.parametrize("name", [name for name in enums.__all__])
def test_choices_are_those_of_the_header(name: str) -> None:
    kind = getattr(enums, name)
    expected = constants(re.sub(r"(?<!^)([A-Z])", r"_\1", name).upper())
    if name == "ResultFlags":
        expected["NONE"] = 0
    assert {choice.name: choice.value for choice in kind.__members__.values()} == expected


DESCRIBED = [
    enums.Termination, enums.Start, enums.EndState, enums.EndSource, enums.LimbStatus, enums.Part, enums.Conformity,
]


@pytest.mark.parametrize("kind", DESCRIBED)
def test_constants_are_described(kind: Any) -> None:
    for choice in kind:
        name, text = choice.description.split(": ")
        assert name == choice.name and len(text) > 5


def test_flags_are_described_one_by_one() -> None:
    flags = enums.ResultFlags.POOR_FIT | enums.ResultFlags.WEAK_RADIUS
    weak, poor = flags.descriptions
    assert weak.startswith("WEAK_RADIUS: ") and poor.startswith("POOR_FIT: ")
    assert enums.ResultFlags.NONE.descriptions == []
    for flag in enums.ResultFlags:
        assert [text.split(": ")[0] for text in flag.descriptions] == ([flag.name] if flag else [])


def test_constants_print_as_their_names() -> None:
    flags = enums.ResultFlags.POOR_FIT | enums.ResultFlags.WEAK_RADIUS
    assert str(flags) == f"{flags}" == "%s" % flags == "weak_radius, poor_fit"
    assert str(enums.ResultFlags.NONE) == f"{enums.ResultFlags(0)}" == "none"
    assert f"{enums.ResultFlags(1 << 31 | 64)}" == f"weak_radius, {1 << 31}"
    assert f"{enums.EndState.SEEN:>6}{enums.ResultFlags.POOR_FIT:>10}" == "  seen  poor_fit"
    assert f"{enums.EndState.SEEN:d} {flags:#x}" == "1 0x40040"


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
    with cylfuse.Detector() as detector:
        assert detector.options == cylfuse.DetectorOptions() and detector.fit_options == cylfuse.Options()


def test_version() -> None:
    major, minor, patch = (int(x) for x in cylfuse.version().split("."))
    assert cylfuse.version_number() == major << 16 | minor << 8 | patch
    assert cylfuse.version() in cylfuse.build_info()


def import_with(library: pathlib.Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "CYLFUSE_LIBRARY": str(library)}
    command = [sys.executable, "-c", "import cylfuse; print(cylfuse.version())"]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


def test_a_library_that_cannot_be_used_is_said(tmp_path: pathlib.Path) -> None:
    text = tmp_path / "text.so"
    text.write_text("no library")
    cases = {
        tmp_path / "nowhere.so": "nowhere.so could not be loaded as the library of cylfuse",
        text: "set it to the path of the shared library",
    }
    if shutil.which("cc"):
        versions = {"other": (0, "other.so could not be loaded as the library of cylfuse"),
                    "later": (7, "later.so has version 7 of the binary interface but this package needs 1"),
                    "older": (1, "older.so has no function cylfuse_version_number: it is older than")}  # fmt: skip
        for name, (version, expected) in versions.items():
            source, library = tmp_path / f"{name}.c", tmp_path / f"{name}.so"
            source.write_text(f"unsigned {'cylfuse_abi_version' if version else 'other'}(void) {{ return {version}; }}\n")
            subprocess.run(["cc", "-shared", "-fPIC", source, "-o", library], check=True)
            cases[library] = expected
    for library, expected in cases.items():
        run = import_with(library)
        assert run.returncode != 0 and "ImportError: " in run.stderr and expected in run.stderr, run.stderr


def test_a_library_in_a_folder_with_any_name(tmp_path: pathlib.Path) -> None:
    library = tmp_path / "a folder, größer" / "the library.so"
    library.parent.mkdir()
    shutil.copy(_native.library_path(), library)
    run = import_with(library)
    assert run.stdout.strip() == cylfuse.version(), run.stderr


def test_no_warning_in_a_whole_program() -> None:
    readme = (ROOT / "bindings/python/README.md").read_text()
    code = readme.split("```python\n")[1].split("```")[0]
    run = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True)
    assert run.returncode == 0 and run.stdout == "radius 0.500000\n" and run.stderr == "", run.stderr


@pytest.mark.parametrize("options", [[], ["--strict"]], ids=["package", "program"])
def test_the_types_hold(options: list[str]) -> None:
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--cache-dir", os.devnull, *options]
    if options:
        command += ["--config-file", os.devnull, pathlib.Path(__file__).with_name("typed_program.py")]
    checked = subprocess.run(command, cwd=ROOT / "bindings/python", capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout


def test_everything_public_is_documented() -> None:
    for name in cylfuse.__all__:
        item = getattr(cylfuse, name)
        assert inspect.getdoc(item), name
        if inspect.isclass(item) and not issubclass(item, tuple):
            for part, value in vars(item).items():
                if not part.startswith("_") and (inspect.isroutine(value) or isinstance(value, property)):
                    assert inspect.getdoc(value), f"{name}.{part}"


def test_results_have_the_fields_of_their_structs() -> None:
    kinds = {cylfuse.Result: [_structs.Result, _structs.CylinderEstimate]}
    for kind in (cylfuse.Counts, cylfuse.Extent, cylfuse.CylinderDiagnosis, cylfuse.Completion, cylfuse.Progress,
                 cylfuse.DetectionProgress):  # fmt: skip
        kinds[kind] = [getattr(_structs, kind.__name__)]
    for kind, structs in kinds.items():
        fields = [name for struct in structs for name, *_ in struct._fields_ if name != "struct_size"]
        declared = ["lambda" if name == "damping" else name for name in kind.__annotations__ if name[0] != "_"]
        assert declared == fields
    for kind in (cylfuse.Limb, cylfuse.LimbSamples, cylfuse.EndSamples):
        struct = getattr(_structs, kind.__name__.removesuffix("s"))
        assert list(kind._fields) == [name for name, _ in struct._fields_]


def test_the_package_holds_what_it_should() -> None:
    files = {str(file) for file in importlib.metadata.files("cylfuse") or []}
    if not any(file.endswith("_native.py") for file in files):
        pytest.skip("the package is installed from its folder")
    assert "cylfuse/py.typed" in files
    for name in ("LICENSE-APACHE", "LICENSE-MIT"):
        assert any(file.endswith(name) for file in files), name
    wheel = importlib.metadata.distribution("cylfuse").read_text("WHEEL") or ""
    assert "Root-Is-Purelib: false" in wheel and re.search(r"^Tag: py3-none-(?!any)", wheel, re.MULTILINE), wheel
