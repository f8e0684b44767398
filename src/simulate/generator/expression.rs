//! A building as an expression of convex pieces, and the solid that it is.

use nalgebra::{Point3, Vector3};

use super::convex::Convex;
use super::error::Flaw;
use crate::geometry::{Aabb, Plane};
use crate::reconstruct::complex::{Complex, IntegerPlane};
use crate::reconstruct::confidence::Confidence;
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use crate::reconstruct::semantics;
use crate::reconstruct::surface::{Labelled, SurfaceParameters, extract};
use crate::solid::{Face, Solid};
use crate::validate::semantics::Label;
use crate::validate::{Tolerances, first_fault, semantics as labels};
use geo::MultiPolygon;

/// Space between a building and the box around it, metres.
const MARGIN: f64 = 1.0;
/// Planes whose normals differ by less, and whose distances from the middle of the building differ by less than
/// [`SAME_OFFSET`], are one: walls that are flush were drawn by different routes.
const SAME_NORMAL: f64 = 1e-5;
/// Metres.
const SAME_OFFSET: f64 = 1e-4;
/// How far the volume of the solid may be from that of its cells: what rounding and slivers make of it.
const SAME_VOLUME: f64 = 1e-3;
/// A building of more cells is not worth its time; ordinary ones have a few hundred.
const MAX_CELLS: usize = 60_000;

/// The union of some convex pieces without some others, above the ground.
#[derive(Debug, Clone, Default)]
pub(super) struct Expression {
    pub(super) added: Vec<Convex>,
    pub(super) removed: Vec<Convex>,
    /// Metres in the local frame.
    pub(super) ground: f64,
}

impl Expression {
    /// Whether the building holds a point.
    pub(super) fn contains(&self, point: &Point3<f64>) -> bool {
        point.z >= self.ground
            && self.added.iter().any(|piece| piece.contains(point))
            && !self.removed.iter().any(|piece| piece.contains(point))
    }

    /// The closed, valid, labelled solid of this expression, on the grid of `step` metres.
    ///
    /// Every face of every piece cuts the exact cell complex, so that no cell is partly in a piece: a cell is inside if
    /// its centroid is. The surface between inside and outside is extracted as that of a reconstructed building.
    pub(super) fn solid(&self, step: [f64; 3], footprint: &MultiPolygon<f64>) -> Result<Solid, Flaw> {
        let (snapped, primitives) = self.snapped()?;
        let bounds = self.bounds(&primitives)?;
        let complex = Complex::adaptive_within(&primitives, &bounds, MAX_CELLS)?;
        let cells = 0..complex.cells.len() as u32;
        let inside: Vec<bool> = cells.clone().map(|cell| snapped.contains(&complex.cell_centroid(cell))).collect();
        let volumes: Vec<f64> = cells.map(|cell| complex.cell_volume(cell)).collect();
        // Nothing may be relabelled: a spot that is no 2-manifold is a flaw of the draft.
        let fixed: Vec<Option<bool>> = inside.iter().copied().map(Some).collect();
        let occupancy: Vec<f64> = inside.iter().map(|&inside| f64::from(u8::from(inside))).collect();
        let labelled =
            Labelled { complex: &complex, inside: &inside, occupancy: &occupancy, volumes: &volumes, fixed: &fixed };
        let mut extraction = extract(&labelled, step, &SurfaceParameters { minimum_feature: 0.0 })?;
        let (Some(mut shell), pieces) = (extraction.shells.pop(), extraction.shells.len()) else {
            return Err(Flaw::Pieces(0));
        };
        if pieces > 0 {
            return Err(Flaw::Pieces(pieces + 1));
        }
        semantics::assign(&mut shell.solid, &shell.planes, Some(footprint), &Confidence::default());
        let solid = shell.solid;
        let known = |face: &Face| Label::Known(solid.kind(face));
        let fault = first_fault(&solid, &Tolerances::default())
            .or_else(|| labels::check(&solid, known).into_iter().next())
            .or_else(|| labels::check_ground(&solid, known));
        if let Some(fault) = fault {
            return Err(Flaw::Invalid(fault));
        }
        let expected: f64 = volumes.iter().zip(&inside).filter(|(_, inside)| **inside).map(|(volume, _)| volume).sum();
        let found = solid.volume();
        if (found - expected).abs() > SAME_VOLUME * expected {
            return Err(Flaw::Volume { expected, found });
        }
        Ok(solid)
    }

