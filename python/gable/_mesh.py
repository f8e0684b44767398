"""Triangles."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one building or of several.

    Faces that share an edge share its vertices, so the mesh of a valid solid is closed:

    >>> trimesh.Trimesh(mesh.vertices, mesh.triangles).is_watertight  # doctest: +SKIP
    True
    >>> pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.triangles).plot()  # doctest: +SKIP
    """

    #: Coordinates in the CRS of the model, float64 [n, 3].
    vertices: NDArray[np.float64]
    #: Vertices of each triangle, counter-clockwise from outside, int64 [m, 3].
    triangles: NDArray[np.int64]
    #: The type of the surface of each triangle as a place in :attr:`surface_types`, int32 [m].
    surfaces: NDArray[np.int32]
    #: ``RoofSurface``, ``WallSurface``, …; ``""`` for a surface without a type.
    surface_types: tuple[str, ...]
    #: The building of each triangle as a place in :attr:`ids`, int32 [m].
    buildings: NDArray[np.int32]
    #: The ids of the buildings.
    ids: tuple[str, ...] = field(repr=False)

    @property
    def semantics(self) -> NDArray[np.str_]:
        """The type of the surface of each triangle as text [m]."""
        return np.array(self.surface_types, dtype=str)[self.surfaces]

    def __repr__(self) -> str:
        count = f"{len(self.ids)} buildings, " if len(self.ids) != 1 else ""
        return f"<gable.Mesh: {count}{len(self.vertices)} vertices, {len(self.triangles)} triangles>"


def single(
    id: str,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    surfaces: NDArray[np.int32],
    types: tuple[str, ...],
) -> Mesh:
    """The mesh of one building."""
    return Mesh(vertices, triangles, surfaces, types, np.zeros(len(triangles), np.int32), (id,))


def merged(meshes: Iterable[Mesh], types: tuple[str, ...]) -> Mesh:
    """One mesh of several, which share nothing."""
    meshes = list(meshes)
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([np.empty((0, 3)), *(mesh.vertices for mesh in meshes)]),
        np.concatenate([np.empty((0, 3), np.int64), *(m.triangles + first for m, first in zip(meshes, firsts))]),
        np.concatenate([np.empty(0, np.int32), *(mesh.surfaces for mesh in meshes)]),
        types,
        np.repeat(np.arange(len(meshes), dtype=np.int32), [len(mesh.triangles) for mesh in meshes]),
        tuple(mesh.ids[0] for mesh in meshes),
    )
