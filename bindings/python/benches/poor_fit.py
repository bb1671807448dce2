"""How many fits of what is no cylinder are flagged, and how many right ones: benches/poor_fit.py SHARED [SCENES...]

SHARED is the folder with scenes, frames, objects, real and real2; SCENES are more folders of scenes, such as those that
`cylfuse twin` writes. A fit is right where it hits a cylinder of the truth by the rule of SHARED/README.md.
"""

from __future__ import annotations

import collections
import json
import pathlib
import re
import sys
from typing import Any, Iterator

import numpy as np
from PIL import Image

import cylfuse


def pixels(path: pathlib.Path, grey: bool = True) -> Any:
    image = Image.open(path)
    return np.array(image.convert("L") if grey else image)


def arguments(folder: pathlib.Path) -> dict[str, Any]:
    """What cylfuse.fit takes of a frame."""
    frame = json.loads((folder / "frame.json").read_text())
    camera = {name: value for name, value in frame["camera"].items() if name != "distortion_model"}
    return {
        "intrinsics": cylfuse.Intrinsics(**camera),
        "depth": pixels(folder / frame["depth"], grey=False).astype(np.uint16),
        "depth_scale": frame["depth_scale"],
        "image": pixels(folder / frame["image"]),
        "image_gamma": frame.get("image_gamma", 1.0),
        "mask": pixels(folder / frame["mask"]) if frame.get("mask") else None,
        "edges": np.array(frame["edges"], float) if frame.get("edges") else None,
    }


def truths(folder: pathlib.Path) -> list[dict[str, Any]]:
    truth = json.loads((folder / "truth.json").read_text())
    return truth["cylinders"] + truth.get("ignore", []) if "cylinders" in truth else [truth]


def hits(cylinder: cylfuse.Cylinder, truth: dict[str, Any]) -> bool:
    direction = np.asarray(cylinder.direction)
    axis = np.array(truth["axis"]) / np.linalg.norm(truth["axis"])
    offset = np.array(truth["center"]) - np.asarray(cylinder.point)
    across = np.linalg.norm(offset - (offset @ direction) * direction)
    return bool(
        abs(axis @ direction) >= np.cos(np.radians(5.0))
        and across <= 0.5 * truth["radius"]
        and abs(cylinder.radius / truth["radius"] - 1.0) <= 0.15
    )


def masks(folder: pathlib.Path, seed: int) -> Iterator[tuple[str, Any]]:
    """Masks of a scene that hold no cylinder, or more than one."""
    labels = pixels(folder / "labels.png", grey=False)
    chance = np.random.default_rng(seed)
    objects = [label for label in np.unique(labels) if label > 0 and (labels == label).sum() > 600]
    yield "none", None
    yield "every pixel", np.full(labels.shape, True)
    if len(objects) >= 2:
        yield "two objects", np.isin(labels, chance.choice(objects, 2, replace=False))
    height, width = labels.shape
    x, y = chance.integers(0, width // 2), chance.integers(0, height // 2)
    quarter = np.zeros(labels.shape, bool)
    quarter[y : y + height // 2, x : x + width // 2] = True
    yield "a quarter of the image", quarter


def main() -> None:
    shared, more = pathlib.Path(sys.argv[1]), [pathlib.Path(name) for name in sys.argv[2:]]
    counts: dict[str, collections.Counter[str]] = collections.defaultdict(collections.Counter)

    def count(folder: pathlib.Path, kind: str, frame: dict[str, Any]) -> None:
        number = re.search(r"\d+", folder.name)
        of = counts[f"{kind}, {'odd' if number and int(number[0]) % 2 else 'even'}"]
        try:
            result = cylfuse.fit(**frame)
        except cylfuse.DataError:
            of["errors"] += 1
            return
        right = "right" if any(hits(result.cylinder, truth) for truth in truths(folder)) else "wrong"
        of[right] += 1
        of[f"{right} flagged"] += cylfuse.ResultFlags.POOR_FIT in result.flags
        of[f"{right} silent before"] += not result.flags & ~cylfuse.ResultFlags.POOR_FIT
        of[f"{right} silent"] += not result.flags

    for folder in sorted(path.parent for path in shared.glob("**/frame.json")):
        frame = arguments(folder) if folder.parent.name not in ("scenes", "views") else None
        if frame is not None:
            count(folder, "right mask", frame)
            count(folder, "right mask, no image", {**frame, "image": None, "edges": None})
    scenes = [path.parent for top in (shared / "scenes", *more) for path in sorted(top.glob("**/frame.json"))]
    for seed, folder in enumerate(scenes):
        for kind, mask in masks(folder, seed):
            count(folder, kind, {**arguments(folder), "mask": mask})
    for kind, of in counts.items():
        print(kind, dict(of))


if __name__ == "__main__":
    main()
