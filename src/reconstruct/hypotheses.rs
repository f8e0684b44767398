//! Hypotheses: the planes that cut the box of a building, detected or concluded, and what is known about them.

use geo::{Contains, Distance, Euclidean, MinimumRotatedRect, MultiPoint, MultiPolygon, Polygon};
use nalgebra::{Point2, Point3, Unit, Vector2, Vector3};

use super::complex::{Complex, PlaneId};
use super::primitives::enclosure;
use super::primitives::height_jumps::{self, JumpOptions};
use super::primitives::roof_map::RoofMap;
use super::primitives::trace::{self, Trace};
use super::primitives::walls::Walls;
use super::primitives::{Extent, Primitive, PrimitiveKind};
use super::{Detected, Failure, Parameters, outline};
use crate::building::Reason;
use crate::geometry::{Aabb, Plane};
use crate::site::Site;

/// Planes with more verticality than this are walls (paper, section 3.2).
pub const WALL_VERTICALITY: f64 = 0.9;
/// An outline with more corners than this is too jagged for a model with all of them, whose cost grows with their square.
pub(super) const MOST_WALLS: usize = 5_000;
/// The box reaches so far beyond the footprint, metres: enough to have cells outside it.
const SIDE_MARGIN: f64 = 1.0;
/// Without a footprint the roof map ends where points do, give or take a pixel and the noise: so much farther, metres, the
/// box reaches that what lies outside is mostly empty.
const UNCERTAIN_SIDE: f64 = 2.0;
/// The box reaches so far above the highest roof point, metres: no plane can shoot up further than that.
const TOP_MARGIN: f64 = 0.4;
/// Traces reach so far beyond their ends, metres, to meet the planes that they end at.
const TRACE_MARGIN: f64 = 0.05;
/// Height jumps reach further: their ends are known to a pixel only.
const JUMP_MARGIN: f64 = 0.4;
/// A wall this long that was scanned this far from all that are known contradicts the footprint, metres: shorter ones are
/// dormers and balconies, and footprints are seldom better.
const STRAY_LENGTH: f64 = 3.0;
const STRAY_DISTANCE: f64 = 0.5;
/// A height jump this close to the line of a footprint edge or of another jump is on it, metres.
const SAME_LINE: f64 = 0.35;

/// All planes that cut the box, and the evidence about the roof.
#[derive(Debug, Clone)]
pub struct Hypotheses {
    /// Detected roofs first, in the order of detection, then undersides, then walls.
    pub primitives: Vec<Primitive>,
    /// How many of the primitives are roofs.
    pub roofs: usize,
    /// How many of the primitives are undersides.
    pub undersides: usize,
    /// Whether something was seen under a roof: an underside, or a wall that stands back.
    pub shows_overhang: bool,
    /// How many primitives were detected.
    pub detected: usize,
    /// Which roof primitive is on top where.
    pub map: RoofMap,
    /// The outline that the outer walls stand on; nowhere outside the footprint.
    pub footprint: Option<MultiPolygon<f64>>,
    /// For want of a footprint the outline of the roofs, give or take a pixel of the map.
    pub outline: Option<MultiPolygon<f64>>,
    /// That outline with its holes filled.
    envelope: Option<MultiPolygon<f64>>,
    /// The walls that were scanned, for want of a footprint: which primitive each became, and the box of its points.
    pub seen_walls: Vec<(usize, Aabb)>,
    /// The walls that were scanned where neither the footprint nor a step of the roof has one.
    pub strays: Vec<StrayWall>,
    /// The corners of roofs on which no point was scanned, but which a person says are there.
    pub asserted: Vec<Point3<f64>>,
    /// The box to cut: its bottom is the ground.
    pub bounds: Aabb,
    /// Standard deviation of the points across the surfaces that they sample, metres.
    pub noise: f64,
}

/// A wall that contradicts the footprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrayWall {
    /// How long it is, metres.
    pub length: f64,
    /// How far it is from the nearest wall that is known, metres.
    pub distance: f64,
}

