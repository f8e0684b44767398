"""City models."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

from . import _gable, _mesh
from ._listener import Listener, Progress
from ._mesh import Mesh
from ._page import Page
from ._points import is_path, paths
from ._report import Report
from ._scratch import Scratch

if TYPE_CHECKING:
    import geopandas

#: Extensions whose files are CityJSON.
_CITYJSON = (".json", ".jsonl")
#: Levels of detail: one, a text with commas, or several.
Lods: TypeAlias = str | float | Iterable[str | float] | None


class Building:
    """A building of a model: a ``CityJSONFeature`` of it and its parts."""

    def __init__(self, feature: dict[str, Any]) -> None:
        #: The ``CityJSONFeature`` as a dict; its vertices are whole numbers in the ``transform`` of the model.
        self.feature = feature
        #: The id, as in the footprints.
        self.id: str = feature["id"]

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the building: those of the footprint, and gable's (``gable_…``)."""
        attributes: dict[str, Any] = self.feature["CityObjects"][self.id].get("attributes", {})
        return attributes

    @property
    def parts(self) -> list[str]:
        """The ids of its parts."""
        return [id for id in self.feature["CityObjects"] if id != self.id]

    @property
    def lods(self) -> list[str]:
        """The levels of detail at which it or a part of it has geometry, coarsest first."""
        objects = self.feature["CityObjects"].values()
        return sorted({str(g["lod"]) for o in objects for g in o.get("geometry", []) if "lod" in g})

    def __repr__(self) -> str:
        return f"<gable.Building {self.id}: LoD {', '.join(self.lods) or 'none'}>"


