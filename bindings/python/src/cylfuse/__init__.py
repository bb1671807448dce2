"""Measures a cylinder from one RGB-D view by fusing depth with the limb lines in the image.

Lengths are in one unit, which is the caller's; angles are in radians. The camera frame is x to the right, y down, z
forward; pixel centres are at integer coordinates, as in OpenCV.
"""

from . import enums, errors
from ._native import build_info, version, version_number
from .enums import *  # noqa: F403
from .errors import *  # noqa: F403
from .fit import fit, fit_many, fit_points
from .fitter import Fitter, LimbSamples
from .geometry import Comparison, Cylinder, Intrinsics
from .options import Options
from .result import Completion, Counts, Diagnosis, Extent, Progress, Result

__version__ = version()

__all__ = [
    "Comparison", "Completion", "Counts", "Cylinder", "Diagnosis", "Extent", "Fitter", "Intrinsics", "LimbSamples",
    "Options", "Progress", "Result", "build_info", "fit", "fit_many", "fit_points", "version", "version_number",
]  # fmt: skip
__all__ += enums.__all__
__all__ += errors.__all__
