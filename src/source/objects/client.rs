//! The clients of services, and the thread that they work on.

use std::collections::HashMap;
use std::future::Future;
use std::io;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError, mpsc};
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey, resolve_bucket_region};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::client::{HttpClient, HttpConnector, ReqwestConnector};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use object_store::http::HttpBuilder;
use object_store::path::Path as Key;
use object_store::{BackoffConfig, ClientConfigKey, ClientOptions, Error as StoreError, ObjectStore, RetryConfig};
use tokio::runtime::Handle;

use super::address::{Address, Service};
use super::fault;
use crate::error::{Error, InputError, Result};

/// How long a server may be silent, seconds, unless the environment says otherwise.
const PATIENCE: u64 = 30;
/// No request takes longer, seconds: none is for more than some megabytes, but for what comes without ranges.
const LONGEST: u64 = 3600;
/// How often a request is tried again, unless the environment says otherwise.
const RETRIES: usize = 5;
/// The pauses before a request is tried again: the first, each then twice as long, and the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(15);

/// Objects of one bucket.
pub(super) type Store = Arc<dyn ObjectStore>;

/// What waits for answers: one thread for all, for as long as the process lives.
fn runtime() -> Result<&'static Handle> {
    static RUNTIME: OnceLock<Result<Handle, String>> = OnceLock::new();
    let started = RUNTIME.get_or_init(|| {
        // The only provider that is built in; a second installation is refused and does no harm.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(|e| e.to_string())?;
        let handle = runtime.handle().clone();
        let work = move || runtime.block_on(std::future::pending::<()>());
        std::thread::Builder::new().name("gable-objects".to_owned()).spawn(work).map_err(|e| e.to_string())?;
        Ok(handle)
    });
    started.as_ref().map_err(|told| Error::io("the thread for object storage", "start", io::Error::other(told.clone())))
}

/// Where the answer to a request will come.
pub(super) type Answer<T> = mpsc::Receiver<T>;

/// Begins a request; its answer can be waited for.
///
/// # Errors
/// The system gives no thread.
pub(super) fn begin<T: Send + 'static>(request: impl Future<Output = T> + Send + 'static) -> Result<Answer<T>> {
    let (sender, answer) = mpsc::sync_channel(1);
    // Who no longer wants the answer has dropped the other end.
    runtime()?.spawn(async move { drop(sender.send(request.await)) });
    Ok(answer)
}

/// Does a request.
///
/// # Errors
/// The system gives no thread, or it ended.
pub(super) fn wait<T: Send + 'static>(request: impl Future<Output = T> + Send + 'static) -> Result<T> {
    let ended = |e| Error::io("object storage", "wait for", io::Error::other(e));
    begin(request)?.recv().map_err(ended)
}

/// What keeps the object or the objects at `path`, and the key there.
///
/// # Errors
/// It is no address, the environment cannot be understood, or the key is none.
pub(super) fn of(path: &Path) -> Result<(Store, Key)> {
    static STORES: LazyLock<Mutex<HashMap<(Service, String), Store>>> = LazyLock::new(Mutex::default);
    let Some(address) = Address::of(path).filter(|address| !address.container.is_empty()) else {
        let fault = InputError::new(path, "no bucket", "an address such as s3://bucket/key or https://host/path");
        return Err(fault.into());
    };
    let fault = |error: StoreError| fault::of(path, &error, "an object that can be reached");
    runtime()?;
    if address.service == Service::Web {
        // Its address is the whole one: a path may have parts that keys have not, and a query.
        return Ok((web(&address.full).map_err(fault)?, Key::default()));
    }
    // Behind a separator of its own: one at the front is taken off without a word, and `bucket//key` would name another object.
    let key = Key::parse(format!("/{}", address.key)).map_err(|error| fault(error.into()))?;
    let mut stores = STORES.lock().unwrap_or_else(PoisonError::into_inner);
    let place = (address.service, address.container.clone());
    if let Some(store) = stores.get(&place) {
        return Ok((store.clone(), key));
    }
    let bucket = address.container.as_str();
    let store = match address.service {
        Service::S3 => s3(bucket),
        Service::Azure => azure(bucket),
        Service::Google | Service::Web => google(bucket),
    }
    .map_err(fault)?;
    stores.insert(place, store.clone());
    Ok((store, key))
}

