"""The configuration file of a training run: TOML, every key known, nothing ignored."""

import dataclasses
import tomllib
from dataclasses import dataclass, field
from pathlib import Path


class ConfigError(ValueError):
    """A configuration that cannot be run; the message names the file, the key and what was expected."""


@dataclass(frozen=True)
class Network:
    """Which network, and its sizes."""

    kind: str = "field"
    """ "field" or "points2surf"."""
    branch: str = "raster"
    """Global branch of the field: "raster", "tokens", "code" or "none"."""
    widths: tuple = (16, 32, 48, 64)
    """Channels of the U-Net, finest level first; each level halves the grid."""
    code: int = 24
    """Length of the building's code at a place."""
    local: bool = True
    """Whether the field has the branch on the nearest points."""
    patch: tuple = (32, 32)
    """Widths of the layers on each of the nearest points."""
    head: tuple = (64, 64)
    """Widths of the layers after the branches."""
    width: int = 1024
    """Width of Points2Surf; 1024 in the paper."""


@dataclass(frozen=True)
class Inputs:
    """What the network gets to see."""

    symmetries: bool = True
    """Turn and mirror every scan by one of the 8 symmetries of the square, at random."""
    footprint: bool = True
    """Whether the footprint's channels are given at all."""
    footprint_dropout: float = 0.15
    """Share of the scans in training that lose their footprint, so that the network works without one."""
    gravity: bool = True
    """Without: every scan is turned at random in space, and nothing that knows the vertical is given."""


@dataclass(frozen=True)
class Batch:
    """How much one step takes; a negative number takes all that a scan has."""

    scans: int = 16
    near: int = -1
    uniform: int = -1
    cells: int = -1


@dataclass(frozen=True)
class Loss:
    """Weights of the parts of the loss."""

    distance: float = 1.0
    distance_form: str = "smooth-l1"
    """ "smooth-l1" on |d| / r, or "tanh": the squared difference of tanh, as Points2Surf has it."""
    cells: float = 0.5
    """Weight of the cells' mean probability against their true inside share."""
    cell_queries: bool = True
    """Whether the samples of cells count as queries; if not, the other queries get their weight."""
    noise_band: float = 0.005
    """Signs closer to the surface than this share of the scale count less; 0 switches that off."""


@dataclass(frozen=True)
class Optimiser:
    """AdamW with warm-up, then cosine."""

    rate: float = 2e-3
    final_rate: float = 2e-5
    warm_up: int = 200
    weight_decay: float = 1e-4
    clip: float = 1.0
    average: float = 0.999
    """Decay of the running average of the weights, which is what is evaluated and exported."""


@dataclass(frozen=True)
class Run:
    """Length and bookkeeping; the command line overrides `steps`, `minutes` and `seed`."""

    steps: int = 0
    minutes: float = 0.0
    seed: int = 1
    log_steps: int = 50
    checkpoint_minutes: float = 5.0
    validation_minutes: float = 10.0
    validation_scans: int = 0
    """Scans of the validation split that are evaluated; 0 for all."""
    export_batch: int = 256
    """Queries per run of the exported decoder."""


@dataclass(frozen=True)
class Config:
    """One training run."""

    name: str
    note: str = ""
    """One line for tables: what is special about this configuration."""
    credit: tuple = ()
    """Sources of the shards with licence and credit, for the model card: one line each."""
    network: Network = field(default_factory=Network)
    inputs: Inputs = field(default_factory=Inputs)
    batch: Batch = field(default_factory=Batch)
    loss: Loss = field(default_factory=Loss)
    optimiser: Optimiser = field(default_factory=Optimiser)
    run: Run = field(default_factory=Run)


def load(path):
    """Read a configuration; `extends = "other.toml"` takes the rest from another one beside it."""
    path = Path(path)
    config = build(Config, merged(path), path, "")
    check(config, path)
    return config


def merged(path):
    """The tables of a file over those of the file that it extends."""
    try:
        with path.open("rb") as file:
            tables = tomllib.load(file)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not TOML: {error}") from error
    if "extends" not in tables:
        return tables
    base = merged(path.parent / tables.pop("extends"))
    for key, value in tables.items():
        base[key] = {**base.get(key, {}), **value} if isinstance(value, dict) else value
    return base


def build(kind, values, path, place):
    """A dataclass from a table, refusing what it does not know and what has another type."""
    known = {entry.name: entry for entry in dataclasses.fields(kind)}
    for key in values:
        if key not in known:
            raise ConfigError(f"{path}: {place}{key} is unknown; known are {', '.join(known)}")
    made = {}
    for key, value in values.items():
        wanted = known[key].type
        if dataclasses.is_dataclass(wanted):
            if not isinstance(value, dict):
                raise ConfigError(f"{path}: {place}{key} is a single value, expected a table [{key}]")
            value = build(wanted, value, path, f"{place}{key}.")
        elif wanted is tuple and isinstance(value, list):
            value = tuple(value)
        elif wanted is float and type(value) is int:
            value = float(value)
        if not dataclasses.is_dataclass(wanted) and type(value) is not wanted:
            raise ConfigError(f"{path}: {place}{key} is {value!r}, expected a value of type {wanted.__name__}")
        made[key] = value
    if "name" in known and kind is Config and "name" not in made:
        raise ConfigError(f"{path}: name is missing; it names the run and the network file")
    return kind(**made)


def check(config, path):
    """Refuse combinations that cannot mean anything."""
    network, inputs = config.network, config.inputs
    if network.kind not in ("field", "points2surf"):
        raise ConfigError(f'{path}: network.kind is "{network.kind}", expected "field" or "points2surf"')
    if config.loss.distance_form not in ("smooth-l1", "tanh"):
        raise ConfigError(
            f'{path}: loss.distance_form is "{config.loss.distance_form}", expected "smooth-l1" or "tanh"'
        )
    if network.kind == "field" and network.branch == "raster" and not inputs.gravity:
        raise ConfigError(
            f'{path}: inputs.gravity = false has no raster; take network.branch = "tokens", "code" or "none"'
        )
    if network.kind == "points2surf" and network.width < 64:
        raise ConfigError(f"{path}: network.width is {network.width}, expected at least 64")
    if not 0.0 <= inputs.footprint_dropout <= 1.0:
        raise ConfigError(f"{path}: inputs.footprint_dropout is {inputs.footprint_dropout}, expected 0 to 1")
    if config.batch.scans < 1:
        raise ConfigError(f"{path}: batch.scans is {config.batch.scans}, expected at least 1")


def as_dict(config):
    """The configuration as plain tables (for checkpoints and reports)."""
    return dataclasses.asdict(config)
