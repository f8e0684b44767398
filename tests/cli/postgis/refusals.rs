//! What is refused, and that nothing else happens.

use std::net::TcpListener;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use super::server::{HOUSE, reconstruct_house, run_house, run_house_with, server};
use crate::bench::*;

#[test]
fn passwords_come_from_where_libpq_takes_them_and_are_never_shown() {
    let Some(server) = server() else { return };
    server.house("guarded", "");
    server.sql("guarded", "CREATE ROLE locked LOGIN PASSWORD 'open sesame'; GRANT SELECT ON pand TO locked");
    let place = format!("PG:host=localhost port={} user=locked dbname=guarded", server.port);
    let in_string = format!("{place} password='open sesame'");
    let url = format!("postgresql://locked:open%20sesame@localhost:{}/guarded", server.port);
    let secret = ["open sesame", "open%20sesame", "swordfish"];
    let hides = |text: &str| assert!(!secret.iter().any(|secret| text.contains(secret)), "{text}");
    for (address, environment) in
        [(in_string.as_str(), None), (&url, None), (&place, Some(("PGPASSWORD", "open sesame")))]
    {
        let ran = run_house_with(address, "", &[], environment.as_slice());
        ran.attributes("007");
        hides(&ran.all_that_was_written());
        assert!(ran.report()["command"].to_string().contains("dbname=guarded") || address == url);
    }
    let nothing = run_house(&place, "", &[]);
    nothing.refused(&["asks `locked` for a password", "PGPASSWORD", ".pgpass"]);
    for ran in [
        run_house_with(&place, "", &[], &[("PGPASSWORD", "swordfish")]),
        run_house(&format!("{place} password=swordfish"), "", &[]),
        run_house(&format!("postgresql://locked:swordfish@localhost:{}/guarded", server.port), "", &[]),
    ] {
        ran.refused(&["password authentication failed", "`locked`", "PGPASSWORD"]);
        hides(&ran.all_that_was_written());
    }
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), "localhost:*:guarded:locked:open sesame\n").unwrap();
    let environment = [("PGPASSFILE", file.path().to_str().unwrap())];
    run_house_with(&place, "", &[], &environment).attributes("007");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(file.path(), std::fs::Permissions::from_mode(0o644)).unwrap();
        let ran = run_house_with(&place, "", &[], &environment);
        ran.refused(&["is not used: others may read it (mode 644)", "chmod 600"]);
        hides(&ran.all_that_was_written());
    }
    // In the place of a tile it is no file, and no password is told either.
    let run: Run = command(["info", "tile.laz", &format!("x{url}")]).output().unwrap().into();
    assert_eq!(run.code, 1);
    hides(&run.err);
}

