"""The training loop: seeded, resumable to the bit (with a number of steps), stopped by signals without loss."""

import csv
import json
import math
import os
import signal
import time
from pathlib import Path

import numpy as np
import torch

from . import config as configuration
from . import metrics
from .batches import Batches, Loader, to_device
from .losses import losses
from .networks import network_of
from .resident import Resident
from .shards import Shards
from .warm_start import start_from

CURVE = ("step", "minutes", "rate", "loss", "sign", "distance", "cells")


class ResumeError(ValueError):
    """A run folder that cannot be gone on with; the message tells why."""


class Trainer:
    """One run in its folder: checkpoint.pt, curve.csv, validation.jsonl."""

    def __init__(self, config, data, out, device="cpu", resume=False, start=None, resident=False):
        """`start` is a network file whose weights the run begins with; `resident` keeps all shards on the device."""
        self.config, self.out, self.device = config, Path(out), torch.device(device)
        self.start, self.resident = start, resident
        self.out.mkdir(parents=True, exist_ok=True)
        self.checkpoint = self.out / "checkpoint.pt"
        if resume and not self.checkpoint.exists():
            raise ResumeError(f"{self.checkpoint}: not found; start without --resume")
        if not resume and self.checkpoint.exists():
            raise ResumeError(f"{self.checkpoint}: a run is there already; go on with --resume or take another --out")
        self.data = data
        self.batches = Batches(Shards(data, "train"), config)
        self.validation = Batches(Shards(data, "validation"), config)
        torch.manual_seed(config.run.seed)
        self.network = network_of(config, self.batches.shards.interface)
        self.step, self.seconds = 0, 0.0
        if not resume:
            self.standardise()
            if start is not None:
                start_from(self.network, start)
        self.network.to(self.device, memory_format=torch.channels_last)
        self.average = [parameter.detach().clone() for parameter in self.network.parameters()]
        settings = config.optimiser
        decayed = [p for p in self.network.parameters() if p.dim() > 1]
        plain = [p for p in self.network.parameters() if p.dim() <= 1]
        groups = [{"params": decayed, "weight_decay": settings.weight_decay}, {"params": plain, "weight_decay": 0.0}]
        self.optimiser = torch.optim.AdamW(groups, lr=settings.rate, foreach=True)
        if resume:
            self.restore()
        self.stopped = None

    def standardise(self):
        """Fix the scaling of the inputs from up to 256 scans of the training split."""
        random = np.random.default_rng([self.config.run.seed, 2])
        count = len(self.batches.shards)
        indices = random.choice(count, min(256, count), replace=False)
        batch = self.batches.load([int(i) for i in indices], self.config.batch, random, False)
        self.network.standardise(to_device(batch, "cpu"))

    def progress(self):
        """How much of the run is done, 0 to 1: by steps, or else by minutes of training."""
        run = self.config.run
        return self.step / run.steps if run.steps > 0 else self.seconds / 60.0 / run.minutes

    def rate(self):
        """The learning rate of the coming step: warm-up, then cosine."""
        settings = self.config.optimiser
        # A short run warms up over its first tenth.
        warm = (
            min(settings.warm_up, max(self.config.run.steps // 10, 1))
            if self.config.run.steps > 0
            else settings.warm_up
        )
        cosine = 0.5 * (1.0 + math.cos(math.pi * min(self.progress(), 1.0)))
        return min(1.0, (self.step + 1) / max(warm, 1)) * (
            settings.final_rate + (settings.rate - settings.final_rate) * cosine
        )

    def update(self, batch):
        """One step; the parts of the loss, detached."""
        self.network.train()
        rate = self.rate()
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        batch = to_device(batch, self.device)
        parts = losses(self.network, self.network(batch), batch, self.config.loss)
        self.optimiser.zero_grad(set_to_none=True)
        parts["loss"].backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), self.config.optimiser.clip)
        self.optimiser.step()
        # The average of a young run must not remember the random start.
        keep = min(self.config.optimiser.average, (1 + self.step) / (10 + self.step))
        with torch.no_grad():
            torch._foreach_mul_(self.average, keep)
            torch._foreach_add_(self.average, [p.detach() for p in self.network.parameters()], alpha=1.0 - keep)
        self.step += 1
        return torch.stack([parts[name].detach() for name in CURVE[3:]])

    def train(self, report=print):
        """Train to the end, or until a signal comes; True when the end was reached."""
        run = self.config.run
        previous = {s: signal.signal(s, self.interrupted) for s in (signal.SIGINT, signal.SIGTERM)}
        loader = self.loader(report)
        sums, count = None, 0
        saved = validated = self.seconds
        try:
            while self.progress() < 1.0 and self.stopped is None:
                begin = time.monotonic()
                parts = self.update(loader.next())
                sums, count = (parts if sums is None else sums + parts), count + 1
                if self.step % run.log_steps == 0:
                    self.log((sums / count).tolist(), report)
                    sums, count = None, 0
                self.seconds += time.monotonic() - begin
                if self.seconds - validated >= 60.0 * run.validation_minutes:
                    self.validate(report)
                    validated = self.seconds
                if self.seconds - saved >= 60.0 * run.checkpoint_minutes:
                    self.save()
                    saved = self.seconds
        finally:
            loader.close()
            for number, handler in previous.items():
                signal.signal(number, handler)
        self.save()
        return self.stopped is None

    def loader(self, report):
        """What gives the batches from the coming step on."""
        seed = self.config.run.seed
        if not self.resident:
            return Loader(self.batches, self.step, seed, self.device.type == "cuda")
        resident = Resident(self.batches, self.step, seed, self.device)
        report(f"{resident.size() / 1e9:.2f} GB of shards in the memory of {self.device}")
        return resident

    def interrupted(self, number, _frame):
        """Note a signal; the loop stops after the step that runs."""
        self.stopped = number

    def log(self, values, report):
        """One row of the curve."""
        if not math.isfinite(values[0]):
            raise FloatingPointError(
                f"the loss is {values[0]} at step {self.step}; look at the shards, or lower optimiser.rate"
            )
        row = [self.step, round(self.seconds / 60.0, 3), f"{self.rate():.3e}"] + [f"{value:.5f}" for value in values]
        new = not (self.out / "curve.csv").exists()
        with (self.out / "curve.csv").open("a", newline="") as file:
            writer = csv.writer(file)
            if new:
                writer.writerow(CURVE)
            writer.writerow(row)
        report("  ".join(f"{name} {value}" for name, value in zip(CURVE, row)))

    def validate(self, report):
        """Figures of the averaged weights in between: one line of validation.jsonl."""
        predictions = metrics.predict(
            self.averaged(), self.validation, self.device, self.config.run.validation_scans or 256
        )
        found = metrics.figures(predictions, 1.0, np.ones(len(predictions.logit), bool))
        with (self.out / "validation.jsonl").open("a") as file:
            file.write(json.dumps({"step": self.step, "minutes": round(self.seconds / 60.0, 3), **found}) + "\n")
        cells, vote = found["network"], found["vote"]
        report(
            f"validation at step {self.step}: cell accuracy {cells['cell_accuracy']:.4f} "
            f"(vote {vote['cell_accuracy']:.4f}), cell IoU {cells['cell_iou']:.4f} (vote {vote['cell_iou']:.4f})"
        )

    def averaged(self):
        """A copy of the network with the averaged weights, in evaluation mode."""
        network = network_of(self.config, self.batches.shards.interface)
        network.load_state_dict(self.network.state_dict())
        with torch.no_grad():
            for parameter, value in zip(network.parameters(), self.average):
                parameter.copy_(value)
        return network.to(self.device, memory_format=torch.channels_last).eval()

    def save(self):
        """Write the checkpoint; it appears whole or not at all."""
        state = {
            "config": configuration.as_dict(self.config),
            "step": self.step,
            "seconds": self.seconds,
            "network": self.network.state_dict(),
            "average": self.average,
            "optimiser": self.optimiser.state_dict(),
        }
        part = self.checkpoint.with_suffix(".part")
        torch.save(state, part)
        os.replace(part, self.checkpoint)

    def restore(self):
        """Go on from the checkpoint."""
        state = torch.load(self.checkpoint, map_location=self.device)
        wanted = configuration.as_dict(self.config)
        # A run may be lengthened and reported otherwise, but what is trained must be the same.
        for key in ("name", "network", "inputs", "batch", "loss", "optimiser"):
            if state["config"][key] != wanted[key]:
                raise ResumeError(
                    f"{self.checkpoint}: {key} was {state['config'][key]}, now {wanted[key]}; take another --out"
                )
        seed = state["config"]["run"]["seed"]
        if seed != self.config.run.seed:
            raise ResumeError(f"{self.checkpoint}: the seed was {seed}, now {self.config.run.seed}; take another --out")
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.average = [value.to(self.device) for value in state["average"]]
        self.step, self.seconds = state["step"], state["seconds"]
        self.forget_later_rows()

    def forget_later_rows(self):
        """Rows that a killed run wrote after its last checkpoint would stand twice."""
        curve, validation = self.out / "curve.csv", self.out / "validation.jsonl"
        if curve.exists():
            with curve.open(newline="") as file:
                rows = [row for row in csv.reader(file) if row[0] == "step" or int(row[0]) <= self.step]
            with curve.open("w", newline="") as file:
                csv.writer(file).writerows(rows)
        if validation.exists():
            lines = [line for line in validation.read_text().splitlines() if json.loads(line)["step"] <= self.step]
            validation.write_text("".join(f"{line}\n" for line in lines))
