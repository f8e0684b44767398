//! LoD 1.3: blocks with a step wherever the roof has one.
//!
//! The model of LoD 2.2 says where its roofs meet: those that share an edge, or between which the wall is lower than the
//! step that is asked for, become one level top. The walls between the others and those of the outline cut a complex of
//! its own, so that the blocks hold by the same exact construction as the model.

use std::collections::BTreeMap;

use geo::MultiPolygon;
use nalgebra::{Point2, Point3, Vector3};

use super::complex::Complex;
use super::confidence::Confidence;
use super::primitives::trace::{self, Trace};
use super::primitives::{Extent, Primitive, PrimitiveKind};
use super::surface::{self, Labelled};
use super::{Parameters, measures, semantics};
use crate::geometry::{Aabb, Cover, Plane, newell};
use crate::site::Site;
use crate::solid::{Face, Solid, SurfaceType};
use crate::validate;

/// Walls of the model this close to one line are on it, metres: its vertices are rounded to the grid.
const SAME_LINE: f64 = 0.02;
/// Cuts reach so far beyond the ends of what they cut, metres.
const MARGIN: f64 = 0.05;
/// The box reaches so far beyond the model, metres.
const AROUND: f64 = 1.0;

/// The blocks of LoD 1.3: for each of the `solids` of LoD 2.2 those that stand for it, and without these for each of the
/// `blocks` of LoD 1.2 itself. `points` are those that count. Where there are none, the blocks are taken, and `notes` say
/// why.
pub(super) fn of(
    solids: &[Solid],
    blocks: &[Solid],
    site: &Site,
    points: &[Point3<f64>],
    parameters: &Parameters,
    notes: &mut Vec<String>,
) -> Vec<Vec<Solid>> {
    let unstepped = || blocks.iter().map(|block| vec![block.clone()]).collect();
    if solids.is_empty() {
        return unstepped();
    }
    let stepped: Result<Vec<_>, String> =
        solids.iter().map(|solid| of_solid(solid, site, points, parameters)).collect();
    stepped.unwrap_or_else(|reason| {
        notes.push(format!("its LoD 1.3 is that of 1.2: {reason}"));
        unstepped()
    })
}

/// The blocks of LoD 1.3 that stand for one solid of LoD 2.2. Roofs whose heights differ by less than a step where they meet share
/// a top, at the 70th percentile of their points.
///
/// # Errors
/// Why there are none.
fn of_solid(solid: &Solid, site: &Site, points: &[Point3<f64>], parameters: &Parameters) -> Result<Vec<Solid>, String> {
    let roofs = Roofs::of(solid, parameters.block_step);
    let ground = site.ground.height;
    let tops = roofs.tops(points);
    let complex = roofs.partition(&tops, ground)?;
    let cells = 0..complex.cells.len() as u32;
    let (inside, volumes): (Vec<bool>, Vec<f64>) = cells
        .map(|cell| {
            let (volume, centroid) = complex.cell_moments(cell);
            (roofs.over(&centroid.xy()).is_some_and(|(top, _)| centroid.z < tops[top]), volume)
        })
        .unzip();
    let occupancy: Vec<f64> = inside.iter().map(|inside| f64::from(u8::from(*inside))).collect();
    let labelled =
        Labelled { complex: &complex, inside: &inside, occupancy: &occupancy, volumes: &volumes, fixed: &[] };
    let extraction = surface::extract(&labelled, parameters.step(&site.frame), &parameters.surface)
        .map_err(|error| error.to_string())?;
    let mut found = Vec::with_capacity(extraction.shells.len());
    for mut shell in extraction.shells {
        let footprint: Option<&MultiPolygon<f64>> = site.footprint.as_ref();
        semantics::assign(&mut shell.solid, &shell.planes, footprint, &Confidence::default());
        if let Some(fault) = validate::check(&shell.solid, &validate::Tolerances::written()).first() {
            return Err(fault.to_string());
        }
        found.push(shell.solid);
    }
    if found.is_empty() { Err("nothing stands above the ground".to_owned()) } else { Ok(found) }
}

