"""GeoParquet 1.1 without compression: as much of Parquet and of Thrift's compact protocol as that takes."""

import json
import struct

INT32, INT64, DOUBLE, BYTES = 1, 2, 5, 6


def varint(number):
    out = bytearray()
    while number > 127:
        out.append(number & 127 | 128)
        number >>= 7
    return bytes(out + bytes([number]))


def zigzag(number):
    return varint(number << 1 if number >= 0 else -(number << 1) - 1)


def struct_of(fields):
    """A Thrift struct: field number to int, text, bytes, list or dict (another struct)."""
    out, last = b"", 0
    for number, value in sorted(fields.items()):
        kind = {dict: 12, list: 9, str: 8, bytes: 8}.get(type(value), 6 if isinstance(value, Long) else 5)
        out += bytes([(number - last) << 4 | kind]) + value_of(value)
        last = number
    return out + b"\0"


class Long(int):
    """A number of 64 bits."""


def value_of(value):
    if isinstance(value, dict):
        return struct_of(value)
    if isinstance(value, list):
        kind = {dict: 12, str: 8}.get(type(value[0]), 5)
        head = bytes([len(value) << 4 | kind]) if len(value) < 15 else bytes([0xF0 | kind]) + varint(len(value))
        return head + b"".join(map(value_of, value))
    if isinstance(value, (str, bytes)):
        value = value.encode() if isinstance(value, str) else value
        return varint(len(value)) + value
    return zigzag(value)


def geoparquet(rings, rows):
    """Polygons of one ring as WKB, with the attributes id, floors and height."""
    from sound import wkb

    text = lambda value: struct.pack("<I", len(value)) + value
    columns = [
        ("geometry", BYTES, [text(wkb(ring)) for ring in rings]),
        ("id", BYTES, [text(row["id"].encode()) for row in rows]),
        ("floors", INT32, [struct.pack("<i", row["floors"]) for row in rows]),
        ("height", DOUBLE, [struct.pack("<d", row["height"]) for row in rows]),
    ]
    content, chunks = b"PAR1", []
    for name, kind, values in columns:
        page = b"".join(values)
        # Plain values; no levels, since the columns are required.
        head = struct_of({1: 0, 2: len(page), 3: len(page), 5: {1: len(values), 2: 0, 3: 3, 4: 3}})
        meta = {1: kind, 2: [0], 3: [name], 4: 0, 5: Long(len(values)), 6: Long(len(head + page)), 7: Long(len(head + page)),
                9: Long(len(content))}
        chunks.append({2: Long(len(content)), 3: meta})
        content += head + page
    schema = [{4: "schema", 5: len(columns)}]
    schema += [{1: kind, 3: 0, 4: name, **({6: 0} if name == "id" else {})} for name, kind, _ in columns]
    geo = {"version": "1.1.0", "primary_column": "geometry",
           "columns": {"geometry": {"encoding": "WKB", "geometry_types": ["Polygon"], "crs": None}}}
    group = {1: chunks, 2: Long(len(content)), 3: Long(len(rows))}
    footer = struct_of({1: 2, 2: schema, 3: Long(len(rows)), 4: [group], 5: [{1: "geo", 2: json.dumps(geo)}]})
    return content + footer + struct.pack("<I", len(footer)) + b"PAR1"
