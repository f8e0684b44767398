//! The points of tiles around the features of a model.

use std::path::PathBuf;

use rstar::primitives::Rectangle;
use rstar::{AABB, RTree};

use super::packed::steps;
use crate::error::{InputError, Result};
use crate::geometry::Random;
use crate::segment::NOISE;
use crate::site::Frame;
use crate::source::crs::Crs;
use crate::source::points::{Tile, TileProblem};

/// How far around the box of a feature points are shown, metres: what stands beside a wall tells why it stands there.
const MARGIN: f64 = 3.0;

/// Width of the columns in which the sample is ordered, steps of the page. Points that are near follow each other, so that
/// their differences are small.
const COLUMN: i64 = 4_000;

/// A sample of the points around the features.
#[derive(Debug, Default)]
pub(crate) struct Cloud {
    /// The points in steps of the page, with their classes.
    pub points: Vec<([i64; 3], u8)>,
    /// How many there are around the features.
    pub around: usize,
    /// What is wrong with tiles whose other points are here.
    pub problems: Vec<TileProblem>,
}

/// The same of files.
///
/// # Errors
/// A tile cannot be opened, or it says that it is in another CRS than the model.
pub(super) fn sample_files(
    files: &[PathBuf],
    most: usize,
    boxes: &[[[f64; 2]; 2]],
    (frame, crs): (&Frame, Option<&Crs>),
) -> Result<Cloud> {
    let open = |path: &PathBuf| -> Result<Tile> {
        let tile = Tile::open(path)?;
        if let (Some(ours), Some(theirs)) = (crs, &tile.crs)
            && !ours.is_same_horizontally(theirs)
        {
            let expected = format!("{}, that of the model", ours.name);
            return Err(InputError::new(path, format!("the CRS {}", theirs.name), expected)
                .remedy("Show a model with tiles in its own CRS")
                .into());
        }
        Ok(tile)
    };
    sample(files.iter().map(open), most, boxes, frame)
}

/// At most `most` points of the tiles within 3 m of a box, each as likely as the others (algorithm R: Vitter 1985, with a
/// fixed seed). Withheld points and noise are left out.
///
/// # Errors
/// A tile cannot be read any more.
pub(crate) fn sample(
    tiles: impl IntoIterator<Item = Result<Tile>>,
    most: usize,
    boxes: &[[[f64; 2]; 2]],
    frame: &Frame,
) -> Result<Cloud> {
    let widened =
        boxes.iter().map(|[low, high]| Rectangle::from_corners(low.map(|v| v - MARGIN), high.map(|v| v + MARGIN)));
    let near = RTree::bulk_load(widened.collect());
    let wanted = |low: [f64; 2], high: [f64; 2]| {
        let [low, high] = [low, high].map(|[x, y]| frame.to_local([x, y, 0.0]));
        let envelope = AABB::from_corners([low.x, low.y], [high.x, high.y]);
        near.locate_in_envelope_intersecting(&envelope).next().is_some()
    };
    let mut cloud = Cloud::default();
    let mut random = Random::new(0);
    for tile in tiles {
        let tile = tile?;
        let reading = tile.stream(Some(&wanted), &mut |block| {
            for point in block.points().filter(|p| !p.withheld && !NOISE.contains(&p.class)) {
                let local = frame.to_local(point.position);
                if near.locate_at_point(&[local.x, local.y]).is_none() {
                    continue;
                }
                cloud.around += 1;
                let taken = (steps(local.into()), point.class);
                if cloud.points.len() < most {
                    cloud.points.push(taken);
                } else if let Some(place) = cloud.points.get_mut(random.below(cloud.around)) {
                    *place = taken;
                }
            }
        })?;
        cloud.problems.extend(reading.problems(&tile));
    }
    cloud.points.sort_unstable_by_key(|&([x, y, z], class)| (x.div_euclid(COLUMN), y, x, z, class));
    Ok(cloud)
}
