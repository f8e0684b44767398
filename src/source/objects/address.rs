//! Addresses of objects: `s3://bucket/key`, `az://container/key`, `gs://bucket/key`, and `https://host/path` of a web server.
//!
//! Paths are what everything else knows, so an address is one too, as text. What may be a secret in it, the query of a signed
//! address and a login, is taken out as soon as it is named and kept here: no path that goes on from there holds it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

/// What stands for a secret.
const HIDDEN: &str = "***";

/// The addresses with secrets that were named, by what is shown of them.
static SECRETS: LazyLock<Mutex<HashMap<String, String>>> = LazyLock::new(Mutex::default);

/// Who keeps objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Service {
    /// Amazon S3, and whatever speaks its protocol.
    S3,
    /// Azure Blob Storage.
    Azure,
    /// Google Cloud Storage.
    Google,
    /// A web server.
    Web,
}

/// The beginnings of addresses.
const SCHEMES: [(&str, Service); 5] = [
    ("s3://", Service::S3),
    ("az://", Service::Azure),
    ("gs://", Service::Google),
    ("https://", Service::Web),
    ("http://", Service::Web),
];

/// The address of an object, or of all whose keys begin alike.
#[cfg(feature = "remote")]
#[derive(Debug, Clone)]
pub(super) struct Address {
    pub service: Service,
    /// The bucket or container; of a web server the host.
    pub container: String,
    /// What stands behind it, without the first separator.
    pub key: String,
    /// The address with its secrets.
    pub full: String,
}

#[cfg(feature = "remote")]
impl Address {
    /// The parts of an address; `None` where a path is none.
    pub fn of(path: &Path) -> Option<Self> {
        let shown = label(path);
        let shown = shown.to_str()?;
        let (service, _, rest) = parts(shown)?;
        let (container, key) = rest.split_once('/').unwrap_or((rest, ""));
        let full = SECRETS.lock().unwrap_or_else(PoisonError::into_inner).get(shown).cloned();
        let full = full.unwrap_or_else(|| shown.to_owned());
        Some(Self { service, container: container.to_owned(), key: key.to_owned(), full })
    }
}

/// The service that a text is an address at, its scheme, and what follows that.
fn parts(text: &str) -> Option<(Service, &str, &str)> {
    SCHEMES.into_iter().find_map(|(scheme, service)| {
        let (start, rest) = text.split_at_checked(scheme.len())?;
        start.eq_ignore_ascii_case(scheme).then_some((service, start, rest))
    })
}

/// Whether a path is the address of an object.
pub(crate) fn is_object(path: &Path) -> bool {
    path.to_str().is_some_and(|text| parts(text).is_some())
}

/// Whether a path is an address at a web server, which can neither list what it has nor take anything.
pub(crate) fn is_web(path: &Path) -> bool {
    path.to_str().and_then(parts).is_some_and(|(service, ..)| service == Service::Web)
}

/// The address without what may be a secret, as messages and reports show it and as all else knows it; another path as it is.
/// Addresses that differ in their queries alone are numbered.
pub(crate) fn label(path: &Path) -> PathBuf {
    let Some(text) = path.to_str() else { return path.to_path_buf() };
    let Some((Service::Web, scheme, rest)) = parts(text) else { return path.to_path_buf() };
    let place = rest.split(['?', '#']).next().unwrap_or(rest);
    let host_ends = place.find('/').unwrap_or(place.len());
    let public = place[..host_ends].rfind('@').map_or(place, |at| &place[at + 1..]);
    let shown = format!("{scheme}{public}");
    if place.len() == rest.len() && public.len() == place.len() {
        return path.to_path_buf();
    }
    let mut known = SECRETS.lock().unwrap_or_else(PoisonError::into_inner);
    for number in 1.. {
        let name = if number == 1 { shown.clone() } else { format!("{shown}#{number}") };
        // What is numbered already comes back by its number.
        if name == text {
            return path.to_path_buf();
        }
        if known.entry(name.clone()).or_insert_with(|| text.to_owned()) == text {
            return PathBuf::from(name);
        }
    }
    PathBuf::from(shown)
}

