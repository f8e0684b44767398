#!/bin/sh
# Names on standard output a Python that can train: one with torch, numpy and tomllib. As root on Debian or Ubuntu it
# installs what is missing; otherwise it says what to install.
set -eu

able() { command -v "$1" >/dev/null 2>&1 && "$1" -c 'import numpy, tomllib, torch' 2>/dev/null; }
name() {
    for python in "${PYTHON:-python3}" python3 /usr/bin/python3; do
        if able "$python"; then
            echo "$python"
            exit 0
        fi
    done
}

name
packages="python3-torch python3-numpy libopenblas0-pthread"
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    echo "installing $packages" >&2
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    # shellcheck disable=SC2086 # one word per package is meant
    if ! { apt-get -qq update && apt-get -qq install -y --no-install-recommends $packages; } >"$log" 2>&1 </dev/null; then
        cat "$log" >&2
        exit 1
    fi
    rm -f "$log"
    name
fi
echo "training needs a Python 3.11 or newer with torch and numpy: install $packages, or name one in PYTHON" >&2
exit 1
