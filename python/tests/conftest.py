"""The quick start's data, and the model that is made of it."""

import os
import pathlib

import pytest

import gable

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "examples" / "data"
TILE = DATA / "delft_ahn3.laz"
FOOTPRINTS = DATA / "footprints.geojson"


@pytest.fixture(scope="session")
def delft() -> gable.Model:
    """The corner of Delft as the quick start makes it."""
    return gable.reconstruct(TILE, FOOTPRINTS)


@pytest.fixture(scope="session")
def fast():
    """What makes a small model quickly: a few footprints and the vote of the height field."""
    return {"field": "height-field", "filter": "id LIKE '%1730%'"}


@pytest.fixture(scope="session")
def command() -> pathlib.Path:
    """The command line of the same version, which GABLE names."""
    path = os.environ.get("GABLE")
    if not path:
        pytest.skip("GABLE does not name the program `gable`, which this is compared with")
    return pathlib.Path(path)
