//! The virtual laser scanner: from a building to the points that are left of it.
//!
//! ```text
//! Placed ─► scene (building, neighbours, trees, ground) ─► rays of a set-up ─► corruption ─► Scan ─► Site
//! ```

mod airborne;
mod corruption;
mod photographs;
mod scene;
mod sphere;
#[cfg(test)]
mod tests;

use geo::{Contains, MultiPolygon};
use nalgebra::Point3;
use serde_json::Map;

use super::model::Placed;
use super::options::{ScanOptions, Setup, SetupChoice};
use super::random::{Draw, Random};
use crate::record::Record;
use crate::site::{Coverage, Frame, Ground, GroundSource, Site};
use scene::{Return, Scene, Target, Tree};

/// Coordinates are whole multiples of this, metres, as those of laser tiles.
const STEP: f64 = 0.001;

/// What a scanner saw of a building.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Where the scanner stood.
    pub setup: Setup,
    /// The local frame of everything below.
    pub frame: Frame,
    /// Largest side of the building's box (R), metres.
    pub size: f64,
    /// Standard deviation of the noise, as a share of R.
    pub noise: f64,
    /// Building points, local metres, sorted by x, y, z and without duplicates: with a footprint, those in it.
    pub points: Vec<Point3<f64>>,
    /// Ground points around the building, local metres, as asked for.
    pub ground_points: Vec<Point3<f64>>,
    /// The displaced footprint, if the scan has one, local metres.
    pub footprint: Option<MultiPolygon<f64>>,
    /// The height of the ground as it is known, metres.
    pub ground: f64,
    /// Number of flight strips, or of positions of the scanner.
    pub strips: u32,
    /// Building points per m² of the building's outline.
    pub density: f64,
}

impl Scan {
    /// The scan as [`reconstruct`](mod@crate::reconstruct) takes it, under this id.
    pub fn site(&self, id: &str) -> Site {
        Site {
            id: id.to_owned(),
            frame: self.frame,
            footprint: self.footprint.clone(),
            points: self.points.clone(),
            ground_points: Vec::new(),
            ground_line: Vec::new(),
            ground: Ground { height: self.ground, spread: 0.0, source: GroundSource::GroundPoints },
            coverage: Coverage { share: 1.0 },
            covered: None,
            eaves: None,
            attributes: Map::new(),
            record: Record::default(),
            edits: Vec::new(),
        }
    }
}

/// Scans a building: the same building, options and seed give the same points.
///
/// `surroundings` is the width of the ground around the building, metres, whose points are wanted too (not in full view).
/// `None` for a building without surface.
pub fn scan(placed: &Placed, options: &ScanOptions, surroundings: f64, seed: u64) -> Option<Scan> {
    let mut random = Random::new(seed);
    let setup = match options.setup {
        SetupChoice::FullView => Setup::FullView,
        SetupChoice::NoBottom => Setup::NoBottom,
        SetupChoice::Airborne => Setup::Airborne,
        SetupChoice::Photographs => Setup::Photographs,
        SetupChoice::Mixed => match random.below(10) {
            0 => Setup::FullView,
            1 => Setup::NoBottom,
            _ => Setup::Airborne,
        },
    };
    let scene = build(placed, options, setup, &mut random)?;
    let size = scene.aabb.extent().into_iter().fold(0.0, f64::max);
    let area = geo::Area::unsigned_area(&placed.footprint).max(1.0);
    let density = options.density.draw_magnitude(&mut random);
    let (mut returns, strips) = if setup == Setup::Airborne {
        let density = density.min(f64::from(options.most_points) / area);
        airborne::fly(&scene, placed.ground, options, density, surroundings, &mut random)
    } else {
        let surface: f64 = placed.mesh.all_corners().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum();
        let wanted = (density * surface).clamp(16.0, f64::from(options.most_points)) as usize;
        sphere::scan(&scene, setup, wanted, &mut random)
    };

    let noise = options.noise.draw(&mut random);
    corruption::lose(&mut returns, &placed.mesh, options, &mut random);
    match setup {
        Setup::Airborne => corruption::shift_strips(&mut returns, strips, options, &mut random),
        Setup::Photographs => photographs::match_pictures(&mut returns, placed.ground, options, &mut random),
        Setup::FullView | Setup::NoBottom => {}
    }
    corruption::reflect(&mut returns, options, &mut random);
    corruption::blur(&mut returns, noise * size, &mut random);

    let footprint = random.chance(options.footprint).then(|| {
        let (distance, angle) = (options.footprint_shift.draw(&mut random), random.unit() * std::f64::consts::TAU);
        geo::Translate::translate(&placed.footprint, distance * angle.cos(), distance * angle.sin())
    });
    let mut points = building_points(&returns, footprint.as_ref(), options, &mut random);
    corruption::add_outliers(&mut points, &scene.aabb, footprint.as_ref(), options, &mut random);
    let ground_points =
        if surroundings > 0.0 { ground_points(&returns, &placed.footprint, surroundings) } else { Vec::new() };
    let points = tidied(points);
    Some(Scan {
        setup,
        frame: placed.frame,
        size,
        noise,
        density: points.len() as f64 / area,
        points,
        ground_points: tidied(ground_points),
        footprint,
        ground: placed.ground + options.ground_error * random.normal(),
        strips,
    })
}

