//! A model of three buildings of the quick start, the server that mends it, and a client.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::DeflateDecoder;
use serde_json::{Value, json};
use tempfile::TempDir;

pub use crate::bench::{Run, assert_says, command, data};

pub const HOUSE: &str = "NL.IMBAG.Pand.0503100000017310";
/// The options of the run, beside its tiles and footprints.
pub const OPTIONS: [&str; 4] = [
    "--field",
    "height-field",
    "--filter",
    "id >= 'NL.IMBAG.Pand.0503100000017308' AND id <= 'NL.IMBAG.Pand.0503100000017312'",
];

/// Makes a model as the bench has it.
pub fn reconstruct(output: &Path, rest: &[&str]) -> Run {
    let mut command = command(["reconstruct"]);
    command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).arg("-o").arg(output);
    command.args(OPTIONS).args(rest).output().unwrap().into()
}

/// A folder with a model in it.
pub struct Bench {
    pub folder: TempDir,
    pub model: PathBuf,
    pub edits: PathBuf,
}

impl Bench {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [model, edits] = ["city.city.json", "edits.json"].map(|name| folder.path().join(name));
        let run = reconstruct(&model, &[]);
        assert_eq!(run.code, 0, "{}", run.err);
        Self { folder, model, edits }
    }

    /// A server of the model; tiles, footprints and options are those of the run.
    pub fn serve(&self, rest: &[&str]) -> Server {
        Server::start(command(["edit"]).arg(&self.model).args(["--no-browser"]).args(rest))
    }

    /// What stands in the file of edits.
    pub fn written(&self) -> Value {
        serde_json::from_slice(&fs::read(&self.edits).unwrap()).unwrap()
    }

    /// `gable edit --export`.
    pub fn export(&self, name: &str) -> Vec<u8> {
        let output = self.folder.path().join(name);
        let run: Run = command(["edit"]).arg(&self.model).arg("--export").arg(&output).output().unwrap().into();
        assert_eq!(run.code, 0, "{}", run.err);
        fs::read(output).unwrap()
    }
}

/// A server that runs.
pub struct Server {
    pub child: Child,
    pub port: u16,
    pub secret: String,
}

impl Server {
    pub fn start(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut address).unwrap();
        let Some(rest) = address.trim().strip_prefix("http://127.0.0.1:") else {
            let _ = child.kill();
            panic!("{address:?}: {}", said(&mut child));
        };
        let (port, secret) = rest.split_once('/').unwrap();
        Self { child, port: port.parse().unwrap(), secret: secret.trim_end_matches('/').to_owned() }
    }

    /// The head of a request for a path after the secret.
    pub fn head(&self, method: &str, path: &str) -> String {
        format!("{method} /{}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n", self.secret, self.port)
    }

    /// Sends some bytes, and no more, and reads until the server has nothing more to say.
    pub fn end(&self, bytes: &[u8]) -> Answer {
        self.send(bytes, true)
    }

    fn send(&self, bytes: &[u8], ends: bool) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
        // It may have heard enough before all is said.
        let _ = stream.write_all(bytes);
        if ends {
            let _ = stream.shutdown(std::net::Shutdown::Write);
        }
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        Answer::of(&answer)
    }

    pub fn ask(&self, request: &str) -> Answer {
        self.send(request.as_bytes(), false)
    }

    pub fn get(&self, path: &str) -> Answer {
        self.ask(&(self.head("GET", path) + "\r\n"))
    }

    pub fn post(&self, path: &str, body: &Value) -> Answer {
        self.post_text(path, &body.to_string())
    }

    pub fn post_text(&self, path: &str, body: &str) -> Answer {
        let head = self.head("POST", path);
        self.ask(&format!("{head}Content-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}", body.len()))
    }

    /// A building: the head of it.
    pub fn building(&self, id: &str) -> Value {
        self.get(&format!("api/building?id={id}")).head()
    }

    /// Does an edit of the house as it is.
    pub fn edit(&self, revision: &Value, action: &Value) -> Answer {
        self.post("api/edit", &json!({ "id": HOUSE, "revision": revision, "action": action }))
    }

    /// Undoes, redoes or clears edits of the house.
    pub fn turn(&self, way: &str, revision: &Value) -> Answer {
        self.post(&format!("api/{way}"), &json!({ "id": HOUSE, "revision": revision }))
    }

    pub fn decide(&self, id: &str, state: &str) -> Answer {
        self.post("api/state", &json!({ "id": id, "state": state }))
    }

    /// The row of a building in the list.
    pub fn row(&self, id: &str) -> Value {
        let list = self.get("api/model").json();
        list["buildings"].as_array().unwrap().iter().find(|row| row["id"] == id).unwrap().clone()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a process has said on standard error.
pub fn said(child: &mut Child) -> String {
    let mut text = String::new();
    if let Some(mut stream) = child.stderr.take() {
        let _ = stream.read_to_string(&mut text);
    }
    text
}

/// An answer.
#[derive(Debug)]
pub struct Answer {
    /// 0 where there is none.
    pub status: u16,
    pub headers: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn of(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").map_or(bytes.len(), |at| at + 4);
        let headers = String::from_utf8_lossy(&bytes[..end]).into_owned();
        let status = headers.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        Self { status, headers: headers.to_lowercase(), body: bytes[end..].to_vec() }
    }

    pub fn json(&self) -> Value {
        assert_eq!(self.status, 200, "{} {}", self.headers, String::from_utf8_lossy(&self.body));
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Why it was refused.
    pub fn error(&self) -> String {
        let body: Value = serde_json::from_slice(&self.body).unwrap();
        body["error"].as_str().unwrap().to_owned()
    }

    fn unpacked(&self) -> (Value, Vec<u8>) {
        assert_eq!(self.status, 200, "{} {}", self.headers, String::from_utf8_lossy(&self.body));
        let mut bytes = Vec::new();
        DeflateDecoder::new(&STANDARD.decode(&self.body).unwrap()[..]).read_to_end(&mut bytes).unwrap();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        (serde_json::from_slice(&bytes[4..4 + length]).unwrap(), bytes[4 + length..].to_vec())
    }

    /// The head of a building.
    pub fn head(&self) -> Value {
        self.unpacked().0
    }

    /// The numbers of a column of a building.
    pub fn column(&self, name: &str) -> Vec<u64> {
        let (head, bytes) = self.unpacked();
        let mut at = 0;
        for column in head["columns"].as_array().unwrap() {
            let size = column[1].as_u64().unwrap() as usize;
            if column[0] == name {
                return numbers(&bytes[at..at + size]);
            }
            at += size;
        }
        panic!("no column {name}");
    }
}

fn numbers(bytes: &[u8]) -> Vec<u64> {
    let (mut numbers, mut number, mut shift) = (Vec::new(), 0, 0);
    for byte in bytes {
        number |= u64::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            numbers.push(number);
            (number, shift) = (0, 0);
        }
    }
    numbers
}
