//! What the types of a job cannot tell.

use super::Job;
use crate::error::InputError;
use crate::reconstruct::Level;
use crate::segment::{BuildingClasses, NOISE};

/// The most threads that may be asked for: more than the processors of any machine, few enough to start.
pub const MOST_THREADS: u32 = 1024;

impl Job {
    /// Refuses options that cannot both be meant.
    ///
    /// # Errors
    /// Which ones.
    pub fn refuse_contradictions(&self) -> Result<(), InputError> {
        if let BuildingClasses::Listed(classes) = &self.segmentation.building_classes {
            if let Some(class) = classes.iter().find(|class| self.segmentation.ground_classes.contains(class)) {
                let found = format!("class {class} as building and as ground");
                return Err(InputError::new("--building-class and --ground-class", found, "each class in one of them")
                    .remedy("Take it out of one; `gable info` lists the classes of a tile"));
            }
            if let Some(class) = classes.iter().find(|class| NOISE.contains(class)) {
                let found = format!("class {class}, which is noise and never used");
                return Err(InputError::new("--building-class", found, "classes that hold buildings")
                    .remedy("Leave it out; `gable info` lists the classes of a tile"));
            }
        }
        let has_level = self.parameters.lod.has(Level::Overhanging);
        if has_level && self.roofprints.is_none() {
            return Err(InputError::new("--lod", "2.3, and no outlines of roofs", "--roofprint with their file")
                .remedy("LoD 2.3 is of roofs that reach beyond their walls: something must say how far"));
        }
        if self.roofprints.is_some() && (!has_level || self.footprints.is_none()) {
            let expected = if has_level { "--footprints with those of the walls" } else { "--lod with 2.3 in it" };
            return Err(InputError::new("--roofprint", "outlines of roofs that nothing is made of", expected)
                .remedy("Leave --roofprint out if there is to be no LoD 2.3"));
        }
        if self.placement.is_some() && (self.crs.is_some() || self.footprints.is_some()) {
            let with = if self.crs.is_some() { "--crs" } else { "--footprints" };
            let found = format!("a unit or an axis for coordinates without a CRS, together with {with}");
            return Err(InputError::new("--unit and --up-axis", found, "points without a CRS and --no-footprint")
                .remedy("A CRS says what its units are and that heights are along z: leave these options out"));
        }
        let detection = &self.parameters.detection;
        let (least, most) = (detection.minimum_tolerance, detection.maximum_tolerance);
        if least > most {
            let found = format!("a least tolerance of {least} and a largest of {most}");
            let options = "--minimum-tolerance and --maximum-tolerance";
            return Err(InputError::new(options, found, "the first not above the second").remedy("Change one of them"));
        }
        Ok(())
    }
}

/// When a point cloud was recorded: a year, a month or a day of the calendar.
///
/// # Errors
/// What was expected.
pub fn recording_date(text: &str) -> Result<String, String> {
    let parts: Vec<&str> = text.split('-').collect();
    let number = |part: &str, digits: usize| {
        (part.len() == digits && part.bytes().all(|b| b.is_ascii_digit())).then(|| part.parse::<u32>().ok()).flatten()
    };
    let is_date = match parts[..] {
        [year] => number(year, 4).is_some(),
        [year, month] => number(year, 4).is_some() && number(month, 2).is_some_and(|m| (1..=12).contains(&m)),
        [year, month, day] => {
            let leap = |year: u32| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
            let days = |year, month| match month {
                2 => 28 + u32::from(leap(year)),
                4 | 6 | 9 | 11 => 30,
                1..=12 => 31,
                _ => 0,
            };
            match (number(year, 4), number(month, 2), number(day, 2)) {
                (Some(year), Some(month), Some(day)) => (1..=days(year, month)).contains(&day),
                _ => false,
            }
        }
        _ => false,
    };
    if is_date { Ok(text.to_owned()) } else { Err("expected a date such as 2014, 2014-03 or 2014-03-04".to_owned()) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn dates_are_of_the_calendar() {
        for good in ["2014", "2014-03", "2014-03-31", "2024-02-29"] {
            assert_eq!(super::recording_date(good).as_deref(), Ok(good));
        }
        for bad in ["", "14", "2014-13", "2014-02-29", "2014-3-4", "2014-03-04-05", "4 March 2014"] {
            assert!(super::recording_date(bad).is_err(), "{bad}");
        }
    }
}
