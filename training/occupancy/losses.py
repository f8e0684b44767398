"""What is minimised: the paper's two losses (sign and distance, section 3.3) and the cells' probabilities.

Of a real scan only a part is known: what is not counts nothing, and its distances are not known at all.
"""

import torch
from torch.nn import functional


def ratio(network, answers):
    """|d| / r from raw answers [..., 2]."""
    second = answers[..., 1]
    return second.abs() if network.interface.name == "points2surf" else torch.sigmoid(second)


def known_mean(values, known):
    """The mean [n, M] of those values [n, M, T] that are known, 0.5 where none is."""
    count = known.sum(dim=2)
    mean = (values * known).sum(dim=2) / count.clamp(min=1.0)
    return torch.where(count > 0, mean, torch.full_like(mean, 0.5))


def losses(network, answers, batch, settings):
    """The parts of the loss: dictionary of scalars "sign", "distance", "cells" (unweighted) and "loss" (their sum).

    `answers` [n·Q, 2] are raw; `batch` is on the same device.
    """
    layout = batch["layout"]
    inside, distance, radius = batch["inside"], batch["distance"], batch["radius"]
    answers = answers.reshape(*inside.shape, 2)
    counted = torch.ones(inside.shape[1], device=inside.device)
    if not settings.cell_queries:
        counted[layout.near + layout.uniform :] = 0.0
    # The mean is 1, so that leaving a group out does not change the size of the loss.
    counted = counted * (counted.numel() / counted.sum().clamp(min=1.0))

    weight = counted * batch["known"]
    if settings.noise_band > 0.0:
        # Labels inside the noise band are a coin toss: they must not dominate.
        weight = weight * (distance / (settings.noise_band * batch["scale"].unsqueeze(1))).clamp(max=1.0)
    sign = functional.binary_cross_entropy_with_logits(answers[..., 0], inside, reduction="none")
    # Over all queries, not over the known ones: a scan of which little is known shall not weigh as much as the others.
    sign = (sign * weight).mean()

    target, found = distance / radius, ratio(network, answers)
    if settings.distance_form == "tanh":
        far = (torch.tanh(found) - torch.tanh(target)).square()
    else:
        far = functional.smooth_l1_loss(found, target.clamp(max=1.0), beta=0.1, reduction="none")
    far = (far * counted * batch["exact"].unsqueeze(1)).mean()

    parts = {"sign": sign, "distance": far, "cells": sign.new_zeros(())}
    if layout.cells > 0 and settings.cells > 0.0:
        logits, known = (
            values[:, layout.near + layout.uniform :].reshape(-1, layout.cells, layout.samples)
            for values in (answers[..., 0], batch["known"])
        )
        mean = known_mean(torch.sigmoid(logits), known).clamp(1e-6, 1.0 - 1e-6)
        cells = functional.binary_cross_entropy(mean, batch["cell_inside"].clamp(0.0, 1.0), reduction="none")
        # None of the drawn samples may be known although some of the cell is.
        counted_cells = batch["cell_known"] * known.any(dim=2)
        parts["cells"] = (cells * counted_cells).mean()
    parts["loss"] = sign + settings.distance * far + settings.cells * parts["cells"]
    return parts
