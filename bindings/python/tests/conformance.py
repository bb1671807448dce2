"""Runs the golden cases of bindings/conformance and prints the results as bits: conformance.py > results.txt"""

from __future__ import annotations

import base64
import dataclasses
import json
import math
import pathlib
import struct
import sys
from typing import Any, Iterator

import numpy as np

import cylfuse
from cylfuse import _structs

CASES = pathlib.Path(__file__).resolve().parents[2] / "conformance/cases.json"
TYPES = {"u8": "<u1", "u16": "<u2", "f32": "<f4", "f64": "<f8"}
# Fields of a result that are times, and those that are models.
SECONDS = {"seconds_start", "seconds_solve", "seconds_total"}


def number(value: Any) -> float:
    return math.nan if value is None else value


class Runner:
    def __init__(self, file: dict[str, Any]) -> None:
        self.file = file
        self.fitter = cylfuse.Fitter()
        self.frame = cylfuse.Frame()
        self.detector = cylfuse.Detector()

    def array(self, name: str | None) -> Any:
        if name is None:
            return None
        array = self.file["arrays"][name]
        return np.frombuffer(base64.b64decode(array["data"]), TYPES[array["type"]]).reshape(array["shape"])

    def columns(self, given: dict[str, Any] | None, count: int) -> Any:
        if given is None:
            return None
        first = given.get("column", 0)
        columns = self.array(given["array"])[..., first : first + count]
        return columns if count > 1 else columns[..., 0]

    def camera(self, name: str) -> cylfuse.Intrinsics:
        return cylfuse.Intrinsics(**{key: number(value) if key != "distortion" else value
                                     for key, value in self.file["cameras"][name].items()})

    @staticmethod
    def model(given: dict[str, Any] | None) -> cylfuse.Cylinder | None:
        return None if given is None else cylfuse.Cylinder(**given)

    def run(self, step: dict[str, Any]) -> dict[str, Any]:
        fitter, call, model, mask = self.fitter, step["call"], self.model(step.get("model")), None
        if step.get("mask"):
            mask = self.array(step["mask"])
        label = {"label": step["label"]} if "label" in step else {}
        if call == "new_fitter":
            self.fitter.close()
            self.fitter = cylfuse.Fitter()
        elif call == "new_frame":
            self.frame.close()
            self.frame = cylfuse.Frame()
        elif call.startswith("frame_set_"):
            self.set_frame(call.removeprefix("frame_set_"), step)
        elif call == "use_frame":
            fitter.use_frame(self.frame, mask, **label)
        elif call == "select_view":
            fitter.select_view(step["index"])
        elif call == "view_count":
            return {"count": fitter.view_count}
        elif call == "set_pose":
            fitter.set_pose(self.pose(step))
        elif call == "set_depth_camera":
            fitter.set_depth_camera(*self.depth_camera(step))
        elif call == "clear_input":
            fitter.clear_input(*step["inputs"])
        elif call == "set_options":
            fitter.options = cylfuse.Options(**{k: number(v) for k, v in step["options"].items()})
        elif call == "get_options":
            return {name: getattr(fitter.options, name) for name in fitter.options.__dataclass_fields__}
        elif call == "set_intrinsics":
            fitter.intrinsics = self.camera(step["camera"])
        elif call == "set_start_model":
            fitter.set_start_model(model)
        elif call == "reserve":
            fitter.reserve(step["points"], step["segments"])
        elif call in ("clear", "cancel"):
            getattr(fitter, call)()
        elif call == "push_points":
            fitter.push_points(*self.cloud(step["points"]), mask)
        elif call == "push_depth":
            fitter.push_depth(self.array(step["depth"]), mask, **self.range(step), **label)
        elif call == "push_image":
            fitter.push_image(self.array(step["image"]), **self.colors(step))
        elif call == "push_edges":
            fitter.push_edges(self.segments(step), step.get("weights"))
        elif call == "select_edges":
            return {"selected": fitter.select_edges(self.segments(step), step.get("reach", 0.0), model)}
        elif call == "counts":
            return fitter.counts.to_dict()
        elif call == "fit":
            return self.result(fitter.fit())
        elif call in ("get_result", "get_cylinder"):
            return self.part(fitter.result, call == "get_result")
        elif call == "evaluate":
            return self.result(fitter.evaluate(model))
        elif call == "residuals":
            return {"residuals": fitter.residuals(step["kind"], model)}
        elif call == "point_parts":
            return {"parts": fitter.point_parts(model)}
        elif call == "limbs":
            limbs = fitter.limbs()
            return {name: [getattr(limb, name) for limb in limbs] for name in cylfuse.Limb._fields}
        elif call in ("limb_samples", "point_weights"):
            return getattr(fitter, call)()._asdict()
        elif call == "end_samples":
            return fitter.end_samples(model, mask)._asdict()
        elif call == "diagnose":
            return fitter.diagnose(model).to_dict()
        elif call == "complete":
            dtype = np.float32 if step["scalar"] == "F32" else np.float64
            completion = fitter.complete(step["layout"], dtype, model, mask)
            return {**completion.to_dict(), "points": completion.array}
        elif call == "complete_depth":
            dtype = np.uint16 if step["format"] == "U16" else np.float32
            completion = fitter.complete_depth(dtype, step["scale"], model, mask)
            return {**completion.to_dict(), "depth": completion.array}
        elif call == "extent":
            return fitter.extent(model, mask).to_dict()
        elif call == "distances":
            return {"distances": model.distances(self.columns(step["points"], 3))}
        elif call == "project":
            return {"lines": model.project(self.camera(step["camera"]))}
        elif call == "intrinsics_project":
            return {"pixels": self.camera(step["camera"]).project(self.columns(step["points"], 3))}
        elif call == "intrinsics_unproject":
            pixels = [[number(x) for x in pixel] for pixel in step["pixels"]]
            return {"rays": self.camera(step["camera"]).unproject(pixels)}
        elif call == "compare":
            return self.model(step["a"]).compare(self.model(step["b"]))._asdict()
        else:
            return self.run_detector(call, step)
        return {}

    def run_detector(self, call: str, step: dict[str, Any]) -> dict[str, Any]:
        detector = self.detector
        if call == "detector_set_options":
            detector.options = cylfuse.DetectorOptions(**step["options"])
        elif call == "detector_get_options":
            return dataclasses.asdict(detector.options)
        elif call == "detector_set_fit_options":
            detector.fit_options = cylfuse.Options(**step["options"])
        elif call == "detector_get_fit_options":
            return dataclasses.asdict(detector.fit_options)
        elif call == "detector_cancel":
            detector.cancel()
        elif call == "new_detector":
            detector.close()
            self.detector = cylfuse.Detector()
        elif call == "detect":
            detector.detect(self.frame)
        elif call == "detect_points":
            detector.detect_points(*self.cloud(step["points"]))
        elif call == "detector_count":
            return {"count": len(detector.detections)}
        elif call == "detector_detections":
            return self.detections(detector.detections)
        elif call in ("detector_get_result", "detector_get_cylinder"):
            return self.part(self.detected(step).result, call == "detector_get_result")
        elif call == "detector_get_extent":
            return self.detected(step).result.extent.to_dict()
        elif call == "detector_labels":
            return {"labels": detector.labels}
        elif call == "detector_indices":
            return {"indices": detector.indices(step["index"])}
        elif call == "detector_make_fitter":
            fitter = detector.fitter(step["index"])
            self.fitter.close()
            self.fitter = fitter
        else:
            raise ValueError(f"unknown call {call}")
        return {}

    def detected(self, step: dict[str, Any]) -> cylfuse.Detection:
        # The list knows no such error as the library.
        self.detector.indices(step["index"])
        return self.detector.detections[step["index"]]

    @staticmethod
    def detections(found: list[cylfuse.Detection]) -> dict[str, Any]:
        fields = {name: [getattr(one, name) for one in found] for name in ("score", "pixels")}
        for part in ("point", "direction", "radius"):
            fields[f"model.{part}"] = [getattr(one.cylinder, part) for one in found]
        return fields

    def cloud(self, points: dict[str, Any]) -> tuple[Any, ...]:
        weights, normals = self.columns(points.get("weights"), 1), self.columns(points.get("normals"), 3)
        return self.columns(points, 3), weights, normals

    def set_frame(self, what: str, step: dict[str, Any]) -> None:
        frame = self.frame
        if what == "intrinsics":
            frame.intrinsics = self.camera(step["camera"])
        elif what == "pose":
            frame.set_pose(self.pose(step))
        elif what == "depth_camera":
            frame.set_depth_camera(*self.depth_camera(step))
        elif what == "depth":
            frame.set_depth(self.array(step["depth"]), **self.range(step))
        else:
            frame.set_image(self.array(step["image"]), **self.colors(step))

    @staticmethod
    def pose(step: dict[str, Any]) -> cylfuse.Pose:
        numbers = [number(x) for x in step["pose"]["rotation"]], [number(x) for x in step["pose"]["translation"]]
        return cylfuse.Pose(np.reshape(numbers[0], (3, 3)), numbers[1])

    def depth_camera(self, step: dict[str, Any]) -> tuple[Any, ...]:
        return (None,) if step["camera"] is None else (self.camera(step["camera"]), self.pose(step))

    @staticmethod
    def range(step: dict[str, Any]) -> dict[str, float]:
        return {name: step[name] for name in ("scale", "min_depth", "max_depth") if name in step}

    @staticmethod
    def colors(step: dict[str, Any]) -> dict[str, Any]:
        return {"gamma": step.get("gamma", 1.0), "bgr": step.get("format", "").startswith("BGR")}

    @staticmethod
    def segments(step: dict[str, Any]) -> list[list[float]]:
        return [[number(x) for x in segment] for segment in step["segments"]]

    @staticmethod
    def result(result: cylfuse.Result) -> dict[str, Any]:
        fields: dict[str, Any] = {}
        for name, value in result.to_dict().items():
            if isinstance(value, cylfuse.Cylinder):
                for part in ("point", "direction", "radius"):
                    fields[f"{name}.{part}"] = getattr(value, part)
            elif name not in SECONDS:
                fields["lambda" if name == "damping" else name] = value
        return fields

    @classmethod
    def part(cls, result: cylfuse.Result, of_result: bool) -> dict[str, Any]:
        """One of the two structs of C that a result is made of."""
        names = {"lambda", *(name for name, _ in _structs.Result._fields_)}
        return {name: value for name, value in cls.result(result).items() if (name in names) == of_result}


def bits(value: float) -> str:
    return "nan" if math.isnan(value) else struct.pack(">d", value).hex()


def lines() -> Iterator[str]:
    """The results of all cases."""
    file = json.loads(CASES.read_text())
    for case in file["cases"]:
        runner = Runner(file)
        for index, step in enumerate(case["steps"]):
            start = f"{case['name']}\t{index}"
            try:
                fields = runner.run(step)
            except cylfuse.CylfuseError as error:
                yield f"{start}\terror\t{error.name}\t{error.message}"
                continue
            yield f"{start}\tok"
            for name, value in fields.items():
                yield f"{start}\t{name}\t{' '.join(bits(float(x)) for x in np.ravel(value))}"
        runner.fitter.close()
        runner.detector.close()


if __name__ == "__main__":
    sys.stdout.writelines(f"{line}\n" for line in lines())
