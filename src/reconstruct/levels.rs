//! Levels of detail.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use crate::solid::{Face, Model, Part, RoofPolygon, Solid, SurfaceType};

/// A level of detail (Biljecki, Ledoux, Stoter 2016).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Level {
    /// 0: the footprint.
    Footprint,
    /// 0.1: what the roofs cover, at one height.
    RoofOutlines,
    /// 0.3: what each roof covers, at its height.
    RoofParts,
    /// 1.2: a block over every part of the footprint.
    Block,
    /// 1.3: blocks with a step wherever the roof has one.
    Stepped,
    /// 2.2: roofs as they are.
    Roofs,
    /// 2.3: roofs that reach beyond the walls under them.
    Overhanging,
}

impl Level {
    /// All, from the coarsest on.
    pub const ALL: [Self; 7] = [
        Self::Footprint,
        Self::RoofOutlines,
        Self::RoofParts,
        Self::Block,
        Self::Stepped,
        Self::Roofs,
        Self::Overhanging,
    ];

    /// What CityJSON calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Footprint => "0",
            Self::RoofOutlines => "0.1",
            Self::RoofParts => "0.3",
            Self::Block => "1.2",
            Self::Stepped => "1.3",
            Self::Roofs => "2.2",
            Self::Overhanging => "2.3",
        }
    }
}

/// Levels of detail that a model has, such as `0,1.2,2.2`. It is text in JSON and on the command line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Levels(BTreeSet<Level>);

impl Levels {
    /// Whether a model has this level.
    pub fn has(&self, level: Level) -> bool {
        self.0.contains(&level)
    }

    /// Adds to a model what lies flat at the height of its blocks, with or without steps, where it shall have that.
    pub(super) fn lay_flat(&self, model: &mut Model) {
        if self.has(Level::RoofOutlines) {
            model.roof_outlines = model.lod12().flat_map(roof_polygons).collect();
        }
        if self.has(Level::RoofParts) {
            model.roof_parts = model.lod13().flat_map(roof_polygons).collect();
        }
    }

    /// Takes away from a model what is of no level that it shall have.
    pub(super) fn keep(&self, model: &mut Model) {
        if !self.has(Level::Footprint) {
            model.footprint.clear();
        }
        for part in &mut model.parts {
            for (level, solid) in [
                (Level::Block, &mut part.lod12),
                (Level::Stepped, &mut part.lod13),
                (Level::Roofs, &mut part.lod22),
                (Level::Overhanging, &mut part.lod23),
            ] {
                if !self.has(level) {
                    *solid = None;
                }
            }
        }
        model.parts.retain(|part| part.solids().next().is_some());
    }
}

impl Levels {
    /// The usual ones: 0, 1.2 and 2.2, and 2.3 where outlines of roofs are known.
    pub fn usual(with_roofprints: bool) -> Self {
        let mut levels = Self::default();
        if with_roofprints {
            levels.0.insert(Level::Overhanging);
        }
        levels
    }
}

impl Default for Levels {
    /// 0, 1.2 and 2.2.
    fn default() -> Self {
        Self(BTreeSet::from([Level::Footprint, Level::Block, Level::Roofs]))
    }
}

impl FromStr for Levels {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let level = |name: &str| Level::ALL.into_iter().find(|level| level.name() == name.trim());
        match text.split(',').map(level).collect::<Option<BTreeSet<Level>>>() {
            Some(levels) => Ok(Self(levels)),
            None => Err(format!(
                "found '{text}', expected some of {}, parted by commas",
                Level::ALL.map(Level::name).join(", ")
            )),
        }
    }
}

impl fmt::Display for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.0.iter().map(|level| level.name()).collect();
        f.write_str(&names.join(","))
    }
}

impl TryFrom<String> for Levels {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Levels> for String {
    fn from(levels: Levels) -> Self {
        levels.to_string()
    }
}

impl JsonSchema for Levels {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Levels".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        String::json_schema(generator)
    }
}

/// The level roofs of a solid of LoD 1 as polygons.
fn roof_polygons(solid: &Solid) -> Vec<RoofPolygon> {
    let vertex = |v: &u32| solid.vertices.get(*v as usize).copied().unwrap_or_default();
    let roofs = solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::Roof);
    let polygon = |face: &Face| {
        let height = face.rings.iter().flatten().map(vertex).map(|[.., z]| z).max()?;
        let flat = |ring: &Vec<u32>| ring.iter().map(vertex).map(|[x, y, _]| [x, y]).collect();
        Some(RoofPolygon { polygon: face.rings.iter().map(flat).collect(), height })
    };
    roofs.filter_map(polygon).collect()
}

/// Parts of LoD 2.2 `solids`, LoD 1.2 `blocks`, the LoD 1.3 blocks that stand for each of the solids, or else for each
/// of the blocks, and the solids of LoD 2.3.
pub(super) fn parts(
    solids: Vec<Solid>,
    blocks: Vec<Solid>,
    stepped: Vec<Vec<Solid>>,
    overhanging: Vec<Solid>,
) -> Vec<Part> {
    let count = solids.len().max(blocks.len()).max(stepped.len()).max(overhanging.len());
    let (mut solids, mut blocks, mut stepped) = (solids.into_iter(), blocks.into_iter(), stepped.into_iter());
    let mut overhanging = overhanging.into_iter();
    let mut more = Vec::new();
    let mut part = || {
        let mut of_part = stepped.next().unwrap_or_default().into_iter();
        let part =
            Part { lod12: blocks.next(), lod13: of_part.next(), lod22: solids.next(), lod23: overhanging.next() };
        more.extend(of_part.map(|solid| Part { lod13: Some(solid), ..Part::default() }));
        part
    };
    let mut parts: Vec<Part> = (0..count).map(|_| part()).collect();
    parts.append(&mut more);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_read_as_they_are_written() {
        assert_eq!(Levels::default().to_string(), "0,1.2,2.2");
        assert_eq!("2.2, 1.3".parse::<Levels>().unwrap().to_string(), "1.3,2.2");
        for bad in ["", "2", "1.2,", "foo", "1.2;2.2"] {
            assert!(
                bad.parse::<Levels>().unwrap_err().contains("expected some of 0, 0.1, 0.3, 1.2, 1.3, 2.2, 2.3"),
                "{bad}"
            );
        }
    }
}
