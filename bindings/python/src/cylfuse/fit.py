"""Single calls: one frame or cloud in, one result out; and many of them at once."""

from __future__ import annotations

import collections
import dataclasses
import itertools
import os
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Callable, Deque, Iterable, Iterator, Mapping, Optional, Sized, Union

import numpy as np
import numpy.typing as npt

from ._arrays import Array, depth_pixels
from ._check import instance, whole
from .errors import CylfuseError
from .fitter import Fitter
from .geometry import Intrinsics, Pose
from .options import Options
from .result import Result


def fit(
    *,
    depth: Array,
    intrinsics: Intrinsics | npt.ArrayLike,
    mask: Optional[Array] = None,
    image: Optional[Array] = None,
    edges: Optional[npt.ArrayLike] = None,
    depth_scale: Optional[float] = None,
    min_depth: float = 0.0,
    max_depth: Optional[float] = None,
    image_gamma: float = 1.0,
    image_bgr: bool = False,
    depth_camera: Optional[Intrinsics] = None,
    depth_pose: Pose | npt.ArrayLike = Pose(),
    options: Optional[Options] = None,
) -> Result:
    """Fits the cylinder in a frame. For several views see :class:`Fitter`.

    :param depth: rows x columns of uint16 or float32 (float64 is converted), z = value * ``depth_scale``; 0, and
        65535 of uint16, = not measured
    :param depth_scale: the length of one unit of depth: 0.001 for millimetres where lengths are to be metres; 1 for float
        depth where it is left out, and needed for uint16
    :param intrinsics: the camera: :class:`Intrinsics`, or the 3 x 3 camera matrix of a pinhole
    :param mask: rows x columns of bool or uint8: the cylinder, give or take some pixels: its lateral surface alone, or
        the whole object with caps, lids and handles, which the fit leaves out by the depth. None = every measured pixel:
        the fit then searches them for a cylinder and takes the one with most of them
    :param image: rows x columns of uint8, uint16 or float32, or in colour rows x columns x 3 or 4 of uint8: the image,
        in which the limbs are located
    :param edges: N x 4 (x1, y1, x2, y2): segments on the two limbs in pixels
    :param min_depth: the nearest depth that becomes a point; the extent is found with all depths
    :param max_depth: the farthest depth that becomes a point
    :param image_gamma: light is the value of the image to this power: 2.2 for sRGB, in which cameras and image files
        usually come
    :param image_bgr: the first channel is blue, as OpenCV reads files, and not red
    :param depth_camera: the camera of the depth, when that is not registered to the image; ``mask``, ``image`` and
        ``edges`` are in the pixels of ``intrinsics``
    :param depth_pose: the motion from the depth camera to that of ``intrinsics``
    :param options: settings other than the defaults
    :raises DataError: the data do not determine a cylinder
    """
    if not isinstance(intrinsics, Intrinsics):
        of_image = [given for given in (image, mask) if isinstance(given, np.ndarray)]
        height, width = (of_image[0] if depth_camera and of_image else depth_pixels(depth)).shape[:2]
        intrinsics = Intrinsics.from_matrix(intrinsics, width, height)
    fitter = Fitter(intrinsics, options)
    if depth_camera is not None:
        fitter.set_depth_camera(depth_camera, depth_pose)
    fitter.push_depth(depth, mask, depth_scale, min_depth, max_depth)
    if image is not None:
        fitter.push_image(image, image_gamma, bgr=image_bgr)
    if edges is not None:
        fitter.push_edges(edges)
    return fitter.fit()


def fit_points(
    points: npt.ArrayLike,
    weights: Optional[npt.ArrayLike] = None,
    normals: Optional[npt.ArrayLike] = None,
    *,
    mask: Optional[Array] = None,
    edges: Optional[npt.ArrayLike] = None,
    intrinsics: Optional[Intrinsics] = None,
    options: Optional[Options] = None,
) -> Result:
    """Fits a cylinder to a cloud, N x 3 or rows x columns x 3, in any frame; in the camera frame with edges."""
    fitter = Fitter(intrinsics, options)
    fitter.push_points(points, weights, normals, mask)
    if edges is not None:
        fitter.push_edges(edges)
    return fitter.fit()


#: The arguments of :func:`fit` for a frame, or a function that returns them.
Arguments = Union[Mapping[str, Any], Callable[[], Mapping[str, Any]]]
Outcome = Union[Result, CylfuseError]


def fit_many(
    frames: Iterable[Arguments],
    *,
    options: Optional[Options] = None,
    threads: Optional[int] = None,
    progress: bool = False,
) -> Iterator[Outcome]:
    """Fits frames in threads and yields their outcomes in order: a result, or the :class:`CylfuseError` that
    :func:`fit` raised. Any other exception, of ``frames`` or of a frame, comes out once the outcomes before it are
    out.

    Only a few frames per thread are held at a time, so an endless iterable works. The results have their extents but
    not the data: ``residuals()``, ``complete()`` and so on need those of :func:`fit`.

    :param frames: the arguments of :func:`fit` for each frame, or functions that return them, such as
        ``functools.partial(load, path)``, which then run in the threads too
    :param options: settings of all frames
    :param threads: fits at once, by default one a processor; each fit itself takes one thread
    :param progress: shows a bar; needs the package tqdm
    """
    single = dataclasses.replace(instance("options", options or Options(), Options), max_threads=1)
    count = os.cpu_count() or 1 if threads is None else whole("threads", threads, 1, 2**16)
    outcomes = _in_order(iter(frames), single, count)
    if progress:
        from tqdm.auto import tqdm

        total = len(frames) if isinstance(frames, Sized) else None
        return iter(tqdm(outcomes, total=total, unit="frame"))
    return outcomes


def _outcome(frame: Arguments, options: Options) -> Outcome:
    try:
        return fit(**{"options": options, **(frame() if callable(frame) else frame)})._let_go()
    except CylfuseError as error:
        # The traceback would keep the data of the frame.
        return error.with_traceback(None)


def _in_order(frames: Iterator[Arguments], options: Options, threads: int) -> Iterator[Outcome]:
    waiting: Deque[Future[Outcome]] = collections.deque()
    failure: Optional[Exception] = None
    with ThreadPoolExecutor(threads, thread_name_prefix="cylfuse") as pool:
        try:
            while True:
                try:
                    for frame in itertools.islice(frames, 2 * threads - len(waiting)):
                        waiting.append(pool.submit(_outcome, frame, options))
                except Exception as error:
                    frames, failure = iter(()), error
                if waiting:
                    yield waiting.popleft().result()
                elif failure is not None:
                    raise failure
                else:
                    return
        finally:
            for future in waiting:
                future.cancel()
