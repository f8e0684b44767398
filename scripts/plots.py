#!/usr/bin/env python3
"""Measures how gable answers to the smoothness weight, to noise, to the number of primitives and to that of buildings, and
draws it.

    make plots                     all of it, on 12 generated buildings
    make plots BUILDINGS=40        on more

What was measured waits in out/plots/, apart for each build of gable and one file per scan and setting, so that a run that was
ended goes on where it was; --fresh measures anew. The figures go to docs/plots/ as CSV, and from these they are drawn as SVG.
"""

import argparse
import csv
import hashlib
import json
import math
import shutil
import statistics
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "docs" / "plots"
WORK = ROOT / "out" / "plots"
SETUPS = ["full-view", "no-bottom", "airborne"]
NOISES = [0, 0.001, 0.005, 0.01, 0.05]
LAMBDAS = [0, 0.01, 0.03, 0.1, 0.3, 0.6, 1, 1.5, 2, 3, 5]
# Seeds of the buildings, from this one on; nothing was tuned on them.
FIRST_SEED = 9001
# Faces of a building that has something to lose.
FEWEST_FACES = 10


def build_of(binary):
    """What tells one build of gable from another."""
    with open(binary, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:12]


def gable(binary, *arguments):
    return subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True, check=False)


def scan(options, seed, setup, noise):
    """A folder with one generated building, scanned: points.laz, footprints.geojson, reference.city.json."""
    folder = WORK / options.build / f"{seed}-{setup}-{noise}"
    if not (folder / "done").exists():
        shutil.rmtree(folder, ignore_errors=True)
        density = ["--density", 10 if setup == "airborne" else 20]
        run = gable(options.gable, "simulate", "--generate", 1, "--seed", seed, "--clean", "--setup", setup, *density,
                    "--noise", noise, "--scans", folder, "-q")
        if run.returncode != 0:
            sys.exit(f"{folder}: {run.stderr}")
        (folder / "done").touch()
    return folder


def faces(reference):
    """The faces of the only building of a reference."""
    things = json.loads(reference.read_text())["CityObjects"].values()
    solids = [g for thing in things for g in thing.get("geometry", []) if g["type"] == "Solid"]
    return sum(len(shell) for solid in solids for shell in solid["boundaries"])


def chosen(options):
    """The seeds of the first buildings that have enough faces."""
    seeds, seed = [], FIRST_SEED
    while len(seeds) < options.buildings:
        if faces(scan(options, seed, "airborne", 0) / "reference.city.json") >= FEWEST_FACES:
            seeds.append(seed)
        seed += 1
    return seeds


def renamed(reference, name):
    """The reference with its only building under the name that an object without a footprint has."""
    document = json.loads(reference.read_text())
    building = next(id for id, thing in document["CityObjects"].items() if thing["type"] == "Building")
    text = json.dumps(document).replace(f'"{building}"', f'"{name}"')
    path = reference.with_name("renamed.city.json")
    path.write_text(text)
    return path


def measure(options, seed, setup, noise, weight):
    """The figures of one reconstruction; None of one that gave no solid."""
    folder = scan(options, seed, setup, noise)
    key = folder / f"lambda-{weight}.json"
    if key.exists():
        return json.loads(key.read_text())
    model = folder / f"lambda-{weight}.city.json"
    where = ["-f", folder / "footprints.geojson"] if setup == "airborne" else ["--no-footprint"]
    smooth = [] if weight is None else ["--lambda", weight]
    start = time.monotonic()
    gable(options.gable, "reconstruct", folder / "points.laz", *where, *smooth, "-o", model, "--overwrite", "-q", "-j", 1)
    seconds = time.monotonic() - start
    reference = folder / "reference.city.json"
    if setup != "airborne":
        reference = renamed(reference, "points")
    figures = folder / f"lambda-{weight}.evaluated.json"
    gable(options.gable, "evaluate", model, "--reference", reference, "--json", figures)
    found = {"smh": None, "iou": 0.0, "faces": None, "seconds": seconds}
    if figures.exists():
        building = json.loads(figures.read_text())["buildings"][0]
        agreement = building.get("reference") or {}
        if agreement.get("surfaces"):
            found["smh"] = 100 * agreement["surfaces"]["relative_symmetric_mean"]
        if agreement.get("overlap"):
            found["iou"] = agreement["overlap"]["volume_iou"]
        found["faces"] = sum(solid["merged"] for solid in building["solids"]) or None
    key.write_text(json.dumps(found))
    return found


def row(first, found):
    """Medians over buildings; a building without a solid counts as IoU 0 and has no distance."""
    solid = [f for f in found if f["smh"] is not None]
    middle = lambda name: statistics.median([f[name] for f in solid]) if solid else math.nan
    return {**first, "buildings": len(found), "failed": len(found) - len(solid), "smh_percent": round(middle("smh"), 4),
            "iou": round(statistics.median(f["iou"] for f in found), 4), "faces": middle("faces"),
            "seconds": round(statistics.median(f["seconds"] for f in found), 3)}


