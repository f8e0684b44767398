#!/usr/bin/env bash
# Builds the plugin of pdal/ against a real PDAL (2.4 or newer, with its headers) and holds both programs against each other:
# the same pipelines in `pdal pipeline` and in `gable pipeline`. PDAL is the one that is installed, or that of the folder
# PDAL_DIR (with bin/pdal in it); without one the tests are skipped, and say so. Arguments choose test modules or cases:
#
#     PDAL_DIR=/opt/pdal scripts/test-pdal.sh test_writer.Writer.test_options
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

skip() {
    echo "skipped: the tests of PDAL need $1"
    exit 0
}

if [[ -n "${PDAL_DIR:-}" ]]; then
    PDAL="$PDAL_DIR/bin/pdal"
    [[ -x "$PDAL" ]] || { echo "there is no bin/pdal in PDAL_DIR, $PDAL_DIR" >&2; exit 1; }
else
    PDAL=$(command -v pdal) || skip 'pdal, on the path or in PDAL_DIR'
fi
PDAL=$(realpath "$PDAL")
prefix=$(dirname "$(dirname "$PDAL")")
command -v cmake >/dev/null || skip 'cmake'

CARGO_TARGET_DIR=$(realpath -m "${CARGO_TARGET_DIR:-target}")
export CARGO_TARGET_DIR
target=$CARGO_TARGET_DIR
cargo build --release --locked --quiet
build="$target/pdal-plugin"
mkdir -p "$build"
if ! cmake -S pdal -B "$build" -DCMAKE_PREFIX_PATH="$prefix" >"$build/configure.log" 2>&1; then
    if grep -q 'package configuration file provided by "PDAL"\|compatible with requested version' "$build/configure.log"; then
        skip 'PDAL 2.4 or newer with its headers (libpdal-dev)'
    fi
    cat "$build/configure.log" >&2
    exit 1
fi
cmake --build "$build" >"$build/build.log" 2>&1 || { cat "$build/build.log" >&2; exit 1; }

"$PDAL" --version | sed -n 's/^\(pdal [0-9][^ ]*\).*/\1/p'
export PDAL GABLE="$target/release/gable" PDAL_DRIVER_PATH="$build"
cd scripts/pdal
if (($#)); then
    exec python3 -B -m unittest --verbose "$@"
fi
exec python3 -B -m unittest discover --verbose
