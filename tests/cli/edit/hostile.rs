//! Requests that are malformed, too large, too many or noise: none ends the server, changes anything or holds it up.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use gable::geometry::Random;
use serde_json::json;

use super::bench::*;

/// The largest body.
const LARGEST: usize = 4 << 20;

fn is_well(server: &Server) {
    assert_eq!(server.get("api/model").status, 200);
}

#[test]
fn bodies_that_are_no_requests_are_told_and_change_nothing() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let revision = server.building(HOUSE)["revision"].clone();
    for (path, body) in [
        ("api/edit", ""),
        ("api/edit", "{"),
        ("api/edit", "null"),
        ("api/edit", "[]"),
        ("api/edit", r#"{"id": 1}"#),
        ("api/edit", r#"{"id": "a", "revision": -1, "action": {"set-floor": {"height": 1}}}"#),
        ("api/edit", r#"{"id": "a", "revision": 1, "action": {"fly": {}}}"#),
        ("api/edit", r#"{"id": "a", "revision": 1, "action": {"set-floor": {"height": 1}}, "more": 1}"#),
        ("api/edit", r#"{"id": "a", "revision": 1, "action": {"set-floor": {"height": 1e999}}}"#),
        ("api/edit", "\u{0}\u{1}"),
        ("api/undo", r#"{"id": "a"}"#),
        ("api/state", r#"{"id": "a", "state": "finished"}"#),
        ("api/export", r#"{"path": "/etc/passwd"}"#),
    ] {
        let answer = server.post_text(path, body);
        assert_eq!(answer.status, 400, "{path} {body}: {answer:?}");
        assert!(!answer.error().is_empty());
    }
    let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    assert_eq!(server.post_text("api/edit", &deep).status, 400);
    for (path, body) in [
        ("api/undo", json!({ "id": "nobody", "revision": 1 })),
        ("api/state", json!({ "id": "nobody", "state": "accepted" })),
    ] {
        assert_eq!(server.post(path, &body).status, 404);
    }
    // Coordinates that are absurd are edits that do not apply.
    let far = json!({ "add-plane": { "places": [[1e300, 0, 0], [0, 1e300, 0], [0, 0, 1e300]] } });
    let now = server.edit(&revision, &far).head();
    assert_eq!((&now["edits"][0]["applied"], &now["now"]), (&json!(false), &now["before"]));
    let now = server.turn("undo", &now["revision"]).head();
    assert_eq!((&now["now"], &now["state"]), (&now["before"], &json!("open")));
}

#[test]
fn what_is_too_large_is_not_read() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let head = server.head("POST", "api/edit") + "Content-Type: application/json\r\n";
    // It says that it is, …
    let announced = server.ask(&format!("{head}Content-Length: {}\r\n\r\n{{", LARGEST + 1));
    assert_eq!(announced.status, 413);
    let absurd = server.ask(&format!("{head}Content-Length: 99999999999999999999\r\n\r\n{{"));
    assert_eq!(absurd.status, 400);
    // … or does not.
    let mut chunked = format!("{head}Transfer-Encoding: chunked\r\n\r\n").into_bytes();
    for _ in 0..=LARGEST / 65_536 {
        chunked.extend(b"10000\r\n");
        chunked.resize(chunked.len() + 65_536, b' ');
        chunked.extend(b"\r\n");
    }
    chunked.extend(b"0\r\n\r\n");
    assert!([0, 413].contains(&server.end(&chunked).status));
    let long = server.ask(&(server.head("GET", "api/model") + "X: " + &"x".repeat(200_000) + "\r\n\r\n"));
    assert!([0, 431].contains(&long.status), "{}", long.status);
    let many = "X: 1\r\n".repeat(500);
    assert_eq!(server.ask(&(server.head("GET", "api/model") + &many + "\r\n")).status, 431);
    is_well(&server);
    // The largest that is taken.
    let body = format!("{{\"id\": \"nobody\", \"revision\": 1{}}}", " ".repeat(LARGEST - 100));
    assert_eq!(server.post_text("api/undo", &body).status, 404);
}

#[test]
fn noise_ends_nothing() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let revision = server.building(HOUSE)["revision"].clone();
    let whole = {
        let body = json!({ "id": HOUSE, "revision": 0, "action": { "set-floor": { "height": 1.5 } } }).to_string();
        let head = server.head("POST", "api/edit");
        format!("{head}Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}", body.len()).into_bytes()
    };
    let mut random = Random::new(15);
    for round in 0..300 {
        let mut bytes = whole.clone();
        match round % 4 {
            // Bytes of any kind.
            0 => bytes = (0..random.below(600)).map(|_| random.below(256) as u8).collect(),
            // A request that is cut off.
            1 => bytes.truncate(random.below(whole.len())),
            // One with a few bytes that are others.
            2 => {
                for _ in 0..=random.below(8) {
                    let at = random.below(bytes.len());
                    bytes[at] = random.below(256) as u8;
                }
            }
            // One with a piece in it twice.
            _ => {
                let from = random.below(bytes.len());
                let piece = bytes[from..(from + random.below(40)).min(bytes.len())].to_vec();
                let at = random.below(bytes.len());
                bytes.splice(at..at, piece);
            }
        }
        let status = server.end(&bytes).status;
        assert_ne!(status, 500, "round {round}: {}", String::from_utf8_lossy(&bytes));
    }
    is_well(&server);
    assert_eq!(server.building(HOUSE)["revision"], revision);
    assert!(!bench.edits.exists());
}

#[test]
fn many_at_once_each_get_an_answer_and_one_of_them_is_first() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let revision = server.building(HOUSE)["revision"].clone();
    let edit = |i: usize| json!({ "set-floor": { "height": 0.1 * i as f64 } });
    let statuses: Vec<u16> = std::thread::scope(|scope| {
        let edits: Vec<_> = (0..12)
            .map(|i| {
                scope.spawn({
                    let (server, revision, action) = (&server, &revision, edit(i));
                    move || server.edit(revision, &action).status
                })
            })
            .collect();
        let lists: Vec<_> = (0..12).map(|_| scope.spawn(|| server.get("api/model").status)).collect();
        for list in lists {
            assert_eq!(list.join().unwrap(), 200);
        }
        edits.into_iter().map(|edit| edit.join().unwrap()).collect()
    });
    assert_eq!(statuses.iter().filter(|status| **status == 200).count(), 1, "{statuses:?}");
    assert_eq!(statuses.iter().filter(|status| **status == 409).count(), 11, "{statuses:?}");
    assert_eq!(bench.written()["buildings"][HOUSE]["edits"].as_array().unwrap().len(), 1);
}

#[test]
fn whoever_says_nothing_holds_up_nobody() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let mut idle: Vec<TcpStream> = (0..40).map(|_| TcpStream::connect(("127.0.0.1", server.port)).unwrap()).collect();
    for stream in &mut idle {
        stream.write_all(b"GET / HTTP/1.1\r\nHo").unwrap();
    }
    let started = Instant::now();
    is_well(&server);
    assert!(started.elapsed() < Duration::from_secs(5));
    // Of too many the last are sent away, and there is room again when some go.
    idle.extend((0..60).filter_map(|_| TcpStream::connect(("127.0.0.1", server.port)).ok()));
    std::thread::sleep(Duration::from_millis(300));
    idle.clear();
    let until = Instant::now() + Duration::from_secs(20);
    while server.get("api/model").status != 200 {
        assert!(Instant::now() < until);
        std::thread::sleep(Duration::from_millis(100));
    }
}
