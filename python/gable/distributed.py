"""A run in several jobs on many machines, by Dask or Ray.

>>> from gable import distributed
>>> plan = distributed.plan("tiles/", "buildings.gpkg", "plan/", jobs=64)  # doctest: +SKIP
>>> from dask.distributed import Client  # doctest: +SKIP
>>> frame = distributed.run_on_dask(plan, Client("tcp://head:8786"))  # doctest: +SKIP
>>> frame.wall_seconds.describe()  # doctest: +SKIP
>>> plan.merge("city.city.jsonl")  # doctest: +SKIP

The plan, its jobs and joining them are those of ``gable plan``, ``gable reconstruct --plan`` and ``gable merge --plan``: a job
that is done again does nothing, one that was killed goes on where it was, and the model is that of one run, byte for byte.
The folder of the plan and the tiles must have the same names on all machines.
"""

from __future__ import annotations

import json
import os
import pathlib
import socket
import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from . import _gable
from ._crs import crs_text
from ._footprints import Footprints
from ._listener import Listener, Progress
from ._options import options_text
from ._points import paths
from ._record import Record, Table
from ._report import Report
from ._scratch import Scratch
from .errors import GableError, InputError

if TYPE_CHECKING:
    import pandas

__all__ = ["JobsFailed", "Plan", "plan", "run_on_dask", "run_on_ray"]

#: What is found of a job that another process is doing.
_BUSY = "another run that is writing this model"
#: Seconds until such a job is looked at again.
_PAUSE = 1.0

_Path = str | os.PathLike[str]


class JobsFailed(GableError):
    """Some jobs came to nothing; the others are done. Called again, the same function does those that are missing."""

    def __init__(self, frame: pandas.DataFrame) -> None:
        failed = frame[frame.error.notna()]
        first = failed.iloc[0]
        super().__init__(f"{len(failed)} of {len(frame)} jobs failed, the first of them job {failed.index[0]}: {first.error}")
        #: All jobs, as those that are returned; ``error`` says why one failed.
        self.frame = frame


class Plan(Record):
    """A plan: a run that is divided into jobs. Its members are those of ``schemas/plan.schema.json``."""

    def __init__(self, folder: _Path) -> None:
        #: The folder of the plan, absolute.
        self.folder = os.path.abspath(os.fspath(folder))
        super().__init__(json.loads(_gable.read_plan(self.folder)))

    @property
    def jobs(self) -> Table:
        """The jobs: how many footprints each has, which tiles it reads, and what it is expected to cost."""
        return Table(self._members["jobs"], "job")

    def missing(self, parts: _Path | Sequence[_Path] = ()) -> list[int]:
        """The numbers of the jobs that have no part yet, in the folder of the plan or in these."""
        return _gable.missing_jobs(self.folder, paths(parts) if parts else [])

    def do(
        self,
        job: int,
        *,
        parts: _Path | None = None,
        threads: int | None = None,
        overwrite: bool = False,
        progress: Progress = False,
    ) -> dict[str, Any]:
        """Does a job in this process, unless it is done already.

        :param parts: the folder that its part goes to; by default that of the plan
        :param threads: how many threads; by default one per processor
        :param overwrite: whether it is done anew
        :return: what it came to, as a row of the frames of :func:`run_on_dask`
        """
        return _do(self.folder, job, None if parts is None else os.fspath(parts), threads, overwrite, progress)

    def merge(
        self,
        output: _Path,
        *,
        parts: _Path | Sequence[_Path] = (),
        report: _Path | None = None,
        overwrite: bool = False,
        progress: Progress = None,
    ) -> Report:
        """Joins the parts of all jobs into a model, in the format of its extension; :func:`gable.read` opens one that is
        CityJSON.

        :return: the report. It holds no buildings, of which there may be millions; the file of the report, beside the
            model, does
        :raises InputError: jobs or footprints are missing or there twice; they are listed
        """
        with Listener(progress) as listener:
            told, summary = _gable.merge_parts(
                self.folder, paths(parts) if parts else [], os.fspath(output), report, overwrite, listener
            )
        return Report(json.loads(told), summary)

    def __repr__(self) -> str:
        return f"<gable.distributed.Plan: {self['footprints']} footprints in {len(self['jobs'])} jobs, {self.folder}>"


