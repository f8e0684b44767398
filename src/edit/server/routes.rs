//! What is answered to which request.

use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::CONTENT_TYPE;
use hyper::{Method, Request, StatusCode};
use percent_encoding::percent_decode_str;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use tokio::sync::Semaphore;

use super::access::Access;
use super::answer::{Answer, empty, error, json, other_method, page, refusal, text};
use crate::edit::{Desk, Refusal};
use crate::edits::{Action, State};
use crate::guard::guarded;
use crate::view::page::fill;

/// The page: made from `src/edit/page` by `make page`.
const TEMPLATE: &str = include_str!("../page/dist/page.html");
/// The largest body of a request, bytes: a plane through 100 000 places is smaller.
const LARGEST: usize = 4 << 20;
/// A body that takes longer is given up.
const BODY_TIME: Duration = Duration::from_secs(30);

/// What requests are answered from.
pub(super) struct Service {
    pub desk: Arc<Desk>,
    pub access: Access,
    /// Who may work on a building.
    pub at_work: Semaphore,
}

/// What is asked to be done to a building.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Doing {
    id: String,
    revision: u64,
    action: Action,
}

/// Which building, as it was known.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    id: String,
    revision: u64,
}

/// What is decided about a building.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Decision {
    id: String,
    state: State,
}

/// Nothing that is said.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

/// Work that a request asks for.
type Work = Box<dyn FnOnce(&Desk) -> Result<Answer, Refusal> + Send>;

/// What comes to an end before it is done: its answer.
type Early<T> = Result<T, Box<Answer>>;

fn early(answer: Answer) -> Box<Answer> {
    Box::new(answer)
}

fn refused(why: Refusal) -> Box<Answer> {
    early(refusal(why))
}

impl Service {
    /// The answer to a request.
    pub async fn answer(self: Arc<Self>, request: Request<Incoming>) -> Answer {
        let Some(path) = self.access.inner(request.uri().path()).map(str::to_owned) else {
            return empty(StatusCode::NOT_FOUND);
        };
        if !self.access.is_own(request.headers()) {
            return empty(StatusCode::FORBIDDEN);
        }
        let gets = request.method() == Method::GET;
        let outcome = match path.as_str() {
            "" | "api/model" | "api/building" | "api/edits" if !gets => Err(early(other_method("GET"))),
            "" => Ok(page(fill(TEMPLATE, self.desk.name(), "").into())),
            // The list waits for nobody: it is made here, and not where buildings are worked on.
            "api/model" => self.desk.list().map(json).map_err(refused),
            "api/edits" => self.desk.edits().map(json).map_err(refused),
            "api/building" => match asked_for(request.uri().query().unwrap_or_default()) {
                Some(id) => self.work(Box::new(move |desk| desk.building(&id).map(text))).await,
                None => {
                    Err(early(error(StatusCode::BAD_REQUEST, "the id of a building is expected: api/building?id=…")))
                }
            },
            "api/edit" | "api/undo" | "api/redo" | "api/clear" | "api/state" | "api/export" if gets => {
                Err(early(other_method("POST")))
            }
            "api/edit" | "api/undo" | "api/redo" | "api/clear" | "api/state" | "api/export" => {
                self.change(&path, request).await
            }
            _ => Err(early(empty(StatusCode::NOT_FOUND))),
        };
        outcome.unwrap_or_else(|early| *early)
    }

    /// Does what a request asks to be changed.
    async fn change(&self, path: &str, request: Request<Incoming>) -> Early<Answer> {
        if request.method() != Method::POST {
            return Err(early(other_method("POST")));
        }
        let body = body(request).await?;
        let known = |act: fn(&Desk, &str, u64) -> Result<String, Refusal>| -> Early<Work> {
            let Known { id, revision } = said(&body)?;
            Ok(Box::new(move |desk| act(desk, &id, revision).map(text)))
        };
        let work: Work = match path {
            "api/edit" => {
                let Doing { id, revision, action } = said(&body)?;
                Box::new(move |desk| desk.edit(&id, revision, action).map(text))
            }
            "api/undo" => known(Desk::undo)?,
            "api/redo" => known(Desk::redo)?,
            "api/clear" => known(Desk::clear)?,
            "api/state" => {
                let Decision { id, state } = said(&body)?;
                Box::new(move |desk| desk.decide(&id, state).map(json))
            }
            _ => {
                let Nothing {} = said(&body)?;
                return self.export().await;
            }
        };
        self.work(work).await
    }

    /// Works on a building on a thread of its own, when it is its turn.
    async fn work(&self, work: Work) -> Early<Answer> {
        // Nobody ever closes it.
        let _turn = self.at_work.acquire().await;
        self.aside(work).await
    }

    /// An export takes as long as a run, and nobody's turn.
    async fn export(&self) -> Early<Answer> {
        let exported = |desk: &Desk| {
            let exported = desk.export()?;
            serde_json::to_string(&exported).map(json).map_err(|fault| Refusal::Failed(fault.to_string()))
        };
        self.aside(Box::new(exported)).await
    }

    async fn aside(&self, work: Work) -> Early<Answer> {
        let desk = self.desk.clone();
        let done = tokio::task::spawn_blocking(move || guarded(|| work(&desk))).await;
        match done {
            Ok(Ok(outcome)) => outcome.map_err(refused),
            Ok(Err(why)) => Err(early(error(StatusCode::INTERNAL_SERVER_ERROR, &why))),
            Err(fault) => Err(early(error(StatusCode::INTERNAL_SERVER_ERROR, &fault.to_string()))),
        }
    }
}

/// The id in a query.
fn asked_for(query: &str) -> Option<String> {
    let id = query.split('&').find_map(|pair| pair.strip_prefix("id="))?;
    percent_decode_str(id).decode_utf8().ok().map(std::borrow::Cow::into_owned)
}

/// The body of a request, which must be JSON.
async fn body(request: Request<Incoming>) -> Early<Bytes> {
    let kind = request.headers().get(CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    let kind = kind.split(';').next().unwrap_or_default().trim();
    if !kind.eq_ignore_ascii_case("application/json") {
        return Err(early(error(StatusCode::UNSUPPORTED_MEDIA_TYPE, "application/json is expected")));
    }
    let too_large = || early(error(StatusCode::PAYLOAD_TOO_LARGE, &format!("at most {LARGEST} bytes are expected")));
    if request.body().size_hint().lower() > LARGEST as u64 {
        return Err(too_large());
    }
    match tokio::time::timeout(BODY_TIME, Limited::new(request.into_body(), LARGEST).collect()).await {
        Ok(Ok(body)) => Ok(body.to_bytes()),
        Ok(Err(fault)) if fault.is::<LengthLimitError>() => Err(too_large()),
        Ok(Err(fault)) => Err(early(error(StatusCode::BAD_REQUEST, &fault.to_string()))),
        Err(_) => Err(early(empty(StatusCode::REQUEST_TIMEOUT))),
    }
}

/// What a body says.
fn said<T: DeserializeOwned>(body: &[u8]) -> Early<T> {
    serde_json::from_slice(body).map_err(|fault| early(error(StatusCode::BAD_REQUEST, &fault.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::page::tests::named;

    #[test]
    fn the_page_is_made_from_its_sources() {
        let sources = named("src/edit/page", &["src/view/page", "src/explain/page"]);
        assert!(TEMPLATE.contains(&sources), "the page is stale: run `make page`");
        for place in ["<!--gable:name-->", "<!--gable:payload-->"] {
            assert_eq!(TEMPLATE.matches(place).count(), 1, "{place}");
        }
    }
}
