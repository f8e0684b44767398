"""Points in all the shapes in which Python has them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from ._crs import crs_text
from ._gable import Feed
from .errors import InputError

#: So many points are handed over at a time: what must be converted is copied piece by piece.
_CHUNK = 1 << 18
#: What messages call points that come without a file.
NAME = "points"
#: Flags of a point, as in LAS 1.4 R15, table 16.
_FLAGS = {"synthetic": 0x01, "withheld": 0x04, "overlap": 0x08}
_SHAPES = (
    "a path or a list of paths, a laspy.LasData, structured arrays of PDAL, or the columns x, y, z and classification "
    "as a dict or a tuple of arrays"
)

Columns: TypeAlias = Mapping[str, Any]


def is_path(value: Any) -> bool:
    """Whether it names a file."""
    return isinstance(value, (str, os.PathLike))


def paths(values: Any) -> list[str]:
    """One path or several, as text."""
    if is_path(values):
        values = [values]
    elif not isinstance(values, Sequence) or not all(map(is_path, values)):
        raise TypeError(f"found {_describe(values)}, expected a path or a list of paths")
    return [os.fspath(path) for path in values]


class Points:
    """Either the names of tiles or a feed of points, and the CRS of the latter if it is known."""

    def __init__(self, points: Any) -> None:
        self.tiles: list[str] = []
        self.feed: Feed | None = None
        self.crs: str | None = None
        if is_path(points) or (isinstance(points, Sequence) and points and all(map(is_path, points))):
            self.tiles = paths(points)
            return
        clouds = [_columns(cloud) for cloud in _clouds(points)]
        if _is_laspy(points):
            self.crs = crs_text(points.header.parse_crs())
        self.feed = Feed(NAME)
        for cloud in clouds:
            for chunk in _chunks(cloud):
                self.feed.push(*chunk)


def _is_laspy(points: Any) -> bool:
    return all(hasattr(points, name) for name in ("header", "x", "y", "z", "classification"))


def _clouds(points: Any) -> list[Any]:
    """The clouds that are given: PDAL has a list of arrays, one for each view."""
    is_list = isinstance(points, list) and bool(points)
    if is_list and all(isinstance(cloud, np.ndarray) and cloud.dtype.names for cloud in points):
        return list(points)
    return [points]


def _columns(points: Any) -> Columns:
    """Columns by names in small letters and without ``_``."""
    if _is_laspy(points):
        wanted = ["x", "y", "z", "classification", "return_number", *_FLAGS]
        there = set(points.point_format.dimension_names) | {"x", "y", "z"}
        columns: Mapping[Any, Any] = {name: getattr(points, name) for name in wanted if name in there}
    elif isinstance(points, np.ndarray) and points.dtype.names:
        columns = {name: points[name] for name in points.dtype.names}
    elif isinstance(points, Mapping):
        columns = points
    elif hasattr(points, "columns") and hasattr(points, "iloc"):
        columns = {name: points[name].to_numpy() for name in points.columns}
    elif isinstance(points, (tuple, list)) and len(points) in (3, 4) and not any(map(is_path, points)):
        columns = dict(zip(("x", "y", "z", "classification"), points))
    else:
        raise TypeError(f"points are {_describe(points)}: give {_SHAPES}")
    # Of names that are one, such as X and x, the first counts.
    found: dict[str, Any] = {}
    for name, column in columns.items():
        found.setdefault(str(name).lower().replace("_", ""), column)
    missing = [name for name in ("x", "y", "z") if name not in found]
    if missing:
        names = ", ".join(map(str, columns)) or "none"
        raise InputError.of(NAME, f"the columns {names}", f"also {', '.join(missing)}")
    return found


def _describe(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} of shape {value.shape}"
    return f"a {type(value).__name__}"


def _chunks(columns: Columns) -> Iterator[tuple[Any, ...]]:
    """Contiguous pieces of all columns in the types that the feed takes; columns that have them are not copied."""
    count = len(columns["x"])
    lengths = {name: len(columns[name]) for name in ("x", "y", "z", "classification") if name in columns}
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{length} of {name}" for name, length in lengths.items())
        raise InputError.of(NAME, f"columns of different lengths ({found})", "columns of one length")
    for start in range(0, count, _CHUNK):
        end = min(start + _CHUNK, count)

        def piece(name: str, dtype: type, start: int = start, end: int = end) -> Any:
            values = np.asarray(columns[name][start:end])
            if values.ndim != 1:
                raise InputError.of(NAME, f"{values.ndim} dimensions", "one", place=f"column {name}")
            if dtype is np.uint8 and values.dtype != np.uint8:
                values = _bytes(values, name, start)
            return np.ascontiguousarray(np.require(values, dtype, "A"))

        def maybe(name: str) -> Any:
            return piece(name, np.uint8) if name in columns else None

        classes = maybe("classification")
        if classes is None:
            classes = np.zeros(end - start, np.uint8)
        yield (
            piece("x", np.float64),
            piece("y", np.float64),
            piece("z", np.float64),
            classes,
            maybe("returnnumber"),
            _flags(columns, maybe),
        )


def _bytes(values: Any, name: str, start: int) -> Any:
    """Whole numbers from 0 to 255, whatever their type."""
    whole = values.astype(np.uint8)
    wrong = np.flatnonzero(whole != values)
    if wrong.size:
        place = f"point {start + int(wrong[0])}"
        raise InputError.of(NAME, f"{name} = {values[wrong[0]]}", "a whole number from 0 to 255", place=place)
    return whole


def _flags(columns: Columns, maybe: Any) -> Any:
    """The flags of all points in one byte each; ``None`` where no column has any."""
    together = None
    if "classflags" in columns:
        together = maybe("classflags") & np.uint8(sum(_FLAGS.values()))
    for name, bit in _FLAGS.items():
        if name in columns:
            own = (maybe(name) != 0) * np.uint8(bit)
            together = own if together is None else together | own
    return together
