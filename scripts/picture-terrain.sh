#!/bin/sh
# Makes docs/terrain.png: the quick start with terrain, as the page shows it. Arguments: the
# program, and the browser if it has another name than chromium.
set -eu
cd "$(dirname "$0")/.."
gable=${1:-${CARGO_TARGET_DIR:-target}/release/gable}
data=examples/data
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$gable" reconstruct $data/delft_ahn3.laz --footprints $data/footprints.geojson -o "$work/delft.city.json" --terrain --view --quiet
CHROMIUM=${2:-${CHROMIUM:-}} sh scripts/picture.sh "$work/delft.html" docs/terrain.png 'theme=light'
