#!/bin/sh
# Makes docs/explain.png and docs/method/*.png: the page of `gable explain`, and every step of the method as it shows it, at one
# building of the quick start, in a headless Chromium. Arguments: the program, and the id of the building.
set -eu
cd "$(dirname "$0")/.."
gable=${1:-${CARGO_TARGET_DIR:-target}/release/gable}
id=${2:-NL.IMBAG.Pand.0503100000017310}
data=examples/data
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$gable" explain $data/delft_ahn3.laz --footprints $data/footprints.geojson --id "$id" -o "$work/steps.html" --quiet
sh scripts/picture.sh "$work/steps.html" docs/explain.png 'theme=light&step=cells'
mkdir -p docs/method
for step in points found refined walls cells field cut surface result; do
    PICTURE_SIZE=900,560 sh scripts/picture.sh "$work/steps.html" "docs/method/$step.png" "theme=light&plain=on&step=$step"
done
