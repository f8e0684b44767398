#!/usr/bin/env bash
# Reads footprints from a real PostgreSQL with PostGIS: starts a server of its own in a temporary folder, on a socket and a
# port of this machine, runs the tests of tests/cli/postgis*.rs against it and stops it. The programs come from the
# distribution: installed as root, else unpacked into .tools/postgis. What cannot be had is named, and the tests are
# skipped. Arguments go to the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec </dev/null

skip() {
    echo "skipped: the tests of PostGIS need $1"
    exit 0
}

# The newest server that has PostGIS: its folder of programs.
programs() {
    local control
    for control in $(ls -d {,.tools/postgis}/usr/share/postgresql/*/extension/postgis.control 2>/dev/null | sort -rV); do
        local version root
        version=$(basename "$(dirname "$(dirname "$control")")")
        root=${control%/usr/share/*}
        if [[ -x "$root/usr/lib/postgresql/$version/bin/postgres" ]]; then
            realpath -s "$root/usr/lib/postgresql/$version/bin"
            return
        fi
    done
}

packages() {
    apt-cache pkgnames postgresql- 2>/dev/null | sed -n 's/^postgresql-\([0-9]*\)-postgis-3$/postgresql-\1 &/p' | sort -V | tail -n 1
}

install() {
    local wanted
    if [[ "$(id -u)" == 0 ]]; then
        apt-get -qq update || true
        wanted=$(packages)
        [[ -n "$wanted" ]] || return 0
        echo "installing $wanted"
        # shellcheck disable=SC2086 # one word per package is meant
        DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends $wanted
        return
    fi
    wanted=$(packages)
    [[ -n "$wanted" ]] || return 0
    echo "unpacking $wanted into .tools/postgis"
    mkdir -p .tools/postgis/packages
    # shellcheck disable=SC2086
    apt-get -s install --no-install-recommends $wanted | awk '/^Inst/ { print $2 }' |
        (cd .tools/postgis/packages && xargs apt-get -qq download)
    for package in .tools/postgis/packages/*.deb; do
        dpkg -x "$package" .tools/postgis
    done
    rm -r .tools/postgis/packages
    # What an installation does by itself: the file of the extension is a link.
    local control
    for control in .tools/postgis/usr/share/postgresql/*/extension/postgis-3.control; do
        ln -sf postgis-3.control "$(dirname "$control")/postgis.control"
    done
}

bin=$(programs)
if [[ -z "$bin" ]] && command -v apt-get >/dev/null; then
    log=$(mktemp)
    install >"$log" 2>&1 || cat "$log" >&2
    rm -f "$log"
    bin=$(programs)
fi
[[ -n "$bin" ]] || skip 'postgresql and postgresql-NN-postgis-3 (as root: apt-get install them)'
command -v openssl >/dev/null || skip 'openssl, for the certificate of the server'
case "$bin" in "$PWD"/.tools/*)
    unpacked="$PWD/.tools/postgis/usr"
    libraries="$unpacked/lib/$(uname -m)-linux-gnu"
    export LD_LIBRARY_PATH="$libraries:$libraries/blas:$libraries/lapack${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
    export PROJ_LIB="$unpacked/share/proj"
    ;;
esac

# A server refuses to run as root.
folder=$(mktemp -d "${TMPDIR:-/tmp}/gable-postgis.XXXXXX")
as=()
if [[ "$(id -u)" == 0 ]]; then
    owner=nobody
    id -u postgres >/dev/null 2>&1 && owner=postgres
    command -v setpriv >/dev/null || skip 'setpriv, to run a server as another user than root'
    as=(setpriv "--reuid=$(id -u "$owner")" "--regid=$(id -g "$owner")" --clear-groups env "HOME=$folder")
fi

stop() {
    "${as[@]}" "$bin/pg_ctl" -D "$folder/data" -m immediate stop >/dev/null 2>&1 || true
    rm -rf "$folder"
}
trap stop EXIT

# Its own certificate, which is its own root: for localhost, not for 127.0.0.1.
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -addext subjectAltName=DNS:localhost \
    -keyout "$folder/server.key" -out "$folder/server.crt" 2>"$folder/openssl.log" || { cat "$folder/openssl.log" >&2; exit 1; }
chmod 600 "$folder/server.key"
chmod 644 "$folder/server.crt"
[[ "$(id -u)" != 0 ]] || chown -R "$owner" "$folder"
chmod 755 "$folder"
"${as[@]}" "$bin/initdb" -D "$folder/data" -U postgres -E UTF8 --locale=C --auth=trust --no-sync >"$folder.log" 2>&1 ||
    { cat "$folder.log" >&2; rm -f "$folder.log"; exit 1; }
rm -f "$folder.log"
"${as[@]}" sh -c 'cat > "$0"' "$folder/data/pg_hba.conf" <<'RULES'
local all all trust
host all locked all scram-sha-256
host all all all trust
RULES
for attempt in 1 2 3 4 5; do
    port=$((20000 + RANDOM % 30000))
    settings="-p $port -c listen_addresses=localhost -c unix_socket_directories=$folder -c fsync=off -c full_page_writes=off"
    settings+=" -c ssl=on -c ssl_cert_file=$folder/server.crt -c ssl_key_file=$folder/server.key -c shared_buffers=32MB"
    settings+=" -c autovacuum=off -c max_connections=50"
    if "${as[@]}" "$bin/pg_ctl" -D "$folder/data" -l "$folder/server.log" -o "$settings" -w -t 30 start >/dev/null; then
        break
    fi
    [[ "$attempt" != 5 ]] || { cat "$folder/server.log" >&2; exit 1; }
done
echo "PostgreSQL of $bin on port $port"

# Each test gets a copy of this database.
"$bin/psql" -X -q -h "$folder" -p "$port" -U postgres -d postgres -c 'CREATE DATABASE with_postgis' >/dev/null
"$bin/psql" -X -q -h "$folder" -p "$port" -U postgres -d with_postgis -c 'CREATE EXTENSION postgis' >/dev/null

export GABLE_POSTGIS_HOST="$folder" GABLE_POSTGIS_PORT="$port" GABLE_POSTGIS_CERTIFICATE="$folder/server.crt"
cargo test --release --locked --test cli postgis "$@"
