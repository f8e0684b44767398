"""Shards: folders of safetensors files that `gable simulate` writes, one row per virtual scan."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import safetensors
from .interface import Interface, names
from .safetensors import FormatError

CELL_TENSORS = ("cell_inside", "cell_known", "cell_volume", "cell_vote")
SCAN_TENSORS = ("scale", "exact", "setup", "noise", "density")
QUERY_TENSORS = ("place", "patch", "radius", "inside", "known", "distance")


@dataclass(frozen=True)
class Layout:
    """How the queries of a scan follow each other: near the surface, uniform, then the cells' samples."""

    near: int
    uniform: int
    cells: int
    samples: int

    @property
    def queries(self):
        """Queries per scan."""
        return self.near + self.uniform + self.cells * self.samples


def folders_of(data):
    """The folders of shards: one path, or several."""
    return [Path(data)] if isinstance(data, (str, Path)) else [Path(folder) for folder in data]


class Shards:
    """All shards of one split in one folder or several, mapped into memory; row i is scan i."""

    def __init__(self, folders, split):
        self.files, described, paths = [], None, []
        for folder in folders_of(folders):
            if not any(folder.glob("*.safetensors")):
                raise FormatError(f"{folder}: no shards; write them with `gable simulate`")
            paths += sorted(folder.glob(f"{split}-*.safetensors"))
        if not paths:
            named = ", ".join(str(folder) for folder in folders_of(folders))
            raise FormatError(f"{named}: no {split}-*.safetensors; `gable simulate --split` gives every split its share")
        for path in paths:
            tensors, metadata = safetensors.read(path)
            described = described or (path, metadata)
            for key in (
                "interface",
                "raster_channels",
                "place_channels",
                "patch_channels",
                "near",
                "uniform",
                "cells",
                "samples_per_cell",
                "setups",
            ):
                if metadata.get(key) != described[1].get(key):
                    raise FormatError(
                        f"{path}: {key} is {metadata.get(key)!r}, but {described[1].get(key)!r} in {described[0]}; "
                        "all shards must be of one kind"
                    )
            for name, tensor in tensors.items():
                wanted = self.files[0][1].get(name) if self.files else tensor
                if (
                    wanted is None
                    or wanted.shape[1:] != tensor.shape[1:]
                    or len(tensor) != len(next(iter(tensors.values())))
                ):
                    raise FormatError(
                        f"{path}: {name} {tensor.shape} does not fit the other tensors, or those of {described[0]}"
                    )
            self.files.append((path, tensors))
        path, metadata = described
        self.setups = names(metadata.get("setups", ""))
        try:
            self.layout = Layout(*(int(metadata[key]) for key in ("near", "uniform", "cells", "samples_per_cell")))
        except (KeyError, ValueError) as error:
            raise FormatError(f"{path}: the metadata lacks the numbers of queries ({error})") from error
        first = self.files[0][1]
        self.check(path, first, metadata)
        self.interface = Interface(
            name=metadata["interface"],
            raster_channels=names(metadata.get("raster_channels", "")) if "raster" in first else (),
            grid=first["raster"].shape[2] if "raster" in first else 0,
            place_channels=names(metadata["place_channels"]),
            patch_channels=names(metadata["patch_channels"]),
            neighbours=first["patch"].shape[2],
            subsample=first["subsample"].shape[1],
        )
        self.starts = np.cumsum([0] + [tensors["place"].shape[0] for _, tensors in self.files])

    def check(self, path, tensors, metadata):
        """The first shard has what the README lists, in sizes that fit the metadata."""
        for name in QUERY_TENSORS + CELL_TENSORS + SCAN_TENSORS + ("subsample",):
            if name not in tensors:
                raise FormatError(f"{path}: tensor {name} is missing")
        for name, axis, key in (
            ("place", 2, "place_channels"),
            ("patch", 3, "patch_channels"),
            ("raster", 1, "raster_channels"),
        ):
            if name in tensors and tensors[name].shape[axis] != len(names(metadata.get(key, ""))):
                raise FormatError(f"{path}: {name} {tensors[name].shape} does not fit {key} = {metadata.get(key)!r}")
        if tensors["place"].shape[1] != self.layout.queries:
            raise FormatError(
                f"{path}: {tensors['place'].shape[1]} queries per scan, the metadata tells {self.layout.queries}"
            )

    def __len__(self):
        return int(self.starts[-1])

    def scan(self, index):
        """Views of the tensors of one scan."""
        file = int(np.searchsorted(self.starts, index, side="right")) - 1
        row = index - int(self.starts[file])
        return {name: tensor[row] for name, tensor in self.files[file][1].items()}


def draw(layout, batch, random):
    """Indices of the queries and of the cells that one step takes of a scan, and the layout that they make."""

    def some(have, want):
        if want < 0 or want >= have:
            return np.arange(have)
        return np.sort(random.choice(have, want, replace=False))

    near, uniform, cells = (
        some(layout.near, batch.near),
        some(layout.uniform, batch.uniform),
        some(layout.cells, batch.cells),
    )
    samples = (cells[:, None] * layout.samples + np.arange(layout.samples)).ravel()
    queries = np.concatenate([near, layout.near + uniform, layout.near + layout.uniform + samples])
    return queries, cells, Layout(len(near), len(uniform), len(cells), layout.samples)
