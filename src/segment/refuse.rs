//! What cannot be segmented at all, and why.

use super::boxes::Boxes;
use super::counts::PointCounts;
use super::harvest::Roles;
use super::options::SegmentOptions;
use crate::error::{InputError, Result};
use crate::source::crs::Crs;
use crate::source::points::{Extent, Tile};

/// The largest longitude and latitude.
const DEGREES: [f64; 2] = [180.0, 90.0];

/// A length, share or percentage that is out of range.
pub(super) fn options(options: &SegmentOptions) -> Result<()> {
    let any = f64::MIN_POSITIVE..=f64::MAX;
    let ranges = [
        ("ring_width", options.ring_width, any.clone()),
        ("ring_limit", options.ring_limit, 0.0..=f64::MAX),
        ("ground_percentile", options.ground_percentile, 0.0..=100.0),
        ("cloud_density", options.cloud_density, 0.0..=f64::MAX),
        ("cloud_no_data", options.cloud_no_data, 0.0..=1.0),
        ("least_height", options.least_height, 0.0..=f64::MAX),
        ("flatness", options.flatness, 0.0..=1.0),
        ("hover_gap", options.hover_gap, any.clone()),
        ("party_wall_band", options.party_wall_band, 0.0..=f64::MAX),
        ("party_wall_rise", options.party_wall_rise, any),
    ];
    for (name, value, range) in ranges {
        if !range.contains(&value) {
            let (low, high) = (range.start(), range.end());
            let expected = match (*low > 0.0, *high < f64::MAX) {
                (true, _) => "more than 0".to_owned(),
                (false, true) => format!("{low} to {high}"),
                (false, false) => "0 or more".to_owned(),
            };
            return Err(InputError::new("segmentation options", value.to_string(), expected).at(name).into());
        }
    }
    Ok(())
}

/// Degrees are no lengths.
pub(super) fn geographic(crs: &Crs) -> Result<()> {
    if crs.is_geographic {
        return Err(InputError::new("tiles", format!("the geographic CRS {}", label(crs)), "a projected CRS")
            .remedy("Coordinates in degrees have no metric distances: reproject the cloud to a projected CRS first")
            .into());
    }
    Ok(())
}

/// There is not one point.
pub(super) fn without_points(tiles: &[Tile]) -> Result<()> {
    if tiles.iter().all(|tile| tile.points == 0) {
        let found = if tiles.is_empty() { "no tile".to_owned() } else { format!("no point in {} tiles", tiles.len()) };
        return Err(InputError::new(name_of(&tiles.iter().collect::<Vec<_>>()), found, "tiles with points").into());
    }
    Ok(())
}

/// Tiles and footprints lie apart.
pub(super) fn apart(tiles: &[Tile], boxes: &Boxes, crs: &Crs) -> Result<()> {
    let mut cloud = Extent::EMPTY;
    for tile in tiles.iter().filter(|tile| tile.points > 0) {
        // What is not known cannot be ruled out.
        let Some(extent) = tile.extent else { return Ok(()) };
        for area in tile.areas().iter().chain([&extent]) {
            if boxes.touches([area.min[0], area.min[1]], [area.max[0], area.max[1]]) {
                return Ok(());
            }
            cloud.join(area);
        }
    }
    // Before the tiles are said to lie elsewhere, their headers are held against some of their points.
    if tiles.iter().any(|tile| tile.points > 0 && !tile.is_true_to_its_extent()) {
        return Ok(());
    }
    let mut layer = Extent::EMPTY;
    for (_, (low, high)) in boxes.iter() {
        layer.grow([low[0], low[1], 0.0]);
        layer.grow([high[0], high[1], 0.0]);
    }
    if layer.is_empty() {
        return Ok(());
    }
    let shown = |extent: &Extent| {
        let ([x0, y0, _], [x1, y1, _]) = (extent.min, extent.max);
        format!("x {x0:.2} to {x1:.2}, y {y0:.2} to {y1:.2} in {}", label(crs))
    };
    let found = format!("no overlap: the footprints, brought to the CRS of the tiles, extend over {}", shown(&layer));
    let mut remedy = format!(
        "Check that both show the same place and that their CRSs are stated rightly (tiles, such as {}: --crs; \
         footprints: --footprint-crs)",
        name_of(&tiles.iter().collect::<Vec<_>>())
    );
    if (0..2).all(|axis| layer.min[axis] >= -DEGREES[axis] && layer.max[axis] <= DEGREES[axis]) {
        remedy.push_str(". The footprints look like degrees: if they are, give --footprint-crs EPSG:4326");
    }
    Err(InputError::new("footprints", found, format!("footprints where the tiles are: {}", shown(&cloud)))
        .remedy(remedy)
        .into())
}

/// The classes asked for do not occur in what was read.
pub(super) fn without_buildings(
    tiles: &[&Tile],
    counts: &PointCounts,
    roles: &Roles,
    options: &SegmentOptions,
) -> Result<()> {
    if counts.classes.is_empty() || counts.classes.keys().any(|class| roles.is_building(*class)) {
        return Ok(());
    }
    let listed: Vec<String> = counts.classes.iter().map(|(class, n)| format!("{class} ({n} points)")).collect();
    let found =
        format!("no point of building class {}; the classes are {}", options.building_classes, listed.join(", "));
    Err(InputError::new(name_of(tiles), found, "building points")
        .remedy("Name the classes that hold buildings, such as --building-class 1,6, or use --building-class any")
        .into())
}

fn label(crs: &Crs) -> String {
    match &crs.code {
        Some(code) => format!("{code} ({})", crs.name),
        None => crs.name.clone(),
    }
}

/// The tile that stands for all in a message.
fn name_of(tiles: &[&Tile]) -> String {
    match tiles {
        [] => "tiles".to_owned(),
        [one] => one.path.display().to_string(),
        [first, rest @ ..] => format!("{} and {} more", first.path.display(), rest.len()),
    }
}