def write(name, rows):
    OUT.mkdir(parents=True, exist_ok=True)
    with (OUT / f"{name}.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"docs/plots/{name}.csv")


def measured(options):
    seeds = chosen(options)
    settings = [({"setup": setup, "noise": noise}, setup, noise, None) for setup in SETUPS for noise in NOISES]
    smooth = [({"lambda": weight}, "full-view", 0.005, weight) for weight in LAMBDAS]
    with ThreadPoolExecutor(options.jobs) as pool:
        # Scans first: no two threads make one.
        list(pool.map(lambda job: scan(options, *job), {(s, c[1], c[2]) for c in settings + smooth for s in seeds}))
        for name, cases in [("noise", settings), ("lambda", smooth)]:
            rows = []
            for first, setup, noise, weight in cases:
                rows.append(row(first, list(pool.map(lambda seed: measure(options, seed, setup, noise, weight), seeds))))
                print(rows[-1], flush=True)
            write(name, rows)


def scalability(options):
    kept = WORK / options.build / "scalability.csv"
    if not kept.exists():
        run = subprocess.run(["cargo", "bench", "--locked", "--bench", "scalability"], cwd=ROOT, text=True,
                             stdout=subprocess.PIPE, check=True)
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(run.stdout)
    with kept.open() as file:
        write("scalability", list(csv.DictReader(file)))


def memory(options):
    kept = WORK / options.build / "memory.json"
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run([sys.executable, ROOT / "benches" / "run_memory.py", "--gable", options.gable, "--copies",
                        options.copies, "--any", "--json", kept], check=True)
    rows = json.loads(kept.read_text())
    write("memory", [{"buildings": row["buildings"], "memory": row["memory"] or "", "peak_mb": round(row["peak_mb"]),
                      "cpu_ms": round(row["cpu_ms"], 2)} for row in rows])


def read(name):
    with (OUT / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def draw():
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "gable", "font.size": 9, "axes.grid": True, "grid.alpha": 0.3})
    from matplotlib import pyplot

    def figure(name, panels):
        sheet, axes = pyplot.subplots(1, len(panels), figsize=(4 * len(panels), 3.2), layout="constrained")
        for axis, panel in zip(axes, panels):
            panel(axis)
        sheet.savefig(OUT / f"{name}.svg", metadata={"Date": None})
        pyplot.close(sheet)
        print(f"docs/plots/{name}.svg")

    def against(rows, first, column, label, scale, groups=None):
        def panel(axis):
            for group in groups or [None]:
                chosen = [r for r in rows if group is None or r["setup"] == group]
                # Where most buildings gave no solid, the others tell little; the IoU counts all of them.
                held = [r for r in chosen if column == "iou" or 2 * int(r["failed"]) < int(r["buildings"])]
                points = [(float(r[first]), float(r[column])) for r in held if r[column] not in ("", "nan")]
                axis.plot(*zip(*points), marker="o", label=group)
            axis.set_xscale("symlog", linthresh=scale)
            axis.set_xlim(left=0)
            axis.set_ylim(bottom=0)
            axis.set_xlabel({"lambda": "λ", "noise": "noise, share of R"}[first])
            axis.set_ylabel(label)
            if groups:
                axis.legend()
        return panel

    noise, smooth, growth = read("noise"), read("lambda"), read("scalability")
    columns = [("smh_percent", "SMH, % of R"), ("iou", "IoU"), ("faces", "faces")]
    figure("noise", [against(noise, "noise", c, label, 0.001, SETUPS) for c, label in columns])
    figure("lambda", [against(smooth, "lambda", c, label, 0.01) for c, label in columns])

    def grows(lines, label):
        def panel(axis):
            for column, name in lines:
                axis.loglog([float(r["primitives"]) for r in growth], [float(r[column]) for r in growth], marker="o", label=name)
            axis.set_xlabel("primitives")
            axis.set_ylabel(label)
            axis.legend()
        return panel

    figure("scalability", [grows([("cells", "cells"), ("facets", "facets")], "number"),
                           grows([("partition_s", "partition"), ("cut_s", "cut")], "seconds")])

    held = read("memory")

    def city(column, label):
        def panel(axis):
            for budget, name in [("", "no limit"), ("64MB", "--memory 64MB")]:
                points = [(int(r["buildings"]), float(r[column])) for r in held if r["memory"] == budget]
                axis.plot(*zip(*points), marker="o", label=name)
            axis.set_xscale("log")
            axis.set_ylim(bottom=0)
            axis.set_xlabel("buildings")
            axis.set_ylabel(label)
            axis.legend()
        return panel

    figure("memory", [city("peak_mb", "peak memory, MB"), city("cpu_ms", "processor time per building, ms")])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gable", default=str(ROOT / "target/release/gable"))
    parser.add_argument("--buildings", type=int, default=12)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--copies", default="1,4,16,64,256", help="of the corner of Delft, for memory (default %(default)s)")
    parser.add_argument("--fresh", action="store_true", help="measure what was measured before")
    parser.add_argument("--draw-only", action="store_true", help="draw what stands in docs/plots")
    options = parser.parse_args()
    if not options.draw_only:
        options.build = build_of(options.gable)
        if options.fresh:
            shutil.rmtree(WORK, ignore_errors=True)
        measured(options)
        scalability(options)
        memory(options)
    draw()


if __name__ == "__main__":
    main()
