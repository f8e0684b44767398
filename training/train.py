#!/usr/bin/env python3
"""Train a network on shards of virtual scans and write its network file. See README.md."""

import argparse
import dataclasses
import sys
from pathlib import Path

import torch

from occupancy import network_file
from occupancy.config import ConfigError, load
from occupancy.finish import finish
from occupancy.safetensors import FormatError
from occupancy.trainer import ResumeError, Trainer


def arguments(argv):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", type=Path, required=True, help="configuration (TOML)")
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="folders of shards, from gable simulate")
    parser.add_argument("--out", type=Path, required=True, help="folder of the run")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=float, help="minutes of training")
    length.add_argument("--steps", type=int, help="steps of training")
    parser.add_argument("--from", dest="start", type=Path, metavar="FILE", help="network file to start from")
    parser.add_argument("--rate", type=float, help="highest learning rate; the final one keeps its ratio to it")
    parser.add_argument("--scans", type=int, help="scans per step")
    parser.add_argument("--resume", action="store_true", help="go on from the checkpoint in --out")
    parser.add_argument("--device", default="cpu", help="cpu or cuda (default: cpu)")
    parser.add_argument("--resident", action="store_true", help="keep all shards in the memory of the device")
    parser.add_argument("--threads", type=int, default=1, help="threads of the CPU (default: 1)")
    parser.add_argument("--seed", type=int, help="seed of weights, order and augmentation")
    return parser.parse_args(argv)


def run(config, data, out, device="cpu", threads=1, resume=False, report=print, start=None, resident=False):
    """Train and finish; the figures, or None when a signal stopped the run. `start` and `resident` as in `Trainer`."""
    network_file.require_exporter()
    torch.set_num_threads(threads)
    if torch.device(device).type == "cuda":
        if not torch.cuda.is_available():
            raise ConfigError("--device cuda: torch finds no CUDA device; take --device cpu")
        torch.set_float32_matmul_precision("high")
    trainer = Trainer(config, data, out, device, resume, start, resident)
    parameters, scans = sum(p.numel() for p in trainer.network.parameters()), len(trainer.batches.shards)
    report(f"{config.name}: {parameters} parameters, {scans} training scans, from step {trainer.step}")
    if not trainer.train(report):
        report(f"stopped by a signal at step {trainer.step}; go on with --resume")
        return None
    return finish(trainer, report=report)


def with_length(config, steps=None, minutes=None, seed=None):
    """The configuration with the length and the seed of the command line."""
    changes = {}
    if steps is not None:
        changes = {"steps": steps, "minutes": 0.0}
    if minutes is not None:
        changes = {"steps": 0, "minutes": minutes}
    if seed is not None:
        changes["seed"] = seed
    config = dataclasses.replace(config, run=dataclasses.replace(config.run, **changes))
    if config.run.steps <= 0 and config.run.minutes <= 0.0:
        raise ConfigError("neither steps nor minutes are given; pass --steps N or --minutes N, or set one under [run]")
    return config


def with_pace(config, rate=None, scans=None):
    """The configuration with the learning rate and the scans per step of the command line."""
    optimiser, batch = config.optimiser, config.batch
    if rate is not None:
        ratio = optimiser.final_rate / optimiser.rate
        optimiser = dataclasses.replace(optimiser, rate=rate, final_rate=rate * ratio)
    if scans is not None:
        if scans < 1:
            raise ConfigError(f"--scans is {scans}, expected at least 1")
        batch = dataclasses.replace(batch, scans=scans)
    return dataclasses.replace(config, optimiser=optimiser, batch=batch)


def main(argv=None):
    """Exit status 0 when trained and exported, 1 for bad input, 130 when stopped by a signal."""
    options = arguments(argv)
    try:
        config = with_length(load(options.config), options.steps, options.minutes, options.seed)
        config = with_pace(config, options.rate, options.scans)
        figures = run(
            config,
            options.data,
            options.out,
            options.device,
            options.threads,
            options.resume,
            lambda text: print(text, flush=True),
            options.start,
            options.resident,
        )
    except (ConfigError, FormatError, ResumeError, ModuleNotFoundError, OSError) as error:
        print(f"train.py: {error}", file=sys.stderr)
        return 1
    return 0 if figures else 130


if __name__ == "__main__":
    sys.exit(main())
