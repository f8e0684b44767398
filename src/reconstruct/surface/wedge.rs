//! Wedges where a building touches itself along an upright edge.
//!
//! Where four roofs meet in a corner and two of them, across from each other, are higher than the others, the two touch
//! along an edge that no 2-manifold can have. To give a whole cell the other label would fill or take away a roof. So the
//! complex is cut once more, exactly as before: a wedge of a decimetre beside the edge, below the lower of the two roofs
//! and flush with it, joins them. Where one goes is judged in floating point; what it cuts is cut exactly.

use nalgebra::{Point3, Unit, Vector3};

use super::boundary::{Boundary, Spot};
use super::incidence::contains;
use super::repair::Around;
use super::{Components, Labelled, SurfaceError};
use crate::geometry::Plane;
use crate::reconstruct::complex::{CellId, Complex, Cutter, FacetId, OUTSIDE, PlaneId, VertexId};

/// How far a wedge reaches along both walls, metres.
const REACH: f64 = 0.1;
/// A relabelling that costs less is the better repair, cubic metres.
const CHEAP: f64 = 0.2;
/// Places of one upright line are not farther apart in the plan than this, metres, …
const SAME_LINE: f64 = 1e-3;
/// … and nothing is nearer to a plane than this.
const NOTHING: f64 = 1e-6;
/// So often edges are looked for.
const ROUNDS: usize = 4;
/// Planes with less of a slope against the vertical than this are no roof (the z of their normal).
const ROOF: f64 = 0.1;

/// A complex with wedges, and what is known of its cells; the cells there were before come first.
#[derive(Debug)]
pub(super) struct Wedged {
    pub complex: Complex,
    pub inside: Vec<bool>,
    pub occupancy: Vec<f64>,
    pub volumes: Vec<f64>,
    pub fixed: Vec<Option<bool>>,
    /// How many there are.
    pub wedges: usize,
}

/// What is to be cut at an edge.
struct Wedge {
    ends: [VertexId; 2],
    /// The cells that hold the wedge.
    cells: Vec<CellId>,
    /// The upright plane that parts it from the rest of them.
    side: Plane,
    /// The roof that it is flush with; `None` where its cells end with the edge.
    top: Option<PlaneId>,
}

/// Puts wedges at the upright edges along which the cells `inside` touch, unless a relabelling is cheap. `None` where
/// there are none.
pub(super) fn wedged(labelled: &Labelled, inside: &[bool]) -> Result<Option<Wedged>, SurfaceError> {
    let Some(mut wedged) = once(labelled, inside)? else { return Ok(None) };
    // A wedge that reaches below its edge often mends the one below; what it does not mend gets one of its own.
    for _ in 1..ROUNDS {
        let Some(next) = once(&wedged.labelled(), &wedged.inside)? else { break };
        wedged = Wedged { wedges: wedged.wedges + next.wedges, ..next };
    }
    Ok(Some(wedged))
}

