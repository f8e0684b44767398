//! What `PG:…` and `postgresql://…` say: which server, which database, who asks, and how the server is to be trusted.
//!
//! Settings have libpq's names, defaults and environment variables. No value of a string that cannot be understood is ever
//! repeated: part of a password may be taken for any of them.

use std::path::{Path, PathBuf};
use std::time::Duration;

use percent_encoding::percent_decode_str;
use tokio_postgres::Config;
use tokio_postgres::config::SslMode;

use super::passfile;
use crate::error::InputError;

/// What a connection string begins with.
const PREFIX: &str = "PG:";
const SCHEMES: [&str; 2] = ["postgresql://", "postgres://"];
/// The settings that are understood, with the variables that stand in for them; those without are rarely needed.
const SETTINGS: [(&str, Option<&str>); 22] = [
    ("host", Some("PGHOST")),
    ("hostaddr", Some("PGHOSTADDR")),
    ("port", Some("PGPORT")),
    ("dbname", Some("PGDATABASE")),
    ("user", Some("PGUSER")),
    ("password", Some("PGPASSWORD")),
    ("passfile", Some("PGPASSFILE")),
    ("options", Some("PGOPTIONS")),
    ("application_name", Some("PGAPPNAME")),
    ("sslmode", Some("PGSSLMODE")),
    ("sslrootcert", Some("PGSSLROOTCERT")),
    ("connect_timeout", Some("PGCONNECT_TIMEOUT")),
    ("channel_binding", Some("PGCHANNELBINDING")),
    ("target_session_attrs", Some("PGTARGETSESSIONATTRS")),
    ("sslnegotiation", Some("PGSSLNEGOTIATION")),
    ("load_balance_hosts", Some("PGLOADBALANCEHOSTS")),
    ("keepalives", None),
    ("keepalives_idle", None),
    ("keepalives_interval", None),
    ("keepalives_retries", None),
    ("tcp_user_timeout", None),
    ("client_encoding", None),
];
/// The settings of libpq and GDAL that mean something there and nothing here: they may be named in a message.
const ELSEWHERE: [&str; 18] = [
    "service",
    "sslcert",
    "sslkey",
    "sslpassword",
    "sslcrl",
    "sslcrldir",
    "sslsni",
    "sslcompression",
    "sslcertmode",
    "ssl_min_protocol_version",
    "ssl_max_protocol_version",
    "gssencmode",
    "krbsrvname",
    "require_auth",
    "requirepeer",
    "tables",
    "schemas",
    "active_schema",
];
/// The settings that a message may show.
const SHOWN: [&str; 5] = ["host", "hostaddr", "port", "dbname", "user"];
/// The settings that gable reads itself; all others are the crate's.
const OWN: [&str; 6] = ["sslmode", "sslrootcert", "passfile", "password", "client_encoding", "connect_timeout"];
/// Where servers listen on this machine: Debian's folder, and that of PostgreSQL as it comes.
const SOCKETS: [&str; 2] = ["/var/run/postgresql", "/tmp"];
/// The port of servers unless told otherwise.
const PORT: &str = "5432";
/// How long a server may take to answer unless told otherwise. libpq waits for ever.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(30);
/// What is expected where a string cannot be understood.
const EXPECTED: &str =
    "settings such as PG:host=db.example.org dbname=city user=me, or postgresql://me@db.example.org/city";

/// How far a server is trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trust {
    /// Nothing is encrypted.
    Disable,
    /// Encrypted if the server can, whoever it is.
    Prefer,
    /// Encrypted, whoever the server is; by a root certificate if there is one.
    Require,
    /// Its certificate must come from a root that is trusted.
    VerifyCa,
    /// And be made out to the host.
    VerifyFull,
}

impl Trust {
    const ALL: [(&'static str, Self); 5] = [
        ("disable", Self::Disable),
        ("prefer", Self::Prefer),
        ("require", Self::Require),
        ("verify-ca", Self::VerifyCa),
        ("verify-full", Self::VerifyFull),
    ];

    /// Its name in a connection string.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, trust)| *trust == self).map_or("", |(name, _)| name)
    }
}

