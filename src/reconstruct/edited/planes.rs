//! Planes that are switched off, added, turned and moved.

use nalgebra::{Point3, Unit, Vector2, Vector3};

use super::{Tally, local, plane};
use crate::edits::{Action, Edit, Lie, Place, PlaneAt};
use crate::geometry::{Aabb, Plane};
use crate::reconstruct::Detected;
use crate::reconstruct::hypotheses::WALL_VERTICALITY;
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use crate::site::{Frame, Site};

/// A plane is the one that is meant if it is turned by no more than this, degrees, …
const SAME_ANGLE: f64 = 10.0;
/// … passes the middle of the other within this, metres, …
const SAME_DISTANCE: f64 = 0.5;
/// … and reaches to where the other was, give or take so much, metres.
const SAME_REACH: f64 = 0.5;
/// A point this near to an added plane is on it, metres, if the places that were picked do not say more.
const ON_PLANE: f64 = 0.15;
/// No point is on an added plane that is farther from it than this, metres.
const FARTHEST: f64 = 1.0;
/// An added plane takes points so far beyond its places, metres.
const BESIDE: f64 = 0.3;
/// So many points bear witness to a plane.
const FEWEST: usize = 3;
/// An added plane has no more places than this: more make it no better.
const MOST_PLACES: usize = 100_000;

/// What a plane is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Roof,
    Underside,
    Wall { covered: bool },
}

/// A plane while edits are applied.
struct Known {
    primitive: Primitive,
    part: Part,
    is_on: bool,
    is_added: bool,
    /// Whether it was added, turned or moved.
    is_edited: bool,
}

impl Detected {
    /// Applies the edits of the planes of a site.
    pub(in crate::reconstruct) fn edit(&mut self, site: &Site) {
        let touches = |edit: &Edit| {
            use Action::{AddPlane, AlignPlane, MovePlane, SwitchPlane};
            matches!(edit.action, SwitchPlane { .. } | AddPlane { .. } | AlignPlane { .. } | MovePlane { .. })
        };
        if !site.edits.iter().any(touches) {
            return;
        }
        let mut planes = self.take();
        let mut tally = Tally::default();
        for (index, edit) in site.edits.iter().enumerate().filter(|(_, edit)| touches(edit)) {
            tally.note(index, one(&mut planes, site, &edit.action, self.noise));
        }
        self.put(planes);
        self.tally = tally;
    }

    fn take(&mut self) -> Vec<Known> {
        let known = |part| move |primitive| Known { primitive, part, is_on: true, is_added: false, is_edited: false };
        let roofs = std::mem::take(&mut self.roofs).into_iter().map(known(Part::Roof));
        let undersides = std::mem::take(&mut self.undersides).into_iter().map(known(Part::Underside));
        let covered = std::mem::take(&mut self.covered);
        let walls = std::mem::take(&mut self.walls).into_iter().zip(covered);
        let walls = walls.map(|(primitive, covered)| known(Part::Wall { covered })(primitive));
        roofs.chain(undersides).chain(walls).collect()
    }

    fn put(&mut self, planes: Vec<Known>) {
        for plane in &planes {
            if !plane.is_on {
                self.off.extend(&plane.primitive.inliers);
            }
        }
        self.off.sort_unstable();
        self.off.dedup();
        let mut added = Vec::new();
        for Known { primitive, part, is_on, is_added, is_edited } in planes {
            if is_edited {
                self.edited.push(primitive.plane);
            }
            if !is_on {
                self.off_planes.push(primitive);
                continue;
            }
            match part {
                Part::Roof if is_added => added.push(primitive),
                Part::Roof => self.roofs.push(primitive),
                Part::Underside => self.undersides.push(primitive),
                Part::Wall { .. } if is_added => self.added_walls.push(primitive),
                Part::Wall { covered } => {
                    self.walls.push(primitive);
                    self.covered.push(covered);
                }
            }
        }
        // Walls are put up around what was added, as around what a revision adds.
        self.revised += added.len();
        self.roofs.extend(added);
    }
}

