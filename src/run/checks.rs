//! What the types of a job cannot tell.

use bytesize::ByteSize;

use super::Job;
use crate::error::InputError;
use crate::reconstruct::Level;
use crate::segment::{BuildingClasses, NOISE};

/// The most threads that may be asked for: more than the processors of any machine, few enough to start.
pub const MOST_THREADS: u32 = 1024;

/// No coordinate of any CRS of the Earth is larger.
const FARTHEST: f64 = 1e9;

/// So many bytes of memory, such as 64MB or 1GiB.
///
/// # Errors
/// It is no such number.
pub fn memory(text: &str) -> Result<usize, String> {
    let size = text.trim().parse::<ByteSize>().ok().and_then(|size| usize::try_from(size.as_u64()).ok());
    size.ok_or_else(|| "a number of bytes is expected, such as 64MB or 1GiB".to_owned())
}

impl Job {
    /// Refuses options that cannot both be meant.
    ///
    /// # Errors
    /// Which ones.
    pub fn refuse_contradictions(&self) -> Result<(), InputError> {
        let own = [("--building-class", &self.segmentation.building_classes)];
        let of_clouds = self.clouds.iter().filter_map(|source| Some(("--cloud", source.building_classes.as_ref()?)));
        for (option, classes) in own.into_iter().chain(of_clouds) {
            let BuildingClasses::Listed(classes) = classes else { continue };
            if let Some(class) = classes.iter().find(|class| self.segmentation.ground_classes.contains(class)) {
                let found = format!("class {class} as building and as ground");
                let options = format!("{option} and --ground-class");
                return Err(InputError::new(options, found, "each class in one of them")
                    .remedy("Take it out of one; `gable info` lists the classes of a tile"));
            }
            if let Some(class) = classes.iter().find(|class| NOISE.contains(class)) {
                let found = format!("class {class}, which is noise and never used");
                return Err(InputError::new(option, found, "classes that hold buildings")
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
        self.refuse_grid()?;
        let dates = self.clouds.iter().map(|source| &source.cloud.date).chain([&self.point_cloud.date]);
        if self.segmentation.year_attribute.is_some() && !dates.into_iter().any(Option::is_some) {
            let fault = InputError::new("--year-attribute", "no date of any point cloud", "the dates of the clouds");
            return Err(fault.remedy("Give --point-cloud-date, or date=… with --cloud"));
        }
        if self.terrain.is_some() {
            self.refuse_beside_terrain()?;
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

impl Job {
    /// Refuses what a terrain cannot stand beside.
    fn refuse_beside_terrain(&self) -> Result<(), InputError> {
        let is_fine = self.parameters.grid_steps() == Some(1);
        let (found, remedy) = if self.crop_only {
            ("--crop-only, which writes points alone", "Leave one of them out")
        } else if self.goes_to_many_files()? {
            ("files by tile or building", "Write one file, or leave --terrain out")
        } else if is_fine {
            return Ok(());
        } else {
            ("--grid-scale", "Leave --grid-scale out: triangles of the terrain would fold on a coarser grid")
        };
        Err(InputError::new("--terrain", found, "one model on the finest grid").remedy(remedy))
    }

    /// Refuses a grid on which models cannot stand, or a place of its number 0 that is not on it.
    fn refuse_grid(&self) -> Result<(), InputError> {
        let scale = self.parameters.grid_scale;
        if self.parameters.grid_steps().is_none() {
            let expected = "0.0001, or a multiple of it that divides 1, such as 0.0005, 0.001 or 0.01";
            return Err(InputError::new("--grid-scale", scale.to_string(), expected));
        }
        let is_on_grid = |c: &f64| ((c / scale).round() * scale - c).abs() <= 1e-6 * scale.max(c.abs() * 1e-9);
        match self.translation {
            Some(place) if !place.iter().all(is_on_grid) => {
                let [x, y, z] = place;
                let expected = format!("whole multiples of {scale}, the scale of the grid");
                let fault = InputError::new("--translation", format!("{x},{y},{z}"), expected);
                Err(fault.remedy("Round them, or give a finer --grid-scale: else all coordinates would move"))
            }
            _ => Ok(()),
        }
    }
}

/// Where the number 0 of the coordinates of a file is: `X,Y,Z`.
///
/// # Errors
/// What was expected.
pub fn translation(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(|number| number.trim().parse().ok()).collect::<Option<Vec<f64>>>();
    let place = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let is_place = |place: &[f64; 3]| place.iter().all(|c| c.is_finite() && c.abs() <= FARTHEST);
    place.filter(is_place).ok_or_else(|| format!("three numbers up to {FARTHEST}, X,Y,Z, are expected"))
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
    fn the_grid_is_one_on_which_models_stand() {
        let refused = |scale: f64, translation: Option<[f64; 3]>| {
            let mut job = super::Job { translation, ..super::Job::default() };
            job.parameters.grid_scale = scale;
            job.refuse_contradictions().err().map(|fault| fault.file.display().to_string())
        };
        for good in [0.0001, 0.0002, 0.0005, 0.001, 0.01, 0.1] {
            assert_eq!(refused(good, None), None, "{good}");
        }
        for bad in [0.0003, 0.00015, 0.007, 0.03] {
            assert_eq!(refused(bad, None).as_deref(), Some("--grid-scale"), "{bad}");
        }
        assert_eq!(refused(0.001, Some([84_900.123, 447_400.5, -10.0])), None);
        assert_eq!(refused(0.001, Some([84_900.123_4, 0.0, 0.0])).as_deref(), Some("--translation"));
        assert_eq!(super::translation("1, -2.5,3e3"), Ok([1.0, -2.5, 3000.0]));
        for bad in ["", "1,2", "1,2,x", "nan,0,0", "1e12,0,0"] {
            assert!(super::translation(bad).is_err(), "{bad}");
        }
    }

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