/// What a reference in the file `base` means: itself where it is an address or an absolute path, else a place relative to
/// the folder of that file.
pub(crate) fn resolved(reference: &str, base: &Path) -> PathBuf {
    let reference = reference.strip_prefix("file://").unwrap_or(reference);
    if parts(reference).is_some() || (Path::new(reference).is_absolute() && !is_object(base)) {
        return PathBuf::from(reference);
    }
    let Some((scheme, rest)) = base.to_str().and_then(|text| parts(text).map(|(_, scheme, rest)| (scheme, rest)))
    else {
        return base.parent().unwrap_or_else(|| Path::new("")).join(reference);
    };
    let (container, key) = rest.split_once('/').unwrap_or((rest, ""));
    let mut folders: Vec<&str> = if reference.starts_with('/') { Vec::new() } else { key.split('/').collect() };
    folders.pop();
    for part in reference.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(folders.pop()),
            part => folders.push(part),
        }
    }
    PathBuf::from(format!("{scheme}{container}/{}", folders.join("/")))
}

/// A text with the logins and the queries of the web addresses in it replaced by `***`.
pub(crate) fn redacted(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("://") {
        let (before, after) = rest.split_at(at + "://".len());
        out.push_str(before);
        rest = after;
        let scheme = before[..at].rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        if !["http", "https"].iter().any(|web| scheme.eq_ignore_ascii_case(web)) {
            continue;
        }
        let end = after.find(|c: char| c.is_whitespace() || c == '"' || c == '\'').unwrap_or(after.len());
        let (address, behind) = after.split_at(end);
        let (place, query) = address.split_once('?').map_or((address, None), |(place, query)| (place, Some(query)));
        let host_ends = place.find('/').unwrap_or(place.len());
        match place[..host_ends].rfind('@') {
            Some(login) => out.extend([HIDDEN, &place[login..]]),
            None => out.push_str(place),
        }
        if query.is_some_and(|query| !query.is_empty()) {
            out.extend(["?", HIDDEN]);
        }
        rest = behind;
    }
    out + rest
}

#[cfg(all(test, feature = "remote"))]
mod tests {
    use super::*;

    #[test]
    fn secrets_of_addresses_are_known_here_alone() {
        let signed = "https://me:pw@h.example:8443/a/t.copc.laz?X-Amz-Signature=abc";
        let shown = label(Path::new(signed));
        assert_eq!(shown, Path::new("https://h.example:8443/a/t.copc.laz"));
        assert_eq!(shown.extension().unwrap(), "laz");
        let address = Address::of(&shown).unwrap();
        assert_eq!((address.full.as_str(), address.container.as_str()), (signed, "h.example:8443"));
        assert_eq!(label(&shown), shown);
        let [one, two] = ["https://q.example/get?t=1", "https://q.example/get?t=2"].map(|text| label(Path::new(text)));
        assert_eq!(
            (one.to_str().unwrap(), two.to_str().unwrap()),
            ("https://q.example/get", "https://q.example/get#2")
        );
        assert_eq!(Address::of(&two).unwrap().full, "https://q.example/get?t=2");
        assert_eq!(label(Path::new("https://q.example/get?t=2")), two);
        let key = Path::new("s3://bucket/what?.laz");
        assert_eq!(label(key), key, "a question mark may be part of a key");
        assert_eq!(Address::of(key).unwrap().key, "what?.laz");
        assert!(!is_object(Path::new("tiles/a.laz")) && !is_object(Path::new("s3:/a")));
    }

    #[test]
    fn texts_are_shown_without_secrets() {
        let cases = [
            ("GET https://h/a.laz?sig=x%2Fy&se=1 failed", "GET https://h/a.laz?*** failed"),
            ("--cloud=A=HTTPS://u:p@h/a.laz,date=2020", "--cloud=A=HTTPS://***@h/a.laz,date=2020"),
            ("{\"f\":\"https://h/a?t=1\",\"x\":1}", "{\"f\":\"https://h/a?***\",\"x\":1}"),
            ("s3://b/a?b https://h/@a", "s3://b/a?b https://h/@a"),
        ];
        for (text, expected) in cases {
            assert_eq!(redacted(text), expected);
        }
    }

    #[test]
    fn references_are_relative_to_the_file_that_they_stand_in() {
        let of = |reference: &str, base: &str| resolved(reference, Path::new(base)).to_string_lossy().into_owned();
        assert_eq!(of("../t/a.laz", "https://h/x/y/items.json"), "https://h/x/t/a.laz");
        assert_eq!(of("./a.laz", "s3://b/items.json"), "s3://b/a.laz");
        assert_eq!(of("/a.laz", "https://h/x/items.json"), "https://h/a.laz");
        assert_eq!(of("s3://c/a.laz", "items.json"), "s3://c/a.laz");
        assert_eq!(of("a.laz", "in/items.json"), "in/a.laz");
        assert_eq!(of("/data/a.laz", "in/items.json"), "/data/a.laz");
    }
}
