//! Coordinate reference systems: where they come from, what their units are, and how to go from one to another.

/// A coordinate reference system.
#[derive(Debug, Clone, PartialEq)]
pub struct Crs {
    /// WKT2 of the whole system (compound systems whole), as PROJ writes it.
    pub wkt: String,
    /// Authority and code of the whole system, such as `EPSG:7415`; `None` when it has none.
    pub code: Option<String>,
    /// Its name.
    pub name: String,
    /// Metres per unit along x, y and z (z takes the horizontal unit when the system has no vertical part).
    pub metres_per_unit: [f64; 3],
    /// Whether it is geographic: its horizontal unit is an angle.
    pub is_geographic: bool,
}

impl Crs {
    /// The CRS of a LAS header: WKT VLR or EVLR, else GeoTIFF keys; `None` when it has neither.
    ///
    /// # Errors
    /// What is wrong with a CRS that is there but cannot be understood.
    pub fn from_header(_header: &las::Header) -> Result<Option<Self>, String> {
        Ok(None)
    }
}