impl Hypotheses {
    /// Concludes from the planes that were detected where roofs lie and walls stand.
    ///
    /// # Errors
    /// Fails where the points show no roof above the ground, or the outline has more corners than a model can have.
    pub fn new(site: &Site, detected: &Detected, parameters: &Parameters) -> Result<Self, Failure> {
        let mut roofs = detected.roofs.clone();
        if roofs.is_empty() {
            roofs.push(flat_roof(&site.points)?);
        }
        let outer = site.footprint.as_ref().map(|footprint| Walls::new(footprint, parameters.footprint_tolerance));
        let (footprint, edges) = outer.map_or((None, Vec::new()), |walls| (Some(walls.outline), walls.traces));
        if edges.len() > MOST_WALLS {
            let tolerance = parameters.footprint_tolerance;
            let detail =
                format!("the outline has {} corners to within {tolerance} m, more than {MOST_WALLS}", edges.len());
            return Err(Failure::new(Reason::TooComplex, detail));
        }
        let map = RoofMap::new(&site.points, &roofs, footprint.as_ref(), WALL_VERTICALITY)
            .ok_or_else(|| Failure::new(Reason::NoPrimitives, "no roof plane lies in the footprint"))?;
        let asserted: Vec<Point3<f64>> = roofs.iter().filter_map(Primitive::asserted).flatten().copied().collect();
        let bounds = bounds(site, &roofs, &asserted, footprint.as_ref(), detected.noise)?;
        let regions = map.extremes(roofs.len());
        for (roof, region) in roofs.iter_mut().zip(&regions) {
            reach(roof, region);
        }
        let outline = footprint.is_none().then(|| outline::of_map(&map));
        let mut hypotheses = Self {
            roofs: roofs.len(),
            undersides: detected.undersides.len(),
            shows_overhang: !detected.undersides.is_empty(),
            primitives: roofs,
            detected: detected.count,
            envelope: outline.as_ref().map(without_holes),
            outline,
            seen_walls: Vec::new(),
            strays: Vec::new(),
            asserted,
            map,
            footprint,
            bounds,
            noise: detected.noise,
        };
        hypotheses.primitives.extend(detected.undersides.iter().cloned());
        let revised = &regions[regions.len().saturating_sub(detected.revised)..];
        hypotheses.add_walls(site, &edges, detected, revised, parameters);
        Ok(hypotheses)
    }

    /// Walls from the footprint, from height jumps, around the regions of roofs that were `revised`, and, without a
    /// footprint, from the points.
    fn add_walls(
        &mut self,
        site: &Site,
        edges: &[Trace],
        detected: &Detected,
        revised: &[Vec<Point2<f64>>],
        parameters: &Parameters,
    ) {
        let options = JumpOptions {
            min_height: parameters.step_height.max(3.0 * detected.noise),
            min_length: parameters.step_length,
            ground: self.footprint.is_none().then_some(site.ground.height),
        };
        let walls: Vec<(Trace, Aabb, bool)> = detected
            .walls
            .iter()
            .zip(&detected.covered)
            .filter_map(|(wall, covered)| {
                let points = wall.inliers.iter().filter_map(|&i| site.points.get(i as usize));
                Some((wall_trace(wall, &site.points)?, Aabb::of(points)?, *covered))
            })
            .collect();
        let seen: Vec<Trace> = walls.iter().map(|(trace, ..)| *trace).collect();
        let mut main = height_jumps::main_directions(if edges.is_empty() { &seen } else { edges });
        if main.is_empty() {
            main = roof_directions(&self.primitives[..self.roofs], self.roof_points(site));
        }
        let mut jumps = height_jumps::traces(&self.map, &self.primitives, &main, &options);
        // What a first model left unexplained stands between walls of its own: its outline need not be straight enough to
        // be traced.
        jumps.extend(revised.iter().flat_map(|region| enclosure::around(region, &main)));
        // Without a footprint a wall that was scanned is known better than the border of the roofs over it, which is raster
        // and noise.
        if edges.is_empty() {
            let same_line = SAME_LINE.max(self.map.pixel() + 3.0 * detected.noise);
            trace::regularise(&mut jumps, &seen, same_line);
            let first = self.primitives.len() + edges.len() + jumps.len();
            self.seen_walls = (first..).zip(walls.iter().map(|(_, aabb, _)| *aabb)).collect();
            jumps.extend(seen);
        } else {
            trace::regularise(&mut jumps, edges, SAME_LINE);
        }
        let heights = [self.bounds.min[2] - 1.0, self.bounds.max[2] + 1.0];
        self.primitives.extend(edges.iter().map(|edge| edge.primitive(heights, TRACE_MARGIN)));
        self.primitives.extend(jumps.iter().map(|jump| jump.primitive(heights, JUMP_MARGIN)));
        if !edges.is_empty() {
            let far = STRAY_DISTANCE + 3.0 * detected.noise;
            let open = walls.iter().filter(|(.., covered)| !covered);
            self.strays = open
                .map(|(wall, ..)| {
                    let known = edges.iter().chain(&jumps).map(|known| known.deviation(wall));
                    StrayWall { length: wall.length(), distance: known.fold(f64::INFINITY, f64::min) }
                })
                .filter(|stray| stray.length >= STRAY_LENGTH && stray.distance > far && stray.distance.is_finite())
                .collect();
        }
        let drawn: Vec<Trace> = detected.added_walls.iter().filter_map(drawn_trace).collect();
        self.primitives.extend(drawn.iter().map(|wall| wall.primitive(heights, JUMP_MARGIN)));
        // Walls that stand back under a roof are in no outline and no height jump.
        for (trace, aabb, _) in walls.iter().filter(|(.., covered)| *covered) {
            if edges.iter().chain(&jumps).all(|known| known.deviation(trace) > SAME_LINE) {
                let [low, high] = [aabb.min[2], aabb.max[2]];
                self.primitives.push(trace.primitive([low - JUMP_MARGIN, high + JUMP_MARGIN], JUMP_MARGIN));
                self.shows_overhang = true;
                jumps.push(*trace);
            }
        }
    }

