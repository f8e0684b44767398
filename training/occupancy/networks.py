"""From a configuration and the shards' interface to a network."""

import dataclasses

from .config import ConfigError
from .field import FieldNetwork
from .points2surf import Points2Surf


def network_of(config, interface):
    """An untrained network; the weights depend on torch's seed."""
    wanted = config.network
    if interface.name != wanted.kind:
        raise ConfigError(
            f'the shards have the interface "{interface.name}", the configuration "{config.name}" wants '
            f'"{wanted.kind}"; simulate shards for it'
        )
    if wanted.kind == "points2surf":
        return Points2Surf(interface, wanted.width)
    if not config.inputs.gravity:
        interface = dataclasses.replace(interface, place_channels=interface.place_channels[:3])
    levels = len(wanted.widths) - 1
    if wanted.branch == "raster" and interface.grid % 2**levels != 0:
        raise ConfigError(
            f"a grid of {interface.grid} cannot be halved {levels} times; give network.widths fewer levels"
        )
    return FieldNetwork(interface, wanted.branch, wanted.widths, wanted.code, wanted.local, wanted.patch, wanted.head)
