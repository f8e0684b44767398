"""Augmentation keeps raster, places and patches together; the order depends on the seed and the step alone."""

import tempfile
import unittest
from types import SimpleNamespace

import numpy as np
import torch

from occupancy.batches import (
    SQUARE,
    Batches,
    symmetric,
    without_footprint,
    without_gravity,
)
from occupancy.config import Config, Inputs
from occupancy.field import look_up
from occupancy.interface import EXTENT
from occupancy.shards import Shards
from tests import synthetic


class SymmetryTest(unittest.TestCase):
    def test_what_is_looked_up_does_not_change(self):
        random = np.random.default_rng(3)
        grid = 32
        centre = -EXTENT + 2 * EXTENT * (np.arange(grid) + 0.5) / grid
        y, x = np.meshgrid(centre, centre, indexing="ij")
        # Without any symmetry of its own, and bilinear between the pixels only in part.
        raster = np.stack([np.sin(5 * x) + 2 * y, x * y + 0.3 * x])
        place = random.uniform(-0.5, 0.5, (40, 5)).astype(np.float32)
        patch = random.uniform(-0.05, 0.05, (40, 4, 7)).astype(np.float32)
        before = self.values(raster, place, patch)
        images = []
        for symmetry in SQUARE:
            scan = {
                "raster": raster.copy(),
                "place": place.copy(),
                "patch": patch.copy(),
                "subsample": place[:, :3].copy(),
            }
            symmetric(scan, symmetry)
            for old, new in zip(before, self.values(scan["raster"], scan["place"], scan["patch"])):
                torch.testing.assert_close(new, old, atol=1e-5, rtol=0)
            np.testing.assert_array_equal(scan["subsample"], scan["place"][:, :3])
            np.testing.assert_array_equal(scan["place"][:, 2:], place[:, 2:])
            np.testing.assert_array_equal(scan["patch"][..., 2:], patch[..., 2:])
            images.append(scan["place"][:, :2].round(6).tobytes())
        self.assertEqual(len(set(images)), 8)

    @staticmethod
    def values(raster, place, patch):
        """The raster at the places and at the neighbours, by the network's own look-up."""
        codes = torch.tensor(np.ascontiguousarray(raster), dtype=torch.float32)[None]
        xy = torch.tensor(place[:, :2])
        neighbours = xy[:, None] + torch.tensor(patch[..., :2])
        return look_up(codes, xy[None]), look_up(codes, neighbours.reshape(1, -1, 2))

    def test_look_up_follows_the_contract(self):
        grid = 4
        codes = torch.arange(16.0).reshape(1, 1, grid, grid)
        pixel = 2 * EXTENT / grid
        first = -EXTENT + pixel / 2
        # Row 2, column 1; halfway to column 2; beyond the corner: the corner pixel.
        xy = torch.tensor(
            [[[first + pixel, first + 2 * pixel], [first + 1.5 * pixel, first + 2 * pixel], [-2.0, -2.0]]]
        )
        torch.testing.assert_close(look_up(codes, xy), torch.tensor([[9.0], [9.5], [0.0]]), atol=1e-4, rtol=0)


class BatchesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        synthetic.write(folder.name, scans=6, validation=2)
        self.shards = Shards(folder.name, "train")

    def test_without_footprint_only_its_channels_are_zero(self):
        scan = {name: np.array(value, dtype=np.float32) + 1.0 for name, value in self.shards.scan(0).items()}
        without_footprint(scan, self.shards.interface)
        self.assertEqual(
            [float(abs(channel).max()) == 0.0 for channel in scan["raster"]], [False, False, False, True, True]
        )
        self.assertEqual([float(abs(channel).max()) == 0.0 for channel in scan["place"].T], [False] * 6 + [True, True])

    def test_without_gravity_lengths_stay(self):
        scan = {name: np.array(value) for name, value in self.shards.scan(0).items()}
        before = {name: value.astype(np.float64) for name, value in scan.items()}
        without_gravity(scan, np.random.default_rng(0))
        self.assertEqual(scan["place"].shape[1], 3)
        for name in ("patch", "subsample"):
            self.assertGreater(np.abs(scan[name][..., 2] - before[name][..., 2]).max(), 0.05)
        np.testing.assert_allclose(
            np.linalg.norm(scan["patch"][..., :3], axis=-1),
            np.linalg.norm(before["patch"][..., :3], axis=-1),
            atol=1e-5,
        )

        def between(s):
            return np.linalg.norm(s["place"][:, None, :3] - s["subsample"][None], axis=-1)

        np.testing.assert_allclose(between(scan), between(before), atol=1e-5)
        self.assertEqual(float(np.abs(scan["patch"][..., 5]).max()), 0.0)

    def test_a_batch_depends_on_seed_and_step_alone(self):
        config = Config(name="x", inputs=Inputs(footprint_dropout=0.5))
        one, other = Batches(self.shards, config), Batches(self.shards, config)
        for step in range(3):
            one.training(step, 5)
        a, b, c = one.training(3, 5), other.training(3, 5), other.training(3, 6)
        self.assertTrue(all(torch.equal(a[name], b[name]) for name in a if torch.is_tensor(a[name])))
        self.assertFalse(torch.equal(a["place"], c["place"]))

    def test_every_scan_comes_once_per_epoch(self):
        config = Config(name="x", inputs=Inputs(symmetries=False, footprint_dropout=0.0))
        batches = Batches(self.shards, config)
        seen = []
        batches.load = lambda indices, *_: seen.extend(indices)
        batches.config = SimpleNamespace(batch=SimpleNamespace(scans=4))
        for step in range(3):
            batches.training(step, 1)
        self.assertEqual(sorted(seen[:6]), list(range(6)))
        self.assertEqual(sorted(seen[6:]), list(range(6)))


if __name__ == "__main__":
    unittest.main()
