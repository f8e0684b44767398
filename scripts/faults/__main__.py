#!/usr/bin/env python3
"""Faults and load: damaged inputs of every format, hostile names, full disks, kills, too much of everything.

    python3 scripts/faults --quick                          under a minute, as CI runs it
    python3 scripts/faults --minutes 60                     as many cases as fit into an hour
    python3 scripts/faults --only 'flips f.gpkg' --case 7   one case again
    python3 scripts/faults --only kill,page --minutes 5

Every run of gable has a time limit and limits on its address space and its memory. It must end by itself with one of its exit
codes and a word, say nothing of a panic, leave nothing half-written under a final name, nothing outside of the folder of its
output, and every model that it writes must be valid. Prints, for every breach, the command that makes it again, and a table
of what was run, which a quick run without a breach leaves out; exits with 1 if there is a breach. What follows from --seed
does so whatever else is run. Needs Python 3.9 and nothing else, on Linux; small disks need the right to mount one.
"""

import argparse
import itertools
import os
import shutil
import sys
import tempfile
import threading
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from pathlib import Path

import damage
import hostile
import load
import sound
import surroundings
from bench import Bench, Case

ROOT = Path(__file__).resolve().parent.parent.parent
GABLE = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "release" / "gable"
FORMATS = (
    "tile.laz", "tile1.laz", "tile.las", "tile.copc.laz", "tile.ply", "tile.xyz",
    "f.gpkg", "f.fgb", "f.shp", "f.parquet", "f.geojson", "f.geojsonl",
    "m.city.json", "m.city.jsonl", "terrain.tif", "field.safetensors", "pipeline.json",
)


def kinds():
    """All kinds: name, function, how many of them in a quick run, and how often each comes in a long one."""
    found = [(f"{way} {name}", damage.case_of(way, name), 1, 8) for way in damage.WAYS for name in FORMATS]
    found += [
        ("page and tiles", hostile.outputs, 3, 20),
        ("foreign names", hostile.models, 2, 20),
        ("full disk", surroundings.full_disk, 1, 6),
        ("file limit", surroundings.file_limit, 1, 6),
        ("two runs", surroundings.two_runs, 1, 6),
        ("folder removed", surroundings.folder_removed, 1, 6),
        ("input replaced", surroundings.input_replaced, 2, 10),
        ("fifo", surroundings.fifo, 4, 20),
        ("standard output", surroundings.standard_output, 2, 10),
        ("loops", surroundings.loops, 6, 10),
        ("few handles", surroundings.few_handles, 1, 1),
        ("kill", surroundings.kill, 2, 10),
        ("endless", surroundings.endless, 1, 1),
        ("empty footprints", load.empty, 1, 1),
        ("hall", load.hall, 1, 1),
        ("jagged", load.jagged, 1, 1),
        ("star", load.star, 1, 1),
    ]
    return found


def schedule(chosen, quick):
    """The cases in their order: kind, number, function. Without end unless `quick`."""
    counts = {name: 0 for name, *_ in chosen}

    def of(name, function):
        counts[name] += 1
        return name, counts[name] - 1, function

    for name, function, few, _ in chosen:
        for _ in range(few):
            yield of(name, function)
    if quick:
        return
    most = max(often for *_, often in chosen)
    for turn in itertools.count():
        for name, function, _, often in chosen:
            if turn * often // most != (turn + 1) * often // most:
                yield of(name, function)


def kind_of(name):
    """The kind in the table: damage counts by its way, whatever the format."""
    return name.split()[0] if name.split()[0] in damage.WAYS else name


def summed(counts):
    """The counts by what is one kind in the table, in the order of `kinds`."""
    out = {}
    for name, of_name in ((name, counts[name]) for name, *_ in kinds() if name in counts):
        of_kind = out.setdefault(kind_of(name), {"cases": 0, "runs": 0, "seconds": 0.0, "memory": 0, "codes": {}})
        for what in ("cases", "runs"):
            of_kind[what] += of_name[what]
        for what in ("seconds", "memory"):
            of_kind[what] = max(of_kind[what], of_name[what])
        for code, number in of_name["codes"].items():
            of_kind["codes"][code] = of_kind["codes"].get(code, 0) + number
    return out


