"""The network file: ONNX graphs and their description in one safetensors file, for `gable reconstruct --model`."""

import copy
import importlib.util
import inspect
import io
import warnings

import numpy as np
import torch
from torch import nn

from . import safetensors
from .field import FieldNetwork
from .points2surf import Layer, Points2Surf

VERSION = "1"
OPSET = 13
"""Old enough for every runtime, new enough for Resize as the embedded backend reads it."""


class FieldGraph(nn.Module):
    """The decoder as it is exported: temperature and scaling folded in, the second answer as |d| / r."""

    def __init__(self, decoder, temperature, neighbours):
        super().__init__()
        self.decoder, self.neighbours = copy.deepcopy(decoder), neighbours
        tempered(self.decoder.sign, temperature)
        place = len(self.decoder.factor)
        before = self.decoder.head[0].in_features - place
        if self.decoder.point:
            before -= 2 * self.decoder.point[-2].out_features
        unscaled(self.decoder.head[0], before, self.decoder.shift, self.decoder.factor)
        unscaled(self.decoder.sign, self.decoder.sign.in_features - place, self.decoder.shift, self.decoder.factor)

    def forward(self, code, place, patch):
        answers = self.decoder.answers(code, place, patch, self.pool)
        # The head of the second answer is scaled by no temperature; only its bend is left to do.
        return torch.cat([answers[:, :1], torch.sigmoid(answers[:, 1:])], dim=1)

    def pool(self, features, _neighbours):
        """Numbers, not the sizes of `features`: a graph must not compute them."""
        return halving(features, self.neighbours, self.decoder.point[-2].out_features)


class RasterGraph(nn.Module):
    """The encoder as it is exported: the scaling of the raster folded into the first convolution, which pads with 0."""

    def __init__(self, encoder):
        super().__init__()
        self.encoder = copy.deepcopy(encoder)
        with torch.no_grad():
            self.encoder.stem[0].weight.mul_(self.encoder.factor)

    def forward(self, raster):
        return self.encoder.codes(raster)


def halving(features, neighbours, width):
    """Maximum and mean [B, width] over the neighbours of features [B, neighbours · width], half against half.

    The embedded runtime reduces number by number, an order of magnitude slower than it compares whole rows.
    """
    highest, total, left = features, features, neighbours
    while left > 1:
        pairs, rest = divmod(left, 2)
        # The halves of an odd number overlap: the maximum does not mind.
        highest = torch.maximum(highest[:, : (pairs + rest) * width], highest[:, pairs * width :])
        halved = total[:, : pairs * width] + total[:, pairs * width : 2 * pairs * width]
        total = torch.cat([halved, total[:, 2 * pairs * width :]], dim=1) if rest else halved
        left = pairs + rest
    return [highest, total / neighbours]


@torch.no_grad()
def unscaled(layer, first, shift, factor):
    """Let a layer take its inputs from `first` on as they are, where it took (input − shift) · factor."""
    columns = layer.weight[:, first : first + len(factor)]
    layer.bias.sub_(columns @ (shift * factor))
    columns.mul_(factor)


class Points2SurfGraph(nn.Module):
    """Points2Surf as it is exported: BatchNorm and temperature folded in, the second answer as |d| / r = |p|."""

    def __init__(self, network, temperature):
        super().__init__()
        self.network = copy.deepcopy(network)
        tempered(self.network.sign, temperature)
        for module in self.network.modules():
            if isinstance(module, Layer):
                module.fold()

    def forward(self, patch, subsample):
        hidden = self.network.hidden(patch, subsample)
        p = self.network.distance(hidden)
        # |p| from two ReLU: the loss compares tanh|p| with tanh(|d| / r), so |p| itself is the answer.
        return torch.cat([self.network.sign(hidden), torch.relu(p) + torch.relu(-p)], dim=1)


