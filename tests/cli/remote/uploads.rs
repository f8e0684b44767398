//! Uploads that fail leave nothing behind; credentials are used, or not.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};

use tempfile::tempdir;

use super::server::{Answer, Server};
use super::web::folder_with_copc;
use crate::bench::*;

/// A bucket that begins uploads and takes no part of them but the first; method and target of all requests.
fn failing_bucket() -> (String, Arc<Mutex<Vec<String>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let log = Arc::new(Mutex::new(Vec::new()));
    let seen = log.clone();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let log = seen.clone();
            std::thread::spawn(move || while refuse(&stream, &log).is_some() {});
        }
    });
    (address, log)
}

fn refuse(stream: &TcpStream, log: &Mutex<Vec<String>>) -> Option<()> {
    let mut reader = BufReader::new(stream);
    let mut first = String::new();
    reader.read_line(&mut first).ok().filter(|read| *read > 0)?;
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).ok()?;
        let line = line.trim().to_ascii_lowercase();
        if line.is_empty() {
            break;
        }
        length = line.strip_prefix("content-length:").map_or(length, |text| text.trim().parse().unwrap());
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    log.lock().unwrap().push(first.split(" HTTP").next().unwrap().to_owned());
    let begun = "<InitiateMultipartUploadResult><Bucket>b</Bucket><Key>k</Key><UploadId>u1</UploadId>\
                 </InitiateMultipartUploadResult>";
    let listed = "<ListBucketResult><Name>b</Name><KeyCount>0</KeyCount></ListBucketResult>";
    let (status, body) = match first.as_str() {
        first if first.starts_with("POST") && first.contains("uploads") => ("200 OK", begun),
        first if first.starts_with("PUT") && first.contains("partNumber=1&") => ("200 OK\r\netag: \"1\"", ""),
        first if first.starts_with("DELETE") => ("204 No Content", ""),
        first if first.starts_with("GET") => ("200 OK", listed),
        first if first.starts_with("HEAD") => ("404 Not Found", ""),
        _ => ("500 Internal Server Error", ""),
    };
    let mut out = stream;
    write!(out, "HTTP/1.1 {status}\r\ncontent-length: {}\r\n\r\n{body}", body.len()).ok()
}

#[test]
fn an_upload_that_fails_is_taken_back_and_the_buildings_are_kept() {
    let (address, log) = failing_bucket();
    let here = tempdir().unwrap();
    let mut command = command(["reconstruct"]);
    // Each building eight times is more than one part.
    let mut layer = json_of(data("footprints.geojson"));
    let features = layer["features"].as_array_mut().unwrap();
    *features = features.iter().cycle().take(8 * features.len()).cloned().collect();
    std::fs::write(here.path().join("many.geojson"), layer.to_string()).unwrap();
    command.arg(data("delft_ahn3.laz")).args("-f many.geojson -o s3://b/a.gpkg".split_whitespace());
    command.env("AWS_ENDPOINT_URL", format!("http://{address}")).env("AWS_ALLOW_HTTP", "true").current_dir(here.path());
    command.env("AWS_ACCESS_KEY_ID", "test").env("AWS_SECRET_ACCESS_KEY", "hunter2").env("GABLE_REMOTE_RETRIES", "1");
    let run: Run = command.output().unwrap().into();
    assert_ends(&run, 1, &["s3://b/a.gpkg", "the server answers 500", "a.gpkg.partial", "--resume"]);
    let log = log.lock().unwrap().clone();
    assert!(log.iter().any(|request| request.starts_with("POST") && request.contains("uploads")), "{log:?}");
    assert!(log.iter().any(|request| request.starts_with("DELETE") && request.contains("uploadId=u1")), "{log:?}");
    assert!(!log.iter().any(|request| request.starts_with("POST") && request.contains("uploadId")), "{log:?}");
    assert_eq!(names_in(here.path()), ["a.gpkg.partial", "many.geojson"]);
    assert_eq!(names_in(&here.path().join("a.gpkg.partial")), ["buildings.jsonl"]);
}

#[test]
fn requests_are_signed_unless_that_is_not_wanted() {
    let folder = folder_with_copc();
    std::fs::create_dir(folder.path().join("b")).unwrap();
    std::fs::rename(folder.path().join("delft.copc.laz"), folder.path().join("b/delft.copc.laz")).unwrap();
    for (variable, is_signed) in [("NONE", true), ("AWS_NO_SIGN_REQUEST", false), ("AWS_SKIP_SIGNATURE", false)] {
        let server = Server::of(folder.path(), |_| Answer::Well);
        let mut command = command(["info", "s3://b/delft.copc.laz"]);
        command.env("AWS_ENDPOINT_URL", server.url("").trim_end_matches('/')).env("AWS_ALLOW_HTTP", "true");
        command.env("AWS_ACCESS_KEY_ID", "test").env("AWS_SECRET_ACCESS_KEY", "hunter2").env(variable, "true");
        let run: Run = command.output().unwrap().into();
        assert_eq!(run.code, 0, "{}", run.err);
        assert!(server.requests().iter().all(|request| request.is_signed == is_signed), "{variable}");
    }
}

#[test]
fn nothing_goes_to_a_web_server_and_no_cropped_points_to_a_bucket() {
    let run = delft(Path::new("https://localhost:1/a.city.json?sig=hunter2"), "");
    assert_ends(&run, 1, &["https://localhost:1/a.city.json", "s3://"]);
    assert!(!run.err.contains("hunter2"), "{}", run.err);
    let run = delft(Path::new("s3://b/points"), "--crop-only");
    assert_ends(&run, 1, &["--crop-only", "object storage"]);
}