def table(counts):
    lines = [f"{'kind':16} {'cases':>6} {'runs':>6} {'longest':>8} {'memory':>8}  runs by exit code"]
    for kind, of_kind in counts.items():
        told = ", ".join(f"{code}: {n}" for code, n in sorted(of_kind["codes"].items()))
        memory = f"{of_kind['memory'] >> 20} MiB"
        lines.append(f"{kind:16} {of_kind['cases']:6} {of_kind['runs']:6} {of_kind['seconds']:6.1f} s {memory:>8}  {told}")
    return "\n".join(lines)


def verdict(bench, seconds):
    cases, runs = (sum(of_kind[what] for of_kind in bench.counts.values()) for what in ("cases", "runs"))
    lines = [f"skipped: {kind}: {reason}" for kind, reason in sorted(bench.skipped.items())]
    broken = {}
    for kind, _ in bench.breaches:
        broken[kind] = broken.get(kind, 0) + 1
    told = "; ".join(f"{kind}: {n}" for kind, n in sorted(broken.items()))
    found = f"{len(bench.breaches)} breach(es): {told}" if broken else "no breach"
    return "\n".join([*lines, f"{cases} cases, {runs} runs of gable in {seconds:.0f} s: {found}"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, help="begin new cases for so long")
    parser.add_argument("--quick", action="store_true", help="a few cases of every kind")
    parser.add_argument("--only", default="", help="kinds, by commas; `flips` stands for the flips of all formats")
    parser.add_argument("--case", type=int, help="only the case of this number")
    parser.add_argument("--seed", type=int, default=1, help="of everything random")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="cases at a time")
    parser.add_argument("--gable", type=Path, default=GABLE, help="the program")
    parser.add_argument("--keep", type=Path, default=Path("fault-breaches"), help="folder for the cases with a breach")
    args = parser.parse_args()
    if not args.gable.exists():
        sys.exit(f"{args.gable} is not there: cargo build --release --locked")
    # A case by its number is one of a long run.
    quick = args.quick or (args.minutes is None and args.case is None)
    wanted = [kind for kind in args.only.split(",") if kind]
    chosen = [kind for kind in kinds() if not wanted or any(kind[0] == w or kind[0].startswith(w + " ") for w in wanted)]
    if not chosen:
        sys.exit(f"no kind {args.only!r}; there are: " + ", ".join(name for name, *_ in kinds()))
    bench = Bench(args.gable.resolve(), {}, args.seed, args.keep.resolve())
    bench.undisturbed, bench.results, bench.tags = threading.Lock(), {}, None
    bench.halls = [(24, 16)] if quick else [(40, 20), (160, 100), (300, 200)]
    bench.empty, bench.outlines = (5_000, 4_000) if quick else (100_000, 20_000)
    begun = time.monotonic()
    folder = Path(tempfile.mkdtemp(prefix="gable-sound-"))
    made = Case(bench, "sound", 0, folder)
    bench.sound = sound.make(bench, made, ROOT / "examples" / "data")
    bench.sound["field.safetensors"] = (ROOT / "src" / "network" / "weights" / "field.safetensors").read_bytes()
    bench.sound["many.las"] = sound.plain_las(made, ROOT / "examples" / "data" / "delft_ahn3.laz")
    made.look_around()
    bench.counts.clear()
    shutil.rmtree(folder)
    if args.case is not None:
        for name, function, *_ in chosen:
            bench.case(name, args.case, function)
    else:
        until = begun + 60 * (args.minutes or 1e9)
        pending = set()
        with ThreadPoolExecutor(args.jobs) as pool:
            for name, number, function in schedule(chosen, quick):
                if time.monotonic() > until:
                    break
                pending.add(pool.submit(bench.case, name, number, function))
                if len(pending) >= 2 * args.jobs:
                    done, pending = wait(pending, return_when=FIRST_COMPLETED)
                    for future in done:
                        future.result()
            for future in pending:
                future.result()
    # Where nothing is amiss, a quick run has nothing to tell.
    if bench.breaches or not quick:
        print(table(summed(bench.counts)))
    print(verdict(bench, time.monotonic() - begun))
    return 1 if bench.breaches else 0


if __name__ == "__main__":
    sys.exit(main())
