//! Whether a solid may be written: an exact check on the integer coordinates that are written, level by level, in the
//! vocabulary of val3dity (codes 101 to 601), which users know.
//!
//! - [`ring`]: 101, 102, 104 — each closed line of vertices by itself;
//! - [`polygon`]: 201 to 208 — the rings of a face together;
//! - [`shell`] and its contacts: 301 to 307 — the faces together;
//! - [`solid`]: 401 to 405 — the shells of a solid together;
//! - [`composite`]: 501 to 503 and 601 — solids together;
//! - [`semantics`]: 801 to 805 — whether the labels of the faces say what the faces are. These codes are gable's own, as
//!   are 806 to 808, with which the [audit](crate::audit) of a file says that attributes do not fit the geometry;
//! - [`relief`]: 809 and 810 — whether the faces of a terrain are triangles that look up, gable's own too.
//!
//! Topology is decided by the signs of integer determinants in `i128`, exact for coordinates below 2⁴⁰ grid steps;
//! only the distances and angles that are compared with a [tolerance](Tolerances) are in floating point. Unlike val3dity,
//! which stops at the first level that fails, every level is checked whose terms still make sense: a polygon with a
//! faulty ring is not checked as a polygon, and pinched vertices and self-intersections of a shell are looked for only
//! when all its polygons are sound.
//!
//! One walk over the levels ([`visit`]) answers three questions: [`is_valid`] and [`first_fault`] stop it at the first
//! fault, [`check`] takes them all.

pub mod codes;
pub mod composite;
mod contacts;
mod interiors;
mod overlap;
pub mod polygon;
mod predicates;
pub mod relief;
pub mod ring;
pub mod semantics;
pub mod shell;
pub(crate) mod snap;
pub mod solid;
mod triangles;
mod triangulation;
mod voids;

use std::fmt;
use std::ops::ControlFlow;

use crate::solid::Solid;

/// What is still taken for exact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Neighbouring vertices of a ring no farther apart than this are repeated (102), metres.
    pub snap: f64,
    /// Vertices of a face farther than this from its plane make it non-planar (203), metres.
    pub planarity: f64,
    /// A face is folded (204) where a triangle of it turns from its plane by more than this, degrees.
    pub normals: f64,
    /// Whether so much of an angle does not count as the rounding of the vertices to the grid explains.
    pub rounding: bool,
}

impl Default for Tolerances {
    /// 1 mm, 1 mm and 20° beyond the rounding: val3dity's defaults, except that it allows 1 cm for planarity and nothing for
    /// rounding.
    fn default() -> Self {
        Self { snap: 0.001, planarity: 0.001, normals: 20.0, rounding: true }
    }
}

impl Tolerances {
    /// The default ones, and nothing is forgiven to the rounding: what is written passes every validator, also one that does
    /// not know the grid.
    pub fn written() -> Self {
        Self { rounding: false, ..Self::default() }
    }
}

/// Where a fault is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The solid as a whole.
    Solid,
    /// A face.
    Face(u32),
    /// A ring of a face; 0 is the exterior.
    Ring(u32, u32),
    /// The edge between two vertices.
    Edge(u32, u32),
    /// A vertex.
    Vertex(u32),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Solid => write!(f, "solid"),
            Self::Face(face) => write!(f, "face {face}"),
            Self::Ring(face, ring) => write!(f, "face {face}, ring {ring}"),
            Self::Edge(a, b) => write!(f, "edge {a}-{b}"),
            Self::Vertex(v) => write!(f, "vertex {v}"),
        }
    }
}

/// A fault of a solid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// val3dity's code.
    pub code: u16,
    /// Where it is.
    pub place: Place,
    /// What is wrong, for a person.
    pub message: String,
}

impl Fault {
    fn new(code: u16, place: Place, message: impl Into<String>) -> Self {
        Self { code, place, message: message.into() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}: {}", self.code, self.place, self.message)
    }
}

/// What a set of faces claims to be, and so which levels it is checked on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// Faces that need not hang together (`MultiSurface`): rings and polygons.
    Faces,
    /// One surface that may have a border (`CompositeSurface`): also 303, 305, 306 and 307.
    Surface,
    /// The exterior shell of a solid, looking outwards: all of a shell.
    Exterior,
    /// The shell around a void, looking into the void.
    Void,
}

/// All faults of a solid, in the order of the levels; none if it is valid.
pub fn check(solid: &Solid, tolerances: &Tolerances) -> Vec<Fault> {
    let mut faults = Vec::new();
    let _ = visit(solid, Claim::Exterior, tolerances, &mut |fault| {
        faults.push(fault);
        ControlFlow::Continue(())
    });
    faults
}

/// The first fault of a solid; nothing behind it is looked at.
pub fn first_fault(solid: &Solid, tolerances: &Tolerances) -> Option<Fault> {
    let mut first = None;
    let _ = visit(solid, Claim::Exterior, tolerances, &mut |fault| {
        first = Some(fault);
        ControlFlow::Break(())
    });
    first
}

/// Whether a solid has no fault.
pub fn is_valid(solid: &Solid, tolerances: &Tolerances) -> bool {
    first_fault(solid, tolerances).is_none()
}

/// What is shown each fault as it is found, and says whether to go on.
pub type Visitor<'a> = dyn FnMut(Fault) -> ControlFlow<()> + 'a;

/// Walks over the levels of the faces of a solid and shows each fault to the visitor, until it has seen enough.
pub fn visit(faces: &Solid, claim: Claim, tolerances: &Tolerances, visitor: &mut Visitor) -> ControlFlow<()> {
    let known = faces.vertices.len() as u32;
    for (f, face) in faces.faces.iter().enumerate() {
        if face.rings.is_empty() || face.rings.iter().flatten().any(|&v| v >= known) {
            let message = "a face without rings, or one that refers to a vertex that does not exist";
            return visitor(Fault::new(101, Place::Face(f as u32), message));
        }
    }
    let mut sound = true;
    for (f, face) in faces.faces.iter().enumerate() {
        let found = ring::check(faces, f as u32, face, tolerances);
        let found = if found.is_empty() { polygon::check(faces, f as u32, face, tolerances) } else { found };
        sound &= found.is_empty();
        found.into_iter().try_for_each(&mut *visitor)?;
    }
    if claim == Claim::Faces {
        return ControlFlow::Continue(());
    }
    let topology = shell::check(faces, claim != Claim::Surface);
    let closed = topology.is_empty();
    topology.into_iter().try_for_each(&mut *visitor)?;
    if sound {
        contacts::check(faces).into_iter().try_for_each(&mut *visitor)?;
    }
    match claim {
        Claim::Exterior | Claim::Void if closed => {
            solid::check(faces, claim == Claim::Exterior).into_iter().try_for_each(visitor)
        }
        _ => ControlFlow::Continue(()),
    }
}

#[cfg(test)]
mod tests;