    /// The same expression with its planes on the grid of the cell complex, near ones made one, without sides that bound
    /// nothing; and its faces.
    fn snapped(&self) -> Result<(Self, Vec<Primitive>), Flaw> {
        let mut planes = Planes { known: Vec::new(), middle: self.middle() };
        let mut primitives = Vec::new();
        let mut snap = |pieces: &[Convex]| -> Result<Vec<Convex>, Flaw> {
            let mut snapped = Vec::with_capacity(pieces.len());
            for piece in pieces {
                let sides = piece.sides.iter().map(|side| planes.snap(side)).collect::<Option<Vec<Plane>>>();
                let mut distinct: Vec<Plane> = Vec::new();
                for side in sides.ok_or(Flaw::Far)? {
                    if !distinct.contains(&side) {
                        distinct.push(side);
                    }
                }
                let whole = Convex::new(distinct);
                let faces = whole.faces(self.ground);
                snapped.push(Convex::new(faces.iter().filter_map(|(side, _)| whole.sides.get(*side)).copied()));
                primitives.extend(faces.into_iter().filter_map(|(side, corners)| {
                    Some(Primitive {
                        kind: PrimitiveKind::Detected,
                        plane: *whole.sides.get(side)?,
                        inliers: Vec::new(),
                        residual: 0.0,
                        extent: Extent::Patch(corners),
                    })
                }));
            }
            // A piece without faces would hold everything.
            snapped.retain(|piece| !piece.sides.is_empty());
            Ok(snapped)
        };
        let (added, removed) = (snap(&self.added)?, snap(&self.removed)?);
        Ok((Self { added, removed, ground: self.ground }, primitives))
    }

    /// The mean of the corners.
    fn middle(&self) -> Point3<f64> {
        let faces = self.added.iter().flat_map(|piece| piece.faces(self.ground));
        let corners: Vec<Vector3<f64>> = faces.flat_map(|(_, corners)| corners).map(|p| p.coords).collect();
        Point3::from(corners.iter().sum::<Vector3<f64>>() / corners.len().max(1) as f64)
    }

    /// The box of the faces, with a margin to all sides but the ground.
    fn bounds(&self, primitives: &[Primitive]) -> Result<Aabb, Flaw> {
        let corners = primitives.iter().flat_map(|primitive| match &primitive.extent {
            Extent::Patch(corners) => corners.as_slice(),
            Extent::Everywhere => &[],
        });
        let mut bounds = Aabb::of(corners).ok_or(Flaw::Pieces(0))?;
        for axis in 0..3 {
            bounds.min[axis] -= MARGIN;
            bounds.max[axis] += MARGIN;
        }
        bounds.min[2] = self.ground;
        Ok(bounds)
    }
}

/// Distinct planes on the grid of the cell complex.
struct Planes {
    known: Vec<Plane>,
    middle: Point3<f64>,
}

impl Planes {
    /// The known plane that is the same as `plane` but for rounding, or `plane` itself on the grid; looking where `plane`
    /// does. `None` when it is out of reach.
    fn snap(&mut self, plane: &Plane) -> Option<Plane> {
        let here = plane.distance(&self.middle);
        for known in &self.known {
            for known in [*known, known.flipped()] {
                let near = (known.distance(&self.middle) - here).abs() < SAME_OFFSET;
                if near && (known.normal.into_inner() - plane.normal.into_inner()).norm() < SAME_NORMAL {
                    return Some(known);
                }
            }
        }
        let (snapped, flipped) = IntegerPlane::snap(plane)?;
        let snapped = snapped.to_plane();
        let snapped = if flipped { snapped.flipped() } else { snapped };
        self.known.push(snapped);
        Some(snapped)
    }
}
