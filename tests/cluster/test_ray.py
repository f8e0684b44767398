"""Ray: the same plan, with a worker that is killed in the middle."""

import os
import signal

import pytest

from gable import distributed
from test_dask import in_the_middle

ray = pytest.importorskip("ray")


@pytest.fixture(scope="module", autouse=True)
def cluster():
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, object_store_memory=100_000_000)
    yield
    ray.shutdown()


def test_a_worker_that_is_killed_in_the_middle(plan, is_same):
    happened = in_the_middle(plan, lambda pid: os.kill(pid, signal.SIGKILL))
    frame = distributed.run_on_ray(plan)
    assert happened.wait(30) and frame.resumed.sum() > 0
    assert frame.footprints.sum() == 71 and frame.error.isna().all()
    is_same(plan)
    assert distributed.run_on_ray(plan).was_done.all()