#[test]
fn nothing_can_be_slipped_in_and_nothing_is_written() {
    let Some(server) = server() else { return };
    server.house("shop", "");
    server.sql("shop", "CREATE FUNCTION spoil() RETURNS text LANGUAGE sql AS 'DELETE FROM pand; SELECT ''x''::text'");
    let address = server.address("shop");
    for layer in
        ["pand\"; DROP TABLE pand; --", "pand; DROP TABLE pand", "public.pand(geom\") FROM pand; DROP TABLE pand; --"]
    {
        run_house(&address, "", &["--layer", layer]).refused(&["no layer `", "DROP TABLE", "There are: pand"]);
    }
    let queries = [
        ("SELECT 1; DROP TABLE pand", "cannot insert multiple commands"),
        ("SELECT * FROM pand) AS f; DROP TABLE pand; --", "syntax error"),
        ("SELECT * FROM pand /*", "unterminated"),
        ("DELETE FROM pand RETURNING *", "one SELECT"),
        ("DROP TABLE pand", "gives no rows"),
        ("SELECT id, geom, spoil() AS s FROM pand", "read-only transaction"),
        ("WITH gone AS (DELETE FROM pand RETURNING *) SELECT * FROM gone", "WITH clause"),
        (
            "SELECT * FROM pand WHERE set_config('transaction_read_only', 'off', true) = 'off' AND spoil() = 'x'",
            "read-write mode",
        ),
    ];
    for (query, says) in queries {
        let ran = run_house(&address, "", &["--query", query]);
        ran.refused(&[says, "--query"]);
    }
    // Values and names of attributes are data.
    server.sql(
        "shop",
        "ALTER TABLE pand ADD COLUMN \"x\"\"; DROP TABLE pand; --\" text DEFAULT ''');DROP TABLE pand;--'",
    );
    run_house(&address, "", &["--id-attribute", "x\"; DROP TABLE pand; --"]);
    run_house(&address, "", &["--filter", "id = '007'' OR spoil() = ''x'"]);
    assert_eq!(server.sql("shop", "SELECT count(*) FROM pand"), ["1"]);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let Some(server) = server() else { return };
    server.house("city", "");
    server.sql(
        "city",
        &format!(
            "CREATE TABLE owners (id text, name text); CREATE TABLE roofs AS SELECT id, geom, geom AS \"Eaves\" FROM pand; \
             CREATE SCHEMA closed; CREATE TABLE closed.pand AS SELECT 'x' AS id, {HOUSE} AS geom; \
             CREATE TABLE lines (id text, geom geometry(LineString, 28992)); CREATE ROLE visitor LOGIN; \
             GRANT SELECT ON pand TO visitor"
        ),
    );
    server.sql("postgres", "CREATE DATABASE plain");
    let address = server.address("city");
    let refused = |words: &[&str], says: &[&str]| run_house(&address, "", words).refused(says);
    refused(&["--layer", "pnad"], &["no layer `pnad`", "Did you mean `"]);
    refused(&["--layer", "owners"], &["table public.owners", "no geometry column", "id, name"]);
    refused(&["--layer", "roofs"], &["2 geometry columns", "roofs(geom)", "roofs(Eaves)"]);
    refused(&[], &["4 layers", "Name one with --layer", "closed.pand"]);
    refused(&["--query", "SELECT id FROM pand"], &["no geometry column", "its columns are: id"]);
    refused(&["--query", "SELECT * FROM roofs"], &["2 geometry columns: geom, Eaves"]);
    refused(&["--query", "SELECT id, geom FORM pand"], &["syntax error at or near \"pand\"", "--query, character 22"]);
    refused(&["--query", "SELECT id, geom FROM pond"], &["relation \"pond\" does not exist", "--query, character 22"]);
    refused(&["--query", "SELECT p.*, q.* FROM pand p, roofs q"], &["two columns `id`", "AS another"]);
    refused(&["--query", "SELECT * FROM pand WHERE id = $1"], &["1 parameters"]);
    refused(&["--query", "SELECT geom, 1 / (length(id) - 3) AS n FROM pand"], &["division by zero"]);
    refused(&["--query", "SELECT * FROM pand", "--layer", "pand"], &["cannot be used with"]);
    let file = house_folder();
    let run = run_in(file.path(), "house.laz", "footprints.geojson", "--query x");
    assert_ends(&run, 1, &["a query to a file", "footprints.geojson"]);
    run_house(&server.address("plain"), "", &[]).refused(&["a database without PostGIS", "CREATE EXTENSION postgis"]);
    run_house(&server.address("gone"), "", &[]).refused(&["\"gone\" does not exist", "dbname"]);
    let visitor = address.replace("user=postgres", "user=visitor");
    run_house(&visitor, "--layer pand", &[]).attributes("007");
    run_house(&visitor, "--layer closed.pand", &[]).refused(&["closed.pand", "no right to read it", "GRANT SELECT"]);
    run_house(&visitor, "", &["--query", "SELECT id, geom FROM roofs"]).refused(&["permission denied", "GRANT SELECT"]);
    let run: Run = command(["info", &visitor]).output().unwrap().into();
    assert!(run.code == 0 && run.out.contains("PG:host="), "the only layer that may be read: {}{}", run.out, run.err);
}

#[test]
fn a_server_that_does_not_answer_is_given_up() {
    let Some(server) = server() else { return };
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let silent = format!("PG:host=127.0.0.1 port={} user=u connect_timeout=1", listener.local_addr().unwrap().port());
    let started = Instant::now();
    run_house(&silent, "", &[]).refused(&["no answer within the time of connect_timeout", "127.0.0.1, port"]);
    assert!(started.elapsed() < Duration::from_secs(10));
    drop(listener);
    run_house(&silent, "", &[]).refused(&["no server that answers", "onnection refused", "See whether it runs there"]);
    run_house("PG:host=/nowhere user=u", "", &[]).refused(&["no server that answers", "/nowhere"]);
    run_house("PG:port=5432 x", "", &[]).refused(&["a word without `=`", "PG:host="]);
    server.house("slow", "");
    let address = server.address("slow");
    let sleep = ["--query", "SELECT id, geom, pg_sleep(60)::text AS s FROM pand"];
    let limited = format!("{address} options='-c statement_timeout=300'");
    run_house(&limited, "", &sleep).refused(&["statement timeout", "statement_timeout"]);
    // An interruption ends the wait, and soon the work of the server.
    let folder = house_folder();
    let mut command = reconstruct_house(folder.path(), &address);
    let mut child = command.args(sleep).stderr(Stdio::piped()).spawn().unwrap();
    let running = "SELECT count(*) FROM pg_stat_activity WHERE datname = 'slow' AND application_name = 'gable'";
    let wait_for = |count: &str| {
        let started = Instant::now();
        while server.sql("postgres", running) != [count] {
            assert!(started.elapsed() < Duration::from_secs(20), "{count}");
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    wait_for("1");
    let started = Instant::now();
    let interrupt = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupt.success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert!(started.elapsed() < Duration::from_secs(5));
    wait_for("0");
    assert!(!Path::new(&folder.path().join("out.city.json")).exists());
}