fn web(url: &str) -> Result<Store, StoreError> {
    let options = times().into_iter().fold(ClientOptions::new(), |options, (key, time)| options.with_config(key, time));
    let builder = HttpBuilder::new().with_url(url).with_client_options(options.with_allow_http(true));
    Ok(Arc::new(builder.with_retry(retries()).with_http_connector(Shared).build()?))
}

fn s3(bucket: &str) -> Result<Store, StoreError> {
    let mut builder = AmazonS3Builder::from_env().with_bucket_name(bucket).with_retry(retries());
    for (key, time) in times() {
        builder = builder.with_config(AmazonS3ConfigKey::Client(key), time);
    }
    if is_anonymous("AWS") {
        builder = builder.with_skip_signature(true);
    }
    let is_given = |key: AmazonS3ConfigKey| builder.get_config_value(&key).is_some();
    let has_endpoint = is_given(AmazonS3ConfigKey::Endpoint) || is_given(AmazonS3ConfigKey::S3Endpoint);
    let has_region = ["AWS_REGION", "AWS_DEFAULT_REGION"].iter().any(|name| std::env::var_os(name).is_some());
    if !has_region && !has_endpoint {
        // Buckets say where they are, whoever asks; if this one does not, the usual region is as good as any.
        let name = bucket.to_owned();
        let asked = wait(async move { resolve_bucket_region(&name, &ClientOptions::new()).await });
        if let Ok(Ok(region)) = asked {
            builder = builder.with_region(region);
        }
    }
    Ok(Arc::new(builder.build()?))
}

fn azure(container: &str) -> Result<Store, StoreError> {
    let mut builder = MicrosoftAzureBuilder::from_env().with_container_name(container).with_retry(retries());
    for (key, time) in times() {
        builder = builder.with_config(AzureConfigKey::Client(key), time);
    }
    if is_anonymous("AZURE") {
        builder = builder.with_skip_signature(true);
    }
    Ok(Arc::new(builder.build()?))
}

fn google(bucket: &str) -> Result<Store, StoreError> {
    let mut builder = GoogleCloudStorageBuilder::from_env().with_bucket_name(bucket).with_retry(retries());
    for (key, time) in times() {
        builder = builder.with_config(GoogleConfigKey::Client(key), time);
    }
    if is_anonymous("GOOGLE") {
        builder = builder.with_skip_signature(true);
    }
    Ok(Arc::new(builder.build()?))
}

/// Whether requests are not to be signed, by the variable that GDAL and the tools of Amazon know for it.
fn is_anonymous(service: &str) -> bool {
    let value = std::env::var(format!("{service}_NO_SIGN_REQUEST")).unwrap_or_default();
    ["1", "yes", "true", "on"].contains(&value.to_ascii_lowercase().as_str())
}

/// How long a client waits: for a connection and for the next bytes, and for all of them.
fn times() -> [(ClientConfigKey, String); 3] {
    let patience = number("GABLE_REMOTE_TIMEOUT").unwrap_or(PATIENCE).max(1);
    [
        (ClientConfigKey::ConnectTimeout, format!("{} seconds", patience.min(PATIENCE))),
        (ClientConfigKey::ReadTimeout, format!("{patience} seconds")),
        (ClientConfigKey::Timeout, format!("{LONGEST} seconds")),
    ]
}

/// How requests are tried again that a server refuses for now, or that are cut off.
pub(super) fn retries() -> RetryConfig {
    let max_retries = number("GABLE_REMOTE_RETRIES").map_or(RETRIES, |count| count as usize);
    let backoff = BackoffConfig { init_backoff: FIRST_PAUSE, max_backoff: LONGEST_PAUSE, base: 2.0 };
    RetryConfig { backoff, max_retries, ..RetryConfig::default() }
}

/// A whole number of the environment.
fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.trim().parse().ok()
}

/// One client for all web servers: connections are used again, and certificates read once.
#[derive(Debug)]
struct Shared;

impl HttpConnector for Shared {
    fn connect(&self, options: &ClientOptions) -> Result<HttpClient, StoreError> {
        static CLIENT: Mutex<Option<HttpClient>> = Mutex::new(None);
        let mut client = CLIENT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(client) = &*client {
            return Ok(client.clone());
        }
        Ok(client.insert(ReqwestConnector::default().connect(options)?).clone())
    }
}
