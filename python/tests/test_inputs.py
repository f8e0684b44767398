"""Points and footprints in all their shapes give one model."""

import json
import pathlib

import numpy as np
import pytest

import gable
from conftest import DATA, FOOTPRINTS, TILE

laspy = pytest.importorskip("laspy")
geopandas = pytest.importorskip("geopandas")
CRS = "EPSG:7415"


def made(*arguments, **options):
    """The bytes of a model, which stands in a file as long as it lives."""
    model = gable.reconstruct(*arguments, **options)
    return model.path.read_bytes()


@pytest.fixture(scope="module")
def cloud():
    return laspy.read(TILE)


@pytest.fixture(scope="module")
def expected(fast):
    return made(TILE, FOOTPRINTS, **fast)


def columns(cloud):
    names = ("x", "y", "z", "classification", "return_number", "synthetic", "withheld", "overlap")
    return {name: np.asarray(getattr(cloud, name)) for name in names}


def pdal(cloud):
    """An array as PDAL gives it: packed, so that no column is aligned or contiguous."""
    dtype = [("X", "<f8"), ("Y", "<f8"), ("Z", "<f8"), ("Intensity", "<u2"), ("ReturnNumber", "u1")]
    dtype += [("Classification", "u1"), ("Synthetic", "u1"), ("Withheld", "u1"), ("Overlap", "u1"), ("GpsTime", "<f8")]
    array = np.zeros(len(cloud.x), dtype)
    for name, column in columns(cloud).items():
        array[{"return_number": "ReturnNumber"}.get(name, name.capitalize())] = column
    return array


def test_a_path_or_several(expected, fast, tmp_path):
    text = str(TILE)
    for points in (text, [text], (TILE, TILE), str(DATA / "*.laz"), DATA):
        assert made(points, FOOTPRINTS, **fast) == expected, points


def test_laspy(cloud, expected, fast):
    assert made(cloud, FOOTPRINTS, **fast) == expected


def test_arrays_of_pdal(cloud, expected, fast):
    array = pdal(cloud)
    assert not array["X"].flags.aligned or not array["X"].flags.contiguous
    half = len(array) // 2
    for points in (array, [array], [array[half:], array[:half]]):
        assert made(points, FOOTPRINTS, crs=CRS, **fast) == expected


def test_columns(cloud, expected, fast):
    pandas = pytest.importorskip("pandas")
    all = columns(cloud)
    whole = {**all, "classification": all["classification"].astype(np.int64)}
    reversed = {name: column[::-1] for name, column in all.items()}
    for points in (all, whole, reversed, pandas.DataFrame(all)):
        assert made(points, FOOTPRINTS, crs=7415, **fast) == expected


def test_a_tuple_of_columns(cloud, fast):
    all = columns(cloud)
    points = tuple(all[name] for name in ("x", "y", "z", "classification"))
    model = gable.reconstruct(points, FOOTPRINTS, crs=CRS, **fast)
    assert model.report.inputs["points"]["read"] == len(cloud.x)
    assert model.report.counts["buildings_lod22"] == len(model)


def test_columns_that_fit_are_not_copied(cloud, monkeypatch):
    from gable import _points

    all = {name: np.ascontiguousarray(column) for name, column in columns(cloud).items()}
    handed = []

    class Watcher:
        def __init__(self, name):
            pass

        def push(self, *chunk):
            handed.extend(chunk[:4])

    monkeypatch.setattr(_points, "Feed", Watcher)
    _points.Points(all)
    for column, name in zip(handed, ("x", "y", "z", "classification")):
        assert np.shares_memory(column, all[name]), name


def test_points_that_are_none(cloud):
    all = columns(cloud)
    cases = [
        ({"x": all["x"], "y": all["y"]}, "also z"),
        ({**all, "y": all["y"][1:]}, "columns of different lengths"),
        ({**all, "classification": all["classification"] + 0.5}, "a whole number from 0 to 255"),
        ({**all, "z": np.where(all["z"] > 0, np.nan, 0)}, "NaN"),
    ]
    for points, text in cases:
        with pytest.raises(gable.InputError, match=text):
            gable.reconstruct(points, FOOTPRINTS, crs=CRS)
    for points in (7, np.zeros((5, 3)), [1, 2]):
        with pytest.raises(TypeError, match="give a path or a list of paths"):
            gable.reconstruct(points, FOOTPRINTS)


def test_footprints(expected, fast):
    frame = geopandas.read_file(FOOTPRINTS)
    text = pathlib.Path(FOOTPRINTS).read_text()
    for footprints in (str(FOOTPRINTS), text, json.loads(text), frame, frame.set_index("id")):
        assert made(TILE, footprints, **fast) == expected, type(footprints)


def test_footprints_in_another_crs(fast):
    frame = geopandas.read_file(FOOTPRINTS).to_crs(4326)
    model = gable.reconstruct(TILE, frame, **fast)
    assert model.report.counts["buildings_lod22"] == len(model) > 0
    assert "4326" in model.report.inputs["footprints"]["crs"]


def test_columns_of_dates(fast):
    pandas = pytest.importorskip("pandas")
    frame = geopandas.read_file(FOOTPRINTS)
    frame["seen"] = pandas.Timestamp("2024-05-06")
    building = next(iter(gable.reconstruct(TILE, frame, **fast)))
    assert building.attributes["seen"].startswith("2024-05-06")
