"""The loop learns, goes on to the bit where it stopped, and writes what the README promises."""

import contextlib
import dataclasses
import io
import json
import signal
import tempfile
import unittest
from pathlib import Path

import numpy as np
import torch

import train
from occupancy import metrics, network_file, safetensors
from occupancy.batches import Batches, to_device
from occupancy.config import (
    Batch,
    Config,
    ConfigError,
    Inputs,
    Loss,
    Network,
    Optimiser,
    Run,
    load,
)
from occupancy.shards import Layout, Shards
from occupancy.trainer import ResumeError, Trainer
from tests import synthetic

FOLDER = Path(__file__).resolve().parent.parent
SMALL = Config(
    name="small",
    network=Network(widths=(8, 16, 16), code=8, patch=(16, 16), head=(32, 32)),
    batch=Batch(scans=4),
    run=Run(steps=12, log_steps=6, seed=3),
)


def silent(*_):
    """No report."""


class TrainingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        torch.set_num_threads(1)
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.data = Path(folder.name) / "field"
        synthetic.write(cls.data)
        cls.points = Path(folder.name) / "points2surf"
        synthetic.write(cls.points, interface="points2surf", neighbours=20, subsample=50, layout=(4, 4, 2, 4))

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = Path(folder.name)

    def test_a_hundred_steps_fit_one_shard(self):
        config = dataclasses.replace(
            SMALL,
            inputs=Inputs(symmetries=False, footprint_dropout=0.0),
            batch=Batch(scans=16),
            optimiser=Optimiser(rate=1e-2, warm_up=10, average=0.9),
            run=Run(steps=100, log_steps=100),
        )
        trainer = Trainer(config, self.data, self.out)
        trainer.train(silent)
        predictions = metrics.predict(trainer.averaged(), Batches(Shards(self.data, "train"), config), trainer.device)
        found = metrics.figures(predictions, 1.0, np.ones(16, bool))
        self.assertGreater(found["sign_uniform"], 0.97)
        self.assertGreater(found["sign_near"], 0.9)
        self.assertGreater(found["network"]["cell_accuracy"], 0.85)
        # Far better than the mean distance, which is what a constant answer could reach.
        self.assertLess(
            found["distance_error_m"],
            0.5 * np.abs(predictions.truth["distance"] - predictions.truth["distance"].mean()).mean(),
        )

    def test_a_resumed_run_ends_with_the_same_weights(self):
        straight = Trainer(SMALL, self.data, self.out / "straight")
        self.assertTrue(straight.train(silent))
        stopped = Trainer(SMALL, self.data, self.out / "stopped")
        self.assertFalse(stopped.train(lambda _: signal.raise_signal(signal.SIGTERM)))
        self.assertEqual(stopped.step, 6)
        resumed = Trainer(SMALL, self.data, self.out / "stopped", resume=True)
        self.assertTrue(resumed.train(silent))
        for a, b in zip(straight.network.parameters(), resumed.network.parameters()):
            self.assertTrue(torch.equal(a, b))
        for a, b in zip(straight.average, resumed.average):
            self.assertTrue(torch.equal(a, b))
        rows = [(self.out / run / "curve.csv").read_text().splitlines() for run in ("straight", "stopped")]
        self.assertEqual([row.split(",")[3:] for row in rows[0]], [row.split(",")[3:] for row in rows[1]])

    def test_a_resident_run_learns_and_resumes_like_any_other(self):
        straight = Trainer(SMALL, self.data, self.out / "straight", resident=True)
        self.assertTrue(straight.train(silent))
        stopped = Trainer(SMALL, self.data, self.out / "stopped", resident=True)
        first = []

        def stop(text):
            first.append(text)
            if text.startswith("step"):
                signal.raise_signal(signal.SIGTERM)

        self.assertFalse(stopped.train(stop))
        self.assertIn("GB of shards", first[0])
        resumed = Trainer(SMALL, self.data, self.out / "stopped", resume=True, resident=True)
        self.assertTrue(resumed.train(silent))
        for a, b in zip(straight.average, resumed.average):
            self.assertTrue(torch.equal(a, b))

    def test_a_run_starts_from_a_network_file(self):
        try:
            network_file.require_exporter()
        except ModuleNotFoundError as error:
            self.skipTest(str(error))
        trainer = Trainer(SMALL, self.data, self.out / "first")
        trainer.train(silent)
        path, before = self.out / "small.safetensors", trainer.averaged()
        network_file.write(path, before, name="small", temperature=1.0, batch=8)
        # Other data: other scaling of the inputs, which the weights make up for.
        other = self.out / "other"
        synthetic.write(other, seed=9)
        warm = Trainer(SMALL, other, self.out / "second", start=path)
        batch = to_device(warm.batches.load([0, 1], SMALL.batch, np.random.default_rng(0), False), "cpu")
        with torch.no_grad():
            torch.testing.assert_close(warm.network.eval()(batch), before(batch), atol=1e-3, rtol=1e-3)
        wider = dataclasses.replace(SMALL, network=dataclasses.replace(SMALL.network, head=(48, 32)))
        with self.assertRaisesRegex(safetensors.FormatError, r"head.0.weight is \(32, .*wants \(48"):
            Trainer(wider, other, self.out / "third", start=path)

    def test_the_pace_of_the_command_line(self):
        config = train.with_pace(SMALL, rate=1e-3, scans=9)
        self.assertEqual((config.optimiser.rate, config.batch.scans), (1e-3, 9))
        self.assertAlmostEqual(config.optimiser.final_rate, 1e-5)
        with self.assertRaisesRegex(ConfigError, "--scans"):
            train.with_pace(SMALL, scans=0)

    def test_a_run_is_neither_overwritten_nor_mixed(self):
        Trainer(SMALL, self.data, self.out).save()
        with self.assertRaisesRegex(ResumeError, "--resume"):
            Trainer(SMALL, self.data, self.out)
        other = dataclasses.replace(SMALL, loss=Loss(cells=0.25))
        with self.assertRaisesRegex(ResumeError, "loss was"):
            Trainer(other, self.data, self.out, resume=True)

    def test_every_variant_takes_a_step(self):
        variants = [
            (self.data, Network(branch=branch, code=8), gravity)
            for branch in ("tokens", "code", "none")
            for gravity in (True, False)
        ]
        variants += [
            (self.data, dataclasses.replace(SMALL.network, local=False), True),
            (self.points, Network(kind="points2surf", width=64), False),
        ]
        for index, (data, network, gravity) in enumerate(variants):
            with self.subTest(network=network, gravity=gravity):
                inputs = Inputs(gravity=gravity, footprint=False)
                config = dataclasses.replace(
                    SMALL, network=network, inputs=inputs, loss=Loss(cell_queries=False, distance_form="tanh")
                )
                trainer = Trainer(config, data, self.out / str(index))
                before = [p.detach().clone() for p in trainer.network.parameters()]
                self.assertTrue(torch.isfinite(trainer.update(trainer.batches.training(0, 1))).all())
                moved = [not torch.equal(a, b) for a, b in zip(before, trainer.network.parameters())]
                # Biases before a BatchNorm, and layers behind zeros at the start, do not move.
                self.assertGreater(sum(moved), 0.5 * len(moved))
                predictions = metrics.predict(trainer.averaged(), trainer.validation, trainer.device, 2)
                self.assertTrue(np.isfinite(predictions.logit).all())

    def test_the_command_writes_figures_card_and_network(self):
        try:
            network_file.require_exporter()
        except ModuleNotFoundError as error:
            self.skipTest(str(error))
        config = self.out / "small.toml"
        config.write_text(
            'name = "small"\ncredit = ["Villages by A, CC BY 4.0"]\n'
            "[network]\nwidths = [8, 16]\n[batch]\nscans = 4\n[run]\nlog_steps = 2\n"
        )
        command = [
            "--config",
            str(config),
            "--data",
            str(self.data),
            "--out",
            str(self.out / "run"),
            "--steps",
            "4",
            "--seed",
            "9",
        ]
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(train.main(command), 0)
        tensors, metadata = safetensors.read(self.out / "run" / "small.safetensors")
        self.assertEqual(sorted(tensors), ["decoder.onnx", "encoder.onnx"])
        self.assertEqual(metadata["raster_channels"], ",".join(synthetic.RASTER))
        self.assertEqual(
            (metadata["interface"], metadata["version"], metadata["grid"], metadata["code"]), ("field", "1", "16", "24")
        )
        for text in ("- Villages by A, CC BY 4.0", "seed 9", "4 steps", "boxes and gables"):
            self.assertIn(text, metadata["card"])
        figures = json.loads((self.out / "run" / "metrics.json").read_text())
        self.assertEqual(figures["figures"]["all"]["scans"], 8)
        self.assertEqual(float(metadata["temperature"]), float(f"{figures['temperature']:.6g}"))


