//! `PostGIS`: the tables of a database, or what a query gives.
//!
//! All is read in one transaction that cannot write, by a cursor of the server, batch by batch. Identifiers come from the
//! catalogue of the database and are quoted; numbers are parameters. The query of the user stands by itself first: what is not
//! one whole statement is refused before it is asked as part of another.

mod address;
mod catalogue;
mod columns;
mod faults;
mod passfile;
mod secrets;
mod selection;
mod session;
mod tls;

use std::path::{Path, PathBuf};

use serde_json::Map;
use tokio_postgres::types::ToSql;
use tokio_postgres::{Client, IsolationLevel, Row, Transaction};

use super::reference_system::{crs_of_listing, wanted_in};
use super::{FootprintOptions, LayerInfo, RawFeature, Sink, wkb};
use crate::error::{InputError, Result};
use crate::source::crs::Crs;
use address::Address;
pub use secrets::redacted;
use selection::{Origin, Selection};
use session::Waiting;

/// Rows that are fetched at a time.
const BATCH: i32 = 2_000;
/// The bit of an EWKB type that says that an SRID follows.
const HAS_SRID: u32 = 0x2000_0000;
/// What holds for the transaction: the same text for the same value wherever it is read, and rows in the same order.
const SETTINGS: &str = "SET LOCAL TimeZone = 'UTC'; SET LOCAL DateStyle = 'ISO'; SET LOCAL IntervalStyle = 'iso_8601'; \
    SET LOCAL extra_float_digits = 3; SET LOCAL bytea_output = 'hex'; SET LOCAL synchronize_seqscans = off; \
    SELECT pg_catalog.set_config(name, '1s', true) FROM pg_catalog.pg_settings \
    WHERE name = 'client_connection_check_interval'";

/// Whether a path is no file but the address of a database.
pub(super) fn is_database(path: &Path) -> bool {
    address::text_of(path).is_some()
}

/// A path for messages and reports: of the address of a database what may be shown of it, without the password.
pub(super) fn label(path: &Path) -> PathBuf {
    match address::text_of(path) {
        // Of a string that cannot be understood nothing is known to be no password.
        Some(text) => Address::of(text).map_or_else(|_| PathBuf::from("PG:"), |address| address.label()),
        None => path.to_path_buf(),
    }
}

/// The name of what is read of a database: of the layer, if one was named, else of the database.
pub(super) fn name(path: &Path, options: &FootprintOptions) -> Option<String> {
    let text = address::text_of(path)?;
    let layer = options.layer.as_deref().and_then(|layer| layer.split('(').next()?.rsplit('.').next());
    let database = || Some(Address::of(text).ok()?.get("dbname")?.to_owned());
    layer.map(str::to_owned).or_else(database).filter(|name| !name.is_empty())
}

/// Reads a layer or a query of the database at `path`, until `interrupted` says to stop.
///
/// # Errors
/// There is no connection or no such layer, the database refuses what is asked, or [`crate::error::Error::Interrupted`].
pub(super) fn read(
    path: &Path,
    options: &FootprintOptions,
    sink: Sink<'_>,
    interrupted: &dyn Fn() -> bool,
) -> Result<LayerInfo> {
    let address = Address::of(address::text_of(path).unwrap_or_default())?;
    let (mut client, waiting, hint) = session::connect(&address, interrupted)?;
    let read = read_from(&mut client, &waiting, options, sink);
    waiting.close(client);
    let mut info = read?;
    info.warnings.extend(hint);
    Ok(info)
}

