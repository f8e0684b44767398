"""What goes into the network: the sizes and names which shards, network and inference agree on."""

from dataclasses import dataclass

EXTENT = 0.55
"""Half the side of the square that the raster covers, in the building's frame."""

FOOTPRINT = "footprint_"
"""Prefix of the raster and place channels that come from the footprint and may be missing at work."""


@dataclass(frozen=True)
class Interface:
    """Sizes and channel names of the inputs of one network; see the README for the tensors."""

    name: str = "field"
    raster_channels: tuple = tuple(f"r{i}" for i in range(20))
    grid: int = 32
    place_channels: tuple = ("x", "y", "z") + tuple(f"p{i}" for i in range(3, 14))
    patch_channels: tuple = ("dx", "dy", "dz", "distance", "plane_distance", "plane_nz", "plane_flag")
    neighbours: int = 16
    subsample: int = 1000

    def footprint_raster(self):
        """Indices of the raster channels that come from the footprint."""
        return [i for i, name in enumerate(self.raster_channels) if name.startswith(FOOTPRINT)]

    def footprint_place(self):
        """Indices of the place channels that come from the footprint."""
        return [i for i, name in enumerate(self.place_channels) if name.startswith(FOOTPRINT)]


def names(text):
    """The names of a comma-separated list of the metadata."""
    return tuple(name.strip() for name in text.split(",") if name.strip())
