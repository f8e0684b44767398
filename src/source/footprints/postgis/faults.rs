//! What a database answers instead of rows, in the words of a message.

use std::error::Error as _;
use std::path::Path;

use tokio_postgres::Error as PgError;
use tokio_postgres::error::{DbError, ErrorPosition, SqlState};

use super::address::Address;
use crate::error::InputError;

/// What went wrong on the way to a connection; `hint` is why a password file was not used.
pub(super) fn connecting(address: &Address, error: &PgError, hint: Option<&str>) -> InputError {
    let (label, server) = (address.label(), address.server());
    let user = address.get("user").unwrap_or_default();
    let database = address.get("dbname").unwrap_or_default();
    let hint = hint.map(|hint| format!("; {hint}")).unwrap_or_default();
    let Some(answer) = error.as_db_error() else {
        let reason = reason(error);
        if reason.contains("password missing") {
            return InputError::new(
                label,
                format!("a server that asks `{user}` for a password, and none"),
                "a password",
            )
            .at(server)
            .remedy(format!("Set PGPASSWORD, or put a line into ~/.pgpass{hint}"));
        }
        if is_of_tls(error) {
            return InputError::new(label, format!("no encrypted connection ({reason})"), encrypted(address))
                .at(server)
                .remedy("Give the right sslrootcert, or an sslmode that asks for less");
        }
        return InputError::new(label, format!("no server that answers ({reason})"), "a PostgreSQL server")
            .at(server)
            .remedy("See whether it runs there, takes connections from here, and whether host and port are right");
    };
    let said = answer.message();
    let code = answer.code();
    let fault = |expected: &str| InputError::new(&label, said, expected).at(&server);
    if *code == SqlState::INVALID_PASSWORD || *code == SqlState::INVALID_AUTHORIZATION_SPECIFICATION {
        let expected = format!("a login of `{user}` that the server accepts");
        fault(&expected).remedy(format!("See PGPASSWORD, ~/.pgpass and the pg_hba.conf of the server{hint}"))
    } else if *code == SqlState::INVALID_CATALOG_NAME {
        fault("a database that is there").remedy(format!("Give dbname=…; asked for was `{database}`"))
    } else {
        fault("a server that lets us in")
    }
}

/// How a connection ought to be encrypted.
fn encrypted(address: &Address) -> String {
    let mode = address.get("sslmode").unwrap_or("prefer");
    format!("one as sslmode={mode} asks for")
}

/// What went wrong with a statement of gable's own.
pub(super) fn asking(label: &Path, error: &PgError) -> InputError {
    let Some(answer) = error.as_db_error() else {
        return InputError::new(label, format!("a connection that broke ({})", reason(error)), "an answer");
    };
    let fault = InputError::new(label, told(answer), "an answer");
    let code = answer.code();
    if *code == SqlState::QUERY_CANCELED {
        fault.remedy(
            "A time limit of the server, the role or the `options` ended it: ask for less, or raise statement_timeout",
        )
    } else if *code == SqlState::INSUFFICIENT_PRIVILEGE {
        fault.remedy("Ask the owner of the table for the right to read it (GRANT SELECT)")
    } else {
        fault
    }
}

/// What is wrong with the query of the user; `before` characters stand before it in what was sent.
pub(super) fn of_query(label: &Path, error: &PgError, before: u32) -> InputError {
    let fault = asking(label, error);
    let Some(answer) = error.as_db_error() else { return fault };
    let place = match answer.position() {
        Some(ErrorPosition::Original(at)) if *at > before => format!("--query, character {}", at - before),
        _ => "--query".to_owned(),
    };
    let expected = "one SELECT with a column of geometry, without a semicolon behind it";
    let remedy = if fault.remedy.is_empty() { "Try it in psql".to_owned() } else { fault.remedy };
    InputError::new(label, fault.found, expected).at(place).remedy(remedy)
}

/// What a server says: its message, and what it adds to it.
fn told(answer: &DbError) -> String {
    let more = [answer.detail(), answer.hint()].into_iter().flatten().map(|text| format!(" ({text})"));
    format!("the answer \"{}\"{}", answer.message(), more.collect::<String>())
}

/// Whether encryption failed, not the connection below it.
pub(super) fn is_of_tls(error: &PgError) -> bool {
    error.to_string().contains("TLS")
}

/// What stands behind an error that is not the server's.
fn reason(error: &PgError) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        text = format!("{text}: {cause}");
        source = cause.source();
    }
    text
}
