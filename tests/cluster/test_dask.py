"""Dask: whatever happens to workers and scheduler, the model of one run, nothing lost and nothing doubled."""

import os
import pathlib
import signal
import threading
import time

import pytest

from gable import distributed

dask = pytest.importorskip("distributed")


def in_the_middle(plan, action, *, after=2):
    """Calls ``action(pid)`` once with the process that is in the middle of a job: ``after`` buildings of it are done and it
    is not over. Gives an event that is set when that has happened."""
    happened = threading.Event()

    def watch():
        limit = time.monotonic() + 120
        while time.monotonic() < limit:
            for checkpoint in pathlib.Path(plan.folder, "parts").glob("*.partial/buildings.jsonl"):
                try:
                    if checkpoint.read_bytes().count(b"\n") <= after:
                        continue
                    holder = holder_of(checkpoint)
                    if holder is not None:
                        action(holder)
                        happened.set()
                        return
                except FileNotFoundError:
                    continue
            time.sleep(0.002)

    threading.Thread(target=watch, daemon=True).start()
    return happened


def holder_of(file):
    """The process that has a file open."""
    for folder in pathlib.Path("/proc").glob("[0-9]*/fd"):
        try:
            if any(os.readlink(link) == str(file) for link in folder.iterdir()):
                return int(folder.parent.name)
        except OSError:
            continue
    return None


def test_all_jobs_are_done_and_progress_is_told(plan, client, is_same):
    told = []
    frame = distributed.run_on_dask(plan, client, progress=lambda *news: told.append(news))
    assert list(frame.index) == list(range(8)) and frame.footprints.sum() == 71
    assert frame.error.isna().all() and not frame.was_done.any() and frame.process.nunique() > 1
    assert told[0] == ("jobs", 0, 8) and told[-1] == ("jobs", 8, 8)
    is_same(plan)
    # Again: nothing is done.
    again = distributed.run_on_dask(plan, client)
    assert again.was_done.all()


def test_a_worker_that_is_killed_in_the_middle(plan, client, is_same):
    happened = in_the_middle(plan, lambda pid: os.kill(pid, signal.SIGKILL))
    frame = distributed.run_on_dask(plan, client)
    assert happened.wait(30), "no job was hit in its middle"
    assert frame.resumed.sum() > 0, "the job did not go on where it was"
    is_same(plan)


def test_a_worker_that_runs_out_of_memory(plan, client, is_same):
    def limit():
        import pathlib
        import resource

        held = int(pathlib.Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (held + 1_000_000, resource.RLIM_INFINITY))
        return os.getpid()

    before = client.run(os.getpid)
    [(address, pid)] = client.run(limit, workers=[next(iter(before))]).items()
    frame = distributed.run_on_dask(plan, client)
    assert frame.error.isna().all()
    assert pid not in frame.process.tolist(), f"{address} had memory enough"
    is_same(plan)


def test_a_worker_that_is_slow_is_waited_for_though_its_job_is_given_away(plan, client, is_same):
    stopped = []

    def stop(pid):
        os.kill(pid, signal.SIGSTOP)
        stopped.append(pid)
        # Longer than the scheduler waits until it gives the job to another worker.
        threading.Timer(9, os.kill, (pid, signal.SIGCONT)).start()

    happened = in_the_middle(plan, stop)
    started = time.monotonic()
    frame = distributed.run_on_dask(plan, client)
    assert happened.wait(30) and frame.error.isna().all()
    assert time.monotonic() - started > 4
    is_same(plan)


def test_a_scheduler_that_is_lost_and_a_plan_that_is_resumed(plan, cluster, client, is_same, tmp_path):
    happened = in_the_middle(plan, lambda _: cluster.stop())
    with pytest.raises(Exception) as caught:
        distributed.run_on_dask(plan, client)
    assert happened.wait(30), caught.value
    left = plan.missing()
    assert left, "the plan was done before"
    from conftest import Cluster

    (tmp_path / "again").mkdir()
    again = Cluster(tmp_path / "again")
    try:
        with dask.Client(again.address) as other:
            frame = distributed.run_on_dask(plan, other)
    finally:
        again.stop()
    assert sorted(frame.index[~frame.was_done.astype(bool)]) == left
    is_same(plan)


def test_jobs_that_fail_are_told_and_the_others_are_done(plan, client, is_same):
    share = pathlib.Path(plan.folder, "jobs", "3.jsonl")
    whole = share.read_bytes()
    share.write_bytes(whole[1:])
    with pytest.raises(distributed.JobsFailed, match="1 of 8 jobs failed, the first of them job 3") as caught:
        distributed.run_on_dask(plan, client, retries=1)
    assert "other bytes than those of the plan" in caught.value.frame.error[3]
    assert plan.missing() == [3]
    share.write_bytes(whole)
    distributed.run_on_dask(plan, client)
    is_same(plan)
