"""Much of everything: footprints without points, large halls, outlines of very many corners."""

import json
import math

import sound

MEMORY = 4 << 30


def write_footprints(case, name, rings):
    features = [
        {"type": "Feature", "properties": {"id": f"b{number}"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for number, ring in enumerate(rings)
    ]
    crs = {"type": "name", "properties": {"name": f"urn:ogc:def:crs:EPSG::{sound.EPSG}"}}
    return case.put(name, json.dumps({"type": "FeatureCollection", "crs": crs, "features": features}).encode())


def rectangle(x, y, width, depth):
    return [[x, y], [x + width, y], [x + width, y + depth], [x, y + depth], [x, y]]


def report_of(case, name):
    path = case.out / f"{name}.report.json"
    return json.loads(path.read_text()) if path.exists() else None


def hall(case):
    """A saw-tooth hall, 4 m a tooth, 10 points a square metre, noise of 2 cm: the model fits as well as the noise allows."""
    width, depth = case.bench.halls[case.number % len(case.bench.halls)]
    x0, y0 = 85_000.0, 447_000.0
    points = []
    for _ in range(10 * (width + 20) * (depth + 20)):
        x, y = case.draw.uniform(-10, width + 10), case.draw.uniform(-10, depth + 10)
        is_roof = 0 <= x <= width and 0 <= y <= depth
        z = 8 + 1.5 * (x % 4) / 4 if is_roof else 0
        points.append((x0 + x, y0 + y, z + case.draw.gauss(0, 0.02), 6 if is_roof else 2))
    tile = case.put("hall.las", sound.las(points))
    footprints = write_footprints(case, "hall.geojson", [rectangle(x0, y0, width, depth)])
    ended = case.reconstruct(tile, footprints, rest=["--crs", "EPSG:7415"], codes=(0,), seconds=900, memory=MEMORY)
    report = report_of(case, "m.city.jsonl")
    rmse = report and report["buildings"][0]["rmse_lod22"]
    if rmse is None or not rmse <= 0.03:
        case.breach(f"{width} x {depth} m: RMSE {rmse} at LoD 2.2", ended)


def empty(case):
    """Footprints without any point, around a house that has some: processor time and memory."""
    count = case.bench.empty
    x0, y0 = 85_000.0, 447_000.0
    points = []
    for i in range(-20, 40):
        for j in range(-20, 36):
            x, y = i * 0.5 + 0.25, j * 0.5 + 0.25
            is_roof = 0 <= x < 10 and 0 <= y < 8
            points.append((x0 + x, y0 + y, 6.0 if is_roof else 0.0, 6 if is_roof else 2))
    side = math.isqrt(count)
    rings = [rectangle(x0 + 100 + 12 * (n % side), y0 + 12 * (n // side), 8, 8) for n in range(count)]
    tile = case.put("house.las", sound.las(points))
    footprints = write_footprints(case, "many.geojson", [rectangle(x0, y0, 10, 8), *rings])
    ended = case.reconstruct(tile, footprints, rest=["--crs", "EPSG:7415"], codes=(0,), seconds=600, memory=MEMORY)
    # Half as much again as the processor time that was measured, and a tenth more memory.
    memory = ended.memory / 1e6
    if ended.cpu > 0.5 + count / 8_000 or memory > 80 + count / 600:
        case.breach(f"{count} footprints cost {ended.cpu:.1f} CPU s and {memory:.0f} MB", ended)


def jagged(case):
    """One outline of very many vertices, up to 30 cm in or out."""
    outlines(case, lambda _: case.draw.uniform(19.7, 20.3))


def star(case):
    """One outline of very many spikes, 6 m long."""
    outlines(case, lambda i: 14.0 if i % 2 else 20.0)


def outlines(case, reach):
    """A round house in an outline by the reach of its corners: four times as many may cost six times as much, not sixteen."""
    costs = []
    x0, y0 = 85_000.0, 447_000.0
    spots = [(x0 + 0.5 * i, y0 + 0.5 * j) for i in range(-60, 61) for j in range(-60, 61)]
    roofs = [math.hypot(x - x0, y - y0) < 20.0 for x, y in spots]
    points = [(x, y, 7.0 if roof else 0.0, 6 if roof else 2) for (x, y), roof in zip(spots, roofs)]
    tile = case.put("round.las", sound.las(points))
    for number, count in enumerate((case.bench.outlines // 4, case.bench.outlines)):
        ring = []
        for i in range(count):
            angle, far = 2 * math.pi * i / count, reach(i)
            ring.append([round(x0 + far * math.cos(angle), 3), round(y0 + far * math.sin(angle), 3)])
        footprints = write_footprints(case, f"outline{number}.geojson", [[*ring, ring[0]]])
        rest = ["--crs", "EPSG:7415", "--field", "height-field"]
        ended = case.reconstruct(tile, footprints, f"m{number}.city.jsonl", rest=rest, seconds=600, memory=MEMORY)
        costs.append(ended.cpu)
    if costs[1] > 1.0 + 6 * costs[0]:
        case.breach(f"{case.bench.outlines} vertices cost {costs[1]:.1f} CPU s, a quarter of them {costs[0]:.1f}", ended)
