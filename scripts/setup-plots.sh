#!/bin/sh
# Names on standard output a Python with matplotlib: the one there is, or one in .tools/plots, made here.
set -eu
cd "$(dirname "$0")/.."
for python in "${PYTHON:-python3}" .tools/plots/bin/python; do
    if command -v "$python" >/dev/null 2>&1 && "$python" -c 'import matplotlib' 2>/dev/null; then
        echo "$python"
        exit 0
    fi
done
echo "installing matplotlib into .tools/plots" >&2
python3 -m venv .tools/plots >&2
.tools/plots/bin/pip install --quiet 'matplotlib>=3.8,<4' >&2
echo .tools/plots/bin/python