/// The roofs of a solid, those that share a top together.
struct Roofs<'a> {
    solid: &'a Solid,
    /// For each top the roof faces below it.
    groups: Vec<Vec<&'a Face>>,
    /// For each top what lies under its roofs.
    covers: Vec<Cover>,
    /// The walls that stand: of the outline, and between tops.
    walls: Vec<Trace>,
}

/// An edge of a face: the lower numbers first.
type Edge = [u32; 2];

impl<'a> Roofs<'a> {
    fn of(solid: &'a Solid, step: f64) -> Self {
        let is_roof = |face: &&Face| solid.kind(face) == SurfaceType::Roof;
        let roofs: Vec<&Face> = solid.faces.iter().filter(is_roof).collect();
        let mut at: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
        for (roof, face) in roofs.iter().enumerate() {
            for [a, b] in edges(face) {
                at.entry([a.min(b), a.max(b)]).or_default().push(roof);
            }
        }
        let mut groups = Groups((0..roofs.len()).collect());
        for together in at.values().filter(|together| together.len() > 1) {
            groups.join(together[0], together[1]);
        }
        let walls: Vec<&Face> = solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::Wall).collect();
        let meetings: Vec<Vec<Meeting>> = walls.iter().map(|wall| meetings(solid, wall, &at)).collect();
        let mut jumps: BTreeMap<[usize; 2], [f64; 2]> = BTreeMap::new();
        for meeting in meetings.iter().flatten() {
            let sums = jumps.entry(meeting.roofs).or_default();
            *sums = [sums[0] + meeting.length * meeting.height, sums[1] + meeting.length];
        }
        for ([lower, upper], [heights, length]) in jumps {
            if heights < step * length {
                groups.join(lower, upper);
            }
        }
        let firsts: Vec<usize> = (0..roofs.len()).filter(|&roof| groups.first(roof) == roof).collect();
        let of_group = |first: usize| {
            let members = (0..roofs.len()).filter(|&roof| groups.first(roof) == first);
            members.map(|roof| roofs[roof]).collect()
        };
        let grouped: Vec<Vec<&Face>> = firsts.into_iter().map(of_group).collect();
        // One face may stand on the outline for a part of its length, and above a lower roof for the rest.
        let is_outline = |wall: &Face, meetings: &[Meeting]| {
            foot(solid, wall) > meetings.iter().map(|meeting| meeting.length).sum::<f64>() + SAME_LINE
        };
        let parts = |(wall, meetings): &(&&Face, &Vec<Meeting>)| {
            is_outline(wall, meetings) || meetings.iter().any(|m| groups.first(m.roofs[0]) != groups.first(m.roofs[1]))
        };
        let standing = walls.iter().zip(&meetings).filter(parts);
        let mut traces: Vec<Trace> = standing.filter_map(|(wall, _)| trace_of(solid, wall)).collect();
        trace::regularise(&mut traces, &[], SAME_LINE);
        let covers =
            grouped.iter().map(|faces| Cover::new(faces.iter().flat_map(|face| solid.triangles(face)))).collect();
        Self { solid, groups: grouped, covers, walls: traces }
    }

    /// The top under whose roofs a place of the plan lies, and the height of the roof there.
    fn over(&self, place: &Point2<f64>) -> Option<(usize, f64)> {
        let heights =
            self.covers.iter().enumerate().filter_map(|(top, cover)| Some((top, cover.highest(place.x, place.y)?)));
        heights.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
    }

    /// The height of each top: the 70th percentile of the points over it, or for want of points as far up its roofs.
    fn tops(&self, points: &[Point3<f64>]) -> Vec<f64> {
        let mut heights = vec![Vec::new(); self.groups.len()];
        for point in points {
            if let Some((top, _)) = self.over(&point.xy()) {
                heights[top].push(point.z);
            }
        }
        let of_roofs = |faces: &[&Face]| {
            let corners = faces.iter().flat_map(|face| face.rings.iter().flatten()).map(|&v| self.solid.point(v).z);
            let [low, high] =
                corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
            low + 0.7 * (high - low)
        };
        let tops = heights.iter_mut().zip(&self.groups);
        tops.map(|(heights, faces)| measures::roof_heights(heights).map_or_else(|| of_roofs(faces), |h| h.p70))
            .collect()
    }

    /// The box of the model, cut by its walls and by the tops.
    fn partition(&self, tops: &[f64], ground: f64) -> Result<Complex, String> {
        let corners: Vec<Point3<f64>> = (0..self.solid.vertices.len() as u32).map(|v| self.solid.point(v)).collect();
        let mut bounds = Aabb::of(&corners).ok_or("the model has no vertex")?;
        let highest = tops.iter().copied().fold(ground, f64::max);
        for axis in 0..2 {
            bounds.min[axis] -= AROUND;
            bounds.max[axis] += AROUND;
        }
        (bounds.min[2], bounds.max[2]) = (ground, highest + AROUND);
        let heights = [ground - AROUND, highest + 2.0 * AROUND];
        let mut primitives: Vec<Primitive> = self.walls.iter().map(|wall| wall.primitive(heights, MARGIN)).collect();
        primitives.extend(tops.iter().zip(&self.groups).filter_map(|(&top, faces)| self.level(top, faces)));
        Complex::adaptive(&primitives, &bounds).map_err(|error| error.to_string())
    }

    /// The level plane of a top, over the box of its roofs.
    fn level(&self, top: f64, faces: &[&Face]) -> Option<Primitive> {
        let corners: Vec<Point3<f64>> =
            faces.iter().flat_map(|face| face.rings.iter().flatten()).map(|&v| self.solid.point(v)).collect();
        let Aabb { min: [x0, y0, _], max: [x1, y1, _] } = Aabb::of(&corners)?;
        Some(Primitive {
            kind: PrimitiveKind::Detected,
            plane: Plane::through(&Point3::new(0.0, 0.0, top), Vector3::z_axis()),
            inliers: Vec::new(),
            residual: 0.0,
            extent: Extent::Patch(
                [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Point3::new(x, y, top)).to_vec(),
            ),
        })
    }
}

