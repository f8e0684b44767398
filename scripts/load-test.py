#!/usr/bin/env python3
"""The load test: damaged files, bombs, kills, endless inputs, many footprints, large halls.

    scripts/load-test.py            under two minutes, as CI runs it
    scripts/load-test.py --long     about an hour
    scripts/load-test.py --only flips,kills --gable target/release/gable

Every run of gable has a time limit and a limit on its address space. It must end by itself with one of its exit codes, say
nothing of a panic, and leave nothing half-written. Prints a table of what was run and a line for every breach; exits with 1
if there is one. Needs Python 3.9 and nothing else; the damage follows from --seed.
"""

import argparse
import json
import math
import os
import random
import resource
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
GABLE = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "release" / "gable"
DATA = ROOT / "examples" / "data"
TILE = DATA / "delft_ahn3.laz"
FOOTPRINTS = DATA / "footprints.geojson"
# Address space of a run in bytes; a thread of the pool reserves 64 MiB of it and uses little.
ADDRESS_SPACE = 4 << 30
SECONDS = 120


class Bench:
    """Runs gable and keeps the counts."""

    def __init__(self, gable, folder):
        self.gable, self.folder = gable, folder
        self.counts, self.breaches = {}, []

    def breach(self, kind, text):
        self.breaches.append(f"{kind}: {text}")
        print(f"BREACH {kind}: {text}", flush=True)

    def run(self, kind, args, codes=(0, 1, 2), seconds=SECONDS):
        """Runs gable once and judges how it ended; gives exit code, standard error and wall seconds."""

        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        started = time.monotonic()
        command = [str(self.gable), *map(str, args)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=seconds, preexec_fn=limit)
        except subprocess.TimeoutExpired:
            self.counts.setdefault(kind, {}).setdefault("hang", 0)
            self.counts[kind]["hang"] += 1
            self.breach(kind, f"no end after {seconds} s: {' '.join(command)}")
            return None, "", seconds
        text = done.stderr.decode(errors="replace")
        of_kind = self.counts.setdefault(kind, {})
        of_kind[done.returncode] = of_kind.get(done.returncode, 0) + 1
        if done.returncode not in codes:
            self.breach(kind, f"exit {done.returncode}: {' '.join(command)}\n{text[-600:]}")
        if "panicked" in text or "stack backtrace" in text or "overflowed its stack" in text:
            self.breach(kind, f"a panic: {' '.join(command)}\n{text[-600:]}")
        return done.returncode, text, time.monotonic() - started

    def damaged(self, kind, name, content, keep):
        """Reads one damaged input; keeps it in `keep` when something was wrong with that."""
        path = self.folder / name
        path.write_bytes(content)
        before = len(self.breaches)
        is_tile = path.suffix in (".laz", ".las")
        self.run(kind, ["info", path])
        if is_tile:
            everything = {"pipeline": [str(path), {"type": "filters.head", "count": 10**9}, {"type": "writers.null"}]}
            pipeline = self.folder / "all.json"
            pipeline.write_text(json.dumps(everything))
            self.run(kind, ["pipeline", pipeline])
        if len(self.breaches) > before:
            keep.mkdir(exist_ok=True)
            shutil.copy(path, keep / f"{kind}-{len(self.breaches)}-{name}")


def inputs(bench):
    """Small sound inputs of many kinds: name and content."""
    found = {"tile.laz": TILE.read_bytes()[:400_000], "f.geojson": FOOTPRINTS.read_bytes()}
    gpkg = bench.folder / "made.gpkg"
    bench.run("sound", ["reconstruct", TILE, "-f", FOOTPRINTS, "-o", gpkg, "--quiet"], codes=(0,))
    model = bench.folder / "made.city.jsonl"
    bench.run("sound", ["reconstruct", TILE, "-f", FOOTPRINTS, "-o", model, "--quiet"], codes=(0,))
    found["f.gpkg"], found["model.city.jsonl"] = gpkg.read_bytes(), model.read_bytes()
    # The formats whose times laz decodes by calling itself.
    for point_format in (1, 7):
        path = bench.folder / f"format{point_format}.laz"
        stage = {"type": "writers.las", "filename": str(path), "dataformat_id": point_format, "minor_version": 4}
        pipeline = bench.folder / "convert.json"
        pipeline.write_text(json.dumps({"pipeline": [str(TILE), stage]}))
        bench.run("sound", ["pipeline", pipeline], codes=(0,))
        if path.exists():
            found[path.name] = path.read_bytes()
    return found


