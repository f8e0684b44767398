//! Whether a solid may be written: an exact check on the integer coordinates that are written, level by level, in the
//! vocabulary of val3dity (codes 101 to 405), which users know.
//!
//! - [`ring`]: 101, 102, 104 — each closed line of vertices by itself;
//! - [`polygon`]: 201 to 208 — the rings of a face together;
//! - [`shell`]: 301 to 307 — the faces together;
//! - [`solid`]: 405 — the shell as a boundary.
//!
//! Topology is decided by the signs of integer determinants in `i128`, exact for coordinates below 2⁴⁰ grid steps;
//! only the distances and angles that are compared with a [tolerance](Tolerances) are in floating point. Unlike val3dity,
//! which stops at the first level that fails, every level is checked whose terms still make sense: a polygon with a
//! faulty ring is not checked as a polygon, and pinched vertices and self-intersections of a shell are looked for only
//! when all its polygons are sound.

pub mod polygon;
mod predicates;
pub mod ring;
pub mod shell;
pub mod solid;
mod triangles;
mod triangulation;

use std::fmt;

use crate::solid::Solid;

/// What is still taken for exact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Neighbouring vertices of a ring nearer than this are repeated (102), metres.
    pub snap: f64,
    /// Vertices of a face farther than this from its plane make it non-planar (203), metres.
    pub planarity: f64,
    /// A face is folded (204) where a triangle of it turns from its plane by more than this, degrees.
    pub normals: f64,
}

impl Default for Tolerances {
    /// 1 mm, 1 mm and 20°: val3dity's defaults, except that it allows 1 cm for planarity.
    fn default() -> Self {
        Self { snap: 0.001, planarity: 0.001, normals: 20.0 }
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

/// All faults of a solid, in the order of the levels; none if it is valid.
pub fn check(solid: &Solid, tolerances: &Tolerances) -> Vec<Fault> {
    let mut faults = Vec::new();
    let known = solid.vertices.len() as u32;
    for (f, face) in solid.faces.iter().enumerate() {
        if face.rings.is_empty() || face.rings.iter().flatten().any(|&v| v >= known) {
            let message = "a face without rings, or one that refers to a vertex that does not exist";
            return vec![Fault::new(101, Place::Face(f as u32), message)];
        }
    }
    let mut sound = true;
    for (f, face) in solid.faces.iter().enumerate() {
        let found = ring::check(solid, f as u32, face, tolerances);
        let found = if found.is_empty() { polygon::check(solid, f as u32, face, tolerances) } else { found };
        sound &= found.is_empty();
        faults.extend(found);
    }
    let topology = shell::check(solid);
    let closed = topology.is_empty();
    faults.extend(topology);
    if sound {
        faults.extend(shell::check_contacts(solid));
    }
    if closed {
        faults.extend(solid::check(solid));
    }
    faults
}

#[cfg(test)]
mod tests;
