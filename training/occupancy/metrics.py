"""What a network is worth on a split: figures by set-up, density and noise, beside those of the height-field vote."""

from dataclasses import dataclass

import numpy as np
import torch

from .batches import to_device
from .config import Batch
from .losses import ratio

DENSITY_BANDS = (0.0, 2.0, 5.0, 10.0, 20.0, 50.0, np.inf)
"""Points per square metre of footprint."""

NOISE_BANDS = (0.0, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.05, np.inf)
"""Standard deviation over the largest side of the box."""

PAPER_FACTOR = 1e6
"""The factor of the reference code in sigmoid(factor · distance · volume), both normalised (paper, section 3.3)."""


@dataclass
class Predictions:
    """Answers and truth of a split: queries [n, Q], cells [n, M], scans [n]."""

    logit: np.ndarray
    ratio: np.ndarray
    truth: dict
    layout: object
    setups: tuple

    def cell_logits(self):
        """Sign logits of the cells' samples [n, M, T]."""
        return self.logit[:, self.layout.near + self.layout.uniform :].reshape(
            len(self.logit), self.layout.cells, self.layout.samples
        )

    def known_samples(self):
        """Whether the truth at the cells' samples is known [n, M, T]."""
        known = self.truth["known"][:, self.layout.near + self.layout.uniform :]
        return known.reshape(len(known), self.layout.cells, self.layout.samples).astype(bool)

    def cell_weights(self):
        """The share of each cell that is known [n, M], 0 where none of its samples is."""
        return self.truth["cell_known"] * self.known_samples().any(axis=2)


@torch.no_grad()
def predict(network, batches, device, limit=0):
    """Answers of a network for the first `limit` scans of a split (0: all), evenly spread over it."""
    network.eval()
    count = len(batches.shards)
    chosen = range(count) if limit <= 0 or limit >= count else np.linspace(0, count - 1, limit).astype(int).tolist()
    logits, ratios, truths = [], [], []
    for start in range(0, len(chosen), 16):
        indices = chosen[start : start + 16]
        random = np.random.default_rng([7, int(indices[0])])
        batch = batches.load(indices, Batch(), random, False)
        truths.append(
            {
                name: batch[name].numpy()
                for name in (
                    "inside",
                    "known",
                    "distance",
                    "radius",
                    "cell_inside",
                    "cell_known",
                    "cell_volume",
                    "cell_vote",
                    "scale",
                    "exact",
                    "setup",
                    "noise",
                    "density",
                )
            }
        )
        moved = to_device(batch, device)
        answers = network(moved).reshape(*moved["inside"].shape, 2)
        logits.append(answers[..., 0].cpu().numpy())
        ratios.append(ratio(network, answers).cpu().numpy())
    truth = {name: np.concatenate([part[name] for part in truths]) for name in truths[0]}
    return Predictions(
        np.concatenate(logits), np.concatenate(ratios), truth, batches.shards.layout, batches.shards.setups
    )


def sigmoid(x):
    """The logistic function without overflow."""
    return 0.5 * (1.0 + np.tanh(0.5 * x))


def known_mean(values, known):
    """The mean [n, M] of those values [n, M, T] that are known, 0.5 where none is."""
    count = known.sum(axis=2)
    return np.where(count > 0, (values * known).sum(axis=2) / np.maximum(count, 1), 0.5)


def weighted_mean(values, weights):
    """The mean of some values by weight; 0 without any weight."""
    return float((values * weights).sum() / max(weights.sum(), 1e-9))


def cross_entropy(probability, truth, weights):
    """Mean cross entropy of probabilities against inside shares."""
    p = np.clip(probability, 1e-6, 1.0 - 1e-6)
    return weighted_mean(-(truth * np.log(p) + (1.0 - truth) * np.log(1.0 - p)), weights)


def temperature(predictions):
    """The T that minimises the cross entropy of the cells' mean sigmoid(logit / T) against their inside share."""
    logits, truth = predictions.cell_logits().astype(np.float64), predictions.truth["cell_inside"]
    known, weights = predictions.known_samples(), predictions.cell_weights()

    def cost(t):
        return cross_entropy(known_mean(sigmoid(logits / t), known), truth, weights)

    best, width = 0.0, np.log(8.0)
    # A search on ln T by ever finer grids: one variable, one minimum, no slope needed.
    for _ in range(6):
        grid = best + np.linspace(-width, width, 9)
        best = float(grid[np.argmin([cost(t) for t in np.exp(grid)])])
        width /= 4.0
    return float(np.exp(best))


def calibration_error(probability, truth, weights, bins=15):
    """Expected calibration error: mean over the cells of the gap between told and true inside share of their bin."""
    which = np.minimum((probability * bins).astype(int), bins - 1).ravel()
    told = np.bincount(which, (weights * probability).ravel(), bins)
    true = np.bincount(which, (weights * truth).ravel(), bins)
    return float(np.abs(told - true).sum() / max(weights.sum(), 1e-9))


def cell_figures(probability, truth, weights):
    """Figures of cell probabilities [n, M]: accuracy, IoU, calibration error, all-outside share.

    A cell counts with the share of it that is known, its volume too.
    """
    inside, volume = truth["cell_inside"] > 0.5, truth["cell_volume"] * weights
    found = probability > 0.5
    # Every scan counts alike: volumes as shares of the scan's cells. The second IoU counts cubic metres.
    share = volume / np.maximum(volume.sum(axis=1, keepdims=True), 1e-9)
    both, either = inside & found, inside | found
    solid = (inside & (weights > 0)).any(axis=1)
    return {
        "cell_accuracy": weighted_mean(inside == found, weights),
        "cell_iou": float((share * both).sum() / max((share * either).sum(), 1e-9)),
        "cell_iou_m3": float((volume * both).sum() / max((volume * either).sum(), 1e-9)),
        "calibration_error": calibration_error(probability, truth["cell_inside"], weights),
        "cross_entropy": cross_entropy(probability, truth["cell_inside"], weights),
        "all_outside": float((~found.any(axis=1) & solid).sum() / max(solid.sum(), 1)),
    }


