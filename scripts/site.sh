#!/bin/sh
# Builds the site from docs/ into out/site, and checks that its links lead somewhere. What builds it, zensical, is installed
# from PyPI into .tools/site. Where it cannot be had, that is said, and the site is skipped.
set -eu
cd "$(dirname "$0")/.."
version=0.0.73
tools=.tools/site

if [ "$("$tools/bin/zensical" --version 2>/dev/null | grep -o '[0-9][0-9.]*$')" != "$version" ]; then
    echo "installing zensical $version into $tools"
    log=$(mktemp)
    if ! { python3 -m venv --clear "$tools" && "$tools/bin/pip" install --quiet --disable-pip-version-check "zensical==$version"; } \
        >"$log" 2>&1 </dev/null; then
        tail -n 5 "$log" >&2
        rm -f "$log"
        echo "skipped: the site is built by zensical $version (Python 3.10 or newer, from PyPI), which could not be installed"
        exit 0
    fi
    rm -f "$log"
fi

rm -rf out/site
"$tools/bin/zensical" build --clean --strict
python3 scripts/links.py out/site README.md CONTRIBUTING.md CHANGELOG.md
echo "The site is out/site/index.html; to search in it: python3 -m http.server -d out/site"