def plan(
    tiles: _Path | Sequence[_Path],
    footprints: Any,
    output: _Path,
    *,
    jobs: int | None = None,
    job_size: int | None = None,
    crs: Any = None,
    overwrite: bool = False,
    progress: Progress = None,
    **options: Any,
) -> Plan:
    """Divides a run into jobs, which lie together and cost about the same.

    :param tiles: a path or several: files, folders and glob patterns
    :param footprints: as in :func:`gable.reconstruct`
    :param output: the folder of the plan
    :param jobs: how many jobs
    :param job_size: instead, about how many footprints each has; by default 1000
    :param crs: the CRS of the tiles; goes before what they say
    :param options: those of ``gable reconstruct`` that say what comes out, with ``_`` for ``-``
    """
    scratch = Scratch()
    outlines = Footprints(footprints, scratch)
    options = {**options, "tiles": paths(tiles), "footprints": outlines.path}
    if outlines.crs is not None:
        options.setdefault("footprint_crs", outlines.crs)
    if "footprint_crs" in options:
        options["footprint_crs"] = crs_text(options["footprint_crs"])
    with Listener(progress) as listener:
        _gable.plan(options_text(options), crs_text(crs), os.fspath(output), jobs, job_size, overwrite, listener)
    return Plan(output)


def run_on_dask(
    plan: Plan | _Path,
    client: Any,
    *,
    parts: _Path | None = None,
    threads: int = 1,
    retries: int = 3,
    overwrite: bool = False,
    progress: Progress = None,
    **submit: Any,
) -> pandas.DataFrame:
    """Does all jobs of a plan that are not done yet on a Dask cluster, one task for each.

    A task whose worker dies is done by another one and goes on where it was.

    :param client: a ``dask.distributed.Client``
    :param parts: the folder that parts go to; by default that of the plan
    :param threads: threads of each job; as many as each worker has processors for each of its own threads
    :param retries: how often a job is tried again that fails
    :param overwrite: whether all jobs are done anew
    :param progress: as in :func:`gable.reconstruct`, counted in jobs
    :param submit: more for ``Client.submit``, such as ``resources={"memory": 4e9}``
    :return: a row for each job by its number: footprints, buildings with LoD 2.2, times, memory, host
    :raises JobsFailed: some jobs failed; all others are done
    """
    from distributed import as_completed

    opened = plan if isinstance(plan, Plan) else Plan(plan)
    todo = list(range(len(opened["jobs"]))) if overwrite else opened.missing(parts or ())
    where = None if parts is None else os.path.abspath(os.fspath(parts))
    futures = {}
    try:
        # The dearest first, so that the last ones to end are short.
        for job in sorted(todo, key=lambda job: -float(opened["jobs"][job]["cost"])):
            future = client.submit(
                _do, opened.folder, job, where, threads, overwrite, pure=False, retries=retries, **submit
            )
            futures[future] = job

        def outcomes() -> Iterable[tuple[int, dict[str, Any] | None, str | None]]:
            for future in as_completed(list(futures)):
                if future.status == "finished":
                    yield futures[future], future.result(), None
                else:
                    yield futures[future], None, _dask_error(future)

        return _collected(opened, where, outcomes(), len(todo), progress)
    finally:
        client.cancel(list(futures), force=True)


