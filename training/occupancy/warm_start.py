"""Starting from the weights of a network file: what `network_file` folds into the graphs is unfolded again."""

import torch

from . import safetensors
from .field import FieldNetwork
from .safetensors import FormatError

# Fields of the protocol buffers of ONNX, as onnx.proto numbers them.
GRAPH, INITIALIZER = 7, 5
DIMENSIONS, DATA_TYPE, NAME, RAW_DATA = 1, 2, 8, 9
SINGLE_PRECISION = 1


def start_from(network, path):
    """Give an untrained field, whose inputs are scaled already, the weights of the network file `path`."""
    if not isinstance(network, FieldNetwork):
        raise FormatError(f"{path}: only networks of the interface \"field\" can be started from")
    tensors, metadata = safetensors.read(path)
    sizes = network.interface
    for key, wanted in (("place_channels", sizes.place_channels), ("raster_channels", sizes.raster_channels)):
        if metadata.get(key) != ",".join(wanted):
            raise FormatError(f"{path}: {key} is {metadata.get(key)!r}, the shards have {','.join(wanted)!r}")
    weights = {}
    for graph in ("encoder.onnx", "decoder.onnx"):
        if graph not in tensors:
            raise FormatError(f"{path}: {graph} is missing")
        weights.update(initializers(bytes(tensors[graph]), path))
    decoder = network.decoder
    with torch.no_grad():
        for name, parameter in network.named_parameters():
            if name not in weights or weights[name].shape != parameter.shape:
                found = "none" if name not in weights else f"{tuple(weights[name].shape)}"
                raise FormatError(
                    f"{path}: {name} is {found}, the configuration wants {tuple(parameter.shape)}; take its sizes"
                )
            parameter.copy_(weights[name])
        network.encoder.stem[0].weight.div_(network.encoder.factor)
        place = len(decoder.factor)
        for layer in (decoder.head[0], decoder.sign):
            first = decoder.head[0].in_features - place - 2 * decoder.point[-2].out_features
            first = first if layer is not decoder.sign else layer.in_features - place
            columns = layer.weight[:, first : first + place]
            layer.bias.add_(columns @ decoder.shift)
            columns.div_(decoder.factor)


def initializers(data, path):
    """The single-precision weights of an ONNX model by name."""
    found = {}
    for field, graph in fields(data, path):
        if field != GRAPH:
            continue
        for field, tensor in fields(graph, path):
            if field != INITIALIZER:
                continue
            shape, name, raw, kind = [], "", b"", 0
            for field, value in fields(tensor, path):
                if field == DIMENSIONS:
                    # Packed or one by one: writers differ.
                    shape += [value] if isinstance(value, int) else list(numbers(value))
                elif field == DATA_TYPE:
                    kind = value
                elif field == NAME:
                    name = value.decode()
                elif field == RAW_DATA:
                    raw = value
            if kind == SINGLE_PRECISION and raw:
                found[name] = torch.frombuffer(bytearray(raw), dtype=torch.float32).reshape(shape)
    return found


def fields(data, path):
    """The fields of a protocol buffer: numbers as int, the rest as bytes."""
    at = 0
    while at < len(data):
        key, at = varint(data, at)
        kind = key & 7
        if kind == 0:
            value, at = varint(data, at)
        elif kind == 2:
            size, at = varint(data, at)
            value, at = data[at : at + size], at + size
        elif kind in (1, 5):
            size = 8 if kind == 1 else 4
            value, at = data[at : at + size], at + size
        else:
            raise FormatError(f"{path}: not a graph of ONNX (a field of type {kind})")
        yield key >> 3, value


def numbers(data):
    """The numbers that are packed one after the other."""
    at = 0
    while at < len(data):
        value, at = varint(data, at)
        yield value


def varint(data, at):
    """A number of seven bits a byte, and where it ends."""
    value = shift = 0
    while at < len(data):
        byte = data[at]
        value, shift, at = value | (byte & 0x7F) << shift, shift + 7, at + 1
        if byte < 0x80:
            return value, at
    raise FormatError("not a graph of ONNX (a number is cut off)")
