//! What is told when an object cannot be read or written: in words, and without a secret.

use std::path::Path;

use object_store::Error as StoreError;

use super::address::{Address, Service, redacted};
use crate::error::InputError;

/// Characters of a cause that are shown.
const SHOWN: usize = 200;

/// The fault of a request for `path`.
pub(super) fn of(path: &Path, error: &StoreError, expected: &str) -> InputError {
    let service = Address::of(path).map(|address| address.service);
    let (found, remedy) = match error {
        StoreError::NotFound { .. } => ("no such object".to_owned(), "Look whether its name is right"),
        StoreError::PermissionDenied { .. } | StoreError::Unauthenticated { .. } => {
            (format!("no access ({})", cause(error)), credentials(service))
        }
        StoreError::Precondition { .. } => (changed(), "Run again, when nobody writes to it any more"),
        StoreError::InvalidPath { .. } => {
            (cause(error), "Keys have no empty parts between two separators, and none that is . or ..")
        }
        _ => match (service, cause(error)) {
            // Without any credentials in the environment the machine itself is asked, which only those in a cloud answer.
            (Some(Service::S3 | Service::Google), told) if error.to_string().contains("metadata") => {
                (format!("no credentials in the environment ({told})"), credentials(service))
            }
            (_, told) => (told, "Look whether the server and the network are up, and run again"),
        },
    };
    InputError::new(path, found, expected).remedy(remedy)
}

/// What is found of an object that is not the one that was opened.
pub(super) fn changed() -> String {
    "another version than the one that was opened: it was changed while it was read".to_owned()
}

fn credentials(service: Option<Service>) -> &'static str {
    match service {
        Some(Service::S3) => {
            "Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY (and AWS_REGION), or AWS_NO_SIGN_REQUEST=YES for what is public"
        }
        Some(Service::Azure) => {
            "Set AZURE_STORAGE_ACCOUNT_NAME and a key, or AZURE_NO_SIGN_REQUEST=YES for what is public"
        }
        Some(Service::Google) => "Set GOOGLE_APPLICATION_CREDENTIALS, or GOOGLE_NO_SIGN_REQUEST=YES for what is public",
        Some(Service::Web) | None => "Look whether the address is right, and its signature has not run out",
    }
}

/// What went wrong, in one line: the status and the code of the server's answer, or what stopped the request. The answer itself
/// is not shown: it may repeat what was signed.
fn cause(error: &StoreError) -> String {
    let text = error.to_string();
    let tried = text.split(", after ").nth(1).and_then(|rest| rest.split(" retries").next());
    let tried = tried.and_then(|count| count.parse::<usize>().ok()).map(|count| format!(", after {count} retries"));
    let told = if let Some((_, answer)) = text.split_once("status code: ") {
        let status = answer.split(": ").next().unwrap_or(answer).trim();
        let code = answer.split_once("<Code>").and_then(|(_, rest)| rest.split_once("</Code>")).map(|(code, _)| code);
        match code.filter(|code| code.chars().all(|c| c.is_ascii_alphanumeric())) {
            Some(code) => format!("the server answers {status}, {code}"),
            None => format!("the server answers {status}"),
        }
    } else {
        let mut innermost: &dyn std::error::Error = error;
        while let Some(source) = innermost.source() {
            innermost = source;
        }
        let line = redacted(innermost.to_string().lines().next().unwrap_or_default());
        line.chars().take(SHOWN).collect()
    };
    told + &tried.unwrap_or_default()
}
