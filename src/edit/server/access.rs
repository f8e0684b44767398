//! Whose requests are answered.

use std::fmt::Write;

use hyper::header::{HOST, HeaderMap, HeaderValue, ORIGIN};

use crate::error::{Error, Result};

/// Bytes of the secret in the address.
const SECRET: usize = 24;

/// The address of the page, and what a request must have to be answered.
#[derive(Debug, Clone)]
pub(super) struct Access {
    port: u16,
    secret: String,
}

impl Access {
    /// On a port, with a new secret.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn new(port: u16) -> Result<Self> {
        let mut bytes = [0; SECRET];
        getrandom::fill(&mut bytes)
            .map_err(|fault| Error::io("random numbers", "get", std::io::Error::other(fault.to_string())))?;
        let secret = bytes.iter().fold(String::new(), |mut secret, byte| {
            // Writing to memory does not fail.
            let _ = write!(secret, "{byte:02x}");
            secret
        });
        Ok(Self { port, secret })
    }

    /// Where it listens.
    pub fn place(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.place(), self.secret)
    }

    /// What of a path comes after the secret; `None` where it has another.
    pub fn inner<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (secret, rest) = path.strip_prefix('/')?.split_once('/')?;
        // However much of it is right, that takes as long.
        let differs = secret.bytes().zip(self.secret.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b));
        (secret.len() == self.secret.len() && differs == 0).then_some(rest)
    }

    /// Whether a request came by a name of this machine, and from no other site.
    pub fn is_own(&self, headers: &HeaderMap) -> bool {
        let hosts = [self.place(), format!("localhost:{}", self.port)];
        let only = |mut values: hyper::header::GetAll<'_, HeaderValue>| {
            let mut values = values_of(&mut values);
            values.next().filter(|_| values.next().is_none())
        };
        let Some(host) = only(headers.get_all(HOST)).filter(|host| hosts.iter().any(|own| own == host)) else {
            return false;
        };
        let is_from_here = match headers.get_all(ORIGIN).iter().count() {
            0 => true,
            _ => only(headers.get_all(ORIGIN)).is_some_and(|origin| origin == format!("http://{host}")),
        };
        // What browsers say of where a request comes from; `none` is a person.
        let sites = headers.get_all("sec-fetch-site");
        is_from_here && sites.iter().all(|site| site == "same-origin" || site == "none")
    }
}

fn values_of<'a>(values: &mut hyper::header::GetAll<'a, HeaderValue>) -> impl Iterator<Item = String> + use<'a> {
    values.iter().map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(*name, HeaderValue::from_str(value).unwrap());
        }
        headers
    }

    #[test]
    fn the_secret_is_long_new_and_asked_for_whole() {
        let [one, other] = [(); 2].map(|()| Access::new(80).unwrap());
        assert!(one.secret.len() == 48 && one.secret != other.secret);
        let path = |secret: &str| format!("/{secret}/api/model");
        assert_eq!(one.inner(&path(&one.secret)), Some("api/model"));
        assert_eq!(one.inner(&format!("/{}/", one.secret)), Some(""));
        let (short, long) = (&one.secret[..47], format!("{}0", one.secret));
        for wrong in [&path(&other.secret), &path(short), &path(&long), &path(""), "", "/", "//", &one.secret] {
            assert_eq!(one.inner(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn only_this_machine_and_this_page_are_answered() {
        let access = Access::new(8123).unwrap();
        let own = |pairs: &[(&'static str, &str)]| access.is_own(&headers(pairs));
        let host = ("host", "127.0.0.1:8123");
        assert!(own(&[host]) && own(&[("host", "localhost:8123")]));
        assert!(own(&[host, ("origin", "http://127.0.0.1:8123"), ("sec-fetch-site", "same-origin")]));
        assert!(own(&[host, ("sec-fetch-site", "none")]));
        for others in [
            &[][..],
            &[("host", "127.0.0.1")],
            &[("host", "127.0.0.1:80")],
            &[("host", "evil.example:8123")],
            &[host, host],
            &[host, ("origin", "null")],
            &[host, ("origin", "http://evil.example")],
            &[host, ("origin", "https://127.0.0.1:8123")],
            &[host, ("origin", "http://localhost:8123")],
            &[host, ("origin", "http://127.0.0.1:8123"), ("origin", "http://evil.example")],
            &[host, ("sec-fetch-site", "cross-site")],
            &[host, ("sec-fetch-site", "same-site")],
        ] {
            assert!(!own(others), "{others:?}");
        }
    }
}
