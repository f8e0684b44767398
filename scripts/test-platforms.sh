#!/usr/bin/env bash
# Opens what gable writes with the programs that it is written for: CesiumJS and the page in a headless Chromium, the glTF
# validator, GDAL. Installs what is missing: Debian packages as root, npm packages into .tools/. What cannot be had is
# named, and the tests are skipped. Arguments choose test files; without any, all of tests/platforms run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

have() { command -v "$1" >/dev/null 2>&1; }

missing() {
    have node || printf ' nodejs'
    have npm || printf ' npm'
    [[ -n "${CHROMIUM:-}" ]] || have chromium || have chromium-browser || have google-chrome || printf ' chromium'
    have ogrinfo || printf ' gdal-bin'
}

packages=$(missing)
if [[ -n "$packages" && "$(id -u)" == 0 ]] && have apt-get; then
    echo "installing$packages"
    log=$(mktemp)
    # shellcheck disable=SC2086 # one word per package is meant
    if ! { apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends $packages; } \
        >"$log" 2>&1; then
        cat "$log" >&2
    fi
    rm -f "$log"
fi
packages=$(missing)
if [[ -n "$packages" ]]; then
    echo "skipped: the tests of tests/platforms need$packages (as root: apt-get install$packages)"
    exit 0
fi

# Beside the tests there is only the list of packages; the packages are kept with the other tools.
place=.tools/platforms
mkdir -p "$place"
if ! cmp -s tests/platforms/package-lock.json "$place/installed.json"; then
    cp tests/platforms/package.json tests/platforms/package-lock.json "$place/"
    if ! npm ci --prefix "$place" --ignore-scripts --no-audit --no-fund --loglevel=error; then
        echo 'skipped: the npm packages of tests/platforms/package.json could not be installed'
        exit 0
    fi
    cp tests/platforms/package-lock.json "$place/installed.json"
fi

# The tests make what they open; they do it with this binary.
if [[ -z "${GABLE:-}" ]]; then
    cargo build --release --locked --quiet
    GABLE=${CARGO_TARGET_DIR:-target}/release/gable
fi
GABLE=$(realpath "$GABLE")
export GABLE NODE_PATH="$PWD/$place/node_modules"
if (($#)); then
    node --test --test-concurrency=1 "$@"
else
    node --test --test-concurrency=1 tests/platforms/*.test.js
fi
