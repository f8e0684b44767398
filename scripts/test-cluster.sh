#!/usr/bin/env bash
# A run in several jobs on real engines: a Dask cluster of processes on the loopback whose workers and scheduler are killed,
# stopped and starved, Ray, Snakemake, the tasks of a Slurm array, the manifest for Kubernetes (tests/cluster). The wheel is
# that of scripts/test-python.sh, or is built. PYTHON names another interpreter than python3.
# Where there is no Python 3.10 or newer with venv and pip, or no package index, it says so and that it was skipped.
# Arguments go to pytest.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

skip() {
    echo "skipped: runs on clusters are not tested: $1"
    exit 0
}

python=${PYTHON:-python3}
command -v "$python" >/dev/null 2>&1 || skip "there is no $python (name one in PYTHON)"
"$python" -c 'import sys, ensurepip, venv; sys.exit(sys.version_info < (3, 10))' 2>/dev/null ||
    skip "$python is older than 3.10, or has no venv (on Debian: python3-venv)"
place=.tools/cluster-tests
log=$(mktemp)
trap 'rm -f "$log"' EXIT
[[ -x $place/bin/python ]] || "$python" -m venv "$place" >"$log" 2>&1 || skip "$python cannot make a virtual environment"
own=$PWD/$place/bin
pip() { "$own/pip" --disable-pip-version-check --quiet "$@" >"$log" 2>&1; }

wheel=$(ls out/wheels/*.whl 2>/dev/null | head -n 1 || true)
if [[ -z $wheel || -n $(find src python/src python/gable -newer "$wheel" -type f -print -quit) ]]; then
    pip install 'maturin>=1.9.4,<2' || skip "maturin cannot be installed: $(tail -n 1 "$log")"
    rm -rf out/wheels
    "$own/maturin" build --release --locked --quiet --interpreter "$own/python" --out out/wheels
    wheel=$(ls out/wheels/*.whl)
fi
pip install --force-reinstall --no-deps "$wheel"
pip install "$wheel[dask]" pytest || skip "Dask cannot be installed: $(tail -n 1 "$log")"
# Each of these is for tests of its own, which are skipped without it.
for package in 'ray>=2.9' 'kubernetes-validate>=1.31,<1.32' 'snakemake>=8'; do
    pip install "$package" || echo "without $package, and the tests that need it: $(tail -n 1 "$log")"
done
cargo build --release --locked --quiet
GABLE=$(realpath "${GABLE:-${CARGO_TARGET_DIR:-target}/release/gable}")
export GABLE
tests=$PWD/tests/cluster
cd "$place"
exec bin/python -m pytest --quiet -rs -p no:cacheprovider "$tests" "$@"