/// Where a lower and an upper roof meet along a wall.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    /// The lower and the upper roof.
    roofs: [usize; 2],
    /// How long, metres.
    length: f64,
    /// The height of the wall in the middle, metres.
    height: f64,
}

/// The meetings of roofs along a wall; none along one of the outline, at whose foot there is no roof.
fn meetings(solid: &Solid, wall: &Face, at: &BTreeMap<Edge, Vec<usize>>) -> Vec<Meeting> {
    let Some(normal) = wall.rings.first().and_then(|ring| solid.newell(ring).try_normalize(0.0)) else {
        return Vec::new();
    };
    let along = Vector3::z().cross(&normal);
    // Both ends of an edge along the wall, in their order, with the roof there.
    let known = |[a, b]: Edge| {
        let roof = at.get(&[a.min(b), a.max(b)])?.first().copied()?;
        let ends = [a, b].map(|v| solid.point(v)).map(|p| [along.dot(&p.coords), p.z]);
        ((ends[0][0] - ends[1][0]).abs() > 1e-6).then_some((ends, roof))
    };
    // Seen from outside the wall lies to the left of its edges: above those that run along, below the others.
    let (lower, upper): (Vec<_>, Vec<_>) = edges(wall).filter_map(known).partition(|(ends, _)| ends[0][0] < ends[1][0]);
    let meeting = |(ends, roof): ([[f64; 2]; 2], usize)| {
        let [t, z] = [0, 1].map(|i| f64::midpoint(ends[0][i], ends[1][i]));
        let above = upper.iter().filter_map(|([b, a], over)| {
            let share = (t - a[0]) / (b[0] - a[0]);
            let height = a[1] + share * (b[1] - a[1]) - z;
            ((0.0..=1.0).contains(&share) && height > 0.0).then_some((height, *over))
        });
        let (height, over) = above.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Meeting { roofs: [roof, over], length: ends[1][0] - ends[0][0], height })
    };
    lower.into_iter().filter_map(meeting).collect()
}

