//! Laser tiles in the frame of a model.

use std::path::PathBuf;

use nalgebra::Point3;

use super::agreement::PointMeter;
use crate::error::{InputError, Result};
use crate::site::Frame;
use crate::source::crs::Crs;
use crate::source::points::{Tile, TileProblem};

/// Points handed on at a time: enough to keep all threads busy, little enough to stay out of the way.
const BATCH: usize = 1 << 16;

/// Which points count, and where they go.
#[derive(Debug, Clone, Copy)]
pub struct TileFilter<'a> {
    /// Classes of the points that count.
    pub classes: &'a [u8],
    /// The local frame of the model.
    pub frame: Frame,
    /// The CRS of the model, if it is known.
    pub crs: Option<&'a Crs>,
}

/// A point in local metres, and its class.
pub type Classified = (Point3<f64>, u8);

/// Streams the points of these classes, without withheld and synthetic ones, in batches through `visit`.
/// Of a COPC tile only the nodes that touch one of `boxes` (`[min, max]` in local metres) are read.
///
/// Returns what is wrong with tiles whose other points were used.
///
/// # Errors
/// A tile cannot be opened, or it says that it is in another CRS than the model.
pub fn stream_points(
    tiles: &[PathBuf],
    filter: TileFilter<'_>,
    boxes: &[[[f64; 2]; 2]],
    visit: &mut dyn FnMut(&[Classified]),
) -> Result<Vec<TileProblem>> {
    let frame = filter.frame;
    let wanted = |low: [f64; 2], high: [f64; 2]| {
        let [low, high] = [low, high].map(|[x, y]| frame.to_local([x, y, 0.0]));
        boxes.iter().any(|[min, max]| (0..2).all(|axis| min[axis] <= high[axis] && low[axis] <= max[axis]))
    };
    let mut problems = Vec::new();
    let mut batch = Vec::with_capacity(BATCH);
    for path in tiles {
        let tile = Tile::open(path)?;
        if let (Some(ours), Some(theirs)) = (filter.crs, &tile.crs)
            && !ours.is_same_horizontally(theirs)
        {
            return Err(InputError::new(
                path,
                format!("the CRS {}", theirs.name),
                format!("{}, that of the model", ours.name),
            )
            .remedy("Evaluate a model with tiles in its own CRS")
            .into());
        }
        let reading = tile.stream(Some(&wanted), &mut |block| {
            let real = block.points().filter(|p| !p.withheld && !p.synthetic && filter.classes.contains(&p.class));
            for point in real {
                batch.push((frame.to_local(point.position), point.class));
                if batch.len() == BATCH {
                    visit(&batch);
                    batch.clear();
                }
            }
        })?;
        problems.extend(reading.problems(&tile));
    }
    visit(&batch);
    Ok(problems)
}

impl PointMeter {
    /// Measures the points of these tiles; see [`stream_points`].
    ///
    /// # Errors
    /// As [`stream_points`].
    pub fn add_tiles(&mut self, tiles: &[PathBuf], filter: TileFilter<'_>) -> Result<Vec<TileProblem>> {
        let boxes: Vec<_> = self.boxes().collect();
        stream_points(tiles, filter, &boxes, &mut |points| {
            self.add(&points.iter().map(|(point, _)| *point).collect::<Vec<_>>());
        })
    }
}
