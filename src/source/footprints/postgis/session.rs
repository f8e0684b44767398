//! A connection, and waiting for its answers: not longer than the user wants.

use std::future::Future;
use std::path::PathBuf;
use std::pin::pin;
use std::time::Duration;

use tokio::runtime::{Builder, Runtime};
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_postgres::config::SslMode;
use tokio_postgres::{CancelToken, Client, Config, Error as PgError};
use tokio_postgres_rustls::MakeRustlsConnect;

use super::address::{Address, Trust};
use super::{faults, tls};
use crate::error::{Error, InputError, Result};

/// Between two looks at whether to go on.
const STRIDE: Duration = Duration::from_millis(100);
/// How long a server may take to be told that nobody waits any more.
const LAST_WORD: Duration = Duration::from_secs(2);

/// Waits for answers, and gives up when it is told to.
pub(super) struct Waiting<'a> {
    runtime: Runtime,
    connection: Connection,
    cancel: CancelToken,
    tls: MakeRustlsConnect,
    /// The database, for messages.
    pub label: PathBuf,
    interrupted: &'a dyn Fn() -> bool,
}

/// Connects; the text is why a password file was not used.
///
/// # Errors
/// Why there is no connection, or [`Error::Interrupted`].
pub(super) fn connect<'a>(
    address: &Address,
    interrupted: &'a dyn Fn() -> bool,
) -> Result<(Client, Waiting<'a>, Option<String>)> {
    let label = address.label();
    let runtime = Builder::new_current_thread().enable_all().build().map_err(|e| Error::io(&label, "connect to", e))?;
    let (password, hint) = address.password();
    let mut config = address.config(password.as_deref())?;
    let tls = tls::connector(address)?;
    let attempt = |config: &Config| runtime.block_on(watched(limited(config, &tls, address.patience()), interrupted));
    let mut made = attempt(&config);
    let is_optional = address.trust()? == Trust::Prefer;
    if let Some(Ok(Err(error))) = &made
        && is_optional
        && faults::is_of_tls(error)
    {
        config.ssl_mode(SslMode::Disable);
        made = attempt(&config);
    }
    match made {
        None => Err(Error::Interrupted),
        Some(Err(())) => {
            let found = "no answer within the time of connect_timeout";
            Err(InputError::new(label, found, "a PostgreSQL server")
                .at(address.server())
                .remedy("See whether host and port are right, or give connect_timeout=SECONDS")
                .into())
        }
        Some(Ok(Err(error))) => Err(faults::connecting(address, &error, hint.as_deref()).into()),
        Some(Ok(Ok((client, connection)))) => {
            let cancel = client.cancel_token();
            Ok((client, Waiting { runtime, connection, cancel, tls, label, interrupted }, hint))
        }
    }
}

/// What drives a connection until its client is dropped.
type Connection = JoinHandle<Result<(), PgError>>;

/// Connects within a time; `Err` when it is over.
async fn limited(
    config: &Config,
    tls: &MakeRustlsConnect,
    patience: Option<Duration>,
) -> Result<Result<(Client, Connection), PgError>, ()> {
    let connecting = async {
        let (client, connection) = config.connect(tls.clone()).await?;
        // It ends with the client; what goes wrong in it the client is told.
        Ok((client, tokio::spawn(connection)))
    };
    match patience {
        Some(patience) => timeout(patience, connecting).await.map_err(drop),
        None => Ok(connecting.await),
    }
}

/// The outcome of a future, or `None` when it was given up.
async fn watched<T>(future: impl Future<Output = T>, interrupted: &dyn Fn() -> bool) -> Option<T> {
    let mut future = pin!(future);
    loop {
        match timeout(STRIDE, future.as_mut()).await {
            Ok(outcome) => return Some(outcome),
            Err(_) if interrupted() => return None,
            Err(_) => {}
        }
    }
}

impl Waiting<'_> {
    /// The answer to a statement.
    ///
    /// # Errors
    /// What `explain` makes of the refusal, or [`Error::Interrupted`]; then the server is told to stop as well.
    pub fn explained<T>(
        &self,
        answer: impl Future<Output = Result<T, PgError>>,
        explain: impl FnOnce(&PgError) -> InputError,
    ) -> Result<T> {
        if let Some(outcome) = self.runtime.block_on(watched(answer, self.interrupted)) {
            return outcome.map_err(|error| explain(&error).into());
        }
        let stop = self.cancel.cancel_query(self.tls.clone());
        let _ = self.runtime.block_on(async { timeout(LAST_WORD, stop).await });
        Err(Error::Interrupted)
    }

    /// The answer to a statement of gable's own.
    ///
    /// # Errors
    /// As [`Self::explained`].
    pub fn answer<T>(&self, answer: impl Future<Output = Result<T, PgError>>) -> Result<T> {
        self.explained(answer, |error| faults::asking(&self.label, error))
    }

    /// Takes leave of the server, so that it need not note a client that went away.
    pub fn close(self, client: Client) {
        drop(client);
        let _ = self.runtime.block_on(async { timeout(LAST_WORD, self.connection).await });
    }
}
