//! The server, and databases in it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use serde_json::Value;
use tempfile::TempDir;
use tokio_postgres::{NoTls, SimpleQueryMessage};

use crate::bench::*;

/// A running server with `PostGIS`.
pub struct Server {
    /// The folder of its socket.
    pub host: String,
    pub port: String,
    /// Its certificate, for localhost.
    pub certificate: PathBuf,
}

/// The server of this run; `None`, and a line that says so, where there is none.
pub fn server() -> Option<Server> {
    let variable = |name: &str| std::env::var(format!("GABLE_POSTGIS_{name}")).ok();
    let found = (|| {
        let (host, port) = (variable("HOST")?, variable("PORT")?);
        Some(Server { host, port, certificate: variable("CERTIFICATE")?.into() })
    })();
    if found.is_none() {
        println!("skipped: no server; `make postgis` starts one");
    }
    found
}

impl Server {
    /// What SQL gives in a database: the first column of all rows.
    pub fn sql(&self, database: &str, text: &str) -> Vec<String> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let Self { host, port, .. } = self;
        let settings = format!("host='{host}' port={port} user=postgres dbname='{database}'");
        runtime.block_on(async {
            let (client, connection) = tokio_postgres::connect(&settings, NoTls).await.unwrap();
            let connection = tokio::spawn(connection);
            let answers = client.simple_query(text).await.unwrap_or_else(|e| panic!("{text}: {e:?}"));
            drop(client);
            connection.await.unwrap().unwrap();
            let rows = answers.into_iter().filter_map(|answer| match answer {
                SimpleQueryMessage::Row(row) => Some(row.get(0).unwrap_or_default().to_owned()),
                _ => None,
            });
            rows.collect()
        })
    }

    /// A new database with the extension, a copy of that of the script, and these tables.
    pub fn database(&self, name: &str, tables: &str) {
        static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
        let lock = ONE_AT_A_TIME.lock();
        self.sql("postgres", &format!("CREATE DATABASE \"{name}\" TEMPLATE with_postgis"));
        drop(lock);
        self.sql(name, tables);
    }

    /// A table `pand` with the house of [`house_folder`] and the attributes `id` and `more`.
    pub fn house(&self, database: &str, more: &str) {
        self.database(database, &format!("CREATE TABLE pand AS SELECT '007' AS id, {HOUSE} AS geom{more}"));
    }

    /// The address of a database, over the socket.
    pub fn address(&self, database: &str) -> String {
        format!("PG:host={} port={} user=postgres dbname='{database}'", self.host, self.port)
    }
}

/// Reconstructs the house of [`house_folder`] by the footprints at `address`; blanks part the words of `rest`, but those in
/// `words` stand for themselves.
pub fn run_house(address: &str, rest: &str, words: &[&str]) -> Ran {
    run_house_with(address, rest, words, &[])
}

/// The same with these variables.
pub fn run_house_with(address: &str, rest: &str, words: &[&str], environment: &[(&str, &str)]) -> Ran {
    let folder = house_folder();
    let mut command = reconstruct_house(folder.path(), address);
    command.args(rest.split_whitespace()).args(words).envs(environment.iter().copied());
    Ran { run: command.output().unwrap().into(), folder }
}

/// The footprint of [`house_folder`] in SQL.
pub const HOUSE: &str =
    "ST_GeomFromText('POLYGON((85000 447000, 85010 447000, 85010 447008, 85000 447008, 85000 447000))', 28992)";

/// `gable reconstruct` of the house in `folder`, which knows of no password.
pub fn reconstruct_house(folder: &Path, address: &str) -> Command {
    let mut command = command(["reconstruct", "--crs=EPSG:7415", "--field=height-field", "-f", address, "-o"]);
    command.arg(folder.join("out.city.json")).arg(folder.join("house.laz")).env("HOME", folder);
    command.env_remove("PGPASSWORD").env_remove("PGPASSFILE");
    command
}

/// What a run left behind.
pub struct Ran {
    pub run: Run,
    pub folder: TempDir,
}

impl Ran {
    /// The attributes of a building.
    pub fn attributes(&self, id: &str) -> Value {
        assert_eq!(self.run.code, 0, "{}", self.run.err);
        json_of(self.folder.path().join("out.city.json"))["CityObjects"][id]["attributes"].clone()
    }

    pub fn report(&self) -> Value {
        report_of(&self.folder.path().join("out.city.json"))
    }

    /// Everything that was written, in one text.
    pub fn all_that_was_written(&self) -> String {
        let mut text = format!("{}{}", self.run.out, self.run.err);
        for name in names_in(self.folder.path()).iter().filter(|name| name.contains("json")) {
            text += &std::fs::read_to_string(self.folder.path().join(name)).unwrap();
        }
        text
    }

    /// Asserts that it failed and said these things.
    pub fn refused(&self, says: &[&str]) {
        assert_ends(&self.run, 1, says);
    }
}
