//! What is in the files, for a person.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::describe::{CrsInfo, FootprintsInfo, Info, TileInfo};
use super::model::ModelInfo;
use crate::cli::output::{counted, table, thousands};
use crate::source::classes::class_name;

/// How many rejected features are named.
const NAMED: usize = 10;

/// The description as text.
pub fn table_of(info: &Info) -> String {
    let mut blocks: Vec<String> = info.tiles.iter().map(tile).collect();
    if info.tiles.len() > 1 {
        blocks.push(total(&info.tiles));
    }
    blocks.extend(info.footprints.iter().map(footprints));
    blocks.extend(info.models.iter().map(model));
    blocks.join("\n")
}

/// Adds a line `  name  text`.
fn line(out: &mut String, name: &str, text: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "  {name:<11}  {text}");
}

fn crs(crs: Option<&CrsInfo>, fault: Option<&str>) -> String {
    match (crs, fault) {
        (Some(CrsInfo { code: Some(code), name, .. }), _) => format!("{code} ({name})"),
        (Some(CrsInfo { code: None, name, .. }), _) => format!("{name} (no code)"),
        (None, Some(fault)) => format!("cannot be understood: {fault}"),
        (None, None) => "unknown; give it with --crs".to_owned(),
    }
}

/// An extent with its size.
fn extent<const N: usize>(min: [f64; N], max: [f64; N], decimals: usize) -> String {
    let axes = ["x", "y", "z"].iter().zip(min.iter().zip(&max));
    let ranges: Vec<String> =
        axes.map(|(axis, (low, high))| format!("{axis} {low:.decimals$} to {high:.decimals$}")).collect();
    let sizes: Vec<String> = min.iter().zip(&max).map(|(low, high)| format!("{:.decimals$}", high - low)).collect();
    format!("{} ({})", ranges.join(", "), sizes.join(" × "))
}

fn tile(tile: &TileInfo) -> String {
    let summary = &tile.summary;
    let mut out = format!("{}\n", tile.file);
    let points = thousands(summary.points);
    let (kind, version) = (&tile.format, &tile.version);
    match tile.point_format {
        Some(format) => {
            line(&mut out, "format", &format!("{kind} {version}, point format {format}, {points} points"));
            let date = tile.date.as_deref().unwrap_or("no date");
            let software = if tile.software.is_empty() { "unknown software" } else { &tile.software };
            line(&mut out, "made", &format!("{date}, {software}"));
        }
        None => line(&mut out, "format", &format!("{kind} ({version}), {points} points")),
    }
    line(&mut out, "CRS", &crs(tile.crs.as_ref(), tile.crs_fault.as_deref()));
    let decimals = if tile.crs.as_ref().is_some_and(|crs| crs.geographic) { 6 } else { 2 };
    match summary.extent {
        Some([min, max]) => line(&mut out, "extent", &extent(min, max, decimals)),
        None => line(&mut out, "extent", "none: the tile holds no point"),
    }
    if summary.area > 0.0 {
        let area = thousands(summary.area.round() as u64);
        let points = summary.density;
        let pulses = summary.pulse_density.map_or("unknown".to_owned(), |pulses| format!("{pulses:.1}"));
        line(&mut out, "density", &format!("{points:.1} points/m², {pulses} pulses/m² over {area} m²"));
    }
    let flags = [("withheld", summary.withheld), ("synthetic", summary.synthetic), ("overlap", summary.overlap)];
    let flags: Vec<String> =
        flags.iter().filter(|f| f.1 > 0).map(|(name, count)| format!("{name} {}", thousands(*count))).collect();
    if !flags.is_empty() {
        line(&mut out, "flags", &flags.join(", "));
    }
    out += &classes(&summary.classes);
    out += &counts("return", &summary.returns, |number| number.to_string());
    for problem in &summary.problems {
        line(&mut out, "problem", &problem.to_string());
    }
    for note in &tile.notes {
        line(&mut out, "note", note);
    }
    out
}

fn classes(classes: &BTreeMap<u8, u64>) -> String {
    counts("class", classes, |class| format!("{class:>3} {}", class_name(class)))
}

