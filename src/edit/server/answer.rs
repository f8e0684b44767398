//! What answers are made of.

use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{ALLOW, CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::{Response, StatusCode};
use serde_json::json;

use crate::edit::Refusal;

/// An answer.
pub(super) type Answer = Response<Full<Bytes>>;

/// What the page may do: run what is in it, and ask this server.
const PAGE: &str = "default-src 'none'; connect-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                    img-src data: blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";
/// What other answers may do where they are opened as pages: nothing.
const NOTHING: &str = "default-src 'none'; frame-ancestors 'none'";

/// An answer of a type, for the one who asked alone.
fn answer(status: StatusCode, kind: Option<&'static str>, policy: &'static str, body: Bytes) -> Answer {
    let mut answer = Response::new(Full::new(body));
    *answer.status_mut() = status;
    let fixed = [
        (CACHE_CONTROL, "no-store"),
        (CONTENT_SECURITY_POLICY, policy),
        (HeaderName::from_static("x-content-type-options"), "nosniff"),
        (HeaderName::from_static("x-frame-options"), "DENY"),
        (HeaderName::from_static("referrer-policy"), "no-referrer"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ];
    let headers = answer.headers_mut();
    headers.extend(fixed.map(|(name, value)| (name, HeaderValue::from_static(value))));
    if let Some(kind) = kind {
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    }
    answer
}

/// The page.
pub(super) fn page(html: Bytes) -> Answer {
    answer(StatusCode::OK, Some("text/html; charset=utf-8"), PAGE, html)
}

/// Something in JSON.
pub(super) fn json(body: impl Into<Bytes>) -> Answer {
    answer(StatusCode::OK, Some("application/json"), NOTHING, body.into())
}

/// Something packed into text.
pub(super) fn text(body: impl Into<Bytes>) -> Answer {
    answer(StatusCode::OK, Some("text/plain; charset=utf-8"), NOTHING, body.into())
}

/// Nothing but a status.
pub(super) fn empty(status: StatusCode) -> Answer {
    answer(status, None, NOTHING, Bytes::new())
}

/// That a path takes another method.
pub(super) fn other_method(allowed: &'static str) -> Answer {
    let mut answer = empty(StatusCode::METHOD_NOT_ALLOWED);
    answer.headers_mut().insert(ALLOW, HeaderValue::from_static(allowed));
    answer
}

/// Why something is not done.
pub(super) fn error(status: StatusCode, why: &str) -> Answer {
    let mut answer = json(json!({ "error": why }).to_string());
    *answer.status_mut() = status;
    answer
}

/// Why a desk does not do something.
pub(super) fn refusal(refusal: Refusal) -> Answer {
    match refusal {
        Refusal::Unknown(why) => error(StatusCode::NOT_FOUND, &why),
        Refusal::Stale(revision) => {
            let why = "the building has changed since";
            let mut answer = json(json!({ "error": why, "revision": revision }).to_string());
            *answer.status_mut() = StatusCode::CONFLICT;
            answer
        }
        Refusal::Broken(why) => error(StatusCode::UNPROCESSABLE_ENTITY, &format!("the method breaks on it: {why}")),
        Refusal::Busy => error(StatusCode::SERVICE_UNAVAILABLE, "an export is under way"),
        Refusal::Failed(why) => error(StatusCode::INTERNAL_SERVER_ERROR, &why),
    }
}
