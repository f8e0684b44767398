#!/usr/bin/env python3
"""The peak memory and the processor time of `gable reconstruct` against the number of buildings.

    python3 benches/run_memory.py [--gable target/release/gable] [--copies 1,4,16,64,256] [--memory 64MB] [--jobs 2]
                                  [--tiles a.laz b.laz --footprints f.geojson] [--json OUT] [--any]

The bundled corner of Delft (or other tiles, with footprints in their CRS) is laid side by side in a square of that many copies,
with new ids, each copy in tiles of its own. Every size runs without a limit and with `--memory`, and the models of both are
compared byte by byte. Unless --any is given it fails when the largest run needs more than twice the memory of the smallest plus 64 MB.
"""

import argparse
import hashlib
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Where a LAS header has the offsets and the extent (LAS 1.4 R15, table 3).
OFFSETS, EXTENT = 155, 179


def extent(tile: bytes) -> list:
    """Smallest and largest x, smallest and largest y of a tile."""
    max_x, min_x, max_y, min_y = struct.unpack_from("<4d", tile, EXTENT)
    return [min_x, max_x, min_y, max_y]


def shifted(tile: bytes, dx: float, dy: float) -> bytes:
    """The same tile elsewhere: its integers stay, its offsets change."""
    out = bytearray(tile)
    x, y = struct.unpack_from("<2d", tile, OFFSETS)
    struct.pack_into("<2d", out, OFFSETS, x + dx, y + dy)
    min_x, max_x, min_y, max_y = extent(tile)
    struct.pack_into("<4d", out, EXTENT, max_x + dx, min_x + dx, max_y + dy, min_y + dy)
    return bytes(out)


def moved(coordinates, dx: float, dy: float):
    if isinstance(coordinates[0], (int, float)):
        return [coordinates[0] + dx, coordinates[1] + dy, *coordinates[2:]]
    return [moved(part, dx, dy) for part in coordinates]


def lay(folder: pathlib.Path, tiles: list, layer: dict, copies: int) -> None:
    """Writes the tiles and footprints of so many copies."""
    tiles = [(path.name, path.read_bytes()) for path in tiles]
    boxes = [extent(tile) for _, tile in tiles]
    step = [int(max(box[2 * axis + 1] for box in boxes) - min(box[2 * axis] for box in boxes)) + 1 for axis in range(2)]
    side = max(1, round(copies**0.5))
    features = []
    for copy in range(copies):
        dx, dy = copy % side * step[0], copy // side * step[1]
        for name, tile in tiles:
            (folder / f"{copy:05}-{name}").write_bytes(shifted(tile, dx, dy))
        for number, feature in enumerate(layer["features"]):
            geometry = feature["geometry"]
            features.append({
                **feature,
                "properties": {**feature["properties"], "bench_id": f"{copy}-{number}"},
                "geometry": {**geometry, "coordinates": moved(geometry["coordinates"], dx, dy)},
            })
    with open(folder / "footprints.geojson", "w", encoding="utf-8") as out:
        json.dump({**layer, "features": features}, out)


def run(command: list) -> tuple:
    """Peak memory in megabytes, processor seconds and seconds of a command."""
    started = time.monotonic()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 2):
        sys.exit(f"failed: {' '.join(map(str, command))}")
    return usage.ru_maxrss * 1024 / 1e6, usage.ru_utime + usage.ru_stime, time.monotonic() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gable", default=ROOT / "target/release/gable", type=pathlib.Path)
    parser.add_argument("--copies", default="1,4,16,64")
    parser.add_argument("--memory", default="64MB")
    parser.add_argument("--jobs", default="2")
    parser.add_argument("--tiles", nargs="+", type=pathlib.Path, default=[ROOT / "examples/data/delft_ahn3.laz"])
    parser.add_argument("--footprints", type=pathlib.Path, default=ROOT / "examples/data/footprints.geojson")
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--any", action="store_true", help="whatever the memory, it does not fail")
    parser.add_argument("options", nargs="*", help="more options of gable, behind --")
    args = parser.parse_args()
    layer = json.loads(args.footprints.read_text(encoding="utf-8"))
    rows = []
    print(f"{'copies':>7} {'buildings':>9} {'memory':>8} {'peak MB':>8} {'CPU ms/building':>16} {'seconds':>8}")
    for copies in map(int, args.copies.split(",")):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            lay(folder, args.tiles, layer, copies)
            buildings = copies * len(layer["features"])
            hashes = set()
            for memory in [None, args.memory] if args.memory != "none" else [None]:
                out = folder / "model.city.jsonl"
                command = [args.gable, "reconstruct", folder / "*.laz", "-f", folder / "footprints.geojson", "-o", out,
                           "--id-attribute", "bench_id", "--overwrite", "-q", "-j", args.jobs, *args.options]
                command += ["--memory", memory] if memory else []
                peak, cpu, seconds = run(command)
                hashes.add(hashlib.sha256(out.read_bytes()).hexdigest())
                rows.append({"copies": copies, "buildings": buildings, "memory": memory, "peak_mb": peak,
                             "cpu_ms": 1000 * cpu / buildings, "seconds": seconds})
                print(f"{copies:7} {buildings:9} {memory or '-':>8} {peak:8.0f} {1000 * cpu / buildings:16.2f} {seconds:8.1f}",
                      flush=True)
            if len(hashes) != 1:
                sys.exit(f"{copies} copies: the models differ with the memory")
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    peaks = [row["peak_mb"] for row in rows]
    if not args.any and max(peaks) > 2 * peaks[0] + 64:
        sys.exit(f"the largest run needs {max(peaks):.0f} MB, the smallest {peaks[0]:.0f} MB")


if __name__ == "__main__":
    main()