/// The length of the lower edges of a wall, metres.
fn foot(solid: &Solid, wall: &Face) -> f64 {
    let normal = wall.rings.first().and_then(|ring| solid.newell(ring).try_normalize(0.0));
    let Some(along) = normal.map(|normal| Vector3::z().cross(&normal)) else { return 0.0 };
    let run = |[a, b]: Edge| along.dot(&(solid.point(b) - solid.point(a)));
    edges(wall).map(run).filter(|run| *run > 0.0).sum()
}

/// The edges of a face, each from one vertex to the next.
fn edges(face: &Face) -> impl Iterator<Item = Edge> + '_ {
    face.rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| [a, b]))
}

/// The line of a wall in the plan, from end to end.
fn trace_of(solid: &Solid, wall: &Face) -> Option<Trace> {
    let corners: Vec<Point3<f64>> = wall.rings.first()?.iter().map(|&v| solid.point(v)).collect();
    let along = Vector3::z().cross(&newell(&corners));
    let order = |a: &&Point3<f64>, b: &&Point3<f64>| along.dot(&a.coords).total_cmp(&along.dot(&b.coords));
    let (from, to) = (corners.iter().min_by(order)?, corners.iter().max_by(order)?);
    Trace::between(from.xy(), to.xy(), PrimitiveKind::HeightJump)
}

/// Which of some things belong together.
struct Groups(Vec<usize>);

impl Groups {
    /// The first of those that one belongs to.
    fn first(&self, one: usize) -> usize {
        let mut first = one;
        while self.0[first] != first {
            first = self.0[first];
        }
        first
    }

