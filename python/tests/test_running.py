"""While it runs: options, progress, warnings, interruptions."""

import os
import signal
import threading
import time

import pytest

import gable
from conftest import FOOTPRINTS, TILE


def test_options_have_the_names_of_the_command_line(fast):
    model = gable.reconstruct(
        TILE, FOOTPRINTS, **fast, lod="0,1.2,1.3,2.2", building_class=[1, 6], lambda_=2.5, jobs=2, ring_width=4
    )
    report = model.report
    assert report.parameters["labelling"]["lambda"] == 2.5
    assert report.segmentation["building_classes"] == [1, 6] and report.segmentation["ring_width"] == 4
    assert report.threads == 2 and report.counts["solids_lod13"] > 0
    assert report.command == []


def test_a_misspelt_option_is_told():
    for name, text in {
        "bilding_class": 'unknown option, expected one of `gable reconstruct`. Did you mean "building-class"?',
        "quiet": "unknown option",
        "zzzz": "There are footprints",
    }.items():
        with pytest.raises(gable.InputError) as caught:
            gable.reconstruct(TILE, FOOTPRINTS, **{name: 6})
        assert text in str(caught.value)
        assert caught.value.place == f'"{name.replace("_", "-")}"'
    with pytest.raises(gable.InputError, match='Did you mean "planarity"'):
        gable.validate(FOOTPRINTS, planarty=1)
    with pytest.raises(gable.InputError, match="a number from 0 to 1000"):
        gable.reconstruct(TILE, FOOTPRINTS, lambda_=-1)
    with pytest.raises(TypeError, match="first argument"):
        gable.reconstruct(TILE, FOOTPRINTS, tiles="a.laz")


def test_progress_is_told(fast, tmp_path):
    told = []
    model = gable.reconstruct(TILE, FOOTPRINTS, **fast, progress=lambda *news: told.append(news))
    stages = list(dict.fromkeys(stage for stage, _, _ in told))
    assert stages == ["reading inputs", "collecting points", "reconstructing", "finishing the file"]
    assert ("reconstructing", len(model), len(model)) in told
    told.clear()
    model.save(tmp_path / "model.gpkg", progress=lambda *news: told.append(news))
    assert {stage for stage, _, _ in told} == {"converting"}


def test_a_bar_of_tqdm(fast, capsys):
    pytest.importorskip("tqdm")
    gable.reconstruct(TILE, FOOTPRINTS, **fast, progress=True)
    assert "reconstructing" in capsys.readouterr().err
    gable.reconstruct(TILE, FOOTPRINTS, **fast)
    assert capsys.readouterr().err == ""


def test_what_progress_raises_ends_the_run(fast, tmp_path):
    class Enough(Exception):
        pass

    def progress(stage, done, total):
        raise Enough(stage)

    with pytest.raises(Enough, match="reading inputs"):
        gable.reconstruct(TILE, FOOTPRINTS, output=tmp_path / "a.city.json", **fast, progress=progress)
    assert not (tmp_path / "a.city.json").exists()
    for call in (
        lambda: gable.reconstruct(TILE, FOOTPRINTS, **fast).save(tmp_path / "a.gpkg", progress=progress),
        lambda: gable.validate(gable.reconstruct(TILE, FOOTPRINTS, **fast), progress=progress),
        lambda: gable.pipeline([str(TILE), {"type": "filters.stats"}], progress=progress),
    ):
        with pytest.raises(Enough):
            call()
    assert os.listdir(tmp_path) == []


def test_an_interruption_keeps_what_is_done(tmp_path):
    """Ctrl-C: buildings under way are completed, what is done is written, and KeyboardInterrupt is raised."""
    output = tmp_path / "a.city.json"

    def progress(stage, done, total):
        if stage == "reconstructing" and done > 3:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        gable.reconstruct(TILE, FOOTPRINTS, output=output, jobs=1, progress=progress)
    done = gable.read(output)
    assert 3 < len(done) < 71
    assert done.report.interrupted and done.report.counts["not_reached"] > 0


def test_a_signal_ends_a_run_without_a_callback():
    timer = threading.Timer(1.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            gable.reconstruct(TILE, FOOTPRINTS, jobs=1)
    timer.join()
    assert time.monotonic() - started < 60


def test_other_threads_go_on(fast):
    done = threading.Event()
    gaps = []

    def tick():
        last = time.monotonic()
        while not done.is_set():
            time.sleep(0.001)
            now = time.monotonic()
            gaps.append(now - last)
            last = now

    thread = threading.Thread(target=tick)
    thread.start()
    started = time.monotonic()
    gable.reconstruct(TILE, FOOTPRINTS)
    took = time.monotonic() - started
    done.set()
    thread.join()
    assert len(gaps) > 50 and max(gaps) < max(0.5, took / 2), (len(gaps), max(gaps), took)


def test_warnings_point_to_the_caller():
    with pytest.warns(gable.GableWarning, match="class") as caught:
        gable.reconstruct(TILE, FOOTPRINTS, field="height-field", building_class="6,27", filter="id LIKE '%1730%'")
    assert caught[0].filename == __file__


def test_a_warning_can_be_an_error():
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error", gable.GableWarning)
        with pytest.raises(gable.GableWarning):
            gable.reconstruct(TILE, FOOTPRINTS, field="height-field", building_class="6,27")