def run_on_ray(
    plan: Plan | _Path,
    *,
    parts: _Path | None = None,
    threads: int = 1,
    retries: int = 3,
    overwrite: bool = False,
    progress: Progress = None,
    **remote: Any,
) -> pandas.DataFrame:
    """Does all jobs of a plan that are not done yet on the Ray cluster that this process is connected to; as
    :func:`run_on_dask`.

    :param remote: more for ``ray.remote``, such as ``memory=4e9``
    """
    import ray

    opened = plan if isinstance(plan, Plan) else Plan(plan)
    todo = list(range(len(opened["jobs"]))) if overwrite else opened.missing(parts or ())
    where = None if parts is None else os.path.abspath(os.fspath(parts))
    options = {"num_cpus": threads, "max_retries": retries, "retry_exceptions": True, **remote}
    task = ray.remote(**options)(_do)
    waiting = {}
    for job in sorted(todo, key=lambda job: -float(opened["jobs"][job]["cost"])):
        waiting[task.remote(opened.folder, job, where, threads, overwrite)] = job

    def outcomes() -> Iterable[tuple[int, dict[str, Any] | None, str | None]]:
        while waiting:
            done, _ = ray.wait(list(waiting), num_returns=1)
            for reference in done:
                job = waiting.pop(reference)
                try:
                    yield job, ray.get(reference), None
                except Exception as error:
                    cause = getattr(error, "cause", None) or error
                    yield job, None, _text(cause)

    try:
        return _collected(opened, where, outcomes(), len(todo), progress)
    finally:
        for reference in waiting:
            ray.cancel(reference, force=True)


def _do(
    folder: str, job: int, parts: str | None, threads: int | None, overwrite: bool, progress: Progress = False
) -> dict[str, Any]:
    """Does a job in this process; what it came to. While another process does the same, because the scheduler had lost sight
    of it, that one is waited for."""
    while True:
        try:
            with Listener(progress) as listener:
                told = _gable.do_job(folder, job, parts, threads, overwrite, listener)
            break
        except InputError as error:
            if error.found != _BUSY:
                raise
            # What the other one makes is what this one would have made.
            overwrite = False
            time.sleep(_PAUSE)
    return _row(folder, job, parts, None if told is None else json.loads(told))


def _row(folder: str, job: int, parts: str | None, report: dict[str, Any] | None) -> dict[str, Any]:
    """A row for a job; ``report`` is that of one that was done just now."""
    was_done = report is None
    if report is None:
        place = pathlib.Path(parts) if parts else pathlib.Path(folder, "parts")
        report = json.loads((place / f"{job}.report.json").read_text(encoding="utf-8"))
    counts = report["counts"]
    return {
        "job": job,
        "was_done": was_done,
        "footprints": counts["footprints"],
        "buildings_lod22": counts["buildings_lod22"],
        "resumed": counts["resumed"],
        "wall_seconds": report["wall_seconds"],
        "cpu_seconds": report["cpu_seconds"],
        "peak_memory_bytes": report["peak_memory_bytes"],
        "host": None if was_done else socket.gethostname(),
        "process": None if was_done else os.getpid(),
        "error": None,
    }


def _collected(
    plan: Plan,
    parts: str | None,
    outcomes: Iterable[tuple[int, dict[str, Any] | None, str | None]],
    total: int,
    progress: Progress,
) -> pandas.DataFrame:
    """The rows of all jobs, those that were done before among them.

    :raises JobsFailed: some failed
    """
    import pandas

    rows: dict[int, dict[str, Any]] = {}
    with Listener(progress) as listener:
        listener.progress("jobs", "job", 0, total)
        for done, (job, row, error) in enumerate(outcomes, start=1):
            rows[job] = row if row is not None else {"job": job, "was_done": False, "error": error}
            listener.progress("jobs", "job", done, total)
    for job in range(len(plan["jobs"])):
        if job not in rows:
            rows[job] = _row(plan.folder, job, parts, None)
    frame = pandas.DataFrame([rows[job] for job in sorted(rows)]).set_index("job")
    if frame.error.notna().any():
        raise JobsFailed(frame)
    return frame


def _dask_error(future: Any) -> str:
    """Why a future came to nothing."""
    if future.status == "error":
        return _text(future.exception())
    return f"the task was {future.status}: the scheduler has gone, or somebody cancelled it"


def _text(error: BaseException) -> str:
    text = str(error).strip()
    return text if isinstance(error, GableError) else f"{type(error).__name__}: {text}"
