"""Batches of scans: drawn in a seeded order, augmented, and loaded beside the training step."""

import queue
import threading

import numpy as np
import torch

from .shards import CELL_TENSORS, QUERY_TENSORS, SCAN_TENSORS, draw

SQUARE = tuple(
    (mirror_x, mirror_y, swap) for swap in (False, True) for mirror_y in (False, True) for mirror_x in (False, True)
)
"""The 8 symmetries of the square: first mirror x, mirror y, then exchange x and y."""


def symmetric(scan, symmetry):
    """Turn or mirror one scan about the vertical: raster, places, patches and sub-sample together, in place.

    `scan` holds the arrays of one scan (own copies, not the mapped file) under the names of the shards.
    """
    mirror_x, mirror_y, swap = symmetry
    sign = np.array([-1.0 if mirror_x else 1.0, -1.0 if mirror_y else 1.0])
    for name in ("place", "patch", "subsample"):
        if name in scan:
            flat = scan[name][..., :2] * sign.astype(scan[name].dtype)
            scan[name][..., :2] = flat[..., ::-1] if swap else flat
    if "raster" in scan:
        # Rows lie along y, columns along x.
        raster = scan["raster"][:, :: -1 if mirror_y else 1, :: -1 if mirror_x else 1]
        scan["raster"] = raster.swapaxes(1, 2) if swap else raster


def without_footprint(scan, interface):
    """Take the footprint's channels, its flag included, from one scan, in place."""
    scan["place"][:, interface.footprint_place()] = 0.0
    if "raster" in scan:
        scan["raster"][interface.footprint_raster()] = 0.0


def without_gravity(scan, random):
    """Turn one scan at random in space about the middle of its points, and drop what knows the vertical, in place."""
    q = random.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    points = scan["subsample"].astype(np.float32)
    # The frame's origin lies on the ground, which would tell the vertical.
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    scan["subsample"] = (points - middle) @ turn.T
    scan["place"] = (scan["place"][:, :3] - middle) @ turn.T
    patch = scan["patch"].astype(np.float32)
    patch[..., :3] = patch[..., :3] @ turn.T
    if patch.shape[-1] > 4:
        # Distance from the plane without its sign (up), and no inclination of the plane.
        patch[..., 4] = np.abs(patch[..., 4])
        patch[..., 5] = 0.0
    scan["patch"] = patch


class Batches:
    """Batches of one split for one configuration."""

    def __init__(self, shards, config):
        self.shards, self.config = shards, config
        points = (
            config.network.kind == "points2surf"
            or config.network.branch in ("tokens", "code")
            or not config.inputs.gravity
        )
        raster = config.network.kind == "field" and config.network.branch == "raster"
        self.names = QUERY_TENSORS + (("raster",) if raster else ()) + (("subsample",) if points else ())
        self.epoch, self.order = None, None

    def load(self, indices, batch, random, training):
        """The scans `indices` as one dictionary of tensors [n, …], the layout of their queries under "layout"."""
        inputs, interface = self.config.inputs, self.shards.interface
        scans = []
        for index in indices:
            mapped = self.shards.scan(index)
            queries, cells, layout = draw(self.shards.layout, batch, random)
            # Indexing by an array copies: what follows may change it.
            scan = {
                name: mapped[name][queries] if name in QUERY_TENSORS else np.array(mapped[name]) for name in self.names
            }
            scan.update({name: mapped[name][cells] for name in CELL_TENSORS})
            scan.update({name: mapped[name] for name in SCAN_TENSORS})
            if not inputs.footprint or (training and random.random() < inputs.footprint_dropout):
                without_footprint(scan, interface)
            if not inputs.gravity:
                without_gravity(scan, random)
            elif training and inputs.symmetries:
                symmetric(scan, SQUARE[random.integers(8)])
            scans.append(scan)
        loaded = {name: torch.from_numpy(np.stack([scan[name] for scan in scans])) for name in scans[0]}
        loaded["layout"] = layout
        return loaded

    def training(self, step, seed):
        """The batch of a step: a function of the seed and the step alone, so that a run can go on where it stopped."""
        count, scans = len(self.shards), self.config.batch.scans
        indices = []
        for position in range(step * scans, (step + 1) * scans):
            epoch, place = divmod(position, count)
            if epoch != self.epoch:
                self.epoch, self.order = epoch, np.random.default_rng([seed, 0, epoch]).permutation(count)
            indices.append(int(self.order[place]))
        return self.load(indices, self.config.batch, np.random.default_rng([seed, 1, step]), True)


def to_device(batch, device):
    """Single-precision tensors on the device; halves travel as halves."""
    moved = {}
    for name, value in batch.items():
        if torch.is_tensor(value):
            value = value.to(device, non_blocking=True)
            if name != "setup":
                value = value.float()
        moved[name] = value
    return moved


class Loader:
    """Loads the batches of the coming steps in a thread of its own."""

    def __init__(self, batches, first_step, seed, pin, ahead=3):
        self.queue = queue.Queue(maxsize=ahead)
        self.stop = threading.Event()
        self.thread = threading.Thread(target=self.run, args=(batches, first_step, seed, pin), daemon=True)
        self.thread.start()

    def run(self, batches, step, seed, pin):
        """Fill the queue until told to stop; an error travels to the consumer."""
        while not self.stop.is_set():
            try:
                item = batches.training(step, seed)
                if pin:
                    item = {
                        name: value.pin_memory() if torch.is_tensor(value) else value for name, value in item.items()
                    }
            except Exception as error:  # handed over: the training thread raises it again
                item = error
            while not self.stop.is_set():
                try:
                    self.queue.put(item, timeout=0.2)
                    break
                except queue.Full:
                    continue
            if isinstance(item, Exception):
                return
            step += 1

    def next(self):
        """The batch of the next step."""
        item = self.queue.get()
        if isinstance(item, Exception):
            raise item
        return item

    def close(self):
        """Stop the thread and wait for it."""
        self.stop.set()
        self.thread.join()
