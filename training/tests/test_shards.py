"""Shards are read as written, and what is wrong with them is named."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from occupancy import safetensors
from occupancy.config import Batch
from occupancy.shards import Layout, Shards, draw
from tests import synthetic


class ShardsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_tensors_of_every_type_come_back(self):
        path = self.folder / "a.safetensors"
        tensors = {
            "half": np.arange(6, dtype=np.float16).reshape(2, 3),
            "single": np.array([1.5, -2.0], np.float32),
            "byte": np.array([[7, 255]], np.uint8),
            "none": np.zeros((0, 4), np.float32),
        }
        safetensors.write(path, tensors, {"key": "wörd"})
        found, metadata = safetensors.read(path)
        self.assertEqual(metadata, {"key": "wörd"})
        self.assertEqual(set(found), set(tensors))
        for name, tensor in tensors.items():
            self.assertEqual(found[name].dtype, tensor.dtype)
            np.testing.assert_array_equal(found[name], tensor)

    def test_bytes_are_those_of_the_format(self):
        path = self.folder / "a.safetensors"
        safetensors.write(path, {"x": np.array([1, 2], np.uint8)}, {})
        data = path.read_bytes()
        length = int.from_bytes(data[:8], "little")
        self.assertEqual(
            data[8 : 8 + length].strip(), b'{"__metadata__":{},"x":{"dtype":"U8","shape":[2],"data_offsets":[0,2]}}'
        )
        self.assertEqual(data[8 + length :], b"\x01\x02")

    def test_a_scan_is_found_in_its_shard(self):
        synthetic.write(self.folder, scans=6, shards=2)
        shards = Shards(self.folder, "train")
        self.assertEqual(len(shards), 6)
        second, _ = safetensors.read(self.folder / "train-00001.safetensors")
        np.testing.assert_array_equal(shards.scan(4)["place"], second["place"][1])
        self.assertEqual(shards.interface.raster_channels, synthetic.RASTER)
        self.assertEqual(shards.interface.neighbours, 8)

    def test_drawn_queries_keep_the_samples_of_a_cell_together(self):
        queries, cells, layout = draw(Layout(4, 3, 5, 2), Batch(near=2, uniform=-1, cells=2), np.random.default_rng(0))
        self.assertEqual((layout.near, layout.uniform, layout.cells, layout.queries), (2, 3, 2, 9))
        self.assertTrue(all(q < 4 for q in queries[:2]))
        self.assertEqual(list(queries[2:5]), [4, 5, 6])
        self.assertEqual(list(queries[5:]), [7 + 2 * cells[0], 8 + 2 * cells[0], 7 + 2 * cells[1], 8 + 2 * cells[1]])

    def test_wrong_files_are_named(self):
        with self.assertRaisesRegex(safetensors.FormatError, "no shards"):
            Shards(self.folder, "train")
        synthetic.write(self.folder, scans=2, shards=1)
        with self.assertRaisesRegex(safetensors.FormatError, "no test-"):
            Shards(self.folder, "test")
        path = self.folder / "train-00000.safetensors"
        tensors, metadata = safetensors.read(path)
        tensors = {name: np.array(value) for name, value in tensors.items()}
        metadata["raster_channels"] = "hit,highest"
        safetensors.write(path, tensors, metadata)
        with self.assertRaisesRegex(safetensors.FormatError, "train-00000.*raster.*raster_channels"):
            Shards(self.folder, "train")
        path.write_bytes(path.read_bytes()[:5000])
        with self.assertRaisesRegex(safetensors.FormatError, "cut off"):
            Shards(self.folder, "train")


if __name__ == "__main__":
    unittest.main()
