//! A server that speaks the protocol of S3: names, lists, and what is written there.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;

use tempfile::tempdir;

use super::web::folder_with_copc;
use crate::bench::*;

/// Host and port of the server; `None`, and a line that says so, where there is none.
fn endpoint() -> Option<String> {
    let endpoint = std::env::var("GABLE_S3_ENDPOINT").ok();
    if endpoint.is_none() {
        println!("skipped: no server that speaks the protocol of S3; scripts/test-remote.sh starts one");
    }
    endpoint
}

/// A request without a library: status and body.
fn ask(endpoint: &str, method: &str, target: &str, body: &[u8]) -> (u16, Vec<u8>) {
    let mut stream = TcpStream::connect(endpoint).unwrap();
    let length = body.len();
    // The server of the tests takes a signature for what it says.
    let credential =
        "AWS4-HMAC-SHA256 Credential=test/20230102/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=x";
    write!(
        stream,
        "{method} {target} HTTP/1.1\r\nhost: {endpoint}\r\nauthorization: {credential}\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n"
    )
    .unwrap();
    stream.write_all(body).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|window| window == b"\r\n\r\n").unwrap() + 4;
    let status = String::from_utf8_lossy(&answer[9..12]).parse().unwrap();
    (status, answer[end..].to_vec())
}

/// A bucket of this test, and the command with what it takes to reach it.
struct Bucket {
    endpoint: String,
    name: &'static str,
}

impl Bucket {
    fn new(name: &'static str) -> Option<Self> {
        let endpoint = endpoint()?;
        assert_eq!(ask(&endpoint, "PUT", &format!("/{name}"), b"").0, 200);
        Some(Self { endpoint, name })
    }

    fn put(&self, key: &str, file: &Path) {
        let (status, _) = ask(&self.endpoint, "PUT", &format!("/{}/{key}", self.name), &std::fs::read(file).unwrap());
        assert_eq!(status, 200, "{key}");
    }

    fn get(&self, key: &str) -> Option<Vec<u8>> {
        let (status, body) = ask(&self.endpoint, "GET", &format!("/{}/{key}", self.name), b"");
        (status == 200).then_some(body)
    }

    fn keys(&self) -> String {
        String::from_utf8(ask(&self.endpoint, "GET", &format!("/{}?list-type=2", self.name), b"").1).unwrap()
    }

    fn uploads(&self) -> String {
        String::from_utf8(ask(&self.endpoint, "GET", &format!("/{}?uploads", self.name), b"").1).unwrap()
    }

    fn command(&self, words: &str) -> Command {
        let words = words.replace("BUCKET", &format!("s3://{}", self.name));
        let mut command = command(words.split_whitespace());
        command.env("AWS_ENDPOINT_URL", format!("http://{}", self.endpoint)).env("AWS_ALLOW_HTTP", "true");
        command.env("AWS_ACCESS_KEY_ID", "test").env("AWS_SECRET_ACCESS_KEY", "hunter2").env("AWS_REGION", "us-east-1");
        command
    }

    fn run(&self, folder: &Path, words: &str) -> Run {
        let run: Run = self.command(words).current_dir(folder).output().unwrap().into();
        assert!(!run.err.contains("hunter2") && !run.out.contains("hunter2"), "{}", run.err);
        run
    }
}

