#!/bin/sh
# Makes docs/levels.png: the same part of Delft at LoD 1.2, 1.3, 2.2 and 2.3, cut out of pictures of the page and laid side by
# side. Arguments: the program, and the browser if it has another name than chromium.
set -eu
cd "$(dirname "$0")/.."
gable=${1:-${CARGO_TARGET_DIR:-target}/release/gable}
browser=${2:-${CHROMIUM:-chromium}}
data=examples/data
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$gable" reconstruct $data/delft_ahn3.laz --footprints $data/footprints.geojson -o "$work/delft.city.json" --lod 0,1.2,1.3,2.2 \
    --view --quiet
"$gable" reconstruct $data/delft_ahn3.laz --footprints $data/walls.geojson --roofprint $data/footprints.geojson \
    -o "$work/eaves.city.json" --view --quiet
{
    echo '<style>
      body { margin: 0; zoom: 0.7; font: 600 22px sans-serif; white-space: nowrap }
      div { display: inline-block; position: relative; width: 480px; height: 520px; overflow: hidden; margin-right: 8px }
      img { position: absolute; left: -660px; top: -170px }
      span { position: absolute; left: 12px; top: 10px; z-index: 1; background: #fffc; padding: 2px 8px; border-radius: 6px }
    </style>'
    for lod in 1.2 1.3 2.2 2.3; do
        page=delft
        [ "$lod" != 2.3 ] || page=eaves
        sh scripts/picture.sh "$work/$page.html" "$work/$lod.png" "theme=light&lod=$lod" >/dev/null
        printf '<div><span>LoD %s</span><img src=%s.png></div>' "$lod" "$lod"
    done
} >"$work/levels.html"
"$browser" --headless --no-sandbox --disable-dev-shm-usage --hide-scrollbars --force-device-scale-factor=1 --window-size=1361,364 \
    --screenshot="$PWD/docs/levels.png" "file://$work/levels.html" >/dev/null 2>&1
echo docs/levels.png
