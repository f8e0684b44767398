#!/usr/bin/env bash
# Reads and writes objects: starts a server that speaks the protocol of S3 (moto, in a Python environment of its own in
# .tools/moto) on a port of this machine, runs the tests of tests/cli/remote against it and stops it. What cannot be had is
# named, and the tests that need it are skipped; those against a web server of their own run anyway. Arguments go to the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

run() {
    cargo test --release --locked --test cli remote -- "$@"
}

skip() {
    echo "skipped: the tests of S3 need $1"
    run "$@"
    exit 0
}

moto=.tools/moto/bin/moto_server
if [[ ! -x "$moto" ]]; then
    command -v python3 >/dev/null || skip 'python3'
    log=$(mktemp)
    if ! { python3 -m venv .tools/moto && .tools/moto/bin/pip install --quiet 'moto[server,s3]>=5,<6'; } >"$log" 2>&1; then
        cat "$log" >&2
        rm -rf "$log" .tools/moto
        skip 'moto, which could not be installed'
    fi
    rm -f "$log"
fi

folder=$(mktemp -d "${TMPDIR:-/tmp}/gable-remote.XXXXXX")
server=
stop() {
    [[ -z "$server" ]] || kill "$server" 2>/dev/null || true
    rm -rf "$folder"
}
trap stop EXIT

for attempt in 1 2 3 4 5; do
    port=$((20000 + RANDOM % 30000))
    "$moto" -H 127.0.0.1 -p "$port" >"$folder/server.log" 2>&1 &
    server=$!
    for _ in $(seq 100); do
        kill -0 "$server" 2>/dev/null || break
        if python3 -c "import socket; socket.create_connection(('127.0.0.1', $port), 1)" 2>/dev/null; then
            break 2
        fi
        sleep 0.2
    done
    [[ "$attempt" != 5 ]] || { cat "$folder/server.log" >&2; exit 1; }
done
echo "moto on port $port"
export GABLE_S3_ENDPOINT="127.0.0.1:$port"
run "$@"
