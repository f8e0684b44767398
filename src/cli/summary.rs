//! The end of a run for a person: what came out, what failed and why.

use super::output::{duration, table, thousands};
use crate::building::{LadderStep, Outcome, Reason};
use crate::completeness::Count;
use crate::report::{BuildingReport, Percentiles, Report, Revised, TerrainReport};

/// How many failed buildings the summary names; the report names all.
const NAMED: usize = 10;

/// A reason in words.
pub fn reason(reason: Reason) -> &'static str {
    match reason {
        Reason::NoPolygon => "no usable polygon",
        Reason::NoPoints => "no building points in the footprint",
        Reason::TooFewPoints => "too few building points",
        Reason::Incomplete => "not wholly covered by the tiles",
        Reason::OpenGround => "open ground, nothing stands there",
        Reason::NoPrimitives => "no planes found in the points",
        Reason::NothingInside => "nothing found inside",
        Reason::InvalidSolid => "the solid would have been invalid",
        Reason::TooComplex => "too many planes for the memory",
        Reason::AboveEvidence => "the model would have risen above its points",
        Reason::WorseThanBlock => "the model would have fitted its points worse than the block",
        Reason::TooLow => "the roof is hardly above the ground",
        Reason::AsAsked => "as was asked for",
        Reason::LowDensity => "fewer points than were asked for",
        Reason::MissingData => "more without data than was asked for",
        Reason::Outdated => "all point clouds are older than the building",
        Reason::Internal => "a fault of gable itself; please report it",
    }
}

/// One line on one building.
pub fn building(building: &BuildingReport) -> String {
    let mut parts = vec![outcome(&building.outcome)];
    if building.points > 0 {
        parts.push(format!("{} points", thousands(building.points as u64)));
    }
    parts.extend(building.rmse_lod22.map(|rmse| format!("points {rmse:.2} m (RMSE) from its faces")));
    parts.push(format!("{:.0} ms", building.wall_ms));
    if building.resumed {
        parts.push("from an earlier run".to_owned());
    }
    parts.extend_from_slice(&building.notes);
    format!("{}: {}", building.id, parts.join(", "))
}

fn outcome(outcome: &Outcome) -> String {
    let name = match outcome {
        Outcome::Lod22 => "LoD 2.2",
        Outcome::Partial { .. } => "LoD 2.2 of a part",
        Outcome::Lod12 { .. } => "LoD 1.2",
        Outcome::FootprintOnly { .. } => "footprint only",
        Outcome::Rejected { .. } => "rejected",
    };
    match outcome.reason() {
        None => name.to_owned(),
        Some((why, "")) => format!("{name} ({})", reason(why)),
        Some((why, detail)) => format!("{name} ({}: {detail})", reason(why)),
    }
}

/// The summary of a run.
pub fn summary(report: &Report) -> String {
    let counts = &report.counts;
    let number = |n: usize| thousands(n as u64);
    let mut rows = vec![
        vec!["footprints".into(), number(counts.footprints)],
        vec!["  LoD 2.2".into(), number(counts.buildings_lod22)],
    ];
    let coarse = [LadderStep::Lod22Coarse, LadderStep::Lod22Coarsest];
    let coarse: usize = coarse.iter().filter_map(|step| counts.ladder.get(step)).sum();
    if coarse > 0 {
        rows.push(vec!["    with coarser tolerances".into(), number(coarse)]);
    }
    if counts.buildings_partial > 0 {
        rows.push(vec!["  LoD 2.2 of what the tiles cover".into(), number(counts.buildings_partial)]);
    }
    rows.push(vec!["  LoD 1.2 only".into(), number(counts.buildings_lod12)]);
    let by_reason = |(why, &count): (&Reason, &usize)| vec![format!("    {}", reason(*why)), number(count)];
    rows.extend(counts.fallbacks.iter().map(by_reason));
    rows.push(vec!["  without a model".into(), number(counts.skipped.values().sum())]);
    rows.extend(counts.skipped.iter().map(by_reason));
    if counts.not_reached > 0 {
        rows.push(vec!["  not reached".into(), number(counts.not_reached)]);
    }
    if counts.resumed > 0 {
        rows.push(vec!["  taken from an earlier run".into(), number(counts.resumed)]);
    }
    rows.push(vec!["solids at LoD 2.2".into(), number(counts.solids_lod22)]);
    if counts.solids_lod23 > 0 {
        rows.push(vec!["solids at LoD 2.3".into(), number(counts.solids_lod23)]);
    }
    if counts.solids_lod13 > 0 {
        rows.push(vec!["solids at LoD 1.3".into(), number(counts.solids_lod13)]);
    }
    rows.push(vec!["solids at LoD 1.2".into(), number(counts.solids_lod12)]);
    rows.push(vec!["points read".into(), thousands(report.inputs.points.read)]);
    let missing: u64 = report.inputs.tiles.iter().map(|tile| tile.missing_points).sum();
    if missing > 0 {
        rows.push(vec!["points that could not be read".into(), thousands(missing)]);
    }
    rows.push(vec!["points in footprints".into(), thousands(counts.points)]);
    let mut lines = Vec::new();
    if let Some(Percentiles { p50, p90, max, .. }) = report.quality.rmse_lod22 {
        let buildings = format!("{p50:.3} m median, {p90:.3} m at 90 %, {max:.3} m at worst");
        lines.push(("RMSE LoD 2.2", format!("{buildings}: points to the nearest face, per building")));
    }
    let faults = &report.quality.completeness;
    if faults.buildings > 0 {
        let of = |name: &str, count: &Count| format!("{name} {} buildings ({:.0} m²)", count.from_10, count.area);
        let text = [
            of("missing in", &faults.missing),
            of("excess in", &faults.excess),
            of("roofed ground in", &faults.roofed_ground),
        ];
        lines.push(("areas from 10 m²", text.join(", ")));
    }
    let revised = report.quality.revised;
    if revised.buildings > 0 {
        let Revised { buildings, before, after } = revised;
        let text = format!("{buildings} buildings: of {before:.0} m² missing or in excess {after:.0} m² are left");
        lines.push(("made again", text));
    }
    lines.extend(report.terrain.as_ref().map(|terrain| ("terrain", terrain_line(terrain))));
    let mut cost = vec![duration(report.wall_seconds)];
    cost.extend(report.cpu_seconds.map(|cpu| format!("{} of processor time", duration(cpu))));
    cost.extend(report.peak_memory_bytes.map(|bytes| format!("{} MB", bytes.div_ceil(1_000_000))));
    lines.push(("time and memory", cost.join(", ")));
    let written = report.outputs.len();
    // The report, which comes last, is always named.
    let unnamed = written.saturating_sub(NAMED + 1);
    let is_named = |at: &usize| *at < NAMED || at + 1 == written;
    let named = report.outputs.iter().enumerate().filter(|(at, _)| is_named(at));
    lines.extend(named.map(|(_, file)| ("written", file.clone())));
    if unnamed > 0 {
        lines.push(("", format!("and {} more files: see the report", thousands(unnamed as u64))));
    }

    let mut out = table(&rows, "");
    out.extend(lines.iter().map(|(name, text)| format!("{name:<20}  {text}\n")));
    out += &bad_tiles(report);
    out += &failed(report);
    if report.interrupted {
        out += "interrupted: what was done is written, the rest is missing\n";
    }
    out
}

