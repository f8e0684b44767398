"""What can be done with a model."""

import json
import sys

import numpy as np
import pytest

import gable
from conftest import DATA, FOOTPRINTS, TILE

REFERENCE = DATA / "reference_3dbag_lod22.city.jsonl"


def test_buildings(delft):
    assert len(delft) == 71 == len(list(delft))
    assert repr(delft) == "<gable.Model: 71 buildings>"
    building = next(iter(delft))
    assert building.id == delft.ids[0] and building.id.startswith("NL.IMBAG.Pand.")
    assert building.lods == ["0", "1.2", "2.2"] and building.attributes["gable_points"] > 0
    assert building.parts == [f"{building.id}-0"]


def test_cityjson(delft, tmp_path):
    whole = delft.to_cityjson()
    assert whole["type"] == "CityJSON" and whole["metadata"]["referenceSystem"].endswith("/7415")
    head, *features = delft.to_cityjsonseq()
    assert head["type"] == "CityJSON" and [feature["id"] for feature in features] == delft.ids
    sequence = gable.read(delft.save(tmp_path / "a.city.jsonl"))
    assert set(sequence.to_cityjson()["CityObjects"]) == set(whole["CityObjects"])


def test_every_format_is_written(delft, tmp_path):
    for extension in (".city.json", ".city.jsonl", ".gpkg", ".3dtiles", ".obj"):
        path = delft.save(str(tmp_path / f"delft{extension}"))
        assert path.exists()
        with pytest.raises(gable.InputError, match="--overwrite"):
            delft.save(path)
        delft.save(path, overwrite=True)
    assert (tmp_path / "delft.city.json").read_bytes() == delft.path.read_bytes()
    with pytest.raises(gable.InputError, match="unknown extension"):
        delft.save(tmp_path / "delft.shp")
    with pytest.raises(gable.InputError, match="geometry at LoD 3"):
        delft.save(tmp_path / "blocks.obj", lod="3")


def test_saving_levels(delft, tmp_path):
    blocks = gable.read(delft.save(tmp_path / "blocks.city.json", lod="1.2"))
    assert {lod for building in blocks for lod in building.lods} == {"1.2"}


def test_a_model_is_not_written_over_itself(delft):
    with pytest.raises(gable.InputError):
        delft.save(delft.path, overwrite=True)
    assert len(gable.read(delft.path)) == 71


def test_meshes_are_closed(delft):
    trimesh = pytest.importorskip("trimesh")
    meshes = delft.meshes()
    assert set(meshes) <= set(delft.ids) and len(meshes) >= 70
    closed = 0
    for mesh in meshes.values():
        assert mesh.vertices.dtype == np.float64 and mesh.triangles.dtype == np.int64
        assert mesh.vertices.shape[1] == mesh.triangles.shape[1] == 3
        assert len(mesh.semantics) == len(mesh.triangles)
        solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        closed += solid.is_watertight and solid.volume > 0
    assert closed == len(meshes)


def test_merged_meshes(delft):
    meshes = delft.meshes()
    one = delft.meshes(merge=True)
    assert one.ids == tuple(meshes) and one.triangles.max() == len(one.vertices) - 1
    last = list(meshes.values())[-1]
    own = one.triangles[one.buildings == len(meshes) - 1]
    assert np.array_equal(one.vertices[own], last.vertices[last.triangles])
    assert set(one.semantics) >= {"RoofSurface", "WallSurface", "GroundSurface"}
    ground = one.vertices[one.triangles[one.semantics == "GroundSurface"]]
    assert np.ptp(ground[:, :, 2], axis=1).max() < 1e-6
    assert len(delft.meshes(lod=None)) == len(delft.meshes("0")) == 71
    with pytest.raises(gable.InputError, match="buildings at LoD 0, 1.2, 2.2 only, expected buildings at LoD 3"):
        delft.meshes("3")


def test_geopandas(delft):
    geopandas = pytest.importorskip("geopandas")
    footprints = delft.to_geopandas()
    assert isinstance(footprints, geopandas.GeoDataFrame) and list(footprints.index) == delft.ids
    assert footprints.crs.to_epsg() in (7415, 28992) or "7415" in footprints.crs.to_string()
    assert footprints.area.min() > 1 and footprints.gable_points.sum() > 20_000
    # What comes out can go in.
    again = gable.reconstruct(TILE, footprints[["geometry"]], field="height-field")
    assert again.ids == delft.ids
    faces = delft.to_geopandas(surfaces=True)
    assert set(faces.surface_type) >= {"RoofSurface", "WallSurface", "GroundSurface"}
    assert faces.has_z.all() and faces[faces.surface_type == "RoofSurface"].slope.notna().all()
    assert set(faces.feature) == set(delft.ids)