fn read_from(
    client: &mut Client,
    waiting: &Waiting<'_>,
    options: &FootprintOptions,
    sink: Sink<'_>,
) -> Result<LayerInfo> {
    let begin = client.build_transaction().read_only(true).isolation_level(IsolationLevel::RepeatableRead);
    let transaction = waiting.answer(begin.start())?;
    waiting.answer(transaction.batch_execute(SETTINGS))?;
    let extension = catalogue::extension(waiting, &transaction)?;
    let origin = match &options.query {
        Some(query) => Origin::Query(query.trim_end().trim_end_matches([';', ' ', '\n', '\t', '\r']).to_owned()),
        None => Origin::Layer(catalogue::layer(waiting, &transaction, &extension, options.layer.as_deref())?),
    };
    let selection = Selection::of(origin, waiting, &transaction, &extension)?;
    let srid = selection.srid(waiting, &transaction)?;
    let mut info = LayerInfo { layer: selection.name(), ..LayerInfo::default() };
    info.crs = crs_of(waiting, &transaction, &extension, srid, options)?;
    info.columns = selection.columns.iter().map(|column| column.name.clone()).collect();
    info.warnings.extend(selection.warnings.iter().cloned());
    let wanted = wanted_in(options, info.crs.as_ref());
    if let Some(extent) = &wanted
        && selection.leaves_out(waiting, &transaction, extent, srid)?
    {
        info.has_more = true;
        info.warnings.push("features beside the tiles are not asked for".to_owned());
    }
    rows(waiting, &transaction, &selection, wanted.as_ref(), srid, sink)?;
    waiting.answer(transaction.rollback())?;
    Ok(info)
}

/// Hands over all rows that are wanted.
fn rows(
    waiting: &Waiting<'_>,
    transaction: &Transaction<'_>,
    selection: &Selection,
    wanted: Option<&[f64; 4]>,
    srid: i32,
    sink: Sink<'_>,
) -> Result<()> {
    let sql = selection.sql(wanted.is_some());
    let statement = waiting.explained(transaction.prepare(&sql), |error| selection.fault(waiting, error, &sql))?;
    let bounds = wanted.copied().unwrap_or_default();
    let parameters: [&(dyn ToSql + Sync); 5] = [&bounds[0], &bounds[1], &bounds[2], &bounds[3], &srid];
    let parameters = if wanted.is_some() { &parameters[..] } else { &[] };
    let portal = waiting.answer(transaction.bind(&statement, parameters))?;
    loop {
        let batch = transaction.query_portal(&portal, BATCH);
        let batch = waiting.explained(batch, |error| selection.fault(waiting, error, &sql))?;
        if batch.is_empty() {
            return Ok(());
        }
        for row in &batch {
            sink(waiting.answer(std::future::ready(feature_of(row, selection, srid)))?);
        }
    }
}

fn feature_of(row: &Row, selection: &Selection, srid: i32) -> Result<RawFeature, tokio_postgres::Error> {
    let mut attributes = Map::new();
    let outline = match row.try_get::<_, Option<&[u8]>>(0)? {
        None => Err("it has no geometry".to_owned()),
        Some(blob) => match srid_of(blob) {
            own if own == srid => wkb::outline(blob),
            own => Err(format!("its SRID is {own}, and that of the first feature {srid}")),
        },
    };
    for (i, column) in selection.columns.iter().enumerate() {
        attributes.insert(column.name.clone(), column.value(row, i + 1)?);
    }
    Ok(RawFeature { attributes, outline })
}

/// The SRID of EWKB; 0 where it has none.
fn srid_of(blob: &[u8]) -> i32 {
    let [order, kind @ ..] = blob else { return 0 };
    let number = |bytes: &[u8]| -> Option<u32> {
        let bytes = bytes.first_chunk()?;
        Some(if *order == 0 { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) })
    };
    let srid = number(kind).filter(|kind| kind & HAS_SRID != 0).and_then(|_| number(kind.get(4..)?));
    srid.map_or(0, u32::cast_signed)
}

/// The CRS of an SRID; `None` where it means none.
fn crs_of(
    waiting: &Waiting<'_>,
    transaction: &Transaction<'_>,
    extension: &str,
    srid: i32,
    options: &FootprintOptions,
) -> Result<Option<Crs>> {
    if srid <= 0 || options.crs.is_some() {
        return Ok(None);
    }
    let sql = format!("SELECT auth_name || ':' || auth_srid, srtext FROM {extension}.spatial_ref_sys WHERE srid = $1");
    let Some(row) = waiting.answer(transaction.query_opt(&sql, &[&srid]))? else {
        return Err(InputError::new(&waiting.label, format!("the SRID {srid}"), "one that is in spatial_ref_sys")
            .remedy("Say with --footprint-crs which reference system it is")
            .into());
    };
    let listed = || Ok((row.try_get::<_, Option<String>>(0)?, row.try_get::<_, Option<String>>(1)?));
    let (code, definition) = waiting.answer(std::future::ready(listed()))?;
    crs_of_listing(&waiting.label, srid.into(), code, definition, options)
}