def of_model(name):
    return name.startswith("model")


def try_damage(bench, kind, name, content, keep):
    if of_model(name):
        path = bench.folder / name
        path.write_bytes(content)
        bench.run(kind, ["validate", path])
    else:
        bench.damaged(kind, name, content, keep)


def flips(bench, draw, sound, count, keep):
    """Single bits, half of them in the first kilobyte."""
    for number in range(count):
        name, content = draw.choice(sorted(sound.items()))
        damaged = bytearray(content)
        at = draw.randrange(min(1024, len(damaged)) if number % 2 else len(damaged))
        damaged[at] ^= 1 << draw.randrange(8)
        try_damage(bench, "flips", name, bytes(damaged), keep)


def blocks(bench, draw, sound, count, keep):
    """Blocks of one byte or of noise."""
    for number in range(count):
        name, content = draw.choice(sorted(sound.items()))
        damaged = bytearray(content)
        length = min(len(damaged) - 1, draw.choice([16, 512, 4096, 60_000]))
        at = draw.randrange(len(damaged) - length)
        damaged[at : at + length] = [b"\0" * length, b"\xff" * length, draw.randbytes(length)][number % 3]
        try_damage(bench, "blocks", name, bytes(damaged), keep)


def cuts(bench, draw, sound, count, keep):
    """Files that are cut off."""
    for _ in range(count):
        name, content = draw.choice(sorted(sound.items()))
        try_damage(bench, "cuts", name, content[: draw.randrange(len(content))], keep)


def bombs(bench, draw, sound, count, keep):
    """Counts, lengths and offsets of a LAS header (LAS 1.4 R15, section 2.4) beyond all measure."""
    fields = [(94, "<H"), (96, "<I"), (100, "<I"), (105, "<H"), (107, "<I"), (235, "<Q"), (243, "<I"), (247, "<Q")]
    tiles = sorted(name for name in sound if name.endswith(".laz"))
    for number in range(count):
        name = tiles[number % len(tiles)]
        damaged = bytearray(sound[name])
        at, form = fields[number // len(tiles) % len(fields)]
        largest = 256 ** struct.calcsize(form) - 1
        value = draw.choice([largest, largest >> 1, 1 << 31 & largest, draw.randrange(largest + 1)])
        struct.pack_into(form, damaged, at, value)
        try_damage(bench, "bombs", name, bytes(damaged), keep)


def endless(bench):
    """Inputs without an end: views, devices, pipes."""
    rows = "WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM r) SELECT i AS fid, "
    for view in [rows + "randomblob(1000) AS geom FROM r", rows + "x'00' AS geom FROM r WHERE i < 0"]:
        path = bench.folder / "endless.gpkg"
        path.unlink(missing_ok=True)
        database = sqlite3.connect(path)
        database.executescript(
            "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);"
            "CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INT);"
            "INSERT INTO gpkg_contents VALUES ('v', 'features', 0);"
            "INSERT INTO gpkg_geometry_columns VALUES ('v', 'geom', 'POLYGON', 0);"
            f"CREATE VIEW v AS {view};"
        )
        database.close()
        bench.run("endless", ["info", path], codes=(1,))
    pipe = bench.folder / "pipe.laz"
    os.mkfifo(pipe)
    bench.run("endless", ["info", pipe], codes=(1,), seconds=20)
    bench.run("endless", ["validate", "/dev/zero"], codes=(1,), seconds=20)
    loops = bench.folder / "loops"
    for name in "abcdef":
        (loops / name).mkdir(parents=True)
        for back in "123":
            (loops / name / back).symlink_to("..")
    bench.run("endless", ["info", f"{loops}/**/*.laz"], codes=(1,), seconds=20)


def kills(bench, draw, count):
    """kill -9 at any moment, then --resume: the bytes of an undisturbed run."""
    for number in range(count):
        # A file that names another (OBJ its materials) must not differ by its own name.
        name = "model" + [".city.json", ".city.jsonl", ".gpkg", ".obj", ".3dtiles"][number % 5]
        whole, killed = bench.folder / "whole", bench.folder / f"killed{number}"
        whole.mkdir(exist_ok=True)
        killed.mkdir()
        base = ["reconstruct", str(TILE), "-f", str(FOOTPRINTS), "--quiet", "-o"]
        if not (whole / name).exists():
            bench.run("kills", [*base, whole / name], codes=(0,))
        process = subprocess.Popen([str(bench.gable), *base, str(killed / name)], stderr=subprocess.DEVNULL)
        time.sleep(draw.uniform(0.05, 3.0))
        process.send_signal(signal.SIGKILL)
        ended = process.wait()
        if ended != 0 and (killed / name).is_file():
            bench.breach("kills", f"{name} stands under its name after a kill")
        if ended != 0:
            bench.run("kills", [*base, killed / name, "--resume"], codes=(0,))
        if contents(whole / name) != contents(killed / name):
            bench.breach("kills", f"{name} differs from an undisturbed run")
        left = [path.name for path in killed.iterdir() if ".partial" in path.name or path.suffix == ".part"]
        if left:
            bench.breach("kills", f"{left} stay beside {name}")
        shutil.rmtree(killed)


def contents(path):
    files = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.is_file())
    return [(str(p.relative_to(path)), p.read_bytes()) for p in files]


