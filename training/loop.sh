#!/bin/sh
# The whole loop in small: scans of generated buildings, a short training, the network file, a city model made with it.
# Shows that the parts fit; the network is a poor one. MINUTES=N trains longer.
set -eu
cd "$(dirname "$0")/.."
python=$(sh scripts/setup-training.sh)
loop=out/loop
rm -rf "$loop"
mkdir -p "$loop"
gable() { cargo run --release --locked --quiet -- "$@"; }

gable simulate --generate 150 --variants 2 --most-points 4000 --split 0.8,0.2,0 --shard 64 -o "$loop/shards"
"$python" training/train.py --config training/field.toml --data "$loop/shards" --out "$loop/run" --minutes "${MINUTES:-2}"
gable reconstruct examples/data/delft_ahn3.laz --footprints examples/data/footprints.geojson -o "$loop/delft.city.json" \
    --model "$loop/run/field.safetensors" --field neural
gable validate "$loop/delft.city.json"
"$python" - "$loop" <<'CHECK'
import json
import sys

loop = sys.argv[1]
with open(f"{loop}/delft.city.json.report.json", encoding="utf-8") as file:
    report = json.load(file)
solids = sum(building["solids_lod22"] > 0 for building in report["buildings"])
overruled = sum("the height-field vote decided" in note for building in report["buildings"] for note in building["notes"])
print(f"{len(report['buildings'])} buildings, {solids} at LoD 2.2, in {overruled} of them the vote decided")
assert report["field"]["field"] == "neural" and report["field"]["model"].endswith("run/field.safetensors"), report["field"]
assert solids >= 70 and overruled <= 7
CHECK