/// Where to connect, and as whom. It is never printed: only [`Self::label`] is.
pub(super) struct Address {
    /// The settings that the string gives.
    given: Vec<(String, String)>,
    /// The settings in force: given, or of the environment.
    settings: Vec<(&'static str, String)>,
    home: Option<PathBuf>,
}

/// The connection string in the place of a file name; `None` when it is the name of a file.
pub(super) fn text_of(path: &Path) -> Option<&str> {
    let text = path.to_str()?;
    let prefix = text.get(..PREFIX.len()).filter(|start| start.eq_ignore_ascii_case(PREFIX));
    match prefix {
        Some(_) => text.get(PREFIX.len()..),
        None => is_url(text).then_some(text),
    }
}

fn is_url(text: &str) -> bool {
    SCHEMES.iter().any(|scheme| text.starts_with(scheme))
}

impl Address {
    /// What `text`, without `PG:` before it, and this process's environment say.
    ///
    /// # Errors
    /// It cannot be understood.
    pub fn of(text: &str) -> Result<Self, InputError> {
        Self::with(text, &|name| std::env::var(name).ok())
    }

    fn with(text: &str, environment: &dyn Fn(&str) -> Option<String>) -> Result<Self, InputError> {
        let text = text.trim();
        let given = if is_url(text) { url(text) } else { keywords(text) };
        let given = given.map_err(|found| InputError::new(PREFIX, found, EXPECTED))?;
        for (name, _) in &given {
            if !SETTINGS.iter().any(|(known, _)| known == name) {
                // What is no setting at all may be part of a password.
                let shown = ELSEWHERE.contains(&name.as_str()).then(|| format!("`{name}`, which gable does not know"));
                let found = shown.unwrap_or_else(|| "a word before `=` that is no setting".to_owned());
                let known: Vec<&str> = SETTINGS.iter().map(|(name, _)| *name).collect();
                return Err(InputError::new(PREFIX, found, format!("settings out of {}", known.join(", ")))
                    .remedy("A value with blanks stands in single quotes"));
            }
        }
        let setting = |&(name, variable): &(&'static str, Option<&str>)| {
            // The last one counts, as in libpq; an empty one is none.
            let value = given.iter().rev().find(|(key, _)| key == name).map(|(_, value)| value.clone());
            let value = value.filter(|value| !value.is_empty()).or_else(|| environment(variable?));
            value.filter(|value| !value.is_empty()).map(|value| (name, value))
        };
        let settings = SETTINGS.iter().filter_map(setting).collect();
        let mut address = Self { given, settings, home: environment("HOME").map(PathBuf::from) };
        if address.get("user").is_none() {
            let user = environment("USER").or_else(|| environment("LOGNAME"));
            let user = user.filter(|user| !user.is_empty()).ok_or_else(|| {
                InputError::new(address.label(), "no `user`", "the role that asks").remedy("Give user=…, or set PGUSER")
            })?;
            address.settings.push(("user", user));
        }
        if address.get("dbname").is_none() {
            let user = address.get("user").unwrap_or_default().to_owned();
            address.settings.push(("dbname", user));
        }
        if address.get("host").is_none() && address.get("hostaddr").is_none() {
            let port = address.get("port").unwrap_or(PORT);
            let listens = |folder: &&&str| Path::new(folder).join(format!(".s.PGSQL.{port}")).exists();
            let host = SOCKETS.iter().find(listens).map_or("localhost", |folder| folder).to_owned();
            address.settings.push(("host", host));
        }
        address.trust()?;
        Ok(address)
    }

    /// A setting that is in force.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.settings.iter().find(|(key, _)| *key == name).map(|(_, value)| value.as_str())
    }

    /// The address for messages and reports: what was given of host, port, database and user.
    pub fn label(&self) -> PathBuf {
        // `postgresql://user:password` without a host has the password where a port should stand.
        let is_shown = |(name, value): &&(String, String)| {
            SHOWN.contains(&name.as_str()) && (name != "port" || value.chars().all(|c| c.is_ascii_digit() || c == ','))
        };
        let shown = self.given.iter().filter(is_shown);
        let shown: Vec<String> = shown.map(|(name, value)| format!("{name}={value}")).collect();
        PathBuf::from(format!("{PREFIX}{}", shown.join(" ")))
    }