    fn join(&mut self, a: usize, b: usize) {
        let [a, b] = [a, b].map(|one| self.first(one));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use geo::polygon;

    use super::super::{occupancy::HeightField, reconstruct};
    use super::*;
    use crate::building::Building;
    use crate::site::Frame;

    /// A building of 20 m by 10 m whose roof has this height at a place, with 4 points per square metre.
    fn building(height: impl Fn(f64, f64) -> f64, parameters: &Parameters) -> Building {
        let place = |i: u32| (0.25 + 0.5 * f64::from(i % 40), 0.25 + 0.5 * f64::from(i / 40));
        let points = (0..40 * 20).map(place).map(|(x, y)| Point3::new(x, y, height(x, y))).collect();
        let footprint = polygon![(x: 0.0, y: 0.0), (x: 20.0, y: 0.0), (x: 20.0, y: 10.0), (x: 0.0, y: 10.0)];
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let site = Site::new("stepped", frame, points, 0.0).with_footprint(&MultiPolygon(vec![footprint]));
        reconstruct(&site, parameters, &HeightField)
    }

    fn with(levels: &str, block_step: f64) -> Parameters {
        Parameters { lod: levels.parse().unwrap(), block_step, ..Parameters::default() }
    }

    /// The heights of the roofs of the only LoD 1.3 solid, ascending, and its volume.
    fn tops(building: &Building) -> (Vec<f64>, f64) {
        let [solid] = building.model.lod13().collect::<Vec<_>>()[..] else { panic!("{:?}", building.notes) };
        let roofs = solid.surfaces.iter().filter(|surface| surface.kind == SurfaceType::Roof);
        let mut heights: Vec<f64> = roofs.map(|roof| roof.heights.unwrap()[0]).collect();
        heights.sort_by(f64::total_cmp);
        (heights, solid.volume())
    }

    #[test]
    fn a_step_is_one_where_it_is_high_enough() {
        // 4 m, then 9 m and 10.5 m.
        let height = |x: f64, _: f64| {
            if x < 10.0 {
                4.0
            } else if x < 16.0 {
                9.0
            } else {
                10.5
            }
        };
        let found = building(height, &with("0,1.2,1.3,2.2", 3.0));
        assert_eq!(found.model.lod22().map(|solid| solid.faces.len()).sum::<usize>(), 10);
        // Of the points on the high part 60 % are at 9 m: their 70th percentile is the other height.
        let (heights, volume) = tops(&found);
        assert_eq!(heights, [4.0, 10.5]);
        assert!((volume - 1450.0).abs() < 10.0 && found.measures.volume_lod13 == Some(volume), "{volume}");
        assert_eq!(tops(&building(height, &with("1.3", 1.0))).0, [4.0, 9.0, 10.5]);
        // All is one block where no step is high enough: the 70th percentile of 4, 9 and 10.5 m.
        let (heights, volume) = tops(&building(height, &with("1.3", 10.0)));
        assert_eq!(heights, [9.0]);
        assert!((volume - 1800.0).abs() < 1e-6, "{volume}");
    }

    #[test]
    fn a_wall_that_stands_on_the_outline_for_a_part_stays() {
        // A house of 20 m by 10 m with an annex of 8 m by 5 m that is a metre lower.
        let ring = polygon![
            (x: 0.0, y: 0.0), (x: 20.0, y: 0.0), (x: 20.0, y: 10.0), (x: 8.0, y: 10.0), (x: 8.0, y: 15.0), (x: 0.0, y: 15.0)
        ];
        let places = (0..40 * 30).map(|i| (0.25 + 0.5 * f64::from(i % 40), 0.25 + 0.5 * f64::from(i / 40)));
        let places = places.filter(|(x, y)| *y < 10.0 || *x < 8.0);
        let points = places.map(|(x, y)| Point3::new(x, y, if y < 10.0 { 6.0 } else { 5.0 })).collect();
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let site = Site::new("annex", frame, points, 0.0).with_footprint(&MultiPolygon(vec![ring]));
        let found = reconstruct(&site, &with("1.3", 3.0), &HeightField);
        let (heights, volume) = tops(&found);
        assert_eq!(heights, [6.0]);
        assert!((volume - 240.0 * 6.0).abs() < 10.0, "{volume}");
    }

    #[test]
    fn what_lies_flat_is_the_roofs_of_the_blocks() {
        let height = |x: f64, _: f64| if x < 10.0 { 4.0 } else { 9.0 };
        let found = building(height, &with("0.1,0.3", 3.0)).model;
        let area = |roofs: &[crate::solid::RoofPolygon]| -> Vec<(f64, f64)> {
            let of_ring = |ring: &Vec<[i64; 2]>| {
                let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
                pairs.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<i64>() as f64 / 2e8
            };
            let whole = roofs.iter().map(|roof| (roof.height as f64 / 1e4, roof.polygon.iter().map(of_ring).sum()));
            whole.collect()
        };
        let mut parts = area(&found.roof_parts);
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(low, west), (high, east)] = parts[..] else { panic!("{parts:?}") };
        assert_eq!((low, high), (4.0, 9.0));
        assert!((west - 100.0).abs() < 3.0 && (west + east - 200.0).abs() < 0.01, "{west} {east}");
        assert_eq!(area(&found.roof_outlines), [(9.0, 200.0)]);
        assert!(found.parts.is_empty() && found.footprint.is_empty());
        let usual = building(height, &Parameters::default()).model;
        assert!(usual.roof_parts.is_empty() && usual.roof_outlines.is_empty());
    }

    #[test]
    fn a_gable_is_one_top_and_levels_are_what_was_asked_for() {
        let gable = |_: f64, y: f64| 9.0 - (y - 5.0).abs();
        let found = building(gable, &with("1.3", 3.0));
        let (heights, _) = tops(&found);
        assert!(matches!(heights[..], [top] if (top - 7.5).abs() < 0.3), "{heights:?}");
        assert!(found.model.footprint.is_empty() && found.model.lod12().chain(found.model.lod22()).next().is_none());
        let usual = building(gable, &Parameters::default());
        assert!(usual.model.lod13().next().is_none() && usual.measures.rmse_lod13.is_none());
        // A low part along one side meets the slope of the gable, 3.5 m and more above it.
        let lower = |x: f64, y: f64| if y < 3.0 { 3.0 } else { gable(x, y) };
        let (heights, _) = tops(&building(lower, &with("1.3,2.2", 3.0)));
        assert!(heights.len() == 2 && heights[0] == 3.0 && (heights[1] - 7.8).abs() < 0.4, "{heights:?}");
    }
}