/// The building with what the options put around it.
fn build(placed: &Placed, options: &ScanOptions, setup: Setup, random: &mut Random) -> Option<Scene> {
    if setup == Setup::FullView {
        // An object that is turned round before the scanner: nothing else is there.
        return Scene::new(&placed.mesh, &[], Vec::new(), None);
    }
    let around: &[_] = if random.chance(options.neighbours) { &placed.neighbours } else { &[] };
    let top = placed.mesh.aabb()?.max[2];
    let count = if random.chance(options.tree_chance) { options.trees.draw_count(random) } else { 0 };
    let trees = Tree::grow(placed, top, count, &options.tree_opacity, random);
    Scene::new(&placed.mesh, around, trees, Some(placed.ground))
}

/// The points that are taken for the building's: its own, and with a footprint those in it that a classification gets
/// wrong or that are of a building beside it.
fn building_points(
    returns: &[Return],
    footprint: Option<&MultiPolygon<f64>>,
    options: &ScanOptions,
    random: &mut Random,
) -> Vec<Point3<f64>> {
    let [stray_neighbours, stray_ground, stray_vegetation] =
        [options.stray_neighbours, options.stray_ground, options.stray_vegetation].map(|share| share.draw(random));
    let covers = |p: &Point3<f64>| footprint.is_none_or(|f| f.contains(&geo::Point::new(p.x, p.y)));
    let mut points = Vec::with_capacity(returns.len());
    for hit in returns {
        let taken = match hit.target {
            Target::Building(_) => true,
            // Without an outline a person has cut out the building.
            Target::Neighbour => footprint.is_some() && random.chance(stray_neighbours),
            Target::Ground => footprint.is_some() && random.chance(stray_ground),
            Target::Tree => random.chance(stray_vegetation),
        };
        if taken && covers(&hit.position) {
            points.push(hit.position);
        }
    }
    points
}

/// The points of the ground outside the building and no farther from its box than `width`, metres: who looks past it near
/// the horizon sees the ground far away.
fn ground_points(returns: &[Return], outline: &MultiPolygon<f64>, width: f64) -> Vec<Point3<f64>> {
    let Some(rect) = geo::BoundingRect::bounding_rect(outline) else { return Vec::new() };
    let (x, y) = (rect.min().x - width..=rect.max().x + width, rect.min().y - width..=rect.max().y + width);
    let ground = returns.iter().filter(|hit| hit.target == Target::Ground).map(|hit| hit.position);
    ground.filter(|p| x.contains(&p.x) && y.contains(&p.y) && !outline.contains(&geo::Point::new(p.x, p.y))).collect()
}

/// The points on the grid of a laser tile, in order and without duplicates.
fn tidied(mut points: Vec<Point3<f64>>) -> Vec<Point3<f64>> {
    for p in &mut points {
        p.coords.apply(|c| *c = (*c / STEP).round() * STEP);
    }
    points.sort_unstable_by(|a, b| {
        a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
    });
    points.dedup();
    points
}