    /// Host and port for a message, as they are in force.
    pub fn server(&self) -> String {
        let host = self.get("host").or_else(|| self.get("hostaddr")).unwrap_or_default();
        format!("{host}, port {}", self.get("port").unwrap_or(PORT))
    }

    /// The folder of the user's own files.
    pub fn home(&self) -> Option<&Path> {
        self.home.as_deref()
    }

    /// How far the server is trusted.
    ///
    /// # Errors
    /// An `sslmode` that there is not.
    pub fn trust(&self) -> Result<Trust, InputError> {
        let Some(mode) = self.get("sslmode") else { return Ok(Trust::Prefer) };
        Trust::ALL.iter().find(|(name, _)| *name == mode).map(|(_, trust)| *trust).ok_or_else(|| {
            let modes: Vec<&str> = Trust::ALL.iter().map(|(name, _)| *name).collect();
            let expected = format!("one of {}", modes.join(", "));
            InputError::new(self.label(), "an `sslmode` that gable does not know", expected)
        })
    }

    /// How long to wait for the server to let us in: `connect_timeout` for each of the hosts; 0 is for ever.
    pub fn patience(&self) -> Option<Duration> {
        let hosts = self.get("host").map_or(1, |hosts| hosts.split(',').count());
        let each = match self.get("connect_timeout").map(str::parse::<i64>) {
            None | Some(Err(_)) => CONNECT_TIMEOUT,
            Some(Ok(seconds)) => Duration::from_secs(u64::try_from(seconds).ok().filter(|&seconds| seconds > 0)?),
        };
        Some(each.saturating_mul(u32::try_from(hosts).unwrap_or(u32::MAX)))
    }

    /// Whether all hosts are sockets of this machine, over which nothing is encrypted.
    pub fn is_local(&self) -> bool {
        self.get("hostaddr").is_none()
            && self.get("host").is_some_and(|hosts| hosts.split(',').all(|host| host.starts_with(['/', '@'])))
    }

    /// The password: given, of the environment, or of the password file. The second is why a file is not used.
    pub fn password(&self) -> (Option<String>, Option<String>) {
        if let Some(password) = self.get("password") {
            return (Some(password.to_owned()), None);
        }
        let own = self.home.as_ref().map(|home| home.join(".pgpass"));
        let Some(file) = self.get("passfile").map(PathBuf::from).or(own) else { return (None, None) };
        let hosts = self.get("host").or_else(|| self.get("hostaddr")).unwrap_or_default();
        // A host that is the usual socket is entered as localhost.
        let hosts = hosts.split(',').map(|host| if SOCKETS.contains(&host) { "localhost" } else { host });
        let ports: Vec<&str> = self.get("port").unwrap_or(PORT).split(',').collect();
        let ports = ports.iter().chain(std::iter::repeat(ports.last().unwrap_or(&PORT)));
        let places: Vec<_> = hosts.zip(ports.copied()).collect();
        let (dbname, user) = (self.get("dbname").unwrap_or_default(), self.get("user").unwrap_or_default());
        match passfile::password(&file, &places, dbname, user) {
            Ok(password) => (password, None),
            Err(reason) => (None, Some(reason)),
        }
    }

    /// The crate's form of it, but for encryption.
    ///
    /// # Errors
    /// A value that is none, such as a port that is no number; the message names the setting and not the value.
    pub fn config(&self, password: Option<&str>) -> Result<Config, InputError> {
        let passed = self.settings.iter().filter(|(name, _)| !OWN.contains(name));
        let text: Vec<String> = passed
            .map(|(name, value)| format!("{name}='{}'", value.replace('\\', "\\\\").replace('\'', "\\'")))
            .collect();
        let mut config: Config = text.join(" ").parse().map_err(|error: tokio_postgres::Error| {
            let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
            InputError::new(self.label(), format!("settings that cannot be used: {reason}"), EXPECTED)
        })?;
        if let Some(password) = password {
            config.password(password);
        }
        if config.get_application_name().is_none() {
            config.application_name("gable");
        }
        config.ssl_mode(match self.trust()? {
            _ if self.is_local() => SslMode::Disable,
            Trust::Disable => SslMode::Disable,
            Trust::Prefer => SslMode::Prefer,
            Trust::Require | Trust::VerifyCa | Trust::VerifyFull => SslMode::Require,
        });
        Ok(config)
    }
}

