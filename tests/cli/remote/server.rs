//! A web server with ranges and entity tags, which fails as it is told to.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A request that was answered.
#[derive(Debug, Clone)]
pub struct Request {
    pub method: String,
    /// With the query, without the first separator.
    pub target: String,
    /// Whether it was signed.
    pub is_signed: bool,
    /// Its place among the requests for the same file, from 0.
    pub number: usize,
    /// Bytes of the body that was sent.
    pub sent: usize,
}

impl Request {
    /// The file that it asks for.
    pub fn file(&self) -> &str {
        self.target.split('?').next().unwrap_or_default()
    }
}

/// How a request is answered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// As it should be.
    Well,
    /// The tag of the file is another.
    Changed,
    /// Without a tag.
    Untagged,
    /// All of the file, whatever range was asked for.
    Whole,
    /// With this status and no file.
    Status(u16),
    /// The connection is closed before a word is said.
    Cut,
    /// Half of the body, then the connection is closed.
    Half,
    /// Nothing, for longer than anyone waits.
    Silent,
}

type Behaviour = dyn Fn(&Request) -> Answer + Send + Sync;

/// The server; it serves until the test ends.
pub struct Server {
    address: SocketAddr,
    log: Arc<Mutex<Vec<Request>>>,
}

impl Server {
    /// Serves the files of a folder.
    pub fn of(folder: &Path, behaviour: impl Fn(&Request) -> Answer + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let log = Arc::new(Mutex::new(Vec::new()));
        let (folder, behaviour): (PathBuf, Arc<Behaviour>) = (folder.to_path_buf(), Arc::new(behaviour));
        let seen = log.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (folder, behaviour, log) = (folder.clone(), behaviour.clone(), seen.clone());
                std::thread::spawn(move || while answer(&stream, &folder, &*behaviour, &log).is_some() {});
            }
        });
        Self { address, log }
    }

    /// The address of a file.
    pub fn url(&self, name: &str) -> String {
        format!("http://{}/{name}", self.address)
    }

    /// What was asked for until now.
    pub fn requests(&self) -> Vec<Request> {
        self.log.lock().unwrap().clone()
    }

    /// Bytes that were sent of each file.
    pub fn sent(&self) -> HashMap<String, usize> {
        let mut sent = HashMap::new();
        for request in self.requests() {
            *sent.entry(request.file().to_owned()).or_default() += request.sent;
        }
        sent
    }
}

/// Answers one request; `None` when the connection is over.
fn answer(stream: &TcpStream, folder: &Path, behaviour: &Behaviour, log: &Mutex<Vec<Request>>) -> Option<()> {
    let mut reader = BufReader::new(stream);
    let mut line = String::new();
    reader.read_line(&mut line).ok().filter(|read| *read > 0)?;
    let mut words = line.split_whitespace();
    let (method, target) = (words.next()?.to_owned(), words.next()?.trim_start_matches('/').to_owned());
    let mut headers = HashMap::new();
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).ok().filter(|read| *read > 0)?;
        let Some((name, value)) = line.trim().split_once(':') else { break };
        headers.insert(name.to_ascii_lowercase(), value.trim().to_owned());
    }
    let length: usize = headers.get("content-length").and_then(|length| length.parse().ok()).unwrap_or(0);
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    let mut request = Request { method, target, is_signed: headers.contains_key("authorization"), number: 0, sent: 0 };
    let answer = {
        let mut log = log.lock().unwrap();
        request.number = log.iter().filter(|other| other.file() == request.file()).count();
        log.push(request.clone());
        (log.len() - 1, behaviour(&request))
    };
    let (place, answer) = answer;
    let mut out = stream;
    match answer {
        Answer::Cut => return None,
        Answer::Silent => {
            std::thread::sleep(Duration::from_mins(1));
            return None;
        }
        Answer::Status(status) => {
            let text = "<Error><Code>Refused</Code><Secret>hunter2</Secret></Error>";
            let head = format!("HTTP/1.1 {status} Refused\r\ncontent-length: {}\r\n\r\n{text}", text.len());
            return out.write_all(head.as_bytes()).ok();
        }
        Answer::Well | Answer::Changed | Answer::Untagged | Answer::Whole | Answer::Half => {}
    }
    let Ok(bytes) = std::fs::read(folder.join(request.file())) else {
        return out.write_all(b"HTTP/1.1 404 Not Found\r\ncontent-length: 0\r\n\r\n").ok();
    };
    let tag = if answer == Answer::Changed { "\"other\"".to_owned() } else { format!("\"{:x}\"", bytes.len()) };
    if headers.get("if-match").is_some_and(|wanted| *wanted != tag) {
        return out.write_all(b"HTTP/1.1 412 Precondition Failed\r\ncontent-length: 0\r\n\r\n").ok();
    }
    let range = headers.get("range").filter(|_| answer != Answer::Whole).and_then(|text| {
        let (start, end) = text.strip_prefix("bytes=")?.split_once('-')?;
        Some((start.parse::<usize>().ok()?, end.parse::<usize>().map_or(bytes.len(), |end| end + 1).min(bytes.len())))
    });
    let mut head = match range {
        Some((start, end)) if start < end => {
            format!("HTTP/1.1 206 Partial Content\r\ncontent-range: bytes {start}-{}/{}\r\n", end - 1, bytes.len())
        }
        Some(_) => return out.write_all(b"HTTP/1.1 416 Range Not Satisfiable\r\ncontent-length: 0\r\n\r\n").ok(),
        None => "HTTP/1.1 200 OK\r\n".to_owned(),
    };
    let (start, end) = range.unwrap_or((0, bytes.len()));
    let _ = write!(head, "content-length: {}\r\nlast-modified: Mon, 02 Jan 2023 03:04:05 GMT\r\n", end - start);
    if answer != Answer::Untagged {
        let _ = write!(head, "etag: {tag}\r\n");
    }
    head += "\r\n";
    out.write_all(head.as_bytes()).ok()?;
    let end = if answer == Answer::Half { start + (end - start) / 2 } else { end };
    if request.method != "HEAD" {
        out.write_all(&bytes[start..end]).ok()?;
        log.lock().unwrap()[place].sent = end - start;
    }
    (answer != Answer::Half).then_some(())
}
