//! Who is answered, and what else comes with an answer.

use super::bench::*;

#[test]
fn whoever_does_not_know_the_secret_gets_nothing() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let (host, secret) = (format!("Host: 127.0.0.1:{}\r\n", server.port), &server.secret);
    let wrong = [
        "/".to_owned(),
        "/api/model".to_owned(),
        format!("/{}/api/model", secret.to_uppercase()),
        format!("/{}/api/model", &secret[..secret.len() - 1]),
        format!("/{secret}0/"),
        format!("/x/{secret}/"),
        format!("//{secret}/"),
        format!("/{}/", "0".repeat(secret.len())),
        format!("/?{secret}"),
        "/favicon.ico".to_owned(),
    ];
    for path in &wrong {
        let answer = server.ask(&format!("GET {path} HTTP/1.1\r\n{host}Connection: close\r\n\r\n"));
        assert_eq!((answer.status, answer.body.len()), (404, 0), "{path}");
        assert!(!answer.headers.contains(secret.as_str()));
    }
    let page = server.get("");
    assert_eq!(page.status, 200);
    let html = String::from_utf8(page.body).unwrap();
    assert!(html.contains("city.city.json") && !html.contains(secret.as_str()) && !html.contains("<!--gable:"));
    // It listens to this machine alone.
    for other in ["127.0.0.2", "::1"] {
        let other: std::net::IpAddr = other.parse().unwrap();
        assert!(std::net::TcpStream::connect((other, server.port)).is_err(), "{other}");
    }
    // Each start has another.
    assert_ne!(bench.serve(&[]).secret, server.secret);
}

#[test]
fn other_sites_and_other_names_get_nothing() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let (port, secret) = (server.port, &server.secret);
    let line = format!("GET /{secret}/api/model HTTP/1.1\r\nConnection: close\r\n");
    let own = format!("Host: 127.0.0.1:{port}\r\n");
    for right in
        [own.clone(), format!("Host: localhost:{port}\r\n"), format!("{own}Origin: http://127.0.0.1:{port}\r\n")]
    {
        assert_eq!(server.ask(&format!("{line}{right}\r\n")).status, 200, "{right}");
    }
    for wrong in [
        format!("Host: gable.example:{port}\r\n"),
        "Host: 127.0.0.1\r\n".to_owned(),
        format!("{own}Origin: http://gable.example\r\n"),
        format!("{own}Origin: null\r\n"),
        format!("{own}Origin: http://127.0.0.1:1\r\n"),
        format!("{own}Sec-Fetch-Site: cross-site\r\n"),
        format!("{own}Host: gable.example\r\n"),
        String::new(),
    ] {
        let answer = server.ask(&format!("{line}{wrong}\r\n"));
        assert!([400, 403].contains(&answer.status) && answer.body.is_empty(), "{wrong}: {answer:?}");
        assert!(!answer.headers.contains("access-control"), "{answer:?}");
    }
    // What a browser asks before it sends another site's request.
    let preflight = server.head("OPTIONS", "api/edit")
        + "Origin: http://gable.example\r\nAccess-Control-Request-Method: POST\r\n\r\n";
    let answer = server.ask(&preflight);
    assert!(answer.status == 403 && !answer.headers.contains("access-control"), "{answer:?}");
    // A form of another site needs no leave, and is of another type.
    let form = server.head("POST", "api/state") + "Content-Type: text/plain\r\nContent-Length: 2\r\n\r\n{}";
    assert_eq!(server.ask(&form).status, 415);
}

#[test]
fn answers_are_kept_by_nobody_and_shown_in_no_frame() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    for (path, policy) in [("", "connect-src 'self'"), ("api/model", "default-src 'none'"), ("nothing", "")] {
        let headers = server.get(path).headers;
        for header in [
            "cache-control: no-store",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
            "frame-ancestors 'none'",
            policy,
        ] {
            assert!(headers.contains(header), "{path}: {header} in {headers}");
        }
    }
}

#[test]
fn methods_and_paths_are_what_they_are() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let put = |method: &str, path: &str| server.ask(&(server.head(method, path) + "Content-Length: 0\r\n\r\n"));
    for (method, path, status) in [
        ("POST", "", 405),
        ("DELETE", "api/model", 405),
        ("GET", "api/edit", 405),
        ("PUT", "api/edit", 405),
        ("GET", "api/", 404),
        ("GET", "api/model/", 404),
        ("GET", "../api/model", 404),
        ("GET", "%61pi/model", 404),
        ("POST", "api/export", 415),
    ] {
        assert_eq!(put(method, path).status, status, "{method} {path}");
    }
    assert!(put("GET", "api/undo").headers.contains("allow: post"));
}
