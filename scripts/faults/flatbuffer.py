"""FlatGeobuf, version 3, without an index: as much of flatbuffers as that takes."""

import struct


class Table:
    """A table of flatbuffers, with its fields by slot: a scalar as (form, value), or bytes, text, a list or a table."""

    def __init__(self, fields):
        self.fields = fields


class Vector:
    """A vector of scalars of one form."""

    def __init__(self, form, values):
        self.form, self.values = form, values


def build(root):
    """The table with its size in front."""
    out = bytearray(8)
    patches = []

    def align(size):
        while len(out) % size:
            out.append(0)

    def place(value):
        """Writes what is referred to, and gives its place."""
        if isinstance(value, str):
            value = Vector("B", list(value.encode()) + [0])
            align(4)
            at = len(out)
            out.extend(struct.pack("<I", len(value.values) - 1) + bytes(value.values))
            return at
        if isinstance(value, Vector):
            size = struct.calcsize(value.form)
            while (len(out) + 4) % max(size, 4):
                out.append(0)
            at = len(out)
            out.extend(struct.pack(f"<I{len(value.values)}{value.form}", len(value.values), *value.values))
            return at
        if isinstance(value, list):
            align(4)
            at = len(out)
            out.extend(struct.pack("<I", len(value)) + bytes(4 * len(value)))
            for number, item in enumerate(value):
                spot = at + 4 + 4 * number
                struct.pack_into("<I", out, spot, place(item) - spot)
            return at
        return table(value)

    def table(value):
        last = max(value.fields)
        offsets, size = [0] * (last + 1), 4
        for slot, field in sorted(value.fields.items()):
            width = struct.calcsize(field[0]) if isinstance(field, tuple) else 4
            size += -size % width
            offsets[slot] = size
            size += width
        align(8)
        virtual = len(out)
        out.extend(struct.pack(f"<HH{last + 1}H", 4 + 2 * (last + 1), size, *offsets))
        align(8)
        at = len(out)
        out.extend(bytes(size))
        struct.pack_into("<i", out, at, at - virtual)
        for slot, field in value.fields.items():
            spot = at + offsets[slot]
            if isinstance(field, tuple):
                struct.pack_into("<" + field[0], out, spot, field[1])
            else:
                patches.append((spot, field))
        mine = [patch for patch in patches if at <= patch[0] < at + size]
        for patch in mine:
            patches.remove(patch)
            struct.pack_into("<I", out, patch[0], place(patch[1]) - patch[0])
        return at

    root_at = table(root)
    struct.pack_into("<II", out, 0, len(out) - 4, root_at - 4)
    return bytes(out)


def flatgeobuf(rings, rows, epsg):
    """Polygons of one ring with the attributes id, floors and height."""
    columns = [Table({0: name, 1: ("B", kind)}) for name, kind in (("id", 11), ("floors", 5), ("height", 10))]
    header = Table({0: "b", 2: ("B", 3), 7: columns, 8: ("Q", len(rings)), 9: ("H", 0), 10: Table({0: "EPSG", 1: ("i", epsg)})})
    content = b"fgb\x03fgb\x00" + build(header)
    for ring, row in zip(rings, rows):
        text = row["id"].encode()
        values = struct.pack(f"<HI{len(text)}sHiHd", 0, len(text), text, 1, row["floors"], 2, row["height"])
        geometry = Table({1: Vector("d", [c for p in ring for c in p]), 6: ("B", 3)})
        content += build(Table({0: geometry, 1: Vector("B", list(values))}))
    return content
