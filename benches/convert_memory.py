#!/usr/bin/env python3
"""The peak memory and the time of `gable convert` against the number of buildings, per output format.

    python3 benches/convert_memory.py [--gable target/release/gable] [--counts 1000,10000,100000] [--formats city.jsonl,...]

The bundled corner of Delft is reconstructed once and its sequence repeated side by side, with new ids, up to each count.
Fails when the largest model needs more than 1.5 times the memory of the smallest plus 32 MB.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
STREAMED = ["city.jsonl", "3dtiles", "gpkg", "obj"]


def replicate(source: pathlib.Path, target: pathlib.Path, count: int) -> None:
    """Writes `count` features: those of the source again and again, each time a tile further east or north."""
    with open(source, encoding="utf-8") as lines:
        head = lines.readline()
        features = [json.loads(line) for line in lines]
    scale = json.loads(head)["transform"]["scale"]
    step = [round(400 / scale[0]), round(400 / scale[1])]
    with open(target, "w", encoding="utf-8") as out:
        out.write(head)
        for i in range(count):
            feature, copy = features[i % len(features)], i // len(features)
            dx, dy = copy % 40 * step[0], copy // 40 * step[1]
            vertices = [[x + dx, y + dy, z] for x, y, z in feature["vertices"]]
            rename = lambda id: f"{id}.{copy}"
            objects = {}
            for id, city_object in feature["CityObjects"].items():
                links = {key: [rename(link) for link in city_object[key]] for key in ("parents", "children") if key in city_object}
                objects[rename(id)] = {**city_object, **links}
            json.dump({**feature, "id": rename(feature["id"]), "CityObjects": objects, "vertices": vertices}, out,
                      separators=(",", ":"))
            out.write("\n")


def measure(command: list) -> tuple[float, float]:
    """Peak memory in megabytes and seconds of a command."""
    started = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"failed: {' '.join(map(str, command))}")
    return usage.ru_maxrss / 1024, time.monotonic() - started


def size_of(path: pathlib.Path) -> float:
    files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
    return sum(file.stat().st_size for file in files) / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gable", default=ROOT / "target/release/gable")
    parser.add_argument("--counts", default="1000,10000,100000")
    parser.add_argument("--formats", default=",".join([*STREAMED, "city.json"]))
    arguments = parser.parse_args()
    data = ROOT / "examples/data"
    peaks: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder)
        source = place / "delft.city.jsonl"
        subprocess.run([arguments.gable, "reconstruct", data / "delft_ahn3.laz", "-f", data / "footprints.geojson", "-o",
                        source, "--quiet"], check=True, stdout=subprocess.DEVNULL)
        print(f"{'format':12}{'buildings':>10}{'peak MB':>10}{'seconds':>10}{'in MB':>10}{'out MB':>10}", flush=True)
        for count in map(int, arguments.counts.split(",")):
            model = place / "model.city.jsonl"
            replicate(source, model, count)
            for extension in arguments.formats.split(","):
                output = place / f"out.{extension}"
                peak, seconds = measure([arguments.gable, "convert", model, "-o", output, "--overwrite"])
                peaks.setdefault(extension, []).append(peak)
                sizes = f"{size_of(model):10.1f}{size_of(output):10.1f}"
                print(f"{extension:12}{count:10}{peak:10.1f}{seconds:10.1f}{sizes}", flush=True)
                shutil.rmtree(output) if output.is_dir() else output.unlink()
    grown = [name for name in STREAMED if name in peaks and peaks[name][-1] > 1.5 * peaks[name][0] + 32]
    if grown:
        sys.exit(f"memory grows with the number of buildings: {', '.join(grown)}")


if __name__ == "__main__":
    main()
