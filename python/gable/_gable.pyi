import os
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

VERSION: str

class _Listener(Protocol):
    def progress(self, stage: str, unit: str, done: int, total: int) -> None: ...
    def warning(self, text: str) -> None: ...

_Path = str | os.PathLike[str]
_Arrays = tuple[str, NDArray[np.float64], NDArray[np.int64], NDArray[np.int32]]

class Feed:
    def __new__(cls, name: _Path) -> Feed: ...
    def push(
        self,
        x: NDArray[np.float64],
        y: NDArray[np.float64],
        z: NDArray[np.float64],
        classification: NDArray[np.uint8],
        return_number: NDArray[np.uint8] | None = None,
        flags: NDArray[np.uint8] | None = None,
    ) -> None: ...

def reconstruct(
    options: str, crs: str | None, feed: Feed | None, scratch: _Path, listener: _Listener
) -> tuple[Any, str, str]: ...
def validate(model: _Path, options: str, listener: _Listener) -> str: ...
def evaluate(model: _Path, points: list[str], options: str, listener: _Listener) -> str: ...
def convert(
    inputs: list[Any], output: _Path, overwrite: bool, crs: str | None, lods: list[str], listener: _Listener
) -> Any: ...
def copy(from_: _Path, to: _Path, overwrite: bool, listener: _Listener) -> Any: ...
def page(
    model: _Path,
    output: _Path,
    overwrite: bool,
    points: list[str],
    max_points: int | None,
    trust_tiles: bool,
    report: _Path | None,
    listener: _Listener,
) -> Any: ...
def ids(model: _Path, listener: _Listener) -> list[str]: ...
def meshes(model: _Path, lod: str | None, listener: _Listener) -> tuple[list[_Arrays], list[str]]: ...
def pipeline(
    text: str, name: str, overrides: list[str], listener: _Listener
) -> tuple[str, list[tuple[str, str]], int]: ...
def plan(
    options: str,
    crs: str | None,
    output: _Path,
    jobs: int | None,
    job_size: int | None,
    overwrite: bool,
    listener: _Listener,
) -> str: ...
def read_plan(plan: _Path) -> str: ...
def missing_jobs(plan: _Path, parts: list[str]) -> list[int]: ...
def do_job(
    plan: _Path, job: int, parts: _Path | None, threads: int | None, overwrite: bool, listener: _Listener
) -> str | None: ...
def merge_parts(
    plan: _Path, parts: list[str], output: _Path, report: _Path | None, overwrite: bool, listener: _Listener
) -> tuple[str, str]: ...