def write_las(path, points):
    """An uncompressed LAS 1.2 of format 0: x, y, z and class of each point, millimetres."""
    low, high = [[pick(p[axis] for p in points) for axis in range(3)] for pick in (min, max)]
    header = struct.pack(
        "<4sHHIHH8sBB32s32sHHHIIBHI5I3d3d6d", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"", b"load test", 1, 2026, 227, 227,
        0, 0, 20, len(points), len(points), 0, 0, 0, 0, 0.001, 0.001, 0.001, 0.0, 0.0, 0.0,
        high[0], low[0], high[1], low[1], high[2], low[2],
    )
    with open(path, "wb") as out:
        out.write(header)
        for x, y, z, kind in points:
            out.write(struct.pack("<iiiHBBbBH", *(round(v * 1000) for v in (x, y, z)), 0, 9, kind, 0, 0, 0))


def write_footprints(path, rings):
    features = [
        {"type": "Feature", "properties": {"id": f"b{number}"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
        for number, ring in enumerate(rings)
    ]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}}
    path.write_text(json.dumps({"type": "FeatureCollection", "crs": crs, "features": features}))


def rectangle(x, y, width, depth):
    return [[x, y], [x + width, y], [x + width, y + depth], [x, y + depth], [x, y]]


def halls(bench, draw, sizes):
    """Saw-tooth halls, 4 m a tooth, 10 points a square metre, noise of 2 cm: the model fits as well as the noise allows."""
    for width, depth in sizes:
        x0, y0 = 85_000.0, 447_000.0
        points = []
        for _ in range(10 * (width + 20) * (depth + 20)):
            x, y = draw.uniform(-10, width + 10), draw.uniform(-10, depth + 10)
            is_roof = 0 <= x <= width and 0 <= y <= depth
            z = 8 + 1.5 * (x % 4) / 4 if is_roof else 0
            points.append((x0 + x, y0 + y, z + draw.gauss(0, 0.02), 6 if is_roof else 2))
        tile, footprints = bench.folder / "hall.las", bench.folder / "hall.geojson"
        write_las(tile, points)
        write_footprints(footprints, [rectangle(x0, y0, width, depth)])
        out = bench.folder / "hall.city.json"
        args = ["reconstruct", tile, "-f", footprints, "-o", out, "--overwrite", "--quiet", "--crs", "EPSG:7415"]
        _, _, seconds = bench.run("halls", args, codes=(0,), seconds=900)
        building = json.loads(Path(f"{out}.report.json").read_text())["buildings"][0]
        rmse = building["rmse_lod22"]
        print(f"  hall {width} x {depth} m: RMSE {rmse} m in {seconds:.1f} s", flush=True)
        if rmse is None or not rmse <= 0.03:
            bench.breach("halls", f"{width} x {depth} m: RMSE {rmse} at LoD 2.2")


