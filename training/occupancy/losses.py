"""What is minimised: the paper's two losses (sign and distance, section 3.3) and the cells' probabilities."""

import torch
from torch.nn import functional


def ratio(network, answers):
    """|d| / r from raw answers [..., 2]."""
    second = answers[..., 1]
    return second.abs() if network.interface.name == "points2surf" else torch.sigmoid(second)


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

    weight = counted
    if settings.noise_band > 0.0:
        # Labels inside the noise band are a coin toss: they must not dominate.
        weight = counted * (distance / (settings.noise_band * batch["scale"].unsqueeze(1))).clamp(max=1.0)
    sign = (functional.binary_cross_entropy_with_logits(answers[..., 0], inside, reduction="none") * weight).mean()

    target, found = distance / radius, ratio(network, answers)
    if settings.distance_form == "tanh":
        far = (torch.tanh(found) - torch.tanh(target)).square()
    else:
        far = functional.smooth_l1_loss(found, target.clamp(max=1.0), beta=0.1, reduction="none")
    far = (far * counted).mean()

    parts = {"sign": sign, "distance": far, "cells": sign.new_zeros(())}
    if layout.cells > 0 and settings.cells > 0.0:
        logits = answers[:, layout.near + layout.uniform :, 0].reshape(-1, layout.cells, layout.samples)
        mean = torch.sigmoid(logits).mean(dim=2).clamp(1e-6, 1.0 - 1e-6)
        parts["cells"] = functional.binary_cross_entropy(mean, batch["cell_inside"].clamp(0.0, 1.0))
    parts["loss"] = sign + settings.distance * far + settings.cells * parts["cells"]
    return parts