/// Counts with their shares.
fn counts(title: &str, counts: &BTreeMap<u8, u64>, name: impl Fn(u8) -> String) -> String {
    let total = counts.values().sum::<u64>();
    if total == 0 {
        return String::new();
    }
    let mut rows = vec![vec![title.to_owned(), "points".to_owned(), "share".to_owned()]];
    rows.extend(counts.iter().map(|(&key, &count)| {
        let share = format!("{:.1} %", count as f64 / total as f64 * 100.0);
        vec![name(key), thousands(count), share]
    }));
    table(&rows, "  ")
}

/// All tiles together.
fn total(tiles: &[TileInfo]) -> String {
    let mut all: BTreeMap<u8, u64> = BTreeMap::new();
    for (&class, &count) in tiles.iter().flat_map(|tile| &tile.summary.classes) {
        *all.entry(class).or_default() += count;
    }
    let points = thousands(all.values().sum());
    format!("all {}, {points} points\n{}", counted(tiles.len() as u64, "tile"), classes(&all))
}

fn model(model: &ModelInfo) -> String {
    let mut out = format!("{}\n", model.file);
    line(&mut out, "CityJSON", &model.version);
    if let Some(title) = &model.title {
        line(&mut out, "title", title);
    }
    let unnamed = model.crs.is_none() && model.crs_fault.is_none();
    let named = crs(model.crs.as_ref(), model.crs_fault.as_deref());
    line(&mut out, "CRS", if unnamed { "not named" } else { &named });
    let decimals = if model.crs.as_ref().is_some_and(|crs| crs.geographic) { 6 } else { 2 };
    match model.extent {
        Some([min, max]) => line(&mut out, "extent", &extent(min, max, decimals)),
        None => line(&mut out, "extent", "none: it holds no vertex"),
    }
    if !model.reached.is_empty() {
        let reached: Vec<String> =
            model.reached.iter().rev().map(|(level, count)| format!("LoD {level}: {}", thousands(*count))).collect();
        line(&mut out, "reached", &reached.join(", "));
    }
    for (title, counts) in [("object", &model.objects), ("geometry", &model.geometries), ("surface", &model.surfaces)] {
        if !counts.is_empty() {
            let mut rows = vec![vec![title.to_owned(), "number".to_owned()]];
            rows.extend(counts.iter().map(|(name, count)| vec![name.clone(), thousands(*count)]));
            out += &table(&rows, "  ");
        }
    }
    out
}

fn footprints(layer: &FootprintsInfo) -> String {
    let mut out = format!("{}\n", layer.file);
    let mut parts = vec![counted(layer.footprints as u64, "footprint")];
    parts.extend(layer.area.map(|area| format!("{} m²", thousands(area.round() as u64))));
    if layer.mended > 0 {
        parts.push(format!("{} of them mended", thousands(layer.mended as u64)));
    }
    line(&mut out, "footprints", &parts.join(", "));
    line(&mut out, "CRS", &crs(layer.crs.as_ref(), None).replace("--crs", "--footprint-crs"));
    if let Some([min, max]) = layer.extent {
        let decimals = if layer.crs.as_ref().is_some_and(|crs| crs.geographic) { 6 } else { 2 };
        line(&mut out, "extent", &extent(min, max, decimals));
    }
    line(&mut out, "id", layer.id_attribute.as_deref().unwrap_or("no attribute serves as id; ids are made up"));
    line(&mut out, "attributes", &layer.attributes.join(", "));
    if let Some(overlap) = &layer.overlap {
        let text = match &overlap.fault {
            Some(fault) => format!("cannot be told: {fault}"),
            None => format!(
                "{} of {} lie on a tile, {} wholly on one",
                thousands(overlap.touching as u64),
                thousands(layer.footprints as u64),
                thousands(overlap.within as u64)
            ),
        };
        line(&mut out, "on tiles", &text);
    }
    for feature in layer.rejected.iter().take(NAMED) {
        line(&mut out, "rejected", &format!("{}: {}", feature.id, feature.detail));
    }
    if layer.rejected.len() > NAMED {
        line(&mut out, "rejected", &format!("and {} more", thousands((layer.rejected.len() - NAMED) as u64)));
    }
    for warning in &layer.warnings {
        line(&mut out, "warning", warning);
    }
    out
}
