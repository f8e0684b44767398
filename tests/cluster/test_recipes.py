"""The recipes of examples/cluster, as far as they can be run without their clusters."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest

from conftest import FOOTPRINTS, ROOT, TILE

RECIPES = ROOT / "examples" / "cluster"


@pytest.fixture
def with_gable(tmp_path):
    """The environment of a process that finds the program `gable`, which GABLE names."""
    program = os.environ.get("GABLE")
    if not program:
        pytest.skip("GABLE does not name the program `gable`")
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "gable").symlink_to(program)
    return {**os.environ, "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}"}


def test_the_tasks_of_a_slurm_array(plan, with_gable, is_same):
    def missing():
        words = ["gable", "merge", "--plan", plan.folder, "--missing"]
        return subprocess.run(words, env=with_gable, capture_output=True, text=True).stdout.strip()

    assert missing() == "0-7"
    for task in range(8):
        environment = {**with_gable, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_CPUS_PER_TASK": "1"}
        subprocess.run(["bash", RECIPES / "slurm.sh", plan.folder], env=environment, check=True)
    assert missing() == ""
    is_same(plan)


def test_the_kubernetes_job_is_one_and_its_words_do_a_job(plan, with_gable):
    validate = pytest.importorskip("kubernetes_validate")
    yaml = pytest.importorskip("yaml")
    manifest = yaml.safe_load((RECIPES / "kubernetes.yaml").read_text())
    validate.validate(manifest, "1.31", strict=True)
    spoilt = {**manifest, "spec": {**manifest["spec"], "completions": "many"}}
    with pytest.raises(validate.ValidationError):
        validate.validate(spoilt, "1.31", strict=True)
    assert manifest["spec"]["completionMode"] == "Indexed"
    [container] = manifest["spec"]["template"]["spec"]["containers"]
    words = [word.replace("$(JOB_COMPLETION_INDEX)", "5").replace("/data/plan", plan.folder) for word in container["args"]]
    subprocess.run([*container["command"], *words], env=with_gable, check=True)
    assert plan.missing() == [0, 1, 2, 3, 4, 6, 7]


def test_snakemake_makes_the_model_of_one_run(with_gable, one_run, tmp_path):
    pytest.importorskip("snakemake")
    shutil.copy(RECIPES / "Snakefile", tmp_path)
    settings = [f"tiles={TILE}", f"footprints={FOOTPRINTS}", "jobs=4", "options=--lod 0,1.2,1.3,2.2"]
    words = [sys.executable, "-m", "snakemake", "--cores", "2", "--quiet", "all", "--config", *settings]
    done = subprocess.run(words, cwd=tmp_path, env=with_gable, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "city.city.jsonl").read_bytes() == one_run


@pytest.mark.parametrize("name", ["dask", "ray"])
def test_the_programs_make_the_model_of_one_run(plan, name, one_run, tmp_path):
    pytest.importorskip({"dask": "distributed", "ray": "ray"}[name])
    model = tmp_path / "city.city.jsonl"
    words = [sys.executable, RECIPES / f"on_{name}.py", plan.folder, model]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "8 of 8 jobs" in done.stdout
    assert pathlib.Path(model).read_bytes() == one_run