#[test]
fn from_and_to_a_bucket_the_same_bytes_come_out_as_from_files() {
    let Some(bucket) = Bucket::new("city") else { return };
    let folder = folder_with_copc();
    let here = tempdir().unwrap();
    let local = folder.path().join("local.city.json");
    let copc = folder.path().join("delft.copc.laz");
    assert_eq!(reconstruct(&[&copc], &folder.path().join("footprints.geojson"), &local, "").code, 0);
    let expected = std::fs::read(&local).unwrap();
    bucket.put("tiles/delft.copc.laz", &copc);
    bucket.put("tiles/readme.txt", &folder.path().join("footprints.geojson"));
    bucket.put("tiles/deep/er/delft.copc.laz", &copc);
    bucket.put("footprints.geojson", &folder.path().join("footprints.geojson"));
    let names = ["BUCKET/tiles/", "BUCKET/tiles/*.laz", "BUCKET/**/er/*.laz", "BUCKET/tiles/delft.copc.laz"];
    for (number, tiles) in names.into_iter().enumerate() {
        let words = format!("reconstruct {tiles} -f BUCKET/footprints.geojson -o BUCKET/out/{number}.city.json");
        let run = bucket.run(here.path(), &words);
        assert_eq!(run.code, 0, "{tiles}: {}", run.err);
        assert!(bucket.get(&format!("out/{number}.city.json")).unwrap() == expected, "{tiles}");
        let report = bucket.get(&format!("out/{number}.city.json.report.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(report["outputs"][0], format!("s3://city/out/{number}.city.json"));
        assert_eq!(report["inputs"]["tiles"].as_array().unwrap().len(), 1);
        assert!(names_in(here.path()).is_empty(), "nothing is left here: {:?}", names_in(here.path()));
    }
    // What is there is not replaced unless it may be.
    let words = "reconstruct BUCKET/tiles/ -f BUCKET/footprints.geojson -o BUCKET/out/0.city.json";
    let run = bucket.run(here.path(), words);
    assert_ends(&run, 1, &["s3://city/out/0.city.json", "an object of that name", "--overwrite"]);
    assert_eq!(bucket.run(here.path(), &format!("{words} --overwrite")).code, 0);
    let run = bucket.run(here.path(), "info BUCKET/tiles/ BUCKET/footprints.geojson");
    assert_eq!(run.code, 0, "{}", run.err);
    for (words, says) in [
        ("info BUCKET/none/", "below which there is no"),
        ("info BUCKET/none/*.laz", "a pattern that matches no"),
        ("info BUCKET/none.laz", "no such object"),
        ("info s3://nobody/none.laz", "no such object"),
        ("info s3:///none.laz", "no bucket"),
        ("info BUCKET//none.laz", "Keys have no empty parts"),
    ] {
        assert_ends(&bucket.run(here.path(), words), 1, &[says, "s3://"]);
    }
}

#[test]
fn every_format_goes_to_a_bucket_and_folders_when_they_are_whole() {
    let Some(bucket) = Bucket::new("formats") else { return };
    let here = tempdir().unwrap();
    let (tile, footprints) = (data("delft_ahn3.laz"), data("footprints.geojson"));
    let run = |out: &str, rest: &str| {
        let words = format!("reconstruct {} -f {} -o {out} {rest}", tile.display(), footprints.display());
        bucket.run(here.path(), &words)
    };
    for out in ["a.city.jsonl", "a.gpkg", "a.obj", "a.3dtiles"] {
        let local = run(out, "");
        let remote = run(&format!("BUCKET/x/{out}"), "");
        assert_eq!((local.code, remote.code), (0, 0), "{out}: {}{}", local.err, remote.err);
    }
    for file in ["a.city.jsonl", "a.obj", "a.gpkg", "a.3dtiles/tileset.json"] {
        let local = std::fs::read(here.path().join(file)).unwrap();
        assert!(bucket.get(&format!("x/{file}")).unwrap() == local, "{file}");
    }
    // A folder of that name is replaced, and nothing of it is left; something else is not.
    bucket.put("x/a.3dtiles/old.glb", &footprints);
    assert_ends(&run("BUCKET/x/a.3dtiles", ""), 1, &["--overwrite"]);
    let again = run("BUCKET/x/a.3dtiles", "--overwrite");
    assert_eq!(again.code, 0, "{}", again.err);
    assert!(bucket.get("x/a.3dtiles/old.glb").is_none() && bucket.get("x/a.3dtiles/tileset.json").is_some());
    bucket.put("y.3dtiles/mine.txt", &footprints);
    assert_ends(&run("BUCKET/y.3dtiles", "--overwrite"), 1, &["without a tileset.json"]);
    let many = run("BUCKET/many/{tile}.city.json", "");
    assert_eq!(many.code, 0, "{}", many.err);
    assert_says(&bucket.keys(), &["many/delft_ahn3.city.json", "many/gable.report.json"]);
    let named = run("BUCKET/named/", "--view");
    assert_eq!(named.code, 0, "{}", named.err);
    assert_says(&bucket.keys(), &["named/delft_ahn3.city.json", "named/delft_ahn3.html"]);
    let left: Vec<String> = names_in(here.path()).into_iter().filter(|name| name.ends_with(".partial")).collect();
    assert!(left.is_empty(), "{left:?}");
    assert!(!bucket.uploads().contains("<Upload>"), "no part is left behind");
}

#[test]
fn a_run_that_is_killed_goes_on_from_the_folder_that_it_was_started_in() {
    let Some(bucket) = Bucket::new("killed") else { return };
    let here = tempdir().unwrap();
    let words = format!(
        "reconstruct {} -f {} -o BUCKET/a.city.json --jobs 1",
        data("delft_ahn3.laz").display(),
        data("footprints.geojson").display()
    );
    let mut child = bucket.command(&words).current_dir(here.path()).spawn().unwrap();
    let checkpoint = here.path().join("a.city.json.partial/buildings.jsonl");
    while child.try_wait().unwrap().is_none() {
        let done = std::fs::read_to_string(&checkpoint).map_or(0, |text| text.lines().count());
        if done > 3 {
            child.kill().unwrap();
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(checkpoint.is_file() && bucket.get("a.city.json").is_none(), "it was killed in time");
    let run = bucket.run(here.path(), &words);
    assert_ends(&run, 1, &["a.city.json.partial", "--resume"]);
    let run = bucket.run(here.path(), &format!("{words} --resume"));
    assert_ends(&run, 0, &["a.city.json.partial", "are taken from there"]);
    let local = here.path().join("local.city.json");
    assert_eq!(delft(&local, "").code, 0);
    assert!(bucket.get("a.city.json").unwrap() == std::fs::read(local).unwrap());
    assert!(!checkpoint.exists());
}
