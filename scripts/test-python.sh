#!/usr/bin/env bash
# Builds the wheel of the Python package into out/wheels, installs it with all extras into a fresh virtual environment, and
# runs the tests of python/tests on it, the notebook of examples/ among them. PYTHON names another interpreter than python3.
# Where there is no Python 3.10 or newer with venv and pip, or no package index, it says so and that it was skipped.
# Arguments go to pytest.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

skip() {
    echo "skipped: the Python package is not built and not tested: $1"
    exit 0
}

python=${PYTHON:-python3}
command -v "$python" >/dev/null 2>&1 || skip "there is no $python (name one in PYTHON)"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
    skip "$("$python" --version) is older than 3.10 (name another in PYTHON)"
if ! "$python" -c 'import ensurepip, venv' 2>/dev/null && [[ "$(id -u)" == 0 ]] && command -v apt-get >/dev/null; then
    echo 'installing python3-venv'
    { apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends python3-venv; } \
        >/dev/null 2>&1 || true
fi
place=.tools/python-tests
rm -rf "$place"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
"$python" -m venv "$place" >"$log" 2>&1 || skip "$python cannot make a virtual environment (on Debian: python3-venv)"
own=$PWD/$place/bin
pip() { "$own/pip" --disable-pip-version-check --quiet "$@" >"$log" 2>&1; }

pip install 'maturin>=1.9.4,<2' || skip "maturin cannot be installed: $(tail -n 1 "$log")"
# Where the program is built, most of this is.
cargo build --release --locked --quiet
cargo clippy --release --locked --quiet --package gable-python -- -D warnings
rm -rf out/wheels
"$own/maturin" build --release --locked --quiet --interpreter "$own/python" --out out/wheels
wheel=$(ls out/wheels/*.whl)
echo "$wheel: $(du -h "$wheel" | cut -f 1)"
pip install "$wheel[test]" || skip "what the tests need cannot be installed: $(tail -n 1 "$log")"

GABLE=$(realpath "${GABLE:-${CARGO_TARGET_DIR:-target}/release/gable}")
export GABLE
# Not from here, where a folder of that name could be taken for the package.
tests=$PWD/python/tests
cd "$place"
exec bin/python -m pytest --quiet -p no:cacheprovider "$tests" "$@"