/// The terrain in one line.
fn terrain_line(terrain: &TerrainReport) -> String {
    let number = |n: usize| thousands(n as u64);
    let size = format!("{} triangles in {} tiles", number(terrain.triangles), number(terrain.tiles));
    let fit = terrain.rmse.map(|rmse| format!(", RMSE {rmse:.3} m, {:.3} m at worst", terrain.largest));
    let upright =
        if terrain.upright > 0 { format!("; {} upright under walls", number(terrain.upright)) } else { String::new() };
    size + &fit.unwrap_or_default() + &upright
}

/// The summary of a run that wrote the points of buildings, and no model.
pub fn cropped(report: &Report) -> String {
    let counts = &report.counts;
    let number = |n: usize| thousands(n as u64);
    let files = report.buildings.iter().filter(|building| building.file.is_some()).count();
    let rows = [
        vec!["footprints".to_owned(), number(counts.footprints)],
        vec!["  with building points".to_owned(), number(counts.with_points)],
        vec!["files of points".to_owned(), number(files)],
        vec!["points read".to_owned(), thousands(report.inputs.points.read)],
        vec!["building points in footprints".to_owned(), thousands(counts.points)],
    ];
    let mut out = table(&rows, "");
    let mut lines = vec![("time", duration(report.wall_seconds))];
    lines.extend(report.outputs.iter().map(|file| ("written", file.clone())));
    out.extend(lines.iter().map(|(name, text)| format!("{name:<20}  {text}\n")));
    out + &bad_tiles(report)
}

/// How many warnings a line has room for.
const TOLD: usize = 3;

/// What the model lacks where the exit code is not 0, in one line.
pub fn lack(report: &Report) -> Option<String> {
    let counts = &report.counts;
    let bad = report.inputs.tiles.iter().filter(|tile| tile.left_out || tile.missing_points > 0).count();
    let parts = [
        (counts.lacking, "building(s) lack a model"),
        (counts.not_reached, "building(s) were not reached"),
        (bad, "tile(s) could not be read or not wholly"),
    ];
    let parts = parts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
    match report.exit_code {
        0 => None,
        1 => Some("no building has a model".to_owned()),
        _ => Some(parts.collect::<Vec<_>>().join("; ")),
    }
}

/// Why the exit code is not 0, in one line: all that is said of a run of which nothing but errors is to be said.
pub fn shortfall(report: &Report) -> Option<String> {
    let lack = lack(report).filter(|text| !text.is_empty());
    let warnings = report.warnings.iter().rev().take(TOLD).cloned();
    let said: Vec<String> = lack.into_iter().chain(warnings).collect();
    (report.exit_code != 0).then(|| format!("error: {}", said.join("; ")))
}

/// The tiles that could not be read, or not wholly.
fn bad_tiles(report: &Report) -> String {
    let bad: Vec<_> = report.inputs.tiles.iter().filter(|tile| tile.left_out || tile.missing_points > 0).collect();
    if bad.is_empty() {
        return String::new();
    }
    let (count, total) = (thousands(bad.len() as u64), thousands(report.inputs.tiles.len() as u64));
    let mut lines = vec![format!("tiles that could not be read or not wholly: {count} of {total}\n")];
    lines.extend(bad.iter().take(NAMED).flat_map(|tile| &tile.problems).map(|problem| format!("  {problem}\n")));
    if bad.len() > NAMED {
        lines.push(format!("  and {} more: see the report\n", thousands((bad.len() - NAMED) as u64)));
    }
    lines.concat()
}

/// The buildings that lack a model though they ought to have one.
fn failed(report: &Report) -> String {
    let lacking: Vec<_> = report.buildings.iter().filter(|b| b.lacks_model()).collect();
    if lacking.is_empty() {
        return String::new();
    }
    let mut lines = vec!["without a model:\n".to_owned()];
    lines.extend(lacking.iter().take(NAMED).map(|b| format!("  {}: {}\n", b.id, outcome(&b.outcome))));
    if lacking.len() > NAMED {
        lines.push(format!("  and {} more: see the report\n", thousands((lacking.len() - NAMED) as u64)));
    }
    lines.concat()
}
