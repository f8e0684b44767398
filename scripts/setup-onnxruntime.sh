#!/bin/sh
# Names on standard output a library of ONNX Runtime for the tests of --onnxruntime: the one in GABLE_ONNXRUNTIME, or one
# from PyPI, which is put into .tools/. Says nothing when there is none to be had; the tests that need it say so then.
set -u
cd "$(dirname "$0")/.."
folder=$PWD/.tools/onnxruntime

if [ -n "${GABLE_ONNXRUNTIME:-}" ]; then
    echo "$GABLE_ONNXRUNTIME"
    exit 0
fi
library() { find "$folder" -name 'libonnxruntime.so.*' 2>/dev/null | head -n 1; }
if [ -z "$(library)" ] && command -v python3 >/dev/null 2>&1; then
    python3 -m pip install --quiet --disable-pip-version-check --no-deps --target "$folder" 'onnxruntime>=1.24' \
        </dev/null >/dev/null 2>&1
fi
library
