"""What the tests share: the frames of tests/data."""

from __future__ import annotations

import json
import pathlib
from typing import Any

import numpy as np
import pytest
from PIL import Image

import cylfuse

ROOT = pathlib.Path(__file__).resolve().parents[3]
FRAMES = ROOT / "tests/data/frames"


def load(folder: pathlib.Path) -> dict[str, Any]:
    """The arguments of cylfuse.fit for a frame on the disk."""
    frame = json.loads((folder / "frame.json").read_text())
    camera = dict(frame["camera"])
    if any(camera["distortion"]):
        camera["distortion_model"] = "brown_conrady"

    def picture(key: str) -> Any:
        return np.array(Image.open(folder / frame[key]))

    return {
        "depth": picture("depth").astype(np.uint16),
        "mask": picture("mask"),
        "image": np.array(Image.open(folder / frame["image"]).convert("L")),
        "intrinsics": cylfuse.Intrinsics(**camera),
        "edges": frame["edges"],
        "depth_scale": frame["depth_scale"],
    }


def pipe(count: int = 200) -> Any:
    """A quarter of a pipe of radius 0.5 along y."""
    k = np.arange(count)
    angle = 1.6 * k / count
    return np.c_[0.5 * np.cos(angle), 0.1 * (k % 7), 2.0 - 0.5 * np.sin(angle)]


@pytest.fixture(scope="session")
def frame() -> dict[str, Any]:
    return load(FRAMES / "w004")


@pytest.fixture(scope="session")
def result(frame: dict[str, Any]) -> cylfuse.Result:
    return cylfuse.fit(**frame)
