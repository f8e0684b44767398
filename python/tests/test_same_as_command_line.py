"""What comes out is what the command line writes, and what goes wrong is told in its words."""

import json
import os
import re
import subprocess

import pytest

import gable
from conftest import FOOTPRINTS, ROOT, TILE


def run(command, *arguments, cwd=None):
    return subprocess.run([command, *map(str, arguments)], capture_output=True, text=True, cwd=cwd)


def test_the_lines_of_the_readme_give_the_model_of_the_quick_start(command, tmp_path, monkeypatch):
    written = tmp_path / "quickstart.city.json"
    done = run(command, "reconstruct", TILE, "-f", FOOTPRINTS, "-o", written, "-q")
    assert done.returncode == 0, done.stderr

    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    (lines,) = [block for block in blocks if "gable.reconstruct(" in block]
    assert lines == re.findall(r"```python\n(.*?)```", (ROOT / "python/README.md").read_text(), re.DOTALL)[0]
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    exec(compile(lines, "README.md", "exec"), {})

    assert (tmp_path / "delft.city.json").read_bytes() == written.read_bytes()
    assert opened == [(tmp_path / "delft.html").as_uri()]


def test_an_output_is_written_as_by_the_command(command, tmp_path, fast):
    options = [f"--{name}={value}" for name, value in fast.items()]
    for extension in (".city.json", ".city.jsonl", ".obj"):
        theirs, ours = tmp_path / f"theirs{extension}", tmp_path / f"ours{extension}"
        run(command, "reconstruct", TILE, "-f", FOOTPRINTS, "-o", theirs, "-q", *options)
        gable.reconstruct(TILE, FOOTPRINTS, output=ours, **fast)
        expected = theirs.read_bytes().replace(b"theirs", b"ours")
        assert ours.read_bytes() == expected, extension


WRONG = {
    "no such tile": (["missing.laz"], {}),
    "no tile": ([FOOTPRINTS], {}),
    "a class twice": ([TILE], {"building_class": "2"}),
    "no such attribute": ([TILE], {"filter": "height > 3"}),
    "no such layer": ([TILE], {"id_attribute": "idd"}),
    "another extension": ([TILE], {"output": "city.shp"}),
    "no network": ([TILE], {"model": FOOTPRINTS}),
    "a least tolerance over the largest": ([TILE], {"minimum_tolerance": 0.4, "maximum_tolerance": 0.1}),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_told_in_the_same_words(command, tmp_path, case, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tiles, options = WRONG[case]
    named = {"output": "city.city.json", **options}
    arguments = [f"--{name.replace('_', '-')}={value}" for name, value in named.items()]
    done = run(command, "reconstruct", *tiles, "-f", FOOTPRINTS, "-q", *arguments)
    assert done.returncode == 1
    with pytest.raises(gable.GableError) as caught:
        gable.reconstruct(tiles, FOOTPRINTS, **named)
    assert done.stderr == f"error: {caught.value}\n"
    assert isinstance(caught.value, (ValueError, OSError))
    assert not os.listdir(tmp_path)


def test_an_output_that_exists_is_kept(command, tmp_path, fast):
    kept = tmp_path / "kept.city.json"
    kept.write_text("kept")
    done = run(command, "reconstruct", TILE, "-f", FOOTPRINTS, "-o", kept, "-q")
    for call in (
        lambda: gable.reconstruct(TILE, FOOTPRINTS, output=kept),
        lambda: gable.reconstruct(TILE, FOOTPRINTS, **fast).save(kept),
        lambda: gable.convert(ROOT / "examples/data/reference_3dbag_lod22.city.jsonl", kept),
    ):
        with pytest.raises(gable.InputError) as caught:
            call()
        assert done.stderr == f"error: {caught.value}\n"
    assert kept.read_text() == "kept"


def test_findings_and_figures_are_those_of_the_commands(command, tmp_path, delft):
    model = delft.save(tmp_path / "model.city.json")
    expected = tmp_path / "report.json"
    run(command, "validate", model, "--json", expected, "--planarity", "0", "--normals", "0", "--no-rounding")
    found = gable.validate(model, planarity=0, normals=0, no_rounding=True)
    assert found.to_dict() == json.loads(expected.read_text())
    assert not found.valid and found.to_frame().code.isin([203, 204]).any()
    run(command, "evaluate", model, "--points", TILE, "--json", expected)
    assert gable.evaluate(model, TILE).to_dict() == json.loads(expected.read_text())


def test_a_pipeline_is_that_of_the_command(command, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    theirs, ours = tmp_path / "theirs.city.json", tmp_path / "ours.city.json"
    file = ROOT / "pipelines/quickstart.json"
    run(command, "pipeline", file, f"--writers.lod2.filename={theirs}", "-q")
    done = gable.pipeline(file, overrides={"writers.lod2.filename": ours})
    assert ours.read_bytes() == theirs.read_bytes()
    assert done.exit_code == 0 and done.reports[0].counts["footprints"] == 71