    /// Whether a point of the plan is in the footprint; without one, whether it is inside the outline of the roofs or
    /// near it, holes filled: over all that is built there is a roof, and beyond the last that was seen is none.
    pub fn covers(&self, p: &Point2<f64>) -> bool {
        let p = geo::Point::new(p.x, p.y);
        let reach = 2.0 * self.map.pixel();
        let near = |envelope: &MultiPolygon<f64>| {
            envelope.iter().any(|part| part.contains(&p) || Euclidean.distance(part, &p) <= reach)
        };
        match (&self.footprint, &self.envelope) {
            (Some(footprint), _) => footprint.contains(&p),
            (None, envelope) => envelope.as_ref().is_none_or(near),
        }
    }

    /// The planes that the scanned walls became in a complex, each with the box in which it was seen.
    pub fn seen_walls<'a>(&'a self, complex: &'a Complex) -> impl Iterator<Item = (PlaneId, Aabb)> + 'a {
        self.seen_walls.iter().filter_map(|(wall, seen)| Some((complex.primitive_planes.get(*wall)?.plane, *seen)))
    }

    /// The planes that the undersides became in a complex, each with the box in which it was seen.
    pub fn undersides<'a>(&'a self, complex: &'a Complex) -> impl Iterator<Item = (PlaneId, Aabb)> + 'a {
        let primitives = self.primitives.iter().zip(&complex.primitive_planes).skip(self.roofs).take(self.undersides);
        primitives.filter_map(|(primitive, plane)| match &primitive.extent {
            Extent::Patch(corners) => Some((plane.plane, Aabb::of(corners)?)),
            Extent::Everywhere => None,
        })
    }

    /// The points on roof primitives.
    pub fn roof_points<'a>(&'a self, site: &'a Site) -> impl Iterator<Item = &'a Point3<f64>> {
        self.primitives.iter().take(self.roofs).flat_map(|p| &p.inliers).filter_map(|&i| site.points.get(i as usize))
    }
}

/// For want of planes: one horizontal roof at the median height of all points.
fn flat_roof(points: &[Point3<f64>]) -> Result<Primitive, Failure> {
    let mut heights: Vec<f64> = points.iter().map(|p| p.z).collect();
    heights.sort_by(f64::total_cmp);
    let height = heights
        .get(heights.len() / 2)
        .ok_or_else(|| Failure::new(Reason::TooFewPoints, "no point is left to make a roof from"))?;
    let spread = heights.iter().map(|z| (z - height).powi(2)).sum::<f64>() / heights.len() as f64;
    Ok(Primitive {
        kind: PrimitiveKind::Detected,
        plane: Plane::through(&Point3::new(0.0, 0.0, *height), Vector3::z_axis()),
        inliers: (0..points.len() as u32).collect(),
        residual: spread.sqrt(),
        extent: Extent::Everywhere,
    })
}