/// Puts a wedge at every edge that can have one now.
fn once(labelled: &Labelled, inside: &[bool]) -> Result<Option<Wedged>, SurfaceError> {
    let complex = labelled.complex;
    let components = Components::new(complex, inside);
    let mut wedges = Vec::new();
    for (component, facets) in components.facets.iter().enumerate() {
        let member = |cell: CellId| components.of_cell.get(cell as usize) == Some(&(component as u32));
        let boundary = Boundary::new(complex, facets, member)?;
        // What stands on one line is in pieces where planes cross it; their wedges belong into one corner.
        let mut below: Option<(Point3<f64>, Vector3<f64>)> = None;
        for [lower, upper] in upright(complex, &boundary.spots) {
            let around = Around::new(complex, &member, Spot::Edge(lower.min(upper), lower.max(upper)));
            let relabelling = around.cheapest(labelled, inside, &member, |_| true);
            if relabelling.is_some_and(|(cost, _)| cost <= CHEAP) {
                continue;
            }
            let place = complex.vertices[lower as usize].position;
            let corner = below.filter(|(p, _)| (p.xy() - place.xy()).norm() < SAME_LINE).map(|(_, corner)| corner);
            if let Some((wedge, corner)) = Wedge::at(labelled, facets, &member, &around, [lower, upper], corner) {
                below = Some((place, corner));
                wedges.push(wedge);
            }
        }
    }
    if wedges.is_empty() {
        return Ok(None);
    }
    let count = complex.cells.len();
    let mut cutter = Cutter::new(complex.clone());
    let mut wedged = Wedged {
        complex: Complex::default(),
        inside: inside.to_vec(),
        occupancy: labelled.occupancy.to_vec(),
        volumes: labelled.volumes.to_vec(),
        fixed: labelled.fixed.to_vec(),
        wedges: wedges.len(),
    };
    wedged.occupancy.resize(count, 0.5);
    wedged.volumes.resize(count, 0.0);
    wedged.fixed.resize(count, None);
    for wedge in wedges {
        wedged.put(&wedge, &mut cutter);
    }
    wedged.complex = cutter.into_complex();
    Ok(Some(wedged))
}

/// The upright edges among spots, lower end first, line by line from below.
fn upright(complex: &Complex, spots: &[Spot]) -> Vec<[VertexId; 2]> {
    let position = |vertex: VertexId| complex.vertices[vertex as usize].position;
    let ends = spots.iter().filter_map(|spot| {
        let Spot::Edge(a, b) = *spot else { return None };
        let is_upright = (position(a).xy() - position(b).xy()).norm() < SAME_LINE;
        is_upright.then(|| if position(a).z < position(b).z { [a, b] } else { [b, a] })
    });
    let mut edges: Vec<[VertexId; 2]> = ends.collect();
    let key = |edge: &[VertexId; 2]| position(edge[0]);
    edges.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    });
    edges
}

impl Wedge {
    /// Whether a cell holds the whole edge.
    fn is_held(&self, complex: &Complex, cell: CellId) -> bool {
        let holds =
            |end: &VertexId| contains(complex, cell, &complex.cells[cell as usize], &complex.vertices[*end as usize]);
        self.ends.iter().all(holds)
    }

