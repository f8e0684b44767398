"""What goes into the network: the sizes and names which shards, network and inference agree on."""

from dataclasses import dataclass

EXTENT = 0.55
"""Half the side of the square that the raster covers, in the building's frame."""

FOOTPRINT = "footprint_"
"""Prefix of the raster and place channels that come from the footprint and may be missing at work."""


@dataclass(frozen=True)
class Interface:
    """Sizes and channel names of the inputs of one network, as the metadata of shards and network files tell them.

    The first three place channels are x, y, z of the building's frame; the first four patch channels are the offset
    Δx, Δy, Δz and its length, all divided by the radius of the patch.
    """

    name: str
    raster_channels: tuple
    grid: int
    place_channels: tuple
    patch_channels: tuple
    neighbours: int
    subsample: int

    def footprint_raster(self):
        """Indices of the raster channels that come from the footprint."""
        return [i for i, name in enumerate(self.raster_channels) if name.startswith(FOOTPRINT)]

    def footprint_place(self):
        """Indices of the place channels that come from the footprint."""
        return [i for i, name in enumerate(self.place_channels) if name.startswith(FOOTPRINT)]


def names(text):
    """The names of a comma-separated list of the metadata."""
    return tuple(name.strip() for name in text.split(",") if name.strip())
