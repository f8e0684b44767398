"""The end of a run: calibration, figures, model card and network file."""

import dataclasses
import json
import platform
from pathlib import Path

import torch

from . import metrics, network_file
from .batches import Batches
from .shards import Shards, folders_of


def finish(trainer, split="validation", report=print):
    """Calibrate on the validation split, evaluate `split`, write the figures, the card and the network file."""
    out, config = trainer.out, trainer.config
    network = trainer.averaged()
    limit = config.run.validation_scans
    validation = metrics.predict(network, trainer.validation, trainer.device, limit)
    temperature = metrics.temperature(validation)
    predictions = validation
    if split != "validation":
        predictions = metrics.predict(network, Batches(Shards(trainer.data, split), config), trainer.device, limit)
    evaluation, rules = metrics.evaluate(predictions, temperature), metrics.rules(predictions, temperature)
    sizes = trainer.batches.shards.interface
    if config.inputs.footprint and (sizes.footprint_place() or sizes.footprint_raster()):
        # The network has to work without a footprint too: the same scans, the footprint's channels withheld.
        blind = dataclasses.replace(config, inputs=dataclasses.replace(config.inputs, footprint=False))
        withheld = metrics.predict(network, Batches(Shards(trainer.data, split), blind), trainer.device, limit)
        evaluation["all, footprint withheld"] = metrics.evaluate(withheld, temperature)["all"]
    figures = {
        "name": config.name,
        "note": config.note,
        "split": split,
        "steps": trainer.step,
        "minutes": round(trainer.seconds / 60.0, 2),
        "seed": config.run.seed,
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
        "temperature": temperature,
        "figures": evaluation,
        "rules": rules,
    }
    (out / "metrics.json").write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n")
    text = metrics.table(evaluation)
    (out / "metrics.md").write_text(text + "\n" + metrics.rules_table(rules))
    report(text)
    card = model_card(trainer, figures, text)
    (out / "card.md").write_text(card)
    path = out / f"{config.name}.safetensors"
    if network_file.exportable(network):
        network_file.write(
            path, network, name=config.name, temperature=temperature, batch=config.run.export_batch, card=card
        )
        report(f"temperature {temperature:.3f}; network file {path} ({path.stat().st_size / 1e6:.2f} MB)")
    else:
        report(f"temperature {temperature:.3f}; no network file: {config.name} is a variant for comparison only")
    return figures


def model_card(trainer, figures, table):
    """The card that travels in the network file, as Markdown."""
    config = trainer.config
    shards, hours = trainer.batches.shards, trainer.seconds / 3600.0
    scans, held_out = len(shards), len(trainer.validation.shards)
    steps, seed = f"{figures['steps']} steps of {config.batch.scans} scans", config.run.seed
    started = f"; started from `{trainer.start.name}`" if trainer.start else ""
    return f"""\
# {config.name}

{config.note or "Tells for a place in space how likely it is inside a building, and how far the surface is."}

Input: the points of one building, its footprint if there is one. Interface "{trainer.network.interface.name}".
Output: probability of being inside and distance to the surface. Temperature {figures["temperature"]:.3f}, set on cells.

## Data

{credit_lines(config)}
- {scans} training scans of {shards.layout.queries} queries, {held_out} validation scans; split by tile
{manifest_lines(trainer.data)}
## Training

- {figures["parameters"]} parameters, {steps}, {hours:.2f} h, seed {seed}{started}
- hardware: {hardware(trainer.device)}; torch {torch.__version__}

## Figures ({figures["split"]} split; "vote" is the height-field vote on the same cells)

{table}
## Limits

Trained on scans of the buildings above: unseen kinds of buildings and sensors have to be measured.
Not meant for bridges or vegetation.
"""


def credit_lines(config):
    """Sources with licence and credit; what the configuration does not tell is not made up."""
    return "\n".join(f"- {line}" for line in config.credit) or "- the configuration names no source and no licence"


def manifest_lines(data):
    """What the manifests of the shards tell: how each folder was scanned, and its sources, one line each."""
    lines = []
    for folder in folders_of(data):
        path = folder / "manifest.json"
        if not path.exists():
            continue
        manifest = json.loads(path.read_text())
        scans, asked = manifest.get("scans", {}), manifest.get("options", {})
        told = [f"{key} {asked[key]}" for key in ("setup", "density", "noise", "footprint") if key in asked]
        told += [f"{key} {manifest[key]}" for key in ("variants", "seed") if key in manifest]
        counts = ", ".join(f"{count} {split}" for split, count in scans.items())
        lines.append(f"- folder `{folder.name}`: {counts} scans; {', '.join(told)}")
        for source in manifest.get("sources", []):
            lines.append(f"  - {source.get('name')}: {source.get('models', '?')} models")
    return "".join(f"{line}\n" for line in lines)


def hardware(device):
    """What it ran on, in words."""
    if device.type == "cuda":
        return torch.cuda.get_device_name(device)
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{model}, {torch.get_num_threads()} thread(s)"
