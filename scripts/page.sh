#!/bin/sh
# Makes the pages of `gable view`, `gable explain` and `gable edit` (src/*/page/dist/page.html) from their sources; with --check
# only says whether they are stale.
# Needs node and npm: three.js and esbuild, as pinned in src/view/page/package-lock.json, go into .tools/page. With --check
# and without node it says that it was skipped.
set -eu
cd "$(dirname "$0")/.."

if ! command -v node >/dev/null 2>&1 || ! command -v npm >/dev/null 2>&1; then
    if [ "${1:-}" = --check ]; then
        echo "skipped: whether the page is stale can only be told with node and npm"
        exit 0
    fi
    echo "the page is made with node and npm, and they are not here: as root, apt-get install nodejs npm" >&2
    exit 1
fi

place=$PWD/.tools/page
mkdir -p "$place"
if ! cmp -s src/view/page/package-lock.json "$place/installed.json"; then
    cp src/view/page/package.json src/view/page/package-lock.json "$place/"
    if ! npm ci --prefix "$place" --ignore-scripts --no-audit --no-fund --loglevel=error </dev/null; then
        if [ "${1:-}" = --check ]; then
            echo "skipped: three.js and esbuild could not be installed"
            exit 0
        fi
        exit 1
    fi
    cp src/view/page/package-lock.json "$place/installed.json"
fi
PAGE_PACKAGES=$place exec node src/view/page/build.mjs "$@"