    /// The wedge at an upright edge, lower end first, and the direction of the corner that holds it, which is near to that
    /// of `corner` if one is given; `None` where no outside lies between two walls beside the edge.
    fn at(
        labelled: &Labelled,
        facets: &[FacetId],
        member: &impl Fn(CellId) -> bool,
        around: &Around,
        ends: [VertexId; 2],
        corner: Option<Vector3<f64>>,
    ) -> Option<(Self, Vector3<f64>)> {
        let complex = labelled.complex;
        let [lower, upper] = ends;
        let a = complex.vertices[lower as usize].position;
        let roof = |facet: &&u32| {
            let facet = &complex.facets[**facet as usize];
            let is_roof = complex.planes[facet.plane as usize].to_plane().normal.z.abs() > ROOF;
            is_roof && facet.corners.contains(&upper) && facet.cells[0] != OUTSIDE && member(facet.cells[0])
        };
        let top = facets.iter().find(roof).map(|facet| complex.facets[*facet as usize].plane);
        // Whether a cell goes on above the edge.
        let over = complex.vertices[upper as usize].position + Vector3::z() * SAME_LINE;
        let ends_there = |cell: &CellId| {
            complex.cells[*cell as usize].facets.iter().any(|&facet| {
                let facet = &complex.facets[facet as usize];
                let distance = complex.planes[facet.plane as usize].to_plane().distance(&over);
                if facet.cells[0] == *cell { distance > NOTHING } else { distance < -NOTHING }
            })
        };
        let may = |cell: &CellId| !member(*cell) && !labelled.is_fixed(*cell) && (top.is_some() || ends_there(cell));
        let is_free = |cells: &Vec<CellId>| cells.iter().all(may);
        // A wedge in the corner over the higher of the two low roofs stands on it; in the other it might hang.
        let stands = |cells: &Vec<CellId>| {
            let facets = cells.iter().flat_map(|&cell| &complex.cells[cell as usize].facets);
            facets.map(|&id| &complex.facets[id as usize]).any(|facet| {
                let [below, above] = facet.cells;
                let is_roof = complex.planes[facet.plane as usize].to_plane().normal.z > ROOF;
                is_roof && below != OUTSIDE && member(below) && cells.contains(&above) && facet.corners.contains(&lower)
            })
        };
        let held = |cells: Vec<CellId>| {
            // The two walls of the corner, as the directions in which they leave the edge.
            let mut along: Vec<Vector3<f64>> = Vec::new();
            for &id in cells.iter().flat_map(|&cell| &complex.cells[cell as usize].facets) {
                let facet = &complex.facets[id as usize];
                let plane = &complex.planes[facet.plane as usize];
                let holds = ends.iter().all(|&end| plane.side(&complex.vertices[end as usize]).is_eq());
                let is_wall = facet.cells.iter().any(|&cell| cell != OUTSIDE && member(cell));
                if holds && is_wall {
                    let corners = complex.facet_positions(id);
                    let count = corners.len().max(1) as f64;
                    let centre = corners.fold(Vector3::zeros(), |sum, p| sum + p.coords) / count;
                    let away = Vector3::new(centre.x - a.x, centre.y - a.y, 0.0);
                    along.extend(Unit::try_new(away, 1e-9).map(Unit::into_inner));
                }
            }
            let [first, rest @ ..] = &along[..] else { return None };
            let second = rest.iter().min_by(|p, q| p.dot(first).total_cmp(&q.dot(first)))?;
            let across = Unit::try_new(Vector3::new(second.y - first.y, first.x - second.x, 0.0), 0.1)?;
            let side = Plane::through(&Point3::from(a.coords + first * REACH), across);
            let direction = (first + second).try_normalize(0.1)?;
            Some((stands(&cells), direction, Self { ends, cells, side, top }))
        };
        let rank = |(stands, direction, _): &(bool, Vector3<f64>, Self)| match corner {
            Some(corner) => direction.dot(&corner),
            None => f64::from(u8::from(*stands)),
        };
        let best = around.groups().filter(is_free).filter_map(held).min_by(|a, b| rank(b).total_cmp(&rank(a)));
        best.map(|(_, direction, wedge)| (wedge, direction))
    }
}

impl Wedged {
    /// The cells with their labels.
    pub fn labelled(&self) -> Labelled<'_> {
        let Self { complex, inside, occupancy, volumes, fixed, .. } = self;
        Labelled { complex, inside, occupancy, volumes, fixed }
    }

    /// Cuts a wedge off its cells and puts it inside.
    fn put(&mut self, wedge: &Wedge, cutter: &mut Cutter) {
        let Some(side) = cutter.plane(&wedge.side) else { return };
        for &cell in &wedge.cells {
            // A wedge at another edge of this cell may have taken this one's part: it is looked for in the next round.
            if !wedge.is_held(cutter.complex(), cell) {
                continue;
            }
            let mut piece = cell;
            for plane in [Some(side), wedge.top].into_iter().flatten() {
                let Some(new) = cutter.cut(piece, plane) else { continue };
                let (complex, parent) = (cutter.complex(), piece as usize);
                self.inside.push(self.inside[parent]);
                self.occupancy.push(self.occupancy[parent]);
                self.fixed.push(self.fixed[parent]);
                self.volumes.push(complex.cell_moments(new).0);
                self.volumes[parent] = complex.cell_moments(piece).0;
                if wedge.is_held(complex, new) {
                    piece = new;
                }
            }
            self.inside[piece as usize] = true;
            self.fixed[piece as usize] = Some(true);
        }
    }
}