def test_without_geopandas(delft, monkeypatch):
    monkeypatch.setitem(sys.modules, "geopandas", None)
    with pytest.raises(ImportError, match="pip install geopandas"):
        delft.to_geopandas()


def test_report(delft):
    report = delft.report
    assert report.counts["footprints"] == report["counts"]["footprints"] == 71
    assert str(report).startswith("footprints") and "LoD 2.2" in repr(report)
    assert json.loads(json.dumps(report.to_dict()))["gable"] == gable.__version__
    assert report.buildings[0]["id"] == delft.ids[0] and len(report.buildings) == 71
    with pytest.raises(AttributeError, match="it has gable, command"):
        _ = report.nothing
    frame = pytest.importorskip("pandas") and report.to_frame()
    assert list(frame.index) == delft.ids and frame.rmse_lod22.median() < 0.2


def test_page(delft, tmp_path):
    page = delft.view(tmp_path / "delft.html")
    text = page.path.read_text()
    assert text.startswith("<!") and "gable" in text
    without = delft.view(points=False)
    assert len(without.path.read_text()) < len(text)
    shown = page._repr_html_()
    assert shown.startswith("<iframe srcdoc=") and shown.count("<") == 2
    with pytest.raises(gable.InputError, match="--overwrite"):
        delft.view(page.path)


def test_models_of_others(tmp_path):
    model = gable.read(REFERENCE)
    assert len(model) == 11 and model.report is None
    assert len(model.meshes()) == 11
    for path, kind in ((FOOTPRINTS, gable.InputError), (tmp_path / "missing.json", gable.FileError)):
        with pytest.raises(kind, match=path.name):
            gable.read(path)
    assert not isinstance(gable.FileError("a"), ValueError)
    with pytest.raises(OSError) as caught:
        gable.read(tmp_path / "missing.json")
    assert caught.value.errno == 2


def test_validation(delft, tmp_path):
    found = gable.validate(delft)
    assert found and found.valid and found.features_overview[0]["total"] == 71
    whole = delft.to_cityjson()
    whole["vertices"][whole_vertex(whole)][2] += 5000
    path = tmp_path / "broken.city.json"
    path.write_text(json.dumps(whole))
    broken = gable.validate(path)
    assert not broken and len(broken.findings) > 0
    frame = pytest.importorskip("pandas") and broken.to_frame()
    assert {"feature", "code", "description", "id", "info"} <= set(frame.columns)


def whole_vertex(model):
    """A vertex of a solid."""
    solids = (g for o in model["CityObjects"].values() for g in o.get("geometry", []) if g["type"] == "Solid")
    return next(solids)["boundaries"][0][0][0][0]


def test_evaluation(delft):
    found = gable.evaluate(delft, points=TILE, reference=gable.read(REFERENCE))
    assert found.overall["buildings"] == 71 and found.overall["points"]["vertical"]["median"] < 0.1
    assert found.overall["reference"]["matched"] == 11
    frame = pytest.importorskip("pandas") and found.to_frame()
    assert len(frame) == 71


def test_convert(tmp_path):
    path = gable.convert(REFERENCE, tmp_path / "a.city.json", lod=["0", "2.2"])
    assert path == tmp_path / "a.city.json"
    joined = gable.convert([gable.read(path), REFERENCE], tmp_path / "b.city.jsonl")
    assert len(gable.read(joined)) == 11
    with pytest.raises(TypeError, match="no model"):
        gable.convert(7, tmp_path / "c.obj")


def test_pipelines():
    stages = [str(TILE), {"type": "filters.range", "limits": "Classification[6:6]"}, {"type": "filters.stats"}]
    for given in (stages, {"pipeline": stages}, json.dumps(stages)):
        done = gable.pipeline(given)
        assert done.metadata["stages"]["filters.stats"]["statistic"][0]["count"] == 45_646
    few = gable.pipeline(stages, overrides={"readers.las.count": 1000})
    assert few.metadata["stages"]["filters.stats"]["statistic"][0]["count"] < 1000
    with pytest.raises(gable.InputError, match="filters.rnage"):
        gable.pipeline([str(TILE), {"type": "filters.rnage"}])
    with pytest.raises(gable.FileError, match="missing.json: cannot read"):
        gable.pipeline("missing.json")