/// Applies one edit.
fn one(planes: &mut Vec<Known>, site: &Site, action: &Action, noise: f64) -> Result<(), String> {
    match action {
        Action::SwitchPlane { plane, on } => {
            let at = find(planes, &site.frame, plane, |known| known.is_on != *on)?;
            planes[at].is_on = *on;
            Ok(())
        }
        Action::AddPlane { places, lie, unseen } => {
            let known = added(site, places, *lie, *unseen, noise)?;
            if known.part == Part::Roof {
                // Each point is on one plane.
                for other in planes.iter_mut().filter(|other| matches!(other.part, Part::Roof | Part::Underside)) {
                    other.primitive.inliers.retain(|i| known.primitive.inliers.binary_search(i).is_err());
                }
                planes
                    .retain(|other| other.part != Part::Roof || other.is_added || !other.primitive.inliers.is_empty());
            }
            planes.push(known);
            Ok(())
        }
        Action::AlignPlane { plane, lie } => {
            let at = find(planes, &site.frame, plane, |known| known.is_on)?;
            let old = &planes[at].primitive;
            let middle = middle(old, &site.points);
            let normal = lying(&site.frame, *lie, Some(&old.plane.normal))?;
            turn(&mut planes[at], Plane::through(&middle, normal), &site.points)
        }
        Action::MovePlane { plane: old, to } => {
            let at = find(planes, &site.frame, old, |known| known.is_on)?;
            let to = plane(&site.frame, *to)?;
            turn(&mut planes[at], to, &site.points)
        }
        _ => Ok(()),
    }
}

/// The plane that is meant among those that `may` be.
fn find(planes: &[Known], frame: &Frame, wanted: &PlaneAt, may: impl Fn(&Known) -> bool) -> Result<usize, String> {
    let own = plane(frame, wanted.equation)?;
    let corners = wanted.extent.iter().map(|place| local(frame, *place)).collect::<Result<Vec<_>, _>>()?;
    let bounds = Aabb::of(&corners).ok_or_else(|| "the plane has no extent".to_owned())?;
    let centre = Point3::from(corners.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / corners.len() as f64);
    let score = |known: &Known| {
        let Primitive { plane, extent, .. } = &known.primitive;
        let angle = plane.normal.dot(&own.normal).abs().clamp(0.0, 1.0).acos().to_degrees();
        let distance = plane.distance(&centre).abs();
        let overlap = match extent {
            Extent::Patch(corners) => overlap(&Aabb::of(corners)?, &bounds)?,
            Extent::Everywhere => 0.0,
        };
        let fits = angle <= SAME_ANGLE && distance <= SAME_DISTANCE;
        fits.then_some(angle / SAME_ANGLE + distance / SAME_DISTANCE + 1.0 - overlap)
    };
    let scored =
        planes.iter().enumerate().filter(|(_, known)| may(known)).filter_map(|(i, known)| Some((score(known)?, i)));
    scored.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, i)| i).ok_or_else(|| {
        let [x, y, z] = frame.to_crs(&centre);
        format!(
            "no such plane was found at ({x:.2}, {y:.2}, {z:.2}): none within {SAME_DISTANCE} m and {SAME_ANGLE}° of it"
        )
    })
}

/// How much of two boxes is common to both, 0 to 1; `None` where they are apart.
fn overlap(a: &Aabb, b: &Aabb) -> Option<f64> {
    let mut share = 1.0;
    for axis in 0..3 {
        let common = a.max[axis].min(b.max[axis]) - a.min[axis].max(b.min[axis]) + SAME_REACH;
        if common < 0.0 {
            return None;
        }
        let whole = a.max[axis].max(b.max[axis]) - a.min[axis].min(b.min[axis]) + SAME_REACH;
        share *= common / whole;
    }
    Some(share)
}

/// Turns or moves a plane; its points stay on it.
fn turn(known: &mut Known, to: Plane, points: &[Point3<f64>]) -> Result<(), String> {
    let to = if to.normal.z < 0.0 { to.flipped() } else { to };
    let inliers = known.primitive.inliers.clone();
    let turned = Primitive::on_plane(to, points, inliers);
    known.primitive = turned.ok_or_else(|| "its points are on one line of the plane as it would be".to_owned())?;
    known.is_edited = true;
    let stands = known.primitive.plane.verticality() > WALL_VERTICALITY;
    known.part = match (known.part, stands) {
        (Part::Roof | Part::Underside, true) => {
            known.is_added = true;
            Part::Wall { covered: false }
        }
        (Part::Wall { .. }, false) => Part::Roof,
        (part, _) => part,
    };
    Ok(())
}

