"""What is exported answers as the trained network does."""

import tempfile
import unittest
from pathlib import Path

import numpy as np
import torch

from occupancy import network_file, safetensors
from occupancy.field import FieldNetwork, look_up
from occupancy.interface import Interface
from occupancy.points2surf import Layer, Points2Surf, quaternion_terms

try:
    import onnxruntime
except ImportError:
    onnxruntime = None

FORBIDDEN = (b"GridSample", b"Gather", b"TopK", b"Loop", b"Scatter", b"BatchNormalization", b"ReduceMax", b"ReduceMean")


def disturbed(network):
    """Weights and statistics as training could leave them."""
    with torch.no_grad():
        for tensor in list(network.parameters()) + [
            b for m in network.modules() if isinstance(m, Layer) for b in (m.norm.running_mean,)
        ]:
            tensor.add_(0.1 * torch.randn_like(tensor))
        for module in network.modules():
            if isinstance(module, Layer):
                module.norm.running_var.uniform_(0.5, 2.0)
    return network.eval()


class NetworkFileTest(unittest.TestCase):
    def setUp(self):
        try:
            network_file.require_exporter()
        except ModuleNotFoundError as error:
            self.skipTest(str(error))
        torch.manual_seed(1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "network.safetensors"

    def sessions(self):
        """Runtime sessions of the graphs in the file."""
        if onnxruntime is None:
            self.skipTest("onnxruntime is not installed: pip install onnxruntime")
        tensors, _ = safetensors.read(self.path)
        return {
            name: onnxruntime.InferenceSession(data.tobytes(), providers=["CPUExecutionProvider"])
            for name, data in tensors.items()
        }

    def field(self):
        """A field network and one batch for it."""
        interface = Interface(
            "field", ("a", "b", "footprint_flag"), 16, ("x", "y", "z", "height"), tuple("abcdefg"), 6, 50
        )
        network = disturbed(FieldNetwork(interface, widths=(8, 12, 16), code=10, patch=(12, 14), head=(16, 16)))
        batch = {
            "raster": torch.rand(1, 3, 16, 16),
            "place": torch.rand(1, 9, 4) - 0.5,
            "patch": torch.rand(1, 9, 6, 7),
        }
        network.standardise(batch)
        return network, batch

    def test_folded_graphs_answer_alike(self):
        network, batch = self.field()
        with torch.no_grad():
            wanted = network(batch)
            code = network_file.RasterGraph(network.encoder)(batch["raster"])
            graph = network_file.FieldGraph(network.decoder, 2.0, 6)
            found = graph(look_up(code, batch["place"][..., :2]), batch["place"][0], batch["patch"][0])
        np.testing.assert_allclose(found[:, 0], wanted[:, 0] / 2.0, rtol=1e-4, atol=1e-5)
        np.testing.assert_allclose(found[:, 1], torch.sigmoid(wanted[:, 1]), rtol=1e-4, atol=1e-5)

    def test_field_answers_alike(self):
        network, batch = self.field()
        network_file.write(self.path, network, name="test", temperature=1.7, batch=9, card="card")
        sessions = self.sessions()
        code = sessions["encoder.onnx"].run(None, {"raster": batch["raster"].numpy()})[0]
        with torch.no_grad():
            looked_up = look_up(torch.tensor(code), batch["place"][..., :2])
            wanted = network(batch).numpy()
        inputs = {"code": looked_up.numpy(), "place": batch["place"][0].numpy(), "patch": batch["patch"][0].numpy()}
        found = sessions["decoder.onnx"].run(["field"], inputs)[0]
        np.testing.assert_allclose(found[:, 0], wanted[:, 0] / 1.7, atol=1e-5)
        np.testing.assert_allclose(found[:, 1], 1 / (1 + np.exp(-wanted[:, 1])), atol=1e-5)

    def test_points2surf_answers_alike(self):
        interface = Interface("points2surf", (), 0, ("x", "y", "z"), ("dx", "dy", "dz"), 12, 30)
        network = disturbed(Points2Surf(interface, 64))
        network_file.write(self.path, network, name="test", temperature=0.8, batch=5)
        batch = {"place": torch.randn(1, 5, 3), "patch": torch.randn(1, 5, 12, 3), "subsample": torch.randn(1, 30, 3)}
        sessions = self.sessions()
        self.assertEqual(list(sessions), ["decoder.onnx"])
        around = batch["subsample"] - batch["place"][0, :, None]
        found = sessions["decoder.onnx"].run(None, {"patch": batch["patch"][0].numpy(), "subsample": around.numpy()})[0]
        with torch.no_grad():
            wanted = network(batch).numpy()
        np.testing.assert_allclose(found[:, 0], wanted[:, 0] / 0.8, atol=1e-4)
        np.testing.assert_allclose(found[:, 1], np.abs(wanted[:, 1]), atol=1e-4)

    def test_the_graphs_hold_no_operator_that_the_embedded_backend_lacks(self):
        network, _ = self.field()
        network_file.write(self.path, network, name="test")
        tensors, metadata = safetensors.read(self.path)
        for data in tensors.values():
            for operator in FORBIDDEN:
                self.assertNotIn(operator, data.tobytes())
        self.assertEqual(
            (metadata["code"], metadata["batch"], metadata["neighbours"], metadata["temperature"]),
            ("10", "256", "6", "1"),
        )

    def test_equal_networks_give_equal_bytes(self):
        network, _ = self.field()
        network_file.write(self.path, network, name="test")
        first = self.path.read_bytes()
        network_file.write(self.path, network, name="test")
        self.assertEqual(self.path.read_bytes(), first)

    def test_variants_for_comparison_have_no_file(self):
        interface = Interface("field", ("a",), 16, ("x", "y", "z"), tuple("abcdefg"), 6, 50)
        with self.assertRaisesRegex(ValueError, "for comparison"):
            network_file.write(self.path, FieldNetwork(interface, "code"), name="test")

    def test_the_quaternion_turns(self):
        left, right, terms = quaternion_terms()
        # 90° about z: x goes to y.
        q = torch.tensor([[0.5**0.5, 0.0, 0.0, 0.5**0.5]]) * 3.0
        turn = ((q @ left) * (q @ right)) @ terms / (q * q).sum() + torch.eye(3).reshape(1, 9)
        torch.testing.assert_close(
            turn.reshape(3, 3) @ torch.tensor([1.0, 0.0, 0.0]), torch.tensor([0.0, 1.0, 0.0]), atol=1e-6, rtol=0
        )


if __name__ == "__main__":
    unittest.main()