def share_of(right, counted):
    """The share of those that count that are right; None where none counts."""
    return float(right[counted].mean()) if counted.any() else None


def figures(predictions, t, rows):
    """All figures of the scans `rows` (a mask): the network's, and the vote's on the same cells. What is not known does
    not count."""
    truth = {name: value[rows] for name, value in predictions.truth.items()}
    layout, logit = predictions.layout, predictions.logit[rows]
    right, known = (logit > 0.0) == (truth["inside"] > 0), truth["known"] > 0
    near, uniform = slice(layout.near), slice(layout.near, layout.near + layout.uniform)
    probability = known_mean(sigmoid(predictions.cell_logits()[rows] / t), predictions.known_samples()[rows])
    exact = truth["exact"] > 0
    error = np.abs(predictions.ratio[rows] * truth["radius"] - truth["distance"])
    weights = predictions.cell_weights()[rows]
    return {
        "scans": int(rows.sum()),
        "sign_near": share_of(right[:, near], known[:, near]),
        "sign_uniform": share_of(right[:, uniform], known[:, uniform]),
        "distance_error_m": float(error[exact].mean()) if exact.any() else None,
        "network": cell_figures(probability, truth, weights),
        "vote": cell_figures(truth["cell_vote"], truth, weights),
    }


def groups(predictions):
    """Named masks over the scans: all, by set-up, by density band, by noise band; empty ones are left out."""
    truth = predictions.truth
    found = {"all": np.ones(len(truth["setup"]), bool)}
    for index in range(int(truth["setup"].max(initial=0)) + 1):
        name = predictions.setups[index] if index < len(predictions.setups) else f"setup {index}"
        found[name] = truth["setup"] == index
    for quantity, unit, bands in (("density", "points/m²", DENSITY_BANDS), ("noise", "R noise", NOISE_BANDS)):
        for low, high in zip(bands, bands[1:]):
            name = f"{low:g}–{high:g} {unit}" if np.isfinite(high) else f"from {low:g} {unit}"
            found[name] = (truth[quantity] >= low) & (truth[quantity] < high)
    return {name: rows for name, rows in found.items() if rows.any()}


def evaluate(predictions, t):
    """Figures of every group of scans: {group: figures}."""
    return {name: figures(predictions, t, rows) for name, rows in groups(predictions).items()}


def rules(predictions, t):
    """Cell figures of one network under other ways to ask it: fewer samples, and the paper's rule."""
    logits, truth, layout = predictions.cell_logits(), predictions.truth, predictions.layout
    known, found = predictions.known_samples(), {}
    for count in [c for c in (1, 8, 16, 32) if c <= layout.samples]:
        name = "centroid only" if count == 1 else f"{count} samples"
        found[name] = (known_mean(sigmoid(logits[:, :, :count] / t), known[:, :, :count]), count)
    found["centroid only, uncalibrated"] = (sigmoid(logits[:, :, 0]), 1)
    # sigmoid(signed distance × volume × factor) of the centroid, in units of the scale.
    scale = truth["scale"][:, None]
    at = layout.near + layout.uniform + layout.samples * np.arange(layout.cells)
    distance = predictions.ratio[:, at] * truth["radius"][:, at] / scale * np.where(logits[:, :, 0] > 0.0, 1.0, -1.0)
    for factor, name in (
        (PAPER_FACTOR, "paper: sigmoid(10⁶ · distance · volume)"),
        (1.0, "paper: sigmoid(distance · volume)"),
    ):
        found[name] = (sigmoid(factor * distance * truth["cell_volume"] / scale**3), 1)
    figures_of = {}
    for name, (probability, count) in found.items():
        # Of a cell counts what is known of the samples that are asked.
        weights = truth["cell_known"] * known[:, :, :count].any(axis=2)
        figures_of[name] = cell_figures(probability, truth, weights)
        figures_of[name]["undecided"] = weighted_mean(np.abs(probability - 0.5) < 0.1, weights)
    return figures_of


def table(evaluation):
    """The figures as a Markdown table."""
    header = ["scans", "n", "sign near", "sign uniform"]
    for name in ("cell accuracy", "cell IoU", "calibration error", "all outside"):
        header += [name, "vote"]
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    for name, row in evaluation.items():
        cells = [name, str(row["scans"]), number(row["sign_near"]), number(row["sign_uniform"])]
        for key in ("cell_accuracy", "cell_iou", "calibration_error", "all_outside"):
            cells += [number(row["network"][key]), number(row["vote"][key])]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def rules_table(figures_of):
    """The ways to ask one network as a Markdown table."""
    lines = [
        "| rule | cell accuracy | cell IoU | calibration error | cross entropy | undecided (0.4–0.6) |",
        "|---|---|---|---|---|---|",
    ]
    for name, row in figures_of.items():
        keys = ("cell_accuracy", "cell_iou", "calibration_error", "cross_entropy", "undecided")
        lines.append(f"| {name} | " + " | ".join(number(row[key]) for key in keys) + " |")
    return "\n".join(lines) + "\n"


def number(value):
    """A figure of a table."""
    return "–" if value is None else f"{value:.4f}"
