#!/bin/sh
# Makes docs/delft.png: the page of the quick start as a headless Chromium shows it, drawn in software so that every machine
# makes the same picture. Other arguments than none: PAGE.html PICTURE.png [what follows the # of the address]; PICTURE_SIZE is
# its width and height.
set -eu
cd "$(dirname "$0")/.."
page=${1:-out/delft.html}
picture=${2:-docs/delft.png}
asked=${3:-theme=light}

for name in "${CHROMIUM:-}" chromium chromium-browser google-chrome; do
    if [ -n "$name" ] && command -v "$name" >/dev/null 2>&1; then
        browser=$name
        break
    fi
done
if [ -z "${browser:-}" ]; then
    echo "a picture of the page is made with Chromium, and there is none: as root, apt-get install chromium" >&2
    exit 1
fi
[ -e "$page" ] || { echo "$page is not there: make quickstart" >&2; exit 1; }
"$browser" --headless --no-sandbox --disable-dev-shm-usage --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader \
    --ignore-gpu-blocklist --hide-scrollbars --force-device-scale-factor=1 --window-size="${PICTURE_SIZE:-1400,900}" --virtual-time-budget=20000 \
    --screenshot="$(realpath -m "$picture")" "file://$(realpath "$page")#$asked" >/dev/null 2>&1
echo "$picture"