class ConfigTest(unittest.TestCase):
    def test_the_shipped_configurations_are_read(self):
        paths = sorted(FOLDER.glob("*.toml")) + sorted(FOLDER.glob("ablations/*.toml"))
        self.assertGreater(len(paths), 8)
        names = [load(path).name for path in paths]
        self.assertEqual(len(set(names)), len(names))

    def test_unknown_keys_and_wrong_types_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "x.toml"
            for text, message in (
                ('name = "x"\n[network]\nwidht = 3\n', "network.widht is unknown"),
                ('name = "x"\n[batch]\nscans = "many"\n', "batch.scans is 'many', expected"),
                ('name = "x"\n[inputs]\ngravity = false\n', "gravity = false has no raster"),
                ("[run]\nsteps = 3\n", "name is missing"),
            ):
                path.write_text(text)
                with self.assertRaisesRegex(ConfigError, message):
                    load(path)


class MetricsTest(unittest.TestCase):
    def predictions(self):
        """Two scans of two cells with two samples each; logits chosen by hand."""
        logit = np.array([[3.0, -3.0, 4.0, 2.0, -1.0, -3.0], [3.0, -3.0, -2.0, -4.0, -1.0, -1.0]])
        truth = {
            "inside": np.array([[1, 0, 1, 1, 0, 0], [0, 0, 1, 1, 0, 0]]),
            "known": np.ones((2, 6), np.uint8),
            "exact": np.ones(2, np.uint8),
            "cell_known": np.ones((2, 2)),
            "distance": np.ones((2, 6)),
            "radius": 2 * np.ones((2, 6)),
            "cell_inside": np.array([[1.0, 0.0], [1.0, 0.0]]),
            "cell_volume": np.array([[1.0, 3.0], [2.0, 2.0]]),
            "cell_vote": np.array([[1.0, 1.0], [1.0, 0.0]]),
            "scale": np.array([10.0, 10.0]),
            "setup": np.array([0, 2]),
            "noise": np.array([0.0, 0.004]),
            "density": np.array([7.0, 30.0]),
        }
        return metrics.Predictions(logit, np.full((2, 6), 0.5), truth, Layout(1, 1, 2, 2), synthetic.SETUPS)

    def test_figures_by_hand(self):
        found = metrics.evaluate(self.predictions(), 1.0)
        self.assertEqual(
            set(found),
            {
                "all",
                "full-view",
                "airborne",
                "5–10 points/m²",
                "20–50 points/m²",
                "0–0.0005 R noise",
                "0.0025–0.005 R noise",
            },
        )
        everything = found["all"]
        self.assertEqual(
            (everything["sign_near"], everything["sign_uniform"], everything["distance_error_m"]), (0.5, 1.0, 0.0)
        )
        network, vote = everything["network"], everything["vote"]
        self.assertEqual(network["cell_accuracy"], 0.75)
        self.assertAlmostEqual(network["cell_iou"], 0.25 / 0.75)
        self.assertAlmostEqual(network["cell_iou_m3"], 1.0 / 3.0)
        self.assertEqual(network["all_outside"], 0.5)
        self.assertAlmostEqual(vote["cell_iou"], 0.75 / 1.5)
        # The vote's cells: told 1, 1, 1, 0, true 1, 0, 1, 0.
        self.assertAlmostEqual(vote["calibration_error"], 0.25)

    def test_temperature_is_found_again(self):
        random = np.random.default_rng(0)
        honest = random.normal(0, 2, (4000, 1, 1))
        inside = (random.random((4000, 1)) < metrics.sigmoid(honest[:, :, 0])).astype(float)
        predictions = metrics.Predictions(
            (3 * honest).reshape(4000, 1),
            None,
            {"cell_inside": inside, "known": np.ones((4000, 1)), "cell_known": np.ones((4000, 1))},
            Layout(0, 0, 1, 1),
            (),
        )
        self.assertAlmostEqual(metrics.temperature(predictions), 3.0, delta=0.2)

    def test_the_papers_rule(self):
        rules = metrics.rules(self.predictions(), 1.0)
        # Without the factor every probability is within 1e-3 of 0.5; with it none is.
        self.assertEqual(rules["paper: sigmoid(distance · volume)"]["undecided"], 1.0)
        self.assertEqual(rules["paper: sigmoid(10⁶ · distance · volume)"]["undecided"], 0.0)


if __name__ == "__main__":
    unittest.main()
