#!/usr/bin/env python3
"""Evaluate the checkpoint of a run and write its network file: of a run that still trains, or on another split."""

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
    parser.add_argument("--config", type=Path, required=True, help="configuration of the run (TOML)")
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="folders of shards")
    parser.add_argument("--out", type=Path, required=True, help="folder of the run")
    parser.add_argument(
        "--split", default="validation", help="split to evaluate: validation or test (default: validation)"
    )
    parser.add_argument("--seed", type=int, help="seed of the run, if the command line gave one")
    parser.add_argument("--device", default="cpu", help="cpu or cuda (default: cpu)")
    parser.add_argument("--threads", type=int, default=1, help="threads of the CPU (default: 1)")
    return parser.parse_args(argv)


def main(argv=None):
    """Exit status 0 when exported, 1 for bad input."""
    options = arguments(argv)
    torch.set_num_threads(options.threads)
    try:
        network_file.require_exporter()
        config = load(options.config)
        if options.seed is not None:
            config = dataclasses.replace(config, run=dataclasses.replace(config.run, seed=options.seed))
        trainer = Trainer(config, options.data, options.out, options.device, resume=True)
        finish(trainer, options.split)
    except (ConfigError, FormatError, ResumeError, ModuleNotFoundError, OSError) as error:
        print(f"export.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
