#!/bin/sh
# Makes sure that gable can be built: cargo, a C and a C++ compiler, cmake and the sqlite3 tool (the last two build the
# bundled PROJ and its database). Says nothing and is done at once when all is there. As root on Debian or Ubuntu it
# installs what is missing; otherwise cmake comes from PyPI and Python stands in for sqlite3, both in .tools/, and what
# cannot be had that way is named with the command that installs it.
set -eu
cd "$(dirname "$0")/.."
tools=$PWD/.tools
PATH=$tools/bin:$PATH

have() { command -v "$1" >/dev/null 2>&1; }

missing() {
    have cc && have c++ || printf ' g++'
    have make || printf ' make'
    have cmake || printf ' cmake'
    have sqlite3 || printf ' sqlite3'
}

if ! have cargo; then
    echo "gable needs Rust 1.92 or newer, and there is no cargo on the path: see https://rustup.rs" >&2
    exit 1
fi
[ -n "$(missing)" ] || exit 0

if [ "$(id -u)" = 0 ] && have apt-get; then
    packages=$(missing)
    echo "installing$packages"
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    # shellcheck disable=SC2086 # one word per package is meant
    if ! { apt-get -qq update && apt-get -qq install -y --no-install-recommends $packages; } >"$log" 2>&1 </dev/null; then
        cat "$log" >&2
        echo "could not install$packages" >&2
        exit 1
    fi
    rm -f "$log"
elif have python3; then
    mkdir -p "$tools/bin"
    if ! have cmake && python3 -m pip --version >/dev/null 2>&1; then
        echo "installing cmake from PyPI into .tools/"
        if python3 -m pip install --quiet --disable-pip-version-check --upgrade --target "$tools/python" cmake </dev/null; then
            ln -sf "$tools/python/cmake/data/bin/cmake" "$tools/bin/cmake"
        fi
    fi
    if ! have sqlite3 && python3 -c 'import sqlite3' 2>/dev/null; then
        # PROJ only asks it to run a script from standard input: sqlite3 FILE < SCRIPT.
        cat >"$tools/bin/sqlite3" <<'SHIM'
#!/usr/bin/env python3
import sqlite3, sys
sqlite3.connect(sys.argv[1], isolation_level=None).executescript(sys.stdin.read())
SHIM
        chmod +x "$tools/bin/sqlite3"
    fi
fi

packages=$(missing)
if [ -n "$packages" ]; then
    echo "gable cannot be built yet: these are missing:$packages" >&2
    if have apt-get; then
        echo "install them with: sudo apt-get install$packages" >&2
    else
        echo "install them with the package manager of your system" >&2
    fi
    exit 1
fi
