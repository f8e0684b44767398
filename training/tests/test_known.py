"""What a real scan does not show changes neither the loss nor the figures."""

import tempfile
import unittest

import numpy as np
import torch

from occupancy import metrics, safetensors
from occupancy.batches import Batches, to_device
from occupancy.config import Config, Inputs, Loss
from occupancy.losses import losses
from occupancy.networks import network_of
from occupancy.shards import Layout, Shards
from tests import synthetic


class KnownTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        synthetic.write(folder.name, scans=4, validation=2, shards=1)
        torch.manual_seed(1)
        self.config = Config(name="x", inputs=Inputs(symmetries=False, footprint_dropout=0.0))
        self.shards = Shards(folder.name, "train")
        self.network = network_of(self.config, self.shards.interface)
        self.path = self.shards.files[0][0]

    def batch(self):
        return to_device(Batches(self.shards, self.config).load([0, 1, 2, 3], self.config.batch, None, False), "cpu")

    def parts(self, batch):
        return losses(self.network, self.network(batch), batch, Loss())

    def test_unknown_queries_do_not_count(self):
        batch = self.batch()
        random = torch.Generator().manual_seed(2)
        batch["known"] = (torch.rand(batch["known"].shape, generator=random) < 0.5).float()
        batch["exact"][:2] = 0.0
        before = self.parts(batch)
        # Other labels where nothing is known, other distances where they are not exact.
        changed = dict(batch)
        changed["inside"] = torch.where(batch["known"] > 0, batch["inside"], 1.0 - batch["inside"])
        after = self.parts(changed)
        self.assertEqual(float(before["sign"]), float(after["sign"]))
        changed["inside"] = 1.0 - batch["inside"]
        self.assertNotEqual(float(before["sign"]), float(self.parts(changed)["sign"]))
        radius = dict(batch, radius=batch["radius"] * torch.tensor([2.0, 3.0, 1.0, 1.0])[:, None])
        self.assertEqual(float(before["distance"]), float(self.parts(radius)["distance"]))

    def test_a_cell_counts_with_what_is_known_of_it(self):
        batch, layout = self.batch(), self.shards.layout
        batch["cell_known"][:, 0] = 0.0
        before = self.parts(batch)["cells"]
        changed = dict(batch, cell_inside=batch["cell_inside"].clone())
        changed["cell_inside"][:, 0] = 1.0 - changed["cell_inside"][:, 0]
        self.assertEqual(float(before), float(self.parts(changed)["cells"]))
        # None of the drawn samples of the second cell is known.
        first = layout.near + layout.uniform + layout.samples
        changed["known"] = batch["known"].clone()
        changed["known"][:, first : first + layout.samples] = 0.0
        one = self.parts(changed)["cells"]
        changed["cell_inside"][:, 1] = 1.0 - changed["cell_inside"][:, 1]
        self.assertEqual(float(one), float(self.parts(changed)["cells"]))
        self.assertTrue(torch.isfinite(self.parts(changed)["loss"]))

    def test_a_scan_of_which_nothing_is_known_moves_no_weight(self):
        batch = self.batch()
        for name in ("known", "exact", "cell_known"):
            batch[name] = torch.zeros_like(batch[name])
        self.parts(batch)["loss"].backward()
        self.assertEqual(max(float(p.grad.abs().max()) for p in self.network.parameters()), 0.0)

    def test_figures_leave_the_unknown_out(self):
        logit = np.array([[3.0, -3.0, 2.0, 2.0, 2.0, -2.0]])
        truth = {
            "inside": np.array([[0, 0, 1, 1, 0, 0]]),
            "known": np.array([[0, 1, 1, 0, 1, 0]]),
            "exact": np.zeros(1, np.uint8),
            "distance": np.ones((1, 6)),
            "radius": np.ones((1, 6)),
            "cell_inside": np.array([[1.0, 0.0]]),
            "cell_known": np.array([[0.5, 0.25]]),
            "cell_volume": np.array([[2.0, 2.0]]),
            "cell_vote": np.array([[1.0, 0.0]]),
            "scale": np.array([10.0]),
            "setup": np.array([synthetic.SETUPS.index("real")]),
            "noise": np.array([np.nan]),
            "density": np.array([3.0]),
        }
        predictions = metrics.Predictions(logit, np.full((1, 6), 0.5), truth, Layout(1, 1, 2, 2), synthetic.SETUPS)
        found = metrics.evaluate(predictions, 1.0)
        # No band of noise: nobody knows it.
        self.assertEqual(set(found), {"all", "real", "2–5 points/m²"})
        everything = found["all"]
        self.assertEqual((everything["sign_near"], everything["sign_uniform"]), (None, 1.0))
        self.assertIsNone(everything["distance_error_m"])
        # Cell 1, half known, is right; cell 2, a quarter known, is called inside by its only known sample.
        self.assertAlmostEqual(everything["network"]["cell_accuracy"], 0.5 / 0.75)
        self.assertAlmostEqual(everything["network"]["cell_iou"], 0.5 / 0.75)
        self.assertEqual(everything["vote"]["cell_accuracy"], 1.0)

    def test_shards_of_an_older_format_are_named(self):
        tensors, metadata = safetensors.read(self.path)
        tensors = {name: np.array(value) for name, value in tensors.items() if name != "known"}
        safetensors.write(self.path, tensors, metadata)
        with self.assertRaisesRegex(safetensors.FormatError, "known is missing"):
            Shards(self.path.parent, "train")


if __name__ == "__main__":
    unittest.main()
