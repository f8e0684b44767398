//! The page behind a small web server, for one person on the same machine.
//!
//! It listens on 127.0.0.1 alone. Its address has a secret in it, which changes with every start; a request without it gets
//! nothing, nor does one that another site had a browser make, or that comes by a name that is not this machine's. Nothing is
//! asked of any other machine.
//!
//! - `access` says whose requests are answered, `answer` how.
//! - `routes` says what to which.

mod access;
mod answer;
mod routes;

use std::convert::Infallible;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::runtime::Builder;
use tokio::sync::Semaphore;

use super::Desk;
use crate::error::{Error, Result};
use access::Access;
use routes::Service;

/// So many connections are served at a time; a browser opens six.
const MOST_CONNECTIONS: usize = 64;
/// A request whose head takes longer is given up, and a connection that is idle for so long is closed.
const HEAD_TIME: Duration = Duration::from_secs(30);
/// The longest head, bytes.
const LONGEST_HEAD: usize = 64 << 10;
/// So many buildings are worked on at a time; the others wait.
const AT_WORK: usize = 4;
/// How often it is asked whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);
/// What is under way gets so long to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// A server that listens and does not serve yet.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    access: Access,
}

impl Server {
    /// Listens on a port of this machine; 0 is any that is free.
    ///
    /// # Errors
    /// The port is taken, or the system has no random numbers.
    pub fn bind(port: u16) -> Result<Self> {
        let refuse = |action| move |source| Error::io(format!("127.0.0.1:{port}"), action, source);
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refuse("listen on"))?;
        listener.set_nonblocking(true).map_err(refuse("listen on"))?;
        let port = listener.local_addr().map_err(refuse("listen on"))?.port();
        Ok(Self { listener, access: Access::new(port)? })
    }

    /// The address of the page, with its secret.
    pub fn address(&self) -> String {
        self.access.address()
    }

    /// Serves until `stops` says so.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn serve(self, desk: Arc<Desk>, stops: &dyn Fn() -> bool) -> Result<()> {
        let fault = |source| Error::io(self.access.place(), "serve on", source);
        // Requests are read on this thread; what is worked on has threads of its own.
        let runtime = Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(2 * AT_WORK)
            .thread_name("gable-edit")
            .build()
            .map_err(fault)?;
        let service = Arc::new(Service { desk, access: self.access.clone(), at_work: Semaphore::new(AT_WORK) });
        let listener = self.listener.try_clone().map_err(fault)?;
        let done = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener).map_err(fault)?;
            accept(&listener, &service, stops).await;
            Ok(())
        });
        runtime.shutdown_timeout(FAREWELL);
        done
    }
}

async fn accept(listener: &tokio::net::TcpListener, service: &Arc<Service>, stops: &dyn Fn() -> bool) {
    let connections = Arc::new(AtomicUsize::new(0));
    while !stops() {
        let Ok(accepted) = tokio::time::timeout(PATIENCE, listener.accept()).await else { continue };
        let Ok((stream, from)) = accepted else {
            // Too many files are open, or the other end has gone already.
            tokio::time::sleep(PATIENCE).await;
            continue;
        };
        if !is_here(&from) || connections.load(Ordering::Relaxed) >= MOST_CONNECTIONS {
            continue;
        }
        connections.fetch_add(1, Ordering::Relaxed);
        let (service, connections) = (service.clone(), connections.clone());
        tokio::spawn(async move {
            converse(stream, service).await;
            connections.fetch_sub(1, Ordering::Relaxed);
        });
    }
}

fn is_here(from: &SocketAddr) -> bool {
    from.ip().is_loopback()
}

/// Answers the requests of a connection, one after the other.
async fn converse(stream: TcpStream, service: Arc<Service>) {
    // Answers are small or whole: there is nothing to wait for.
    let _ = stream.set_nodelay(true);
    let answer = service_fn(move |request| {
        let service = service.clone();
        async move { Ok::<_, Infallible>(service.answer(request).await) }
    });
    let mut builder = http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(HEAD_TIME).max_buf_size(LONGEST_HEAD);
    // A request that is none is answered by hyper; whoever breaks off gets no answer.
    let _ = builder.serve_connection(TokioIo::new(stream), answer).await;
}
