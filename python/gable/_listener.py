"""From a run to its caller: progress to a bar or a function, warnings to :mod:`warnings`."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from types import TracebackType
from typing import Any, TypeAlias

from .errors import GableWarning

#: Called with the stage, what is done of it, and how much there is to do; 0 where nobody knows.
Callback: TypeAlias = Callable[[str, int, int], object]
#: A bar or none, a function, or by default a bar where tqdm is installed and somebody looks.
Progress: TypeAlias = bool | Callback | None

_PACKAGE = os.path.dirname(os.path.abspath(__file__)) + os.sep


class Listener:
    """Listens while something goes on; a context, which takes the bar away."""

    def __init__(self, progress: Progress = False) -> None:
        self._callback = progress if callable(progress) else None
        self._shows_bars = progress is True or (progress is None and _somebody_looks())
        self._bar: Any = None
        self._stage = ""
        if progress is True:
            _tqdm()

    def progress(self, stage: str, unit: str, done: int, total: int) -> None:
        """So much of a stage is done."""
        if self._callback is not None:
            self._callback(stage, done, total)
        if not self._shows_bars:
            return
        if self._bar is None or stage != self._stage:
            self._close()
            self._stage = stage
            try:
                bar = _tqdm()
            except ImportError:
                self._shows_bars = False
                return
            scaled = unit in ("byte", "point")
            self._bar = bar(total=total or None, desc=stage, unit=f" {unit}s", unit_scale=scaled, leave=False)
        self._bar.update(done - self._bar.n)

    def warning(self, text: str) -> None:
        """Something that stops nothing; told where the caller of this package stands."""
        level = 1
        frame = sys._getframe()
        while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
            frame = frame.f_back
            level += 1
        warnings.warn(text, GableWarning, stacklevel=level)

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def __enter__(self) -> Listener:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close()


def _somebody_looks() -> bool:
    """Whether there is a terminal or a notebook."""
    if sys.stderr is not None and sys.stderr.isatty():
        return True
    get_ipython = getattr(sys.modules.get("IPython"), "get_ipython", None)
    return get_ipython is not None and "kernel" in type(get_ipython()).__module__


def _tqdm() -> Any:
    with warnings.catch_warnings():
        # Without ipywidgets a notebook gets a bar of text, and need not be told so.
        warnings.simplefilter("ignore")
        from tqdm.auto import tqdm
    return tqdm
