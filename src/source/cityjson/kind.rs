//! The types of geometries.

/// The type of a geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GeometryKind {
    /// Surfaces that need not be connected.
    MultiSurface,
    /// Connected surfaces.
    CompositeSurface,
    /// One solid.
    Solid,
    /// Solids that need not touch.
    MultiSolid,
    /// Solids that touch.
    CompositeSolid,
    /// What has no faces of its own (points, lines, template instances), by its name.
    Other(String),
}

impl GeometryKind {
    /// Its name where it has faces of its own.
    pub fn of_faces(&self) -> Option<&'static str> {
        match self {
            Self::MultiSurface => Some("MultiSurface"),
            Self::CompositeSurface => Some("CompositeSurface"),
            Self::Solid => Some("Solid"),
            Self::MultiSolid => Some("MultiSolid"),
            Self::CompositeSolid => Some("CompositeSolid"),
            Self::Other(_) => None,
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::Other(name) => name,
            known => known.of_faces().unwrap_or_default(),
        }
    }
}
