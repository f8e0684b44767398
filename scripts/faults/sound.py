"""Sound inputs of every format, small: a few houses of the bundled corner of Delft."""

import json
import sqlite3
import struct

from flatbuffer import flatgeobuf
from parquet import geoparquet

EPSG = 28992


def make(bench, case, data):
    """All of them by name; `case` runs gable for those that it writes itself."""
    collection = json.loads((data / "footprints.geojson").read_text())
    polygons = [f for f in collection["features"] if f["geometry"]["type"] == "Polygon"]
    first = polygons[len(polygons) // 2]["geometry"]["coordinates"][0]
    x, y = (sum(p[axis] for p in first) / len(first) for axis in (0, 1))
    near = [f for f in polygons if all(abs(p[0] - x) < 22 and abs(p[1] - y) < 22 for p in f["geometry"]["coordinates"][0])]
    found = {"whole.laz": (data / "delft_ahn3.laz").read_bytes(), "whole.geojson": (data / "footprints.geojson").read_bytes()}
    small = {**collection, "features": near}
    found["small.geojson"] = found["f.geojson"] = json.dumps(small).encode()
    found["f.geojsonl"] = b"".join(json.dumps(f).encode() + b"\n" for f in near)
    rings = [[ring[:2] for ring in f["geometry"]["coordinates"][0]] for f in near]
    rows = [{"id": f"b{i}", "floors": i, "height": 2.5 * i} for i in range(len(rings))]
    found["f.gpkg"] = geopackage(case.folder / "f.gpkg", rings, rows)
    found["f.shp"], found["f.shx"], found["f.dbf"] = shapefile(rings, rows)
    found["f.fgb"] = flatgeobuf(rings, rows, EPSG)
    found["f.parquet"] = geoparquet(rings, rows)
    found.update(tiles(case, data / "delft_ahn3.laz", x, y))
    bench.sound = found
    tile, footprints = case.sound("tile.laz"), case.sound("small.geojson")
    for name in ("m.city.json", "m.city.jsonl"):
        case.reconstruct(tile, footprints, name, codes=(0,))
        found[name] = (case.out / name).read_bytes()
    for name in ("f.gpkg", "f.shp", "f.fgb", "f.parquet", "f.geojsonl"):
        others = [other for other in ("f.shx", "f.dbf") if name == "f.shp"]
        path = [case.sound(part) for part in (name, *others)][0]
        case.reconstruct(tile, path, f"of-{name[2:]}.city.jsonl", rest=["--footprint-crs", "EPSG:28992"], codes=(0,))
    found["terrain.tif"] = terrain(x, y)
    found["pipeline.json"] = json.dumps([
        str(data / "delft_ahn3.laz"), {"type": "filters.crop", "bounds": f"([{x - 9}, {x + 9}], [{y - 9}, {y + 9}])"},
        {"type": "filters.outlier", "method": "statistical", "mean_k": 8, "multiplier": 3.0},
        {"type": "filters.expression", "expression": "Classification == 6 && Z > 0"}, {"type": "writers.null"},
    ]).encode()
    for name in ("tile.las", "tile.copc.laz", "tile.ply", "tile.xyz"):
        rest = ["--crs", "EPSG:7415"] if name.endswith(("ply", "xyz")) else []
        case.reconstruct(case.sound(name), footprints, f"of-{name[5:]}.city.jsonl", rest=rest, codes=(0, 2))
    return found


def written(case, source, name, kind, minor, *stages):
    """A tile that the pipeline makes of another."""
    stage = {"type": "writers.las", "filename": str(case.out / name), "dataformat_id": kind, "minor_version": minor}
    case.run(["pipeline", case.put("make.json", json.dumps([str(source), *stages, stage]).encode())], codes=(0,))
    return (case.out / name).read_bytes()


def plain_las(case, source):
    """A tile as LAS of format 0."""
    return written(case, source, "many.las", 0, 2)


def tiles(case, source, x, y):
    """The surroundings of a place as LAS, LAZ in two point formats, COPC, PLY and text."""
    reach = 30
    crop = {"type": "filters.crop", "bounds": f"([{x - reach}, {x + reach}], [{y - reach}, {y + reach}])"}
    kinds = {"tile.laz": (6, 4), "tile1.laz": (1, 2), "tile.las": (6, 4), "plain.las": (0, 2)}
    found = {name: written(case, source, name, *kind, crop) for name, kind in kinds.items()}
    found["tile.copc.laz"] = copc(found["tile.laz"])
    points = points_of_las(found.pop("plain.las"))
    found["tile.xyz"] = ("x y z class\n" + "".join(f"{x:.3f} {y:.3f} {z:.3f} {c}\n" for x, y, z, c in points)).encode()
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
    head += "property double z\nproperty uchar classification\nend_header\n"
    found["tile.ply"] = head.encode() + b"".join(struct.pack("<dddB", *point) for point in points)
    return found


def points_of_las(content):
    """Place and class of the points of a LAS file of format 0."""
    start, size, count = struct.unpack_from("<I", content, 96)[0], *struct.unpack_from("<HI", content, 105)
    scale, offset = struct.unpack_from("<3d", content, 131), struct.unpack_from("<3d", content, 155)
    points = []
    for at in range(start, start + size * count, size):
        place = struct.unpack_from("<3i", content, at)
        points.append((*(p * s + o for p, s, o in zip(place, scale, offset)), content[at + 15] & 31))
    return points


def las(points):
    """An uncompressed LAS 1.2 of format 0: x, y, z and class of each point, millimetres."""
    low, high = [[pick(p[axis] for p in points) for axis in range(3)] for pick in (min, max)]
    header = struct.pack(
        "<4sHHIHH8sBB32s32sHHHIIBHI5I3d3d6d", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"", b"faults", 1, 2026, 227, 227,
        0, 0, 20, len(points), len(points), 0, 0, 0, 0, 0.001, 0.001, 0.001, 0.0, 0.0, 0.0,
        high[0], low[0], high[1], low[1], high[2], low[2],
    )
    rows = (struct.pack("<iiiHBBbBH", *(round(v * 1000) for v in (x, y, z)), 0, 9, kind, 0, 0, 0) for x, y, z, kind in points)
    return header + b"".join(rows)


def copc(laz):
    """A LAZ file of one chunk as COPC: the record that names the octree, and an octree of one node."""
    header, start, records = struct.unpack_from("<HII", laz, 94)
    body = bytearray(laz)
    extended = struct.unpack_from("<Q", laz, 235)[0]
    if extended:
        del body[extended:]
    places = struct.unpack_from("<6d", laz, 179)
    spans = [(places[2 * axis + 1], places[2 * axis]) for axis in range(3)]
    half = max(high - low for low, high in spans) / 2
    middle = [(low + high) / 2 for low, high in spans]
    shift = 54 + 160
    table = struct.unpack_from("<q", laz, start)[0] + shift
    points = struct.unpack_from("<Q", laz, 247)[0]
    info = struct.pack("<4ddQQdd", *middle, half, 1.0, len(body) + shift + 60, 32, 0.0, 0.0) + bytes(88)
    record = struct.pack("<H16sHH32s", 0, b"copc", 1, 160, b"") + info
    struct.pack_into("<II", body, 96, start + shift, records + 1)
    struct.pack_into("<QI", body, 235, len(body) + shift, 1)
    struct.pack_into("<q", body, start, table)
    node = struct.pack("<4iQii", 0, 0, 0, 0, start + shift + 8, table - start - shift - 8, points)
    return bytes(body[:header]) + record + bytes(body[header:]) + struct.pack("<H16sHQ32s", 0, b"copc", 1000, 32, b"") + node


def wkb(ring):
    """A polygon of one ring."""
    return struct.pack("<BIII", 1, 3, 1, len(ring)) + b"".join(struct.pack("<2d", *p) for p in ring)


def geopackage(path, rings, rows):
    database = sqlite3.connect(path)
    database.executescript(f"""
        PRAGMA application_id = 1196444487;
        CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT, srs_id INTEGER PRIMARY KEY, organization TEXT,
            organization_coordsys_id INTEGER, definition TEXT, description TEXT);
        INSERT INTO gpkg_spatial_ref_sys VALUES ('RD', {EPSG}, 'EPSG', {EPSG}, 'undefined', NULL);
        CREATE TABLE gpkg_contents (table_name TEXT PRIMARY KEY, data_type TEXT, identifier TEXT, srs_id INTEGER);
        INSERT INTO gpkg_contents VALUES ('b', 'features', 'b', {EPSG});
        CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER,
            z TINYINT, m TINYINT);
        INSERT INTO gpkg_geometry_columns VALUES ('b', 'geom', 'POLYGON', {EPSG}, 0, 0);
        CREATE TABLE b (fid INTEGER PRIMARY KEY, geom BLOB, id TEXT, floors INTEGER, height REAL);
    """)
    for ring, row in zip(rings, rows):
        head = struct.pack("<2sBBi", b"GP", 0, 1, EPSG)
        values = (head + wkb(ring), row["id"], row["floors"], row["height"])
        database.execute("INSERT INTO b (geom, id, floors, height) VALUES (?, ?, ?, ?)", values)
    database.commit()
    database.close()
    content = path.read_bytes()
    path.unlink()
    return content


def shapefile(rings, rows):
    """The files .shp, .shx and .dbf."""
    bounds = [pick(p[axis] for ring in rings for p in ring) for pick in (min, max) for axis in (0, 1)]
    body, index = b"", b""
    for number, ring in enumerate(rings, 1):
        # Exteriors turn clockwise.
        twice = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:]))
        ring = ring[::-1] if twice > 0 else ring
        box = [pick(p[axis] for p in ring) for pick in (min, max) for axis in (0, 1)]
        record = struct.pack("<i4diii", 5, *box, 1, len(ring), 0) + b"".join(struct.pack("<2d", *p) for p in ring)
        index += struct.pack(">ii", (100 + len(body)) // 2, len(record) // 2)
        body += struct.pack(">ii", number, len(record) // 2) + record

    def head(length):
        return struct.pack(">7i", 9994, 0, 0, 0, 0, 0, length // 2) + struct.pack("<ii8d", 1000, 5, *bounds, 0, 0, 0, 0)

    fields = (("id", b"C", 10, 0), ("floors", b"N", 6, 0), ("height", b"N", 10, 2))
    size = 1 + sum(field[2] for field in fields)
    table = struct.pack("<4BIHH20x", 3, 126, 1, 1, len(rows), 32 + 32 * len(fields) + 1, size)
    table += b"".join(struct.pack("<11sc4xBB14x", name.encode(), kind, *of) for name, kind, *of in fields) + b"\r"
    for row in rows:
        table += f" {row['id']:<10}{row['floors']:>6}{row['height']:>10.2f}".encode()
    return head(100 + len(body)) + body, head(100 + len(index)) + index, table + b"\x1a"


def terrain(x, y):
    """A GeoTIFF of floats, 2 m a pixel, 40 by 40 pixels."""
    heights = b"".join(struct.pack("<f", 0.01 * i) for i in range(1600))
    keys = struct.pack("<12H", 1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, EPSG)
    scale, tie = struct.pack("<3d", 2, 2, 0), struct.pack("<6d", 0, 0, 0, x - 40, y + 40, 0)
    entries = [
        (256, 3, 1, 40), (257, 3, 1, 40), (258, 3, 1, 32), (259, 3, 1, 1), (262, 3, 1, 1), (273, 4, 1, heights), (277, 3, 1, 1),
        (278, 3, 1, 40), (279, 4, 1, len(heights)), (339, 3, 1, 3), (33550, 12, 3, scale), (33922, 12, 6, tie), (34735, 3, 12, keys),
    ]
    at = 8 + 2 + 12 * len(entries) + 4
    directory, body = struct.pack("<H", len(entries)), b""
    for tag, kind, count, value in entries:
        if isinstance(value, bytes):
            value, body = at + len(body), body + value
        directory += struct.pack("<HHII", tag, kind, count, value)
    return struct.pack("<2sHI", b"II", 42, 8) + directory + bytes(4) + body
