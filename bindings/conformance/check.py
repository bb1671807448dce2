#!/usr/bin/env python3
"""Compares the results of a binding with the committed values and, bit by bit, with those of the C runner.

    check.py RESULTS [C_RESULTS]

Prints what differs and, as its last line, how many cases passed and failed. README.md has the format.
"""
import json
import math
import pathlib
import struct
import sys

RELATIVE = 1e-9
# What counts steps or is what rounding leaves over differs with the mathematical library of the machine; it is
# compared with the C runner only.
BITS_ONLY = {"iterations", "rejected_steps", "lambda", "gradient_norm", "step_norm", "termination"}


def parse(path):
    """{(case, step): {field: text}} of a file of results."""
    results = {}
    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        case, step, field, *rest = line.split("\t")
        fields = results.setdefault((case, int(step)), {})
        if field in fields:
            sys.exit(f"{path}: {case} {step} {field} comes twice")
        fields[field] = "\t".join(rest)
    return results


def number(bits):
    """The number of 16 hexadecimal digits."""
    return math.nan if bits == "nan" else struct.unpack(">d", bytes.fromhex(bits))[0]


def near(values, expected):
    """Whether lists agree to RELATIVE of their largest number."""
    expected = [math.nan if x is None else float(x) for x in expected]
    if len(values) != len(expected):
        return False
    scale = max((abs(x) for x in expected if math.isfinite(x)), default=0.0)
    return all(
        x == y or (math.isnan(x) and math.isnan(y)) or abs(x - y) <= RELATIVE * scale
        for x, y in zip(values, expected)
    )


def differences(step, fields):
    """How the results of a step differ from what is committed."""
    if fields is None:
        yield "no result"
        return
    if "error" in step:
        status = fields.get("error", "success").split("\t")[0]
        if status != step["error"]["status"]:
            yield f"{status} instead of {step['error']['status']}"
        return
    if "error" in fields:
        yield f"fails: {fields['error']}"
        return
    expected = step.get("expect", {})
    if set(fields) - {"ok"} != set(expected):
        yield f"other fields: {sorted(set(fields) - {'ok'} ^ set(expected))}"
        return
    for name, values in expected.items():
        if name not in BITS_ONLY and not near([number(bits) for bits in fields[name].split()], values):
            yield f"{name} is not near the committed value"


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    cases = json.loads(pathlib.Path(__file__).with_name("cases.json").read_text())["cases"]
    results = parse(sys.argv[1])
    same = parse(sys.argv[2]) if len(sys.argv) == 3 else results
    failed = 0
    for case in cases:
        wrong = []
        for index, step in enumerate(case["steps"]):
            fields, of_c = (of.get((case["name"], index)) for of in (results, same))
            found = list(differences(step, fields))
            if not found and fields != of_c:
                names = sorted(name for name in fields if fields[name] != (of_c or {}).get(name))
                found = [f"{name} is not that of the C runner: {fields[name][:200]}" for name in names]
            wrong += [f"{case['name']}, step {index} ({step['call']}): {text}" for text in found]
        if wrong:
            failed += 1
            print("\n".join(wrong))
    print(f"{len(cases) - failed} passed, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
