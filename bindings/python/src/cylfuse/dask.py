"""Fits on many machines with Dask: frames in, rows out.

Dask and not Ray: frames that do not know of each other are all there is to share out, for which ``Client.map`` is the
whole program. It is pure Python, a worker needs nothing but this package and the loader, it is what job queues and
Kubernetes have ready-made clusters for, and a frame whose worker died is given to another one. Ray would add its object
store and actors, which nothing here would use.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Callable, Iterable, Mapping, Optional

from distributed import Client

from .fit import fit
from .options import Options


def fit_row(frame: Any, load: Callable[[Any], Mapping[str, Any]], options: Options) -> dict[str, Any]:
    """One frame as a row; whatever goes wrong with it is in the row too."""
    try:
        row = fit(**{"options": options, **load(frame)}).row()
    except Exception as error:
        return _failed(frame, error)
    return {"frame": frame, "error": None, **row}


def _failed(frame: Any, error: Any) -> dict[str, Any]:
    return {"frame": frame, "error": f"{type(error).__name__}: {error}"}


def fit_frames(
    client: Client,
    frames: Iterable[Any],
    load: Callable[[Any], Mapping[str, Any]],
    options: Optional[Options] = None,
) -> list[dict[str, Any]]:
    """Fits every frame on the workers of a cluster and returns one row each, in order: a list for
    ``pandas.DataFrame``.

    :param client: connected to the cluster
    :param frames: what names a frame, such as its path; small, for it travels
    :param load: makes the arguments of :func:`cylfuse.fit` from it, on the worker
    :param options: settings of all frames
    :returns: rows with ``frame``, ``error`` (None, or kind and text) and, without an error, those of
        :meth:`Result.row`
    """
    single = dataclasses.replace(options or Options(), max_threads=1)
    named = list(frames)
    # Not pure: two equal frames are two rows.
    futures = client.map(fit_row, named, load=load, options=single, pure=False)
    rows: Any = client.gather(dict(enumerate(futures)), errors="skip")
    # A frame that killed its workers has no row of its own.
    return [
        rows.get(number) or _failed(frame, futures[number].exception()) for number, frame in enumerate(named)
    ]
