//! The planes that edits can name.

use serde::Serialize;

use crate::edits::PlaneAt;
use crate::geometry::newell;
use crate::reconstruct::primitives::{Extent, Primitive};
use crate::reconstruct::{Detected, WALL_VERTICALITY, equation};
use crate::site::Frame;

/// A plane whose normal is within this of upright, as the length of its projection, falls nowhere.
const LEVEL: f64 = 1e-3;

/// What a plane is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Kind {
    Roof,
    Underside,
    Wall,
}

/// Where a plane comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Source {
    /// It was found in the points.
    Scan,
    /// A person added, turned or moved it.
    Edit,
    /// The method added it for points that a first model had left unexplained; edits are followed before, and cannot name it.
    Revision,
}

/// A plane that is shown in the list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Addressed<'a> {
    pub primitive: &'a Primitive,
    pub kind: Kind,
    pub is_on: bool,
    pub by: Source,
}

impl<'a> Addressed<'a> {
    /// The planes of a building, those that are switched off last.
    pub fn all(detected: Option<&'a Detected>) -> Vec<Self> {
        let Some(detected) = detected else { return Vec::new() };
        let by = |primitive: &Primitive| {
            if detected.edited.contains(&primitive.plane) { Source::Edit } else { Source::Scan }
        };
        let on = |kind| move |primitive: &'a Primitive| Self { primitive, kind, is_on: true, by: by(primitive) };
        let older = detected.roofs.len().saturating_sub(detected.revised);
        let roofs = detected.roofs.iter().enumerate().map(|(i, primitive)| {
            let own = on(Kind::Roof)(primitive);
            let is_revision = i >= older && own.by == Source::Scan;
            if is_revision { Self { by: Source::Revision, ..own } } else { own }
        });
        let walls = detected.walls.iter().chain(&detected.added_walls).map(on(Kind::Wall));
        let off = detected.off_planes.iter().map(|primitive| {
            let kind = if primitive.plane.verticality() > WALL_VERTICALITY { Kind::Wall } else { Kind::Roof };
            Self { primitive, kind, is_on: false, by: by(primitive) }
        });
        roofs.chain(detected.undersides.iter().map(on(Kind::Underside))).chain(walls).chain(off).collect()
    }

    /// What the page is told of it.
    pub fn told(&self, frame: &Frame) -> Told {
        let Primitive { plane, inliers, residual, extent, .. } = self.primitive;
        let corners = match extent {
            Extent::Patch(corners) => corners.as_slice(),
            Extent::Everywhere => &[],
        };
        let normal = if plane.normal.z < 0.0 { -plane.normal } else { plane.normal };
        let falls = normal.x.hypot(normal.y) > LEVEL;
        Told {
            at: PlaneAt {
                equation: equation(frame, plane),
                extent: corners.iter().map(|corner| frame.to_crs(corner)).collect(),
            },
            kind: self.kind,
            points: inliers.len(),
            rms: *residual,
            area: newell(corners).norm() / 2.0,
            tilt: normal.z.clamp(0.0, 1.0).acos().to_degrees(),
            azimuth: falls.then(|| normal.x.atan2(normal.y).to_degrees().rem_euclid(360.0)),
            on: self.is_on,
            by: self.by,
        }
    }
}

/// What the page is told of a plane.
#[derive(Debug, Serialize)]
pub(super) struct Told {
    /// What edits call it.
    at: PlaneAt,
    kind: Kind,
    points: usize,
    /// Root mean square of the distances of its points, metres.
    rms: f64,
    /// Area of its extent, square metres.
    area: f64,
    /// Angle to the horizontal, degrees.
    tilt: f64,
    /// Direction in which it falls, degrees clockwise from north; nothing where it is level.
    azimuth: Option<f64>,
    on: bool,
    by: Source,
}
