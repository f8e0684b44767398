"""The functions of the package."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

from . import _gable
from ._crs import crs_text
from ._footprints import Footprints
from ._listener import Listener, Progress
from ._model import Lods, Model, lods, source
from ._options import options_text
from ._points import Points, is_path, paths
from ._report import Evaluation, Report, Validation
from ._scratch import Scratch
from .errors import FileError, InputError

#: A file of a model, or the model.
AnyModel: TypeAlias = str | os.PathLike[str] | Model
#: Files, folders and glob patterns.
Tiles: TypeAlias = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


def reconstruct(
    points: Any,
    footprints: Any = None,
    *,
    crs: Any = None,
    output: str | os.PathLike[str] | None = None,
    progress: Progress = None,
    **options: Any,
) -> Model:
    """Reconstructs the buildings of footprints from airborne points.

    >>> model = gable.reconstruct("tiles/", "buildings.gpkg", building_class=[1, 6], jobs=4)  # doctest: +SKIP
    >>> model = gable.reconstruct(laspy.read("tile.laz"), geopandas.read_file("buildings.gpkg"))  # doctest: +SKIP
    >>> model = gable.reconstruct({"x": x, "y": y, "z": z, "classification": c}, crs="EPSG:7415")  # doctest: +SKIP

    :param points: a path or several (LAS, LAZ, COPC, PLY, text; folders and glob patterns), a ``laspy.LasData``, structured
        arrays of PDAL (``pipeline.arrays``), or the columns ``x``, ``y``, ``z``, ``classification`` (and ``return_number``,
        ``synthetic``, ``withheld``, ``overlap``) as a dict, a DataFrame, or a tuple of arrays
    :param footprints: a path, a ``geopandas.GeoDataFrame``, or GeoJSON as a dict or a text; without any, what stands apart
        in the points is an object each
    :param crs: the CRS of the points: a text such as ``"EPSG:7415"``, an EPSG code or a ``pyproj.CRS``; goes before what
        files say
    :param output: where the model is written, as with ``--output``; without it the model stands in a temporary file, and
        :meth:`Model.save` writes it
    :param progress: ``True`` or ``False`` for a bar (of tqdm) or none, or a function ``progress(stage, done, total)``; by
        default a bar if tqdm is installed and there is a terminal or a notebook
    :param options: those of ``gable reconstruct`` with ``_`` for ``-``: ``lod="0,1.2,1.3,2.2"``, ``field="height-field"``,
        ``overwrite=True``, …; ``lambda_`` for ``--lambda``
    :raises GableError: with the text of the command line; an :class:`InputError`, which is a ``ValueError``, or a
        :class:`FileError`, which is an ``OSError``
    :raises KeyboardInterrupt: buildings under way are completed, and with ``output`` what is done is written
    """
    if "tiles" in options:
        raise TypeError("tiles are the first argument")
    scratch = Scratch()
    given = Points(points)
    if given.crs is not None and crs is None:
        crs = given.crs
    if given.tiles:
        options["tiles"] = given.tiles
    if footprints is not None:
        outlines = Footprints(footprints, scratch)
        options["footprints"] = outlines.path
        if outlines.crs is not None:
            options.setdefault("footprint_crs", outlines.crs)
    for name in ("footprint_crs", "footprint-crs"):
        if name in options:
            options[name] = crs_text(options[name])
    if output is not None:
        options["output"] = os.fspath(output)
    with Listener(progress) as listener:
        path, report, summary = _gable.reconstruct(
            options_text(options), crs_text(crs), given.feed, scratch.path, listener
        )
    told = Report(json.loads(report), summary)
    could_be_read = [tile["file"] for tile in told["inputs"]["tiles"] if not tile["left_out"]]
    return Model(path, told, scratch, could_be_read if given.feed is None else [])


def read(path: str | os.PathLike[str]) -> Model:
    """Opens a city model, of any maker: CityJSON 1.0 to 2.0 or CityJSONSeq.

    >>> gable.read("examples/data/reference_3dbag_lod22.city.jsonl")  # doctest: +SKIP
    <gable.Model: 11 buildings in examples/data/reference_3dbag_lod22.city.jsonl>
    """
    model = Model(os.fspath(path))
    # What cannot be read is told now.
    len(model)
    return model


def validate(model: AnyModel, *, progress: Progress = None, **options: Any) -> Validation:
    """Checks whether a model is valid, fault by fault.

    :param model: a path or a :class:`Model`
    :param options: those of ``gable validate``: ``planarity=0.01``, ``no_schema=True``, …

    >>> if not gable.validate("city.city.json"): ...  # doctest: +SKIP
    >>> gable.validate(model).to_frame().groupby("code").size()  # doctest: +SKIP
    """
    with Listener(progress) as listener:
        return Validation(json.loads(_gable.validate(source(model), options_text(options), listener)))


def evaluate(
    model: AnyModel,
    points: Tiles | None = None,
    reference: AnyModel | None = None,
    *,
    progress: Progress = None,
    **options: Any,
) -> Evaluation:
    """Measures how good a model is: its faces and faults, its distance to points and to a reference model.

    :param model: a path or a :class:`Model`
    :param points: tiles to compare with: a path or several
    :param reference: a model to compare with: a path or a :class:`Model`
    :param options: those of ``gable evaluate``: ``lod="1.2"``, ``building_class=[1, 6]``, …

    >>> gable.evaluate(model, points="tiles/").overall["points"]["vertical"]["rmse"]  # doctest: +SKIP
    """
    if reference is not None:
        options["reference"] = source(reference)
    tiles = [] if points is None else paths(points)
    with Listener(progress) as listener:
        return Evaluation(json.loads(_gable.evaluate(source(model), tiles, options_text(options), listener)))


def convert(
    src: AnyModel | Sequence[AnyModel],
    dst: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    lod: Lods = None,
    crs: Any = None,
    progress: Progress = None,
) -> pathlib.Path:
    """Writes a model in another format, or joins several into one.

    :param src: a path or a :class:`Model`, or a list of them
    :param dst: the output, whose extension chooses the format: ``.city.json``, ``.city.jsonl``, ``.3dtiles`` (a folder),
        ``.gpkg`` or ``.obj``
    :param overwrite: replace what exists
    :param lod: only these levels of detail, such as ``"2.2"`` or ``["0", "1.2"]``
    :param crs: the CRS of the models; goes before what they say
    :returns: the output

    >>> gable.convert("city.city.json", "city.gpkg")  # doctest: +SKIP
    """
    inputs = [source(model) for model in src] if isinstance(src, (list, tuple)) else [source(src)]
    with Listener(progress) as listener:
        return pathlib.Path(_gable.convert(inputs, os.fspath(dst), overwrite, crs_text(crs), lods(lod), listener))


class Pipeline(NamedTuple):
    """What came of a pipeline."""

    #: What the stages have to tell, as PDAL's ``--metadata`` writes it.
    metadata: dict[str, Any]
    #: The reports of its reconstructions.
    reports: list[Report]
    #: That of the command line: 2 when points could not be read or a reconstruction lacks buildings, else 0.
    exit_code: int


def pipeline(pipeline: Any, *, overrides: Mapping[str, Any] | None = None, progress: Progress = None) -> Pipeline:
    """Runs a pipeline in PDAL's grammar, with ``writers.lod2`` as one more stage.

    :param pipeline: its JSON as a list, a dict or a text; or the path of a file that holds it
    :param overrides: options of all stages of a type or of the one of a tag, such as ``{"readers.las.count": 1000}`` or
        ``{"stage.model.filename": "small.city.json"}``

    >>> gable.pipeline(["tile.laz", {"type": "filters.stats"}]).metadata["stages"]["filters.stats"]  # doctest: +SKIP
    """
    name = "pipeline"
    if isinstance(pipeline, str) and pipeline.lstrip().startswith(("[", "{", "/*", "//")):
        text = pipeline
    elif is_path(pipeline):
        name = os.fspath(pipeline)
        text = _text(name)
    else:
        text = json.dumps(pipeline, default=os.fspath)
    settings = [f"{name}={_setting(value)}" for name, value in (overrides or {}).items()]
    with Listener(progress) as listener:
        metadata, reports, exit_code = _gable.pipeline(text, name, settings, listener)
    made = [Report(json.loads(report), summary) for report, summary in reports]
    return Pipeline(json.loads(metadata), made, exit_code)


def _text(path: str) -> str:
    try:
        return pathlib.Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        place = f"byte {error.start}"
        raise InputError.of(path, "bytes that are no UTF-8", "JSON in UTF-8", place=place) from None
    except OSError as error:
        text = f"{path}: cannot read: {error.strerror} (os error {error.errno})"
        raise FileError(text, error.errno, path) from None


def _setting(value: Any) -> str:
    """A value of an option as text."""
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    return json.dumps(value)
