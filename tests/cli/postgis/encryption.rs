//! Which servers are trusted. The certificate of the server is its own root, and made out to localhost.

use serde_json::json;

use super::server::{Ran, Server, run_house, server};

/// A query that says whether its connection is encrypted.
const ENCRYPTED: [&str; 2] = ["--query", "SELECT p.*, s.ssl FROM pand p, pg_stat_ssl s WHERE s.pid = pg_backend_pid()"];

fn run(server: &Server, host: &str, rest: &str) -> Ran {
    let port = &server.port;
    run_house(&format!("PG:host={host} port={port} user=postgres dbname=sealed {rest}"), "", &ENCRYPTED)
}

#[test]
fn servers_are_trusted_as_sslmode_says() {
    let Some(server) = server() else { return };
    server.house("sealed", "");
    let root = format!("sslrootcert='{}'", server.certificate.display());
    let other = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/postgis/other.crt");
    for (host, rest, is_encrypted) in [
        ("localhost", "sslmode=disable".to_owned(), false),
        ("localhost", String::new(), true),
        ("localhost", "sslmode=require".to_owned(), true),
        ("127.0.0.1", "sslmode=require".to_owned(), true),
        ("localhost", format!("sslmode=verify-full {root}"), true),
        ("127.0.0.1", format!("sslmode=verify-ca {root}"), true),
        (server.host.as_str(), "sslmode=require".to_owned(), false),
    ] {
        let attributes = run(&server, host, &rest).attributes("007");
        assert_eq!(attributes["ssl"], json!(is_encrypted), "{host} {rest}");
    }
    for (host, rest, says) in [
        ("localhost", "sslmode=verify-full".to_owned(), "no root certificate"),
        ("localhost", "sslmode=verify-full sslrootcert=system".to_owned(), "no encrypted connection"),
        ("127.0.0.1", format!("sslmode=verify-full {root}"), "not valid for name"),
        ("localhost", format!("sslmode=verify-ca sslrootcert={other}"), "no encrypted connection"),
        ("localhost", format!("sslmode=require sslrootcert={other}"), "no encrypted connection"),
        ("localhost", "sslmode=verify-full sslrootcert=/none.crt".to_owned(), "/none.crt"),
        ("localhost", "sslmode=verify-full sslrootcert=Cargo.toml".to_owned(), "no usable certificate"),
        ("localhost", "sslmode=require sslrootcert=system".to_owned(), "sslmode=verify-full"),
        ("localhost", "sslmode=allow".to_owned(), "disable, prefer, require, verify-ca, verify-full"),
    ] {
        run(&server, host, &rest).refused(&[says]);
    }
}
