"""The package is typed, and so is what is written with it."""

import subprocess
import sys

import pytest

import gable

USE = """
import gable
import numpy as np
from numpy.typing import NDArray

model: gable.Model = gable.reconstruct("a.laz", "b.gpkg", crs=7415, progress=lambda stage, done, total: None)
vertices: NDArray[np.float64] = model.meshes(merge=True).vertices
meshes: dict[str, gable.Mesh] = model.meshes()
valid: bool = gable.validate(model, planarity=0.01).valid
"""


def test_types_are_told_and_hold(tmp_path):
    pytest.importorskip("mypy")

    def check(*arguments):
        command = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--python-version", "3.10"]
        return subprocess.run([*command, *arguments], capture_output=True, text=True, cwd=tmp_path)

    done = check("-c", USE)
    assert done.returncode == 0, done.stdout
    done = check("-c", USE + "model.save(7)")
    assert done.returncode == 1 and 'Argument 1 to "save"' in done.stdout, done.stdout
    done = check("-p", "gable")
    assert done.returncode == 0, done.stdout


def test_what_is_public_is_documented():
    for name in gable.__all__:
        thing = getattr(gable, name)
        assert thing.__doc__ and thing.__doc__.strip(), name
        if isinstance(thing, type) and thing.__module__.startswith("gable"):
            own = [member for key, member in vars(thing).items() if not key.startswith("_")]
            undocumented = [m for m in own if (callable(m) or isinstance(m, property)) and not m.__doc__]
            assert not undocumented, (name, undocumented)
