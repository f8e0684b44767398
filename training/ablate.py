#!/usr/bin/env python3
"""Run configurations for an equal budget and write their figures as one table. Finished runs are not repeated."""

import argparse
import json
import sys
from pathlib import Path

from occupancy import metrics
from occupancy.config import ConfigError, load
from occupancy.metrics import number
from occupancy.safetensors import FormatError
from occupancy.trainer import ResumeError
from train import run, with_length

FOLDER = Path(__file__).resolve().parent
COLUMNS = ("cell_accuracy", "cell_iou", "calibration_error", "all_outside")


def arguments(argv):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "configs",
        type=Path,
        nargs="*",
        help="configurations; the first is the one compared with (default: field.toml and ablations/*.toml)",
    )
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="folders of shards")
    parser.add_argument("--out", type=Path, required=True, help="folder for the runs, one folder each")
    parser.add_argument(
        "--table",
        type=Path,
        default=FOLDER / "ABLATIONS.md",
        help="Markdown file to write (default: training/ABLATIONS.md)",
    )
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument("--minutes", type=float, help="minutes of training, each")
    length.add_argument("--steps", type=int, help="steps of training, each")
    parser.add_argument("--seed", type=int, help="seed of all runs")
    parser.add_argument("--device", default="cpu", help="cpu or cuda (default: cpu)")
    parser.add_argument("--threads", type=int, default=1, help="threads of the CPU (default: 1)")
    return parser.parse_args(argv)


def one(options, path):
    """Figures of one configuration: those of a finished run, or of a run made now; None when a signal stopped it."""
    config = with_length(load(path), options.steps, options.minutes, options.seed)
    out = options.out / config.name
    finished = out / "metrics.json"
    if finished.exists():
        figures = json.loads(finished.read_text())
        length = figures["steps"] if options.steps else figures["minutes"]
        wanted = options.steps or options.minutes
        # A run by the clock ends with the step that passes it.
        if figures["seed"] != config.run.seed or not wanted <= length <= wanted * 1.05 + 0.5:
            raise ResumeError(
                f"{out}: finished with another length ({length:g}) or seed ({figures['seed']}); take another --out"
            )
        return figures
    resume = (out / "checkpoint.pt").exists()
    return run(config, options.data, out, options.device, options.threads, resume, lambda text: print(text, flush=True))


def document(runs, budget):
    """ABLATIONS.md: a row per run, then the other ways to ask the first one."""
    first = runs[0]
    vote = first["figures"]["all"]["vote"]
    scans = first["figures"]["all"]["scans"]
    header = ("configuration", "what", "parameters", "steps", "sign near", "sign uniform", "cell accuracy", "cell IoU")
    header += ("IoU airborne", "calibration error", "all outside")
    lines = [
        "# Ablations",
        "",
        "Written by `training/ablate.py`; do not edit. Every row was trained on the same shards for the same budget",
        f"({budget}, seed {first['seed']}) and is evaluated on the {first['split']} split ({scans} scans): tiles that",
        "training never saw. Cell IoU is weighted by volume, every scan counting alike. The vote is the height-field",
        "vote on the same cells.",
        "",
        "## Design",
        "",
        "| " + " | ".join(header) + " |",
        "|" + "---|" * len(header),
    ]
    for figures in runs:
        everything = figures["figures"]["all"]
        cells = [figures["name"], figures["note"], str(figures["parameters"]), str(figures["steps"])]
        cells += [number(everything["sign_near"]), number(everything["sign_uniform"])]
        cells += columns(everything["network"], airborne(figures, "network"))
        lines.append("| " + " | ".join(cells) + " |")
    cells = ["height-field vote", "No network", "0", "–", "–", "–"] + columns(vote, airborne(first, "vote"))
    lines.append("| " + " | ".join(cells) + " |")
    lines += [
        "",
        f"## Ways to ask `{first['name']}`",
        "",
        "The same network and the same cells; only the rule differs that makes one occupancy of a cell's samples.",
        "",
    ]
    lines.append(metrics.rules_table(first["rules"]))
    lines += [f"## `{first['name']}` by set-up, density and noise", "", metrics.table(first["figures"])]
    return "\n".join(lines)


def columns(cells, iou_airborne):
    """The last five columns of a row."""
    found = [number(cells[key]) for key in COLUMNS]
    return found[:2] + [number(iou_airborne)] + found[2:]


def airborne(figures, who):
    """Cell IoU on the airborne scans, if there are any."""
    group = figures["figures"].get("airborne")
    return group[who]["cell_iou"] if group else None


def main(argv=None):
    """Exit status 0 when the table is written, 1 for bad input, 130 when a signal stopped a run."""
    options = arguments(argv)
    paths = options.configs or [FOLDER / "field.toml"] + sorted((FOLDER / "ablations").glob("*.toml"))
    budget = f"{options.steps} steps" if options.steps else f"{options.minutes:g} minutes"
    runs = []
    try:
        for path in paths:
            figures = one(options, path)
            if figures is None:
                return 130
            runs.append(figures)
            # After every run: a table of what there is, should the rest not come.
            options.table.write_text(document(runs, budget))
    except (ConfigError, FormatError, ResumeError, ModuleNotFoundError, OSError) as error:
        print(f"ablate.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
