"""A plan of a small city, the model of one run, and a Dask cluster of processes on the loopback."""

import contextlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import pytest

import gable
from gable import distributed

ROOT = pathlib.Path(__file__).resolve().parents[2]
TILE = ROOT / "examples" / "data" / "delft_ahn3.laz"
FOOTPRINTS = ROOT / "examples" / "data" / "footprints.geojson"
#: So that a job takes long enough to be hit in its middle.
SLOW = {"lod": "0,1.2,1.3,2.2"}


@pytest.fixture(scope="session")
def one_run(tmp_path_factory) -> bytes:
    """The bytes of one run."""
    path = tmp_path_factory.mktemp("one") / "footprints.city.jsonl"
    gable.reconstruct(TILE, FOOTPRINTS, output=path, **SLOW)
    return path.read_bytes()


@pytest.fixture
def plan(tmp_path) -> distributed.Plan:
    """A plan of eight jobs."""
    return distributed.plan(TILE, FOOTPRINTS, tmp_path / "plan", jobs=8, **SLOW)


@pytest.fixture
def is_same(one_run, tmp_path):
    """Whether the parts of a plan come to the bytes of one run, with no building lost or doubled."""

    def check(plan):
        assert plan.missing() == []
        model = tmp_path / "merged.city.jsonl"
        report = plan.merge(model)
        assert report.counts["footprints"] == report.counts["written"] == 71
        assert model.read_bytes() == one_run
        left = sorted(path.name for path in pathlib.Path(plan.folder, "parts").iterdir())
        assert left == sorted(f"{job}.{kind}" for job in range(8) for kind in ("part.jsonl", "report.json"))

    return check


class Cluster:
    """A scheduler and its workers, each a process of its own, with nannies that start dead ones again."""

    def __init__(self, folder: pathlib.Path, workers: int = 4) -> None:
        self.folder = folder
        self.processes: list[subprocess.Popen] = []
        self.log = folder / "scheduler.log"
        environment = {
            **os.environ,
            "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "4s",
            "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "5s",
            "DASK_DISTRIBUTED__WORKER__MEMORY__TERMINATE": "False",
        }
        self._start(["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"], environment, self.log)
        self.address = self._wait_for(r"Scheduler at:\s+(tcp://\S+)")
        names = ["worker", self.address, "--host", "127.0.0.1", "--nworkers", str(workers), "--nthreads", "1"]
        self._start([*names, "--no-dashboard", "--local-directory", str(folder)], environment, folder / "workers.log")

    def _start(self, words, environment, log):
        with log.open("wb") as file:
            command = [sys.executable, "-m", "dask", *words] if _has_module("dask.__main__") else ["dask", *words]
            self.processes.append(
                subprocess.Popen(command, env=environment, stdout=file, stderr=file, start_new_session=True)
            )

    def _wait_for(self, pattern: str) -> str:
        limit = time.monotonic() + 60
        while time.monotonic() < limit:
            found = re.search(pattern, self.log.read_text())
            if found:
                return found[1]
            time.sleep(0.1)
        raise AssertionError(self.log.read_text())

    def stop(self) -> None:
        for process in self.processes:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _has_module(name: str) -> bool:
    import importlib.util

    with contextlib.suppress(ModuleNotFoundError):
        return importlib.util.find_spec(name) is not None
    return False


@pytest.fixture
def cluster(tmp_path):
    """Four workers on the loopback."""
    running = Cluster(tmp_path)
    yield running
    running.stop()


@pytest.fixture
def client(cluster):
    """A client of the cluster, whose workers are all there."""
    from distributed import Client

    with Client(cluster.address) as client:
        client.wait_for_workers(4, timeout=60)
        yield client