def empty(bench, count):
    """Footprints without any point, around a house that has some: seconds and memory."""
    x0, y0 = 85_000.0, 447_000.0
    points = []
    for i in range(-20, 40):
        for j in range(-20, 36):
            x, y = i * 0.5 + 0.25, j * 0.5 + 0.25
            is_roof = 0 <= x < 10 and 0 <= y < 8
            points.append((x0 + x, y0 + y, 6.0 if is_roof else 0.0, 6 if is_roof else 2))
    tile, footprints = bench.folder / "house.las", bench.folder / "many.geojson"
    write_las(tile, points)
    side = math.isqrt(count)
    rings = [rectangle(x0 + 100 + 12 * (n % side), y0 + 12 * (n // side), 8, 8) for n in range(count)]
    write_footprints(footprints, [rectangle(x0, y0, 10, 8), *rings])
    out = bench.folder / "many.city.json"
    args = ["reconstruct", tile, "-f", footprints, "-o", out, "--overwrite", "--quiet", "--crs", "EPSG:7415"]
    bench.run("empty", args, codes=(0,), seconds=600)
    report = json.loads(Path(f"{out}.report.json").read_text())
    memory = (report["peak_memory_bytes"] or 0) / 1e6
    print(f"  {count} empty footprints: {report['cpu_seconds']:.1f} CPU s, {memory:.0f} MB", flush=True)
    # Half as much again as the processor time that was measured, and a tenth more memory.
    if report["cpu_seconds"] > 0.5 + count / 25_000 or memory > 65 + count / 550:
        bench.breach("empty", f"{count} cost {report['cpu_seconds']:.1f} CPU s and {memory:.0f} MB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true", help="about an hour instead of two minutes")
    parser.add_argument("--gable", type=Path, default=GABLE, help="the program")
    parser.add_argument("--seed", type=int, default=1, help="of the damage")
    parser.add_argument("--only", default="", help="kinds, by commas")
    parser.add_argument("--keep", type=Path, default=Path("load-test-breaches"), help="folder for what broke it")
    args = parser.parse_args()
    if not args.gable.exists():
        sys.exit(f"{args.gable} is not there: cargo build --release --locked")
    times = 20 if args.long else 1
    with tempfile.TemporaryDirectory(prefix="gable-load-") as folder:
        bench = Bench(args.gable.resolve(), Path(folder))
        draw = random.Random(args.seed)
        sound = inputs(bench)
        kinds = {
            "flips": lambda: flips(bench, draw, sound, 40 * times, args.keep),
            "blocks": lambda: blocks(bench, draw, sound, 40 * times, args.keep),
            "cuts": lambda: cuts(bench, draw, sound, 20 * times, args.keep),
            "bombs": lambda: bombs(bench, draw, sound, 32 * (4 if args.long else 1), args.keep),
            "endless": lambda: endless(bench),
            "kills": lambda: kills(bench, draw, 5 * times),
            "empty": lambda: empty(bench, 100_000 if args.long else 5_000),
            "halls": lambda: halls(bench, draw, [(40, 20), (160, 100), (300, 200)] if args.long else [(24, 16)]),
        }
        wanted = [kind for kind in args.only.split(",") if kind] or list(kinds)
        for kind in wanted:
            kinds[kind]()
        print(f"\n{'kind':10} {'runs':>6}  by exit code")
        for kind, codes in bench.counts.items():
            told = ", ".join(f"{code}: {n}" for code, n in sorted(codes.items(), key=str))
            print(f"{kind:10} {sum(codes.values()):6}  {told}")
        print(f"{len(bench.breaches)} breach(es)")
    return 1 if bench.breaches else 0


if __name__ == "__main__":
    sys.exit(main())
