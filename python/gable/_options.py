"""Options of the command line as arguments."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any


def options_text(options: Mapping[str, Any]) -> str:
    """Options as JSON under the names of the command line: ``ring_width`` is ``--ring-width``. One ``_`` at the end is
    nothing, so that ``lambda_`` can be given."""
    named = {name.removesuffix("_").replace("_", "-"): value for name, value in options.items()}
    return json.dumps(named, default=_plain)


def _plain(value: Any) -> Any:
    """What JSON does not know: paths, and the numbers and arrays of NumPy."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (set, frozenset, range)):
        return sorted(value)
    return str(value)
