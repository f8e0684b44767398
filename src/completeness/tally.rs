//! What the faults of buildings come to.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::areas::{Area, Completeness};

/// Sizes of the largest area of a building from which it is counted, m².
const SIZES: [f64; 3] = [4.0, 10.0, 25.0];

/// How much of a building has a fault.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Extent {
    /// All its areas together, m².
    pub area: f64,
    /// The largest of them, m².
    pub largest: f64,
}

impl Extent {
    /// What these areas come to.
    pub fn of(areas: &[Area]) -> Self {
        let sizes = || areas.iter().map(|area| area.area);
        // Not `sum()`, which makes a negative zero of nothing.
        Self { area: sizes().fold(0.0, |a, b| a + b), largest: sizes().fold(0.0, f64::max) }
    }
}

/// How much of a building is scanned and not modelled, or modelled and not scanned.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Extents {
    /// Scanned above the model.
    pub missing: Extent,
    /// Modelled above everything that was scanned around.
    pub excess: Extent,
    /// Open ground under the model.
    pub roofed_ground: Extent,
}

impl Extents {
    /// The largest area with any of the faults, m².
    pub fn largest(&self) -> f64 {
        self.missing.largest.max(self.excess.largest).max(self.roofed_ground.largest)
    }
}

impl From<&Completeness> for Extents {
    fn from(found: &Completeness) -> Self {
        Self {
            missing: Extent::of(&found.missing),
            excess: Extent::of(&found.excess),
            roofed_ground: Extent::of(&found.roofed_ground),
        }
    }
}

/// How many buildings have a fault, and how much of it there is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Count {
    /// Buildings with an area of at least 4 m².
    pub from_4: usize,
    /// Of at least 10 m².
    pub from_10: usize,
    /// Of at least 25 m².
    pub from_25: usize,
    /// All areas of all buildings, m².
    pub area: f64,
}

/// How many buildings have which faults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Counts {
    /// Buildings that were judged.
    pub buildings: usize,
    /// Scanned above the model.
    pub missing: Count,
    /// Modelled above everything that was scanned around.
    pub excess: Count,
    /// Open ground under the model.
    pub roofed_ground: Count,
}

impl Counts {
    /// Counts buildings.
    pub fn of<'a>(buildings: impl IntoIterator<Item = &'a Extents>) -> Self {
        let mut counts = Self::default();
        buildings.into_iter().for_each(|building| counts.add(building));
        counts
    }

    /// Counts one more building.
    pub fn add(&mut self, building: &Extents) {
        self.buildings += 1;
        for (count, extent) in [
            (&mut self.missing, building.missing),
            (&mut self.excess, building.excess),
            (&mut self.roofed_ground, building.roofed_ground),
        ] {
            let [of_4, of_10, of_25] = SIZES.map(|size| usize::from(extent.largest >= size));
            count.from_4 += of_4;
            count.from_10 += of_10;
            count.from_25 += of_25;
            count.area += extent.area;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buildings_are_counted_by_their_largest_area() {
        let of = |area, largest| Extents { missing: Extent { area, largest }, ..Extents::default() };
        // Three small areas are no large one.
        let counts = Counts::of(&[of(9.0, 3.0), of(5.0, 4.0), of(12.0, 10.0), of(40.0, 30.0), of(0.0, 0.0)]);
        let missing = Count { from_4: 3, from_10: 2, from_25: 1, area: 66.0 };
        assert_eq!(counts, Counts { buildings: 5, missing, ..Counts::default() });
        assert_eq!(Counts::of([]), Counts::default());
    }
}