@torch.no_grad()
def tempered(layer, temperature):
    """Divide the sign logit by the calibration temperature."""
    layer.weight.div_(temperature)
    layer.bias.div_(temperature)


def exportable(network):
    """Whether there is an interface for this network: the ablations without raster or local branch have none."""
    return isinstance(network, Points2Surf) or (
        isinstance(network, FieldNetwork) and network.branch == "raster" and network.local
    )


def graphs(network, temperature, batch):
    """[(file name, module, example inputs, input names, output name)] of a network."""
    sizes = network.interface
    neighbours, features = sizes.neighbours, len(sizes.patch_channels)
    patch = torch.zeros(batch, neighbours, features)
    if isinstance(network, Points2Surf):
        graph = Points2SurfGraph(network, temperature)
        return [
            ("decoder.onnx", graph, (patch, torch.zeros(batch, sizes.subsample, 3)), ["patch", "subsample"], "field")
        ]
    if not exportable(network):
        raise ValueError(
            "only networks with a raster and a local branch have a file; the other variants are for comparison"
        )
    raster = torch.zeros(1, len(sizes.raster_channels), sizes.grid, sizes.grid)
    with torch.no_grad():
        code = network.encoder(raster).shape[1]
    inputs = (torch.zeros(batch, code), torch.zeros(batch, len(sizes.place_channels)), patch)
    return [
        ("encoder.onnx", RasterGraph(network.encoder), (raster,), ["raster"], "code"),
        ("decoder.onnx", FieldGraph(network.decoder, temperature, neighbours), inputs, ["code", "place", "patch"], "field"),
    ]


def write(path, network, *, name, temperature=1.0, batch=256, card=""):
    """Export `network` (on the CPU, in evaluation mode) to the network file `path`."""
    network = copy.deepcopy(network).cpu().eval()
    sizes = network.interface
    metadata = {
        "interface": sizes.name,
        "version": VERSION,
        "name": name,
        "place_channels": ",".join(sizes.place_channels),
        "patch_channels": ",".join(sizes.patch_channels),
        "neighbours": sizes.neighbours,
        "batch": batch,
        "temperature": f"{temperature:.6g}",
        "card": card,
    }
    tensors = {}
    for file, module, inputs, names, output in graphs(network, temperature, batch):
        tensors[file] = np.frombuffer(onnx_bytes(module.eval(), inputs, names, output), dtype=np.uint8)
        if file == "encoder.onnx":
            metadata["raster_channels"] = ",".join(sizes.raster_channels)
            metadata["grid"] = sizes.grid
    if "encoder.onnx" in tensors:
        metadata["code"] = (
            network.decoder.head[0].in_features - len(sizes.place_channels) - 2 * network.decoder.point[-2].out_features
        )
    else:
        metadata["subsample"] = sizes.subsample
    safetensors.write(path, tensors, metadata)


def require_exporter():
    """Fail before the training rather than after it: torch from 2 on exports with the help of the package onnx."""
    if int(torch.__version__.split(".")[0]) >= 2 and importlib.util.find_spec("onnx") is None:
        raise ModuleNotFoundError(
            f"torch {torch.__version__} needs the package onnx to write the network file: pip install onnx"
        )


def onnx_bytes(module, inputs, names, output):
    """One graph with static shapes as the bytes of an ONNX file."""
    buffer = io.BytesIO()
    options = {"input_names": names, "output_names": [output], "opset_version": OPSET, "do_constant_folding": True}
    # From 2.9 on torch would take its other exporter, which needs more packages and names operators differently.
    if "dynamo" in inspect.signature(torch.onnx.export).parameters:
        options["dynamo"] = False
    with torch.no_grad(), warnings.catch_warnings():
        # Torch 1.13 warns of its own constants.
        warnings.filterwarnings("ignore", message="The shape inference of prim::Constant type is missing")
        torch.onnx.export(module, inputs, buffer, **options)
    return buffer.getvalue()
