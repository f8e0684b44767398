#!/bin/sh
# Makes the shards that the shipped networks were trained on. Usage: training/data.sh OUT REAL MODELS…, the models being
# files of LoD 2.2 buildings (3DBAG), REAL a folder with the real scans that README.md lists. One seed for all: the same
# tiles are held back in every folder.
set -eu
gable=${GABLE:-gable}
out=$1
real=$2
shift 2
# Real scans: every tile is wholly for training or wholly held back. None is held back of the small ones.
$gable simulate --real "$real/amsterdam-west/ahn3_2.laz" "$real/amsterdam-west/ahn3_3.laz" \
    --hold-back "$real/amsterdam-west/ahn3_4.laz" -f "$real/amsterdam-west/footprints.geojson" \
    --crs EPSG:7415 --footprint-crs EPSG:28992 --split 1,0,0 --variants 30 --density 0.7..20 -o "$out/west"
# Not classified.
$gable simulate --real "$real"/amsterdam-west/ahn2_?.laz -f "$real/amsterdam-west/footprints.geojson" \
    --crs EPSG:7415 --footprint-crs EPSG:28992 --building-class any --split 1,0,0 --variants 12 --density 0.7..20 \
    -o "$out/west-2"
$gable simulate --real "$real"/delft/*.laz -f "$real/delft/bgt_pand.sqlite" --crs EPSG:7415 \
    --split 1,0,0 --variants 24 --density 0.7..20 -o "$out/delft"
$gable simulate --real "$real"/amsterdam-dense/*.laz -f "$real/amsterdam-dense/footprints.geojson" --crs EPSG:7415 \
    --split 1,0,0 --variants 24 --density 0.7..20 -o "$out/dense"
$gable simulate --real "$real"/ign-rural/*.laz -f "$real"/ign-rural/*.shp \
    --split 1,0,0 --variants 24 --density 0.7..20 -o "$out/rural"
# Virtual ones teach what real airborne ones cannot: walls, undersides, views from all sides, much noise.
$gable simulate "$@" --generate 1000 --variants 2 --setup airborne --density 1..40 --most-points 5000 -o "$out/airborne"
$gable simulate "$@" --generate 1500 --setup no-bottom --noise 0..0.02 --density 1..20 --most-points 5000 -o "$out/no-bottom"
$gable simulate "$@" --generate 1500 --setup full-view --noise 0..0.02 --density 1..20 --most-points 5000 -o "$out/full-view"
$gable simulate "$@" --generate 1500 --noise 0..0.05 --density 1..20 --most-points 3000 -o "$out/noisy"
$gable simulate "$@" --generate 1500 --interface points2surf --near 8 --uniform 8 --cells 2 --density 1..20 \
    --most-points 4000 -o "$out/points2surf"
# For ABLATIONS.md alone: more samples per cell, so that fewer can be compared with them.
$gable simulate "$@" --generate 1500 --samples-per-cell 32 --cells 8 --noise 0..0.02 --density 1..20 \
    --most-points 4000 -o "$out/ablation"
