//! LoD 2.3: roofs that reach beyond the walls under them.
//!
//! First the roofs get a model of their own, as if the walls stood on their outline. Then its cells are cut once more, as
//! exactly as before: by the walls that stand, and outside these by the undersides of the roofs. What lies below the
//! undersides goes; walls that are nearly on the outline of the roofs are on it, so that no roof hangs over by a hair.

use geo::{BooleanOps, Contains, MultiPolygon};
use nalgebra::Point3;

use super::complex::{CellId, Complex, Cutter, PlaneId};
use super::confidence::Confidence;
use super::edited::Tally;
use super::means::Means;
use super::primitives::trace::{self, Trace};
use super::primitives::walls::Walls;
use super::standing::Standing;
use super::surface::{self, Labelled, Shell, SurfaceParameters};
use super::{Parameters, Partitioned, attempt, edited, footprint, ladder, semantics};
use crate::geometry::{Aabb, Cover, Plane};
use crate::solid::Solid;
use crate::validate;

/// A wall this close to the outline of the roofs, metres, stands on it: outlines of roofs are drawn no better.
const SAME_LINE: f64 = 0.1;
/// What rises more than this (the z of its unit normal) is a roof and has an underside.
const RISES: f64 = 0.173_648;
/// Walls cut so far beyond their ends, metres, to meet one another.
const MARGIN: f64 = 0.05;
/// What is nearer to a plane than this, metres, is on it.
const NOTHING: f64 = 1e-6;

/// The model of LoD 2.3 of a site.
///
/// # Errors
/// Why there is none.
pub(super) fn of_site(standing: &Standing, parameters: &Parameters, means: Means) -> Result<Vec<Solid>, String> {
    let site = &*standing.site;
    let eaves = site.eaves.as_ref().ok_or("no outline of its roof is known")?;
    if standing.is_partial {
        return Err("the tiles cover it in part".to_owned());
    }
    let walls = site.footprint.as_ref().ok_or("there is no footprint")?;
    let mut roofs = site.clone();
    roofs.points.extend(&eaves.points);
    roofs.points.sort_unstable_by(|a, b| {
        a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
    });
    roofs.points.dedup();
    let roofs = roofs.with_footprint(&walls.union(&eaves.outline));
    let whole = footprint::parted(&roofs, parameters.step(&roofs.frame));
    let whole = edited::parts(whole, &mut Tally::default());
    let try_with = |parameters: &Parameters| attempt(&roofs, &whole, Some(walls), parameters, means.quietly());
    let attempt = ladder::descend(parameters, try_with);
    match (attempt.result, attempt.overhanging) {
        (Err(failure), _) => Err(failure.detail),
        (Ok(_), Some(overhanging)) => overhanging,
        (Ok(_), None) => Err("nothing was made of it".to_owned()),
    }
}

/// The solids that stand on `walls` (local metres), of what was labelled `inside` under the outline of the roofs, whose
/// shells these are.
///
/// # Errors
/// Why there are none.
pub(super) fn of_cells(
    building: &Partitioned,
    inside: &[bool],
    shells: &[Shell],
    walls: &MultiPolygon<f64>,
    parameters: &Parameters,
) -> Result<Vec<Solid>, String> {
    let site = building.site;
    let outline = site.footprint.as_ref().ok_or("there is no outline of the roofs")?;
    let reach = parameters.footprint_tolerance;
    let Walls { outline: standing, mut traces } = Walls::new(walls, reach);
    trace::regularise(&mut traces, &Walls::new(outline, reach).traces, SAME_LINE);
    let roofs = Roofs::of(&building.complex, shells);
    let mut cells = Cells::new(building.complex.clone(), inside);
    for trace in &traces {
        cells.cut_along(trace, site.ground.height);
    }
    let is_under_eaves = |place: &Point3<f64>| !standing.contains(&geo::Point::new(place.x, place.y));
    cells.hollow(&roofs, parameters.eaves_thickness, is_under_eaves);
    let Cells { cutter, inside } = cells;
    let complex = cutter.into_complex();
    let occupancy: Vec<f64> = inside.iter().map(|inside| f64::from(u8::from(*inside))).collect();
    let volumes: Vec<f64> = (0..complex.cells.len() as u32).map(|cell| complex.cell_moments(cell).0).collect();
    let labelled =
        Labelled { complex: &complex, inside: &inside, occupancy: &occupancy, volumes: &volumes, fixed: &[] };
    // Eaves are as thin as they are.
    let surface = SurfaceParameters { minimum_feature: 0.0 };
    let step = parameters.step(&site.frame);
    let extraction = surface::extract(&labelled, step, &surface).map_err(|error| error.to_string())?;
    let mut solids = Vec::with_capacity(extraction.shells.len());
    for mut shell in extraction.shells {
        semantics::assign(&mut shell.solid, &shell.planes, Some(walls), &Confidence::default());
        if let Some(fault) = validate::check(&shell.solid, &validate::Tolerances::written()).first() {
            return Err(fault.to_string());
        }
        solids.push(shell.solid);
    }
    ladder::check_parts(&solids).map_err(|failure| failure.detail)?;
    if solids.is_empty() { Err("nothing stands on its walls".to_owned()) } else { Ok(solids) }
}

