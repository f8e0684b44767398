"""Batches of scans that all lie in the memory of the device: drawn and augmented there, scan by scan no longer."""

import numpy as np
import torch

from .batches import SQUARE
from .shards import CELL_TENSORS, QUERY_TENSORS, SCAN_TENSORS, draw


class Resident:
    """Takes the place of a `Loader` where the memory of the device holds all shards."""

    def __init__(self, batches, first_step, seed, device):
        self.batches, self.step, self.seed, self.device = batches, first_step, seed, torch.device(device)
        names = tuple(batches.names) + CELL_TENSORS + SCAN_TENSORS
        files = [tensors for _, tensors in batches.shards.files]
        # As they lie in the files: half precision stays half until a batch is drawn.
        self.data = {
            name: torch.cat([torch.from_numpy(np.array(tensors[name])) for tensors in files]).to(self.device)
            for name in names
        }
        self.epoch, self.order = None, None

    def size(self):
        """Bytes on the device."""
        return sum(tensor.numel() * tensor.element_size() for tensor in self.data.values())

    def rows(self, step):
        """The scans of a step: a function of the seed and the step alone, as in `Batches`."""
        count, scans = len(self.batches.shards), self.batches.config.batch.scans
        rows = []
        for position in range(step * scans, (step + 1) * scans):
            epoch, place = divmod(position, count)
            if epoch != self.epoch:
                self.epoch, self.order = epoch, np.random.default_rng([self.seed, 0, epoch]).permutation(count)
            rows.append(int(self.order[place]))
        return torch.tensor(rows, device=self.device)

    def next(self):
        """The batch of the next step."""
        config, interface = self.batches.config, self.batches.shards.interface
        random = np.random.default_rng([self.seed, 1, self.step])
        rows = self.rows(self.step)
        self.step += 1
        queries, cells, layout = draw(self.batches.shards.layout, config.batch, random)
        taken = {name: torch.from_numpy(queries).to(self.device) for name in QUERY_TENSORS}
        taken.update({name: torch.from_numpy(cells).to(self.device) for name in CELL_TENSORS})
        batch = {}
        for name, tensor in self.data.items():
            chosen = tensor[rows] if name not in taken else tensor[rows][:, taken[name]]
            batch[name] = chosen if name == "setup" else chosen.float()
        blind = random.random(len(rows)) < config.inputs.footprint_dropout
        withhold(batch, interface, blind if config.inputs.footprint else np.ones(len(rows), bool))
        if not config.inputs.gravity:
            turn(batch, random)
        elif config.inputs.symmetries:
            mirror(batch, random.integers(8, size=len(rows)))
        batch["layout"] = layout
        return batch

    def close(self):
        """Give the memory back."""
        self.data = {}


def withhold(batch, interface, blind):
    """Take the footprint's channels from the scans that `blind` [n] names, in place."""
    blind = torch.from_numpy(np.flatnonzero(blind)).to(batch["place"].device)
    for channel in interface.footprint_place():
        batch["place"][blind, :, channel] = 0.0
    if "raster" in batch:
        for channel in interface.footprint_raster():
            batch["raster"][blind, channel] = 0.0


def mirror(batch, which):
    """Turn or mirror every scan by the symmetry of the square that `which` [n] names, in place."""
    for index, (mirror_x, mirror_y, swap) in enumerate(SQUARE):
        rows = torch.from_numpy(np.flatnonzero(which == index)).to(batch["place"].device)
        sign = torch.tensor([-1.0 if mirror_x else 1.0, -1.0 if mirror_y else 1.0], device=rows.device)
        for name in ("place", "patch", "subsample"):
            if name in batch:
                flat = batch[name][rows, ..., :2] * sign
                batch[name][rows, ..., :2] = flat.flip(-1) if swap else flat
        if "raster" in batch:
            # Rows lie along y, columns along x.
            axes = [axis for axis, mirrored in ((2, mirror_y), (3, mirror_x)) if mirrored]
            raster = batch["raster"][rows].flip(axes)
            batch["raster"][rows] = raster.transpose(2, 3) if swap else raster


def turn(batch, random):
    """Turn every scan at random in space about the middle of its points, and drop what knows the vertical, in place."""
    points = batch["subsample"]
    q = random.normal(size=(len(points), 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)]
    rows += [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    rows += [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    back = torch.from_numpy(np.stack(rows, axis=1).reshape(-1, 3, 3)).float().to(points.device).transpose(1, 2)
    # The frame's origin lies on the ground, which would tell the vertical.
    middle = (points.amin(dim=1, keepdim=True) + points.amax(dim=1, keepdim=True)) / 2
    batch["subsample"] = (points - middle) @ back
    batch["place"] = (batch["place"][..., :3] - middle) @ back
    batch["patch"][..., :3] = batch["patch"][..., :3] @ back.unsqueeze(1)
    if batch["patch"].shape[-1] > 4:
        # Distance from the plane without its sign (up), and no inclination of the plane.
        batch["patch"][..., 4].abs_()
        batch["patch"][..., 5] = 0.0
