"""The safetensors format: an 8-byte length, a JSON header, then the raw little-endian tensors.

Read by memory mapping, so that a folder of shards larger than memory can be trained on, and written
with sorted keys, so that equal content gives equal bytes.
"""

import json
import math
import os
from pathlib import Path

import numpy as np

DTYPES = {
    "F64": "<f8",
    "F32": "<f4",
    "F16": "<f2",
    "I64": "<i8",
    "I32": "<i4",
    "U8": "|u1",
}


class FormatError(ValueError):
    """A file that is not what it should be; the message names the file and the place."""


def read(path):
    """Map a safetensors file: ({name: read-only array}, {metadata key: string})."""
    path = Path(path)
    size = path.stat().st_size
    with path.open("rb") as file:
        length = int.from_bytes(file.read(8), "little")
        if size < 8 or length > size - 8:
            raise FormatError(f"{path}: cut off: a header of {length} bytes is announced, the file has {size}")
        try:
            header = json.loads(file.read(length))
        except ValueError as error:
            raise FormatError(f"{path}: the header is not JSON ({error}); is this a safetensors file?") from error
    metadata = header.pop("__metadata__", {})
    body = np.memmap(path, dtype=np.uint8, mode="r", offset=8 + length) if size > 8 + length else np.zeros(0, np.uint8)
    tensors = {}
    for name, entry in header.items():
        if entry["dtype"] not in DTYPES:
            raise FormatError(f"{path}: tensor {name} has type {entry['dtype']}, known are {', '.join(DTYPES)}")
        dtype = np.dtype(DTYPES[entry["dtype"]])
        begin, end = entry["data_offsets"]
        wanted = math.prod(entry["shape"]) * dtype.itemsize
        if end - begin != wanted or end > body.size:
            raise FormatError(f"{path}: tensor {name} {entry['shape']} does not fit its bytes {begin}..{end}; cut off?")
        # A plain array view: indexing a memmap object itself costs a microsecond per access.
        tensors[name] = np.asarray(body[begin:end]).view(dtype).reshape(entry["shape"])
    return tensors, metadata


def write(path, tensors, metadata):
    """Write {name: array} and {key: string}; the file appears whole or not at all."""
    names = {np.dtype(value): key for key, value in DTYPES.items()}
    header = {"__metadata__": {key: str(metadata[key]) for key in sorted(metadata)}}
    # Widest type first keeps every tensor aligned to its own size.
    order = sorted(tensors, key=lambda name: (-tensors[name].dtype.itemsize, name))
    offset = 0
    for name in order:
        tensor = tensors[name]
        header[name] = {
            "dtype": names[tensor.dtype.newbyteorder("<")],
            "shape": list(tensor.shape),
            "data_offsets": [offset, offset + tensor.nbytes],
        }
        offset += tensor.nbytes
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 8)
    part = Path(f"{path}.part")
    with part.open("wb") as file:
        file.write(len(text).to_bytes(8, "little"))
        file.write(text)
        for name in order:
            file.write(np.ascontiguousarray(tensors[name]).tobytes())
    os.replace(part, path)