/// The roofs of a model: their planes, where each lies, and how high they are.
struct Roofs {
    /// Each face that rises: its plane, pointing up, and its box.
    faces: Vec<(Plane, Aabb)>,
    /// All of them.
    cover: Cover,
}

impl Roofs {
    fn of(complex: &Complex, shells: &[Shell]) -> Self {
        let mut faces = Vec::new();
        let mut triangles = Vec::new();
        for Shell { solid, planes } in shells {
            for face in &solid.faces {
                let Some(ring) = face.rings.first() else { continue };
                let normal = solid.newell(ring);
                if normal.z <= RISES * normal.norm() {
                    continue;
                }
                let plane: Option<PlaneId> = planes.get(face.surface as usize).map(|(plane, _)| *plane);
                let Some(plane) = plane.and_then(|plane| complex.planes.get(plane as usize)) else { continue };
                let plane = plane.to_plane();
                let plane = if plane.normal.z < 0.0 { plane.flipped() } else { plane };
                let corners: Vec<Point3<f64>> = ring.iter().map(|&vertex| solid.point(vertex)).collect();
                faces.extend(Aabb::of(&corners).map(|aabb| (plane, aabb)));
                triangles.extend(solid.triangles(face));
            }
        }
        Self { faces, cover: Cover::new(triangles) }
    }

    /// The undersides of the roofs over a box, `thickness` metres below them.
    fn undersides<'a>(&'a self, over: &'a Aabb, thickness: f64) -> impl Iterator<Item = Plane> + 'a {
        let meets = |aabb: &Aabb| (0..2).all(|i| aabb.min[i] <= over.max[i] && over.min[i] <= aabb.max[i]);
        let above = self.faces.iter().filter(move |(_, aabb)| meets(aabb));
        above.map(move |(plane, _)| Plane { offset: plane.offset + thickness * plane.normal.z, ..*plane })
    }

    /// How far a place lies below the next roof over it, metres; `None` where there is none.
    fn depth(&self, place: &Point3<f64>) -> Option<f64> {
        let depths = self.cover.heights(place.x, place.y).map(|height| height - place.z);
        depths.filter(|depth| *depth >= -NOTHING).min_by(f64::total_cmp)
    }
}

/// The cells of a complex that is cut further, each with its label; what is cut off has that of the whole.
struct Cells {
    cutter: Cutter,
    inside: Vec<bool>,
}

impl Cells {
    fn new(complex: Complex, inside: &[bool]) -> Self {
        let mut inside = inside.to_vec();
        inside.resize(complex.cells.len(), false);
        Self { cutter: Cutter::new(complex), inside }
    }

    /// Cuts a cell by a plane; returns the part on the positive side, if it parts it.
    fn cut(&mut self, cell: CellId, plane: PlaneId) -> Option<CellId> {
        let new = self.cutter.cut(cell, plane)?;
        self.inside.push(self.inside[cell as usize]);
        Some(new)
    }

