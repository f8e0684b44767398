"""Footprints in all the shapes in which Python has them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from ._crs import crs_text
from ._points import is_path
from ._scratch import Scratch


class Footprints:
    """A file of footprints, and their CRS where the file does not tell."""

    def __init__(self, footprints: Any, scratch: Scratch) -> None:
        self.crs: str | None = None
        if is_path(footprints) and not (isinstance(footprints, str) and footprints.lstrip().startswith("{")):
            self.path = os.fspath(footprints)
            return
        self.path = scratch.file("footprints.geojson")
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(self._geojson(footprints))

    def _geojson(self, footprints: Any) -> str:
        if isinstance(footprints, str):
            return footprints
        if isinstance(footprints, Mapping):
            return json.dumps(footprints, default=str)
        if hasattr(footprints, "to_json") and hasattr(footprints, "total_bounds"):
            self.crs = crs_text(footprints.crs)
            has_named_index = hasattr(footprints, "columns") and footprints.index.name is not None
            if has_named_index and footprints.index.name not in footprints.columns:
                # It is often the id of the building.
                footprints = footprints.reset_index()
            options = {"drop_id": True} if hasattr(footprints, "columns") else {}
            return str(footprints.to_json(default=str, **options))
        if hasattr(footprints, "__geo_interface__"):
            return json.dumps(footprints.__geo_interface__, default=str)
        raise TypeError(
            f"footprints are a {type(footprints).__name__}: give a path, a GeoDataFrame, or GeoJSON as a dict or a text"
        )