class Model:
    """A city model: the buildings of a CityJSON file.

    :func:`gable.reconstruct` makes one, :func:`gable.read` opens one.

    >>> model = gable.read("city.city.json")  # doctest: +SKIP
    >>> len(model)  # doctest: +SKIP
    71
    >>> [building.id for building in model if "2.2" not in building.lods]  # doctest: +SKIP
    >>> model.save("city.gpkg")  # doctest: +SKIP
    """

    def __init__(
        self,
        path: str,
        report: Report | None = None,
        scratch: Scratch | None = None,
        tiles: list[str] | None = None,
    ) -> None:
        #: The file in which it stands: CityJSON or CityJSONSeq. One that was reconstructed without an output stands in a
        #: temporary file, which goes with the model.
        self.path = pathlib.Path(path)
        self._report = report
        self._scratch = scratch or Scratch()
        self._tiles = tiles or []
        self._ids: list[str] | None = None

    @property
    def report(self) -> Report | None:
        """The report of the run that made it; of a model that was opened the one beside it, if there is one."""
        if self._report is None:
            beside = pathlib.Path(f"{self.path}.report.json")
            if beside.is_file():
                self._report = Report(json.loads(beside.read_text(encoding="utf-8")))
        return self._report

    @property
    def ids(self) -> list[str]:
        """The ids of the buildings, in the order of the file."""
        if self._ids is None:
            with Listener() as listener:
                self._ids = _gable.ids(self.path, listener)
        return list(self._ids)

    def __len__(self) -> int:
        return len(self.ids)

    def __bool__(self) -> bool:
        return True

    def __iter__(self) -> Iterator[Building]:
        for feature in self.to_cityjsonseq():
            if feature["type"] == "CityJSONFeature":
                top = feature["CityObjects"].get(feature["id"])
                if top is not None and top["type"] == "Building":
                    yield Building(feature)

    def __repr__(self) -> str:
        where = "" if self._is_temporary() else f" in {self.path}"
        return f"<gable.Model: {len(self)} buildings{where}>"

    def _is_temporary(self) -> bool:
        return self.path.parent == pathlib.Path(self._scratch.path)

    def to_cityjson(self) -> dict[str, Any]:
        """The model as a CityJSON object.

        >>> model.to_cityjson()["metadata"]["referenceSystem"]  # doctest: +SKIP
        'https://www.opengis.net/def/crs/EPSG/0/7415'
        """
        path = pathlib.Path(self._converted("whole.city.json")) if self._is_sequence() else self.path
        try:
            whole: dict[str, Any] = json.loads(path.read_bytes())
        finally:
            if path != self.path:
                path.unlink()
        return whole

    def to_cityjsonseq(self) -> Iterator[dict[str, Any]]:
        """The model as a sequence: a CityJSON object without buildings, then a ``CityJSONFeature`` for each building. They
        are read one by one.

        >>> head, *features = model.to_cityjsonseq()  # doctest: +SKIP
        """
        if self._is_sequence():
            path = os.fspath(self.path)
        else:
            path = self._scratch.file("sequence.city.jsonl")
            if not os.path.exists(path):
                self._converted("sequence.city.jsonl")
        with open(path, encoding="utf-8") as lines:
            for line in lines:
                if line.strip():
                    yield json.loads(line)

    def save(
        self, path: str | os.PathLike[str], overwrite: bool = False, *, lod: Lods = None, progress: Progress = None
    ) -> pathlib.Path:
        """Writes the model to a file or folder, whose extension chooses the format: ``.city.json``, ``.city.jsonl``,
        ``.3dtiles`` (a folder), ``.gpkg`` or ``.obj``.

        In the format in which it was made it is written byte for byte.

        :param overwrite: replace what exists
        :param lod: only these levels of detail, such as ``"2.2"`` or ``["0", "1.2"]``
        :returns: the path
        """
        target = os.fspath(path)
        own = _extension(self.path)
        if own and _extension(target) == own and lod is None:
            with Listener(progress) as listener:
                return pathlib.Path(_gable.copy(self.path, target, overwrite, listener))
        with Listener(progress) as listener:
            return pathlib.Path(_gable.convert([self.path], target, overwrite, None, lods(lod), listener))

    def to_geopandas(self, surfaces: bool = False) -> geopandas.GeoDataFrame:
        """The model as a ``geopandas.GeoDataFrame``.

        :param surfaces: instead of the footprints with all attributes, a row for each surface: its polygons in 3D, and
            ``feature``, ``lod``, ``surface_type`` and its own attributes such as ``slope``

        >>> model.to_geopandas().plot("gable_rmse_lod22")  # doctest: +SKIP
        >>> faces = model.to_geopandas(surfaces=True)  # doctest: +SKIP
        >>> faces[(faces.surface_type == "RoofSurface") & (faces.slope > 30)]  # doctest: +SKIP
        """
        try:
            import geopandas
        except ImportError:
            raise ImportError("to_geopandas() needs geopandas: pip install geopandas") from None
        path = self._converted("tables.gpkg")
        try:
            frame = geopandas.read_file(path, layer="faces" if surfaces else "footprints")
        finally:
            os.remove(path)
        return frame if surfaces else frame.set_index("id")

    @overload
    def meshes(self, lod: str | None = "2.2", merge: Literal[False] = False) -> dict[str, Mesh]: ...

    @overload
    def meshes(self, lod: str | None = "2.2", *, merge: Literal[True]) -> Mesh: ...

    def meshes(self, lod: str | None = "2.2", merge: bool = False) -> dict[str, Mesh] | Mesh:
        """The buildings as triangles: a :class:`Mesh` by id, or one of all of them.

        :param lod: the level of detail; buildings without geometry at it are left out. ``None`` for each at its finest
        :param merge: one mesh, whose :attr:`Mesh.buildings` tells of which building a triangle is

        >>> mesh = model.meshes(merge=True)  # doctest: +SKIP
        >>> roofs = mesh.triangles[mesh.semantics == "RoofSurface"]  # doctest: +SKIP
        """
        with Listener() as listener:
            arrays, names = _gable.meshes(self.path, lod if lod is None else str(lod), listener)
        types = tuple(names)
        meshes = {id: _mesh.single(id, v, t, s, types) for id, v, t, s in arrays}
        return _mesh.merged(meshes.values(), types) if merge else meshes

    def view(
        self,
        path: str | os.PathLike[str] | None = None,
        overwrite: bool = False,
        *,
        points: Any = None,
        max_points: int | None = None,
        progress: Progress = None,
    ) -> Page:
        """Makes the page of ``gable view``: one HTML file that needs no network. In Jupyter it is shown in the cell.

        :param path: where the page goes; without one it is temporary
        :param points: tiles whose points are shown around the buildings; of a model that was made from files these,
            unless ``False``
        :param max_points: show at most so many; of more an even random sample

        >>> model.view("city.html").open()  # doctest: +SKIP
        """
        own = points is None
        shown = self._tiles if own else [] if points is False else paths(points)
        keeps = Scratch() if path is None else None
        target = os.fspath(path) if keeps is None else keeps.file("model.html")  # type: ignore[arg-type]
        report = None
        if self.report is not None:
            report = self._scratch.file("report.json")
            with open(report, "w", encoding="utf-8") as file:
                json.dump(self.report.to_dict(), file)
        with Listener(progress) as listener:
            made = _gable.page(
                self.path, target, overwrite or keeps is not None, shown, max_points, own, report, listener
            )
        return Page(made, keeps)

    def _is_sequence(self) -> bool:
        return self.path.name.lower().endswith(".jsonl")

    def _converted(self, name: str) -> str:
        """The model as a file of its temporary folder; it is removed by whoever asks, unless it is to stay."""
        target = self._scratch.file(name)
        with Listener() as listener:
            return str(_gable.convert([self.path], target, True, None, [], listener))

    def __getstate__(self) -> Mapping[str, Any]:
        raise TypeError("a gable.Model stands in a file and cannot be pickled: save() it, and read() it elsewhere")


def lods(lod: Lods) -> list[str]:
    """Levels of detail, given as one, as a text with commas or as a list."""
    if lod is None:
        return []
    if isinstance(lod, str):
        return [level.strip() for level in lod.split(",")]
    if isinstance(lod, (int, float)):
        return [str(lod)]
    return [str(level) for level in lod]


def source(model: Any) -> pathlib.Path:
    """The file of a model."""
    if isinstance(model, Model):
        return model.path
    if is_path(model):
        return pathlib.Path(model)
    raise TypeError(f"a {type(model).__name__} is no model: give a path or a gable.Model")


def _extension(path: str | os.PathLike[str]) -> str | None:
    """Which of the extensions of CityJSON a path has."""
    name = os.fspath(path).lower()
    return next((extension for extension in _CITYJSON if name.endswith(extension)), None)