    /// The cells that are inside.
    fn members(&self) -> Vec<CellId> {
        (0u32..).zip(&self.inside).filter(|(_, inside)| **inside).map(|(cell, _)| cell).collect()
    }

    fn corners(&self, cell: CellId) -> impl Iterator<Item = Point3<f64>> + '_ {
        let complex = self.cutter.complex();
        complex.cells[cell as usize].facets.iter().flat_map(|&facet| complex.facet_positions(facet))
    }

    /// Cuts the cells inside that a wall crosses.
    fn cut_along(&mut self, wall: &Trace, ground: f64) {
        let upright = wall.primitive([ground, ground + 1.0], 0.0).plane;
        let Some(plane) = self.cutter.plane(&upright) else { return };
        let along = wall.direction();
        for cell in self.members() {
            let (mut span, mut sides) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
            for corner in self.corners(cell) {
                let (t, d) = (along.dot(&corner.coords.xy()), wall.distance(&corner.xy()));
                span = [span[0].min(t), span[1].max(t)];
                sides = [sides[0].min(d), sides[1].max(d)];
            }
            let is_crossed = sides[0] < -NOTHING && sides[1] > NOTHING;
            if is_crossed && span[0] <= wall.span[1] + MARGIN && wall.span[0] - MARGIN <= span[1] {
                self.cut(cell, plane);
            }
        }
    }

    /// Takes away what lies under the eaves, deeper than `thickness` below the roofs.
    fn hollow(&mut self, roofs: &Roofs, thickness: f64, is_under_eaves: impl Fn(&Point3<f64>) -> bool) {
        for cell in self.members() {
            if !is_under_eaves(&self.cutter.complex().cell_moments(cell).1) {
                continue;
            }
            let corners: Vec<Point3<f64>> = self.corners(cell).collect();
            let Some(aabb) = Aabb::of(&corners) else { continue };
            let mut pieces = vec![cell];
            for underside in roofs.undersides(&aabb, thickness) {
                let Some(plane) = self.cutter.plane(&underside) else { continue };
                let new: Vec<CellId> = pieces.iter().filter_map(|&piece| self.cut(piece, plane)).collect();
                pieces.extend(new);
            }
            for piece in pieces {
                let centroid = self.cutter.complex().cell_moments(piece).1;
                self.inside[piece as usize] = roofs.depth(&centroid).is_some_and(|depth| depth < thickness);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use geo::{MultiPolygon, polygon};
    use nalgebra::Point3;

    use super::super::{occupancy::HeightField, reconstruct};
    use super::*;
    use crate::building::Building;
    use crate::site::{Eaves, Frame, Site};
    use crate::solid::SurfaceType;

    fn rectangle(x: [f64; 2], y: [f64; 2]) -> MultiPolygon<f64> {
        MultiPolygon(vec![polygon![(x: x[0], y: y[0]), (x: x[1], y: y[0]), (x: x[1], y: y[1]), (x: x[0], y: y[1])]])
    }

    /// A building on walls of 10 m by 8 m whose roof has this height at a place of the given outline.
    fn building(height: impl Fn(f64, f64) -> f64, roof: ([f64; 2], [f64; 2]), levels: &str) -> Building {
        let (walls, outline) = (rectangle([0.0, 10.0], [0.0, 8.0]), rectangle(roof.0, roof.1));
        let steps =
            |[from, to]: [f64; 2]| (0..((to - from) * 4.0) as u32).map(move |i| from + 0.125 + f64::from(i) / 4.0);
        let places = steps(roof.0).flat_map(|x| steps(roof.1).map(move |y| (x, y)));
        let points: Vec<Point3<f64>> = places.map(|(x, y)| Point3::new(x, y, height(x, y))).collect();
        let is_within = |p: &Point3<f64>| walls.contains(&geo::Point::new(p.x, p.y));
        let (points, under): (Vec<_>, Vec<_>) = points.into_iter().partition(is_within);
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let mut site = Site::new("eaves", frame, points, 0.0).with_footprint(&walls);
        site.eaves = Some(Eaves { outline, points: under });
        let parameters = Parameters { lod: levels.parse().unwrap(), eaves_thickness: 0.25, ..Parameters::default() };
        reconstruct(&site, &parameters, &HeightField)
    }

    fn area(solid: &Solid, kind: SurfaceType) -> f64 {
        solid.faces.iter().filter(|face| solid.kind(face) == kind).map(|face| solid.area(face)).sum()
    }

    #[test]
    fn a_gable_hangs_over_its_eaves() {
        // Half a metre over the eaves, flush at one verge, 4 cm over the other: that is drawn no better.
        let found = building(|_, y| 9.0 - (y - 4.0).abs(), ([0.0, 10.04], [-0.5, 8.5]), "2.2,2.3");
        let [solid] = found.model.lod23().collect::<Vec<_>>()[..] else { panic!("{:?}", found.notes) };
        let ground = area(solid, SurfaceType::Ground);
        assert!((ground - 80.0).abs() < 0.5, "{ground}");
        // Two strips of 10 m by 0.5 m at 45°.
        let ceiling = area(solid, SurfaceType::OuterCeiling);
        assert!((ceiling - 2.0 * 10.0 * 0.5 * 2f64.sqrt()).abs() < 0.2, "{ceiling}");
        let roof = area(solid, SurfaceType::Roof);
        assert!((roof - 9.0 * 10.0 * 2f64.sqrt()).abs() < 1.0, "{roof}");
        // The house, and eaves of 0.25 m measured upright.
        assert!((solid.volume() - (80.0 * 7.0 + 2.0 * 10.0 * 0.5 * 0.25)).abs() < 4.0, "{}", solid.volume());
        let lowest_eave = solid.vertices.iter().map(|v| v[2] as f64 * solid.step[2]).filter(|z| *z > 0.1);
        let lowest_eave = lowest_eave.fold(f64::INFINITY, f64::min);
        assert!((lowest_eave - 4.25).abs() < 0.05, "{lowest_eave}");
        assert!(found.measures.rmse_lod23.unwrap() < 0.02 && found.measures.volume_lod23 == Some(solid.volume()));
        // The model of LoD 2.2 stays on its walls.
        let [inner] = found.model.lod22().collect::<Vec<_>>()[..] else { panic!("{:?}", found.notes) };
        assert_eq!(area(inner, SurfaceType::OuterCeiling), 0.0);
    }

    #[test]
    fn a_flat_roof_hangs_over_on_all_sides_and_a_canopy_at_its_step() {
        // 6 m, and a canopy of 2 m beside it at 3 m.
        let height = |x: f64, _: f64| if x > 10.5 { 3.0 } else { 6.0 };
        let found = building(height, ([-0.5, 12.5], [-0.5, 8.5]), "2.3");
        let solids: Vec<_> = found.model.lod23().collect();
        let ground: f64 = solids.iter().map(|solid| area(solid, SurfaceType::Ground)).sum();
        assert!((ground - 80.0).abs() < 0.5, "{ground} {:?}", found.notes);
        let volume: f64 = solids.iter().map(|solid| solid.volume()).sum();
        let eaves = 0.25 * (11.0 * 9.0 - 80.0) + 0.25 * 2.0 * 9.0;
        assert!((volume - (480.0 + eaves)).abs() < 3.0, "{volume}");
        assert!(found.model.lod22().next().is_none());
    }

    #[test]
    fn without_an_outline_of_the_roof_there_is_none() {
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let points = (0..400).map(|i| Point3::new(f64::from(i % 20) / 2.0, f64::from(i / 20) / 2.5, 6.0)).collect();
        let site = Site::new("a", frame, points, 0.0).with_footprint(&rectangle([0.0, 10.0], [0.0, 8.0]));
        let parameters = Parameters { lod: "2.2,2.3".parse().unwrap(), ..Parameters::default() };
        let found = reconstruct(&site, &parameters, &HeightField);
        assert!(found.model.lod23().next().is_none() && found.model.lod22().next().is_some());
        assert!(found.notes.iter().any(|note| note == "it has no LoD 2.3: no outline of its roof is known"));
    }
}
