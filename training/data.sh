#!/bin/sh
# Makes the shards that the shipped networks were trained on. Usage: training/data.sh OUT MODELS…, the models being files of
# LoD 2.2 buildings (3DBAG). One seed for all: the same tiles are held back in every folder.
set -eu
gable=${GABLE:-gable}
out=$1
shift
$gable simulate "$@" --generate 2200 --variants 4 --density 1..40 --most-points 5000 -o "$out/mixed"
$gable simulate "$@" --generate 1500 --setup no-bottom --noise 0..0.02 --density 1..20 --most-points 5000 -o "$out/no-bottom"
$gable simulate "$@" --generate 1500 --setup full-view --noise 0..0.02 --density 1..20 --most-points 5000 -o "$out/full-view"
$gable simulate "$@" --generate 1500 --noise 0..0.05 --density 1..20 --most-points 3000 -o "$out/noisy"
$gable simulate "$@" --generate 1500 --interface points2surf --near 8 --uniform 8 --cells 2 --density 1..20 \
    --most-points 4000 -o "$out/points2surf"
# For ABLATIONS.md alone: more samples per cell, so that fewer can be compared with them.
$gable simulate "$@" --generate 1500 --samples-per-cell 32 --cells 8 --noise 0..0.02 --density 1..20 \
    --most-points 4000 -o "$out/ablation"
