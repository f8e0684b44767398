"""Batches drawn on the device are those that a loader could have drawn, and depend on seed and step alone."""

import dataclasses
import tempfile
import unittest

import numpy as np
import torch

from occupancy.batches import SQUARE, Batches, symmetric
from occupancy.config import Batch, Config, Inputs
from occupancy.resident import Resident, mirror, turn
from occupancy.shards import Shards
from tests import synthetic


class ResidentTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        synthetic.write(folder.name, scans=6, validation=2)
        self.shards = Shards(folder.name, "train")
        self.config = Config(name="x", batch=Batch(scans=4))

    def resident(self, step=0, seed=5, **inputs):
        config = dataclasses.replace(self.config, inputs=Inputs(**inputs))
        return Resident(Batches(self.shards, config), step, seed, "cpu")

    def test_plain_batches_are_those_of_the_loader(self):
        plain = {"symmetries": False, "footprint_dropout": 0.0}
        resident = self.resident(**plain)
        batches = Batches(self.shards, dataclasses.replace(self.config, inputs=Inputs(**plain)))
        for step in range(4):
            one, other = resident.next(), batches.training(step, 5)
            self.assertEqual(one["layout"], other["layout"])
            self.assertEqual(set(one), set(other))
            for name in set(one) - {"layout"}:
                torch.testing.assert_close(one[name].float(), other[name].float(), atol=0, rtol=0)

    def test_batches_go_on_where_a_run_stopped(self):
        straight = self.resident(footprint_dropout=0.5)
        for _ in range(2):
            straight.next()
        later = self.resident(step=2, footprint_dropout=0.5)
        one, other = straight.next(), later.next()
        self.assertTrue(all(torch.equal(one[name], other[name]) for name in one if name != "layout"))
        self.assertFalse(torch.equal(one["place"], self.resident(step=2, seed=6, footprint_dropout=0.5).next()["place"]))

    def test_every_scan_is_mirrored_as_alone(self):
        scans = [{name: np.array(value, np.float32) for name, value in self.shards.scan(0).items()} for _ in SQUARE]
        names = ("place", "patch", "subsample", "raster")
        batch = {name: torch.from_numpy(np.stack([scan[name] for scan in scans])) for name in names}
        which = np.random.default_rng(1).permutation(len(SQUARE))
        mirror(batch, which)
        for row, (scan, index) in enumerate(zip(scans, which)):
            symmetric(scan, SQUARE[index])
            for name in names:
                np.testing.assert_array_equal(batch[name][row].numpy(), scan[name])

    def test_without_a_footprint_its_channels_are_zero(self):
        batch = self.resident(footprint=False).next()
        interface = self.shards.interface
        self.assertEqual(float(batch["place"][:, :, interface.footprint_place()].abs().max()), 0.0)
        self.assertEqual(float(batch["raster"][:, interface.footprint_raster()].abs().max()), 0.0)
        self.assertGreater(float(batch["raster"][:, 0].abs().max()), 0.0)

    def test_turned_lengths_stay(self):
        batch = {
            name: torch.stack([torch.from_numpy(np.array(self.shards.scan(i)[name], np.float32)) for i in range(3)])
            for name in ("place", "patch", "subsample")
        }
        before = {name: value.clone() for name, value in batch.items()}
        turn(batch, np.random.default_rng(0))

        def between(b):
            return (b["place"][:, :, None, :3] - b["subsample"][:, None]).norm(dim=-1)

        torch.testing.assert_close(between(batch), between(before), atol=1e-4, rtol=1e-4)
        self.assertGreater(float((batch["patch"][..., 2] - before["patch"][..., 2]).abs().max()), 0.05)
        self.assertEqual(batch["place"].shape[-1], 3)
        self.assertEqual(float(batch["patch"][..., 5].abs().max()), 0.0)


if __name__ == "__main__":
    unittest.main()