/// The settings of a keyword/value string (PostgreSQL manual, section 34.1.1.1).
fn keywords(text: &str) -> Result<Vec<(String, String)>, String> {
    let mut settings = Vec::new();
    let mut rest = text.trim_start();
    while !rest.is_empty() {
        let no_equals = || "a word without `=` behind it".to_owned();
        let (name, behind) = rest.split_once('=').ok_or_else(no_equals)?;
        let name = name.trim_end();
        if name.contains(char::is_whitespace) || name.is_empty() {
            return Err(no_equals());
        }
        let behind = behind.trim_start();
        let (quoted, body) = behind.strip_prefix('\'').map_or((false, behind), |body| (true, body));
        let mut value = String::new();
        let mut chars = body.char_indices();
        let mut end = if quoted { None } else { Some(body.len()) };
        while let Some((at, c)) = chars.next() {
            match c {
                '\\' => value.extend(chars.next().map(|(_, c)| c)),
                '\'' if quoted => {
                    end = Some(at + 1);
                    break;
                }
                c if c.is_whitespace() && !quoted => {
                    end = Some(at);
                    break;
                }
                c => value.push(c),
            }
        }
        let end = end.ok_or_else(|| "a quote that does not end".to_owned())?;
        settings.push((name.to_owned(), value));
        rest = body.get(end..).unwrap_or_default().trim_start();
    }
    Ok(settings)
}

/// The settings of a URL (section 34.1.1.2): `postgresql://user:password@host:port,host:port/dbname?name=value&…`.
fn url(text: &str) -> Result<Vec<(String, String)>, String> {
    let decode = |part: &str| {
        percent_decode_str(part).decode_utf8().map(String::from).map_err(|_| "an escape that is no UTF-8".to_owned())
    };
    let (_, rest) = text.split_once("://").unwrap_or_default();
    let (rest, query) = rest.split_once('?').unwrap_or((rest, ""));
    // A password may hold `/` if its writer forgot to escape it; a host never holds `@`.
    let (login, rest) = rest.rsplit_once('@').map_or((None, rest), |(login, rest)| (Some(login), rest));
    let (places, dbname) = rest.split_once('/').unwrap_or((rest, ""));
    let mut settings = Vec::new();
    let mut set = |name: &str, value: String| {
        if !value.is_empty() {
            settings.push((name.to_owned(), value));
        }
    };
    if let Some(login) = login {
        let (user, password) = login.split_once(':').unwrap_or((login, ""));
        set("user", decode(user)?);
        set("password", decode(password)?);
    }
    let (mut hosts, mut ports) = (Vec::new(), Vec::new());
    for place in places.split(',').filter(|place| !place.is_empty()) {
        let (host, port) = match place.strip_prefix('[') {
            Some(bracketed) => {
                let (host, behind) = bracketed.split_once(']').ok_or("an address without `]`")?;
                (host, behind.strip_prefix(':').unwrap_or_default())
            }
            None => place.split_once(':').unwrap_or((place, "")),
        };
        hosts.push(decode(host)?);
        ports.push(if port.is_empty() { PORT.to_owned() } else { port.to_owned() });
    }
    set("host", hosts.join(","));
    set("port", if ports.iter().all(|port| port == PORT) { String::new() } else { ports.join(",") });
    set("dbname", decode(dbname)?);
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        let (name, value) = pair.split_once('=').ok_or("a word without `=` behind `?`")?;
        let name = if name == "ssl" && value == "true" { ("sslmode", "require") } else { (name, value) };
        set(&decode(name.0)?, decode(name.1)?);
    }
    Ok(settings)
}

#[cfg(test)]
#[path = "address_tests.rs"]
mod tests;
