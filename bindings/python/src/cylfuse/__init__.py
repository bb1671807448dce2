"""Measures a cylinder from RGB-D views by fusing depth with the limb lines in the images.

Lengths are in one unit, which is the caller's; angles are in radians. The camera frame is x to the right, y down, z
forward; pixel centres are at integer coordinates, as in OpenCV.
"""

from . import enums, errors
from ._native import build_info, version, version_number
from .batch import fit_all
from .conformity import decide_conformity
from .detector import Detector
from .enums import *  # noqa: F403
from .errors import *  # noqa: F403
from .fit import fit, fit_many, fit_points
from .fitter import Fitter
from .frame import Frame
from .geometry import Comparison, Cylinder, Intrinsics, Pose
from .options import DetectorOptions, Options
from .planning import Deviations, Expectation, plan
from .questions import EndSamples, Limb, LimbSamples, PointWeights
from .result import (
    Completion, Counts, CylinderDiagnosis, Detection, DetectionProgress, Extent, Progress, Result, View,
)  # fmt: skip

__version__ = version()

__all__ = [
    "Comparison", "Completion", "Counts", "Cylinder", "CylinderDiagnosis", "Detection", "DetectionProgress", "Detector",
    "DetectorOptions", "Deviations", "EndSamples", "Expectation", "Extent", "Fitter", "Frame", "Intrinsics", "Limb",
    "LimbSamples", "Options", "PointWeights", "Pose", "Progress", "Result", "View", "build_info", "decide_conformity",
    "fit", "fit_all", "fit_many", "fit_points", "plan", "version", "version_number",
]  # fmt: skip
__all__ += enums.__all__
__all__ += errors.__all__
