"""Coordinate reference systems as text."""

from __future__ import annotations

from typing import Any


def crs_text(crs: Any) -> str | None:
    """What gable takes for a CRS: a code, WKT or PROJJSON.

    ``crs`` may be such a text, an EPSG code as a number, or a ``pyproj.CRS``.
    """
    if crs is None or isinstance(crs, str):
        return crs
    if hasattr(crs, "to_wkt"):
        authority = crs.to_authority(min_confidence=100) if hasattr(crs, "to_authority") else None
        return ":".join(authority) if authority else crs.to_wkt()
    try:
        return f"EPSG:{int(crs)}"
    except (TypeError, ValueError):
        raise TypeError(f"crs is a {type(crs).__name__}: give a text, an EPSG code or a pyproj.CRS") from None