/// A plane that was added.
fn added(site: &Site, places: &[Place], lie: Option<Lie>, unseen: bool, noise: f64) -> Result<Known, String> {
    if places.len() < FEWEST || places.len() > MOST_PLACES {
        return Err(format!("a plane through {} places, {FEWEST} to {MOST_PLACES} are expected", places.len()));
    }
    let places = places.iter().map(|place| local(&site.frame, *place)).collect::<Result<Vec<_>, _>>()?;
    let own = fitted(&site.frame, &places, lie)?;
    let all = (0..places.len() as u32).collect();
    let on_line = || "the places are on one line".to_owned();
    let shape = Primitive::on_plane(own, &places, all).ok_or_else(on_line)?;
    let Extent::Patch(corners) = &shape.extent else { return Err(on_line()) };
    let loosest = places.iter().map(|p| own.distance(p).abs()).fold(0.0, f64::max);
    let near = loosest.max(3.0 * noise).clamp(ON_PLANE, FARTHEST);
    let is_on = |p: &Point3<f64>| own.distance(p).abs() <= near && is_beside(&own, corners, p);
    let inliers: Vec<u32> = (0..).zip(&site.points).filter(|(_, p)| is_on(p)).map(|(i, _)| i).collect();
    let count = inliers.len();
    let seen = if count >= FEWEST { Primitive::on_plane(own, &site.points, inliers) } else { None };
    let stands = own.verticality() > WALL_VERTICALITY;
    let primitive = match seen {
        // A wall cuts as far as it was drawn.
        Some(seen) if stands => Primitive { extent: shape.extent, ..seen },
        Some(seen) => seen,
        None if unseen || stands => Primitive { kind: PrimitiveKind::Detected, inliers: Vec::new(), ..shape },
        None => {
            return Err(format!("{count} point(s) lie on it, at least {FEWEST} are expected of a plane that was seen"));
        }
    };
    let part = if stands { Part::Wall { covered: false } } else { Part::Roof };
    Ok(Known { primitive, part, is_on: true, is_added: true, is_edited: true })
}

/// Whether the projection of a point is in a convex polygon on a plane, counter-clockwise seen from the side of the normal, or
/// beside it.
fn is_beside(plane: &Plane, corners: &[Point3<f64>], p: &Point3<f64>) -> bool {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    edges.filter_map(|(a, b)| Some((a, (b - a).try_normalize(1e-9)?))).all(|(a, along)| {
        let inward = plane.normal.cross(&along);
        inward.dot(&(p - a)) >= -BESIDE
    })
}

/// The plane nearest to some places.
fn fitted(frame: &Frame, places: &[Point3<f64>], lie: Option<Lie>) -> Result<Plane, String> {
    let middle = Point3::from(places.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / places.len() as f64);
    let on_line = || "the places are on one line".to_owned();
    match lie {
        None => Plane::fit(places).map(|(plane, _)| plane).ok_or_else(on_line),
        Some(Lie::Vertical) => {
            // The direction in which the places vary least in the plan.
            let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
            for d in places.iter().map(|p| p - middle) {
                (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
            }
            let along = 0.5 * f64::atan2(2.0 * xy, xx - yy);
            if xx + yy <= 1e-6 {
                return Err(on_line());
            }
            let normal = Vector3::new(-along.sin(), along.cos(), 0.0);
            Ok(Plane::through(&middle, Unit::new_normalize(normal)))
        }
        Some(lie) => Ok(Plane::through(&middle, lying(frame, lie, None)?)),
    }
}

/// The normal of a plane that lies so, pointing up; `old` is the one that it had.
fn lying(frame: &Frame, lie: Lie, old: Option<&Unit<Vector3<f64>>>) -> Result<Unit<Vector3<f64>>, String> {
    let normal = match lie {
        Lie::Level => Vector3::z(),
        Lie::Vertical => {
            let flat = old.map_or_else(Vector2::zeros, |old| old.xy());
            Vector3::new(flat.x, flat.y, 0.0)
        }
        Lie::Parallel(normal) => Vector3::from(normal).component_div(&Vector3::from(frame.metres_per_unit)),
    };
    let unit = Unit::try_new(normal, 1e-6).filter(|_| normal.norm().is_finite());
    let unit = unit.ok_or_else(|| "nothing says which way the plane would face".to_owned())?;
    Ok(if unit.z < 0.0 { -unit } else { unit })
}

/// The middle of what was seen of a plane.
fn middle(primitive: &Primitive, points: &[Point3<f64>]) -> Point3<f64> {
    let own: Vec<&Point3<f64>> = primitive.inliers.iter().filter_map(|&i| points.get(i as usize)).collect();
    let sum = own.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
    match (&primitive.extent, own.len()) {
        (Extent::Patch(corners), 0) if !corners.is_empty() => {
            Point3::from(corners.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords) / corners.len() as f64)
        }
        (_, count) => Point3::from(sum / count.max(1) as f64),
    }
}