/// The box to cut: the footprint (or the points) with a margin, from the ground to just above the roofs.
fn bounds(
    site: &Site,
    roofs: &[Primitive],
    asserted: &[Point3<f64>],
    footprint: Option<&MultiPolygon<f64>>,
    noise: f64,
) -> Result<Aabb, Failure> {
    let seen = roofs.iter().flat_map(|p| &p.inliers).filter_map(|&i| site.points.get(i as usize)).chain(asserted);
    let mut bounds = Aabb::of(seen).ok_or_else(|| Failure::new(Reason::NoPrimitives, "no roof plane has points"))?;
    if let Some(rect) = footprint.and_then(geo::BoundingRect::bounding_rect) {
        (bounds.min[0], bounds.min[1]) = rect.min().x_y();
        (bounds.max[0], bounds.max[1]) = rect.max().x_y();
    }
    let margin = SIDE_MARGIN + if footprint.is_none() { UNCERTAIN_SIDE + 3.0 * noise } else { 0.0 };
    for axis in 0..2 {
        bounds.min[axis] -= margin;
        bounds.max[axis] += margin;
    }
    bounds.max[2] += TOP_MARGIN;
    bounds.min[2] = site.ground.height;
    if bounds.min[2] + TOP_MARGIN >= bounds.max[2] {
        let detail =
            format!("the highest roof point lies {:.2} m below the ground", bounds.min[2] - bounds.max[2] + TOP_MARGIN);
        return Err(Failure::new(Reason::NothingInside, detail));
    }
    Ok(bounds)
}

fn without_holes(outline: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    outline.iter().map(|part| Polygon::new(part.exterior().clone(), Vec::new())).collect()
}

/// Lets a roof reach as far as the roof map sees it, which is farther than its inliers where points are missing; `region`
/// holds corners of the convex hull of that.
fn reach(roof: &mut Primitive, region: &[Point2<f64>]) {
    let hull = geo::ConvexHull::convex_hull(&region.iter().map(|p| geo::Point::new(p.x, p.y)).collect::<MultiPoint>());
    let corners: Vec<Point3<f64>> = hull
        .exterior()
        .coords()
        .skip(1)
        .filter_map(|c| roof.plane.height_at(c.x, c.y).map(|z| Point3::new(c.x, c.y, z)))
        .collect();
    if corners.len() >= 3 {
        roof.extent = Extent::Patch(corners);
    }
}

/// The trace of a wall that was scanned.
fn wall_trace(wall: &Primitive, points: &[Point3<f64>]) -> Option<Trace> {
    let normal = Unit::try_new(wall.plane.normal.xy(), 1e-6)?;
    let mean = wall
        .inliers
        .iter()
        .filter_map(|&i| points.get(i as usize))
        .fold((Vector3::zeros(), 0.0), |(s, n), p| (s + p.coords, n + 1.0));
    let mean = (mean.0 / f64::max(mean.1, 1.0)).xy();
    let mut trace = Trace { normal, offset: normal.dot(&mean), span: [0.0, 0.0], kind: PrimitiveKind::HeightJump };
    let along = trace.direction();
    let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in wall.inliers.iter().filter_map(|&i| points.get(i as usize)) {
        let t = along.dot(&p.coords.xy());
        (from, to) = (from.min(t), to.max(t));
    }
    trace.span = [from, to];
    (from < to).then_some(trace)
}

/// The trace of a wall that a person added: along the longest side of what was drawn of it.
fn drawn_trace(wall: &Primitive) -> Option<Trace> {
    let Extent::Patch(corners) = &wall.extent else { return None };
    let pairs = corners.iter().flat_map(|a| corners.iter().map(move |b| [a.xy(), b.xy()]));
    let [a, b] = pairs.max_by(|[a, b], [c, d]| (a - b).norm_squared().total_cmp(&(c - d).norm_squared()))?;
    Trace::between(a, b, PrimitiveKind::HeightJump)
}

/// Main directions for want of walls: those in which the roofs descend, else those of the smallest rectangle around their
/// `points`.
fn roof_directions<'a>(roofs: &[Primitive], points: impl Iterator<Item = &'a Point3<f64>>) -> Vec<Vector2<f64>> {
    let descent = roofs.iter().find_map(|roof| Unit::try_new(roof.plane.normal.xy(), 0.05));
    let side = || {
        let plan: MultiPoint<f64> = points.map(|p| (p.x, p.y)).collect();
        let rectangle = plan.minimum_rotated_rect()?;
        let corners: Vec<_> = rectangle.exterior().coords().take(2).collect();
        let [a, b] = corners[..] else { return None };
        Unit::try_new(Vector2::new(b.x - a.x, b.y - a.y), 1e-6)
    };
    let along = descent.or_else(side).map_or_else(Vector2::x, Unit::into_inner);
    vec![along, Vector2::new(-along.y, along.x)]
}
