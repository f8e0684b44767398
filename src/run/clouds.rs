//! Several point clouds of one place, of which each building gets the best.

use std::path::PathBuf;

use super::checks::recording_date;
use super::job::Job;
use crate::error::{InputError, Result};
use crate::record::PointCloud;
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::source::points::{self, Tile};

/// What messages call a cloud.
const OPTION: &str = "--cloud";

/// A point cloud with what is known of it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CloudSource {
    /// Its name and date.
    pub cloud: PointCloud,
    /// LAS, LAZ, COPC, PLY and text files, folders of them, and glob patterns.
    pub tiles: Vec<String>,
    /// Clouds of higher priority are looked at first.
    pub priority: i32,
    /// The classes of its building points, where they are not those of the job.
    pub building_classes: Option<BuildingClasses>,
}

/// A cloud as text: `NAME=TILES`, then any of `date=2020-05-01`, `priority=2`, `class=1+6` (or `class=any`) and more tiles,
/// parted by commas.
///
/// # Errors
/// What was expected.
pub fn cloud(text: &str) -> Result<CloudSource, String> {
    const EXPECTED: &str = "NAME=TILES is expected, with ,date=… and ,priority=… behind it where they are known, such as \
                            AHN4=ahn4/*.laz,date=2020-05-01,priority=2";
    let mut parts = text.split(',').map(str::trim);
    let (name, first) = parts.next().and_then(|part| part.split_once('=')).ok_or(EXPECTED)?;
    let (name, first) = (name.trim(), first.trim());
    if name.is_empty() || first.is_empty() || ["date", "priority"].contains(&name) {
        return Err(EXPECTED.to_owned());
    }
    let mut source = CloudSource {
        cloud: PointCloud { source: Some(name.to_owned()), date: None },
        tiles: vec![first.to_owned()],
        priority: 0,
        building_classes: None,
    };
    for part in parts {
        match part.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
            Some(("date", date)) => source.cloud.date = Some(recording_date(date)?),
            Some(("priority", number)) => {
                source.priority =
                    number.parse().map_err(|_| format!("priority={number}: a whole number is expected"))?;
            }
            Some(("class", classes)) => source.building_classes = Some(classes.replace('+', ",").parse()?),
            _ if part.is_empty() => return Err(EXPECTED.to_owned()),
            _ => source.tiles.push(part.to_owned()),
        }
    }
    Ok(source)
}

/// A cloud with its tiles.
#[derive(Debug, Clone)]
pub(super) struct Cloud {
    /// Its name and date.
    pub(super) about: PointCloud,
    pub(super) priority: i32,
    pub(super) building_classes: Option<BuildingClasses>,
    /// The files of its tiles.
    pub(super) paths: Vec<PathBuf>,
}

/// The clouds of a job in the order in which they are looked at: higher priority first, of equal priority the newer first,
/// those without a date last, and else as they were given. What the job has as tiles or was fed is one of them.
///
/// # Errors
/// An argument that names no file, clouds of one name, or a tile in two clouds.
pub(super) fn of_job(job: &Job) -> Result<Vec<Cloud>> {
    let mut clouds = Vec::new();
    let fed = job.fed.as_ref().map(|fed| fed.name().to_path_buf());
    if !job.tiles.is_empty() || fed.is_some() || job.clouds.is_empty() {
        let mut paths = if job.tiles.is_empty() && fed.is_some() { Vec::new() } else { points::expand(&job.tiles)? };
        paths.extend(fed);
        clouds.push(Cloud { about: job.point_cloud.clone(), priority: 0, building_classes: None, paths });
    }
    for source in &job.clouds {
        let name = source.cloud.source.as_deref().unwrap_or_default();
        if clouds.iter().any(|cloud| cloud.about.source == source.cloud.source) {
            let fault = InputError::new(OPTION, format!("two clouds called {name}"), "a name for each");
            return Err(fault.into());
        }
        let paths = points::expand(&source.tiles)?;
        let twice = paths.iter().find(|path| clouds.iter().any(|cloud| cloud.paths.contains(path)));
        if let Some(twice) = twice {
            let fault = InputError::new(twice, "a tile of two clouds", "a tile in one cloud");
            return Err(fault.at(format!("{OPTION} {name}")).into());
        }
        let building_classes = source.building_classes.clone();
        clouds.push(Cloud { about: source.cloud.clone(), priority: source.priority, building_classes, paths });
    }
    // Dates are written so that they sort as text; a year goes before its months.
    clouds.sort_by(|a, b| b.priority.cmp(&a.priority).then_with(|| b.about.date.cmp(&a.about.date)));
    Ok(clouds)
}

impl Cloud {
    /// What messages call it.
    pub(super) fn name(&self) -> &str {
        self.about.source.as_deref().unwrap_or("the tiles")
    }

    /// Its tiles among those that could be opened.
    pub(super) fn tiles(&self, tiles: &[Tile]) -> Vec<Tile> {
        tiles.iter().filter(|tile| self.paths.contains(&tile.path)).cloned().collect()
    }

    /// Which of its points belong to a building, where `options` say so of others.
    pub(super) fn options(&self, options: &SegmentOptions) -> SegmentOptions {
        let building_classes = self.building_classes.clone().unwrap_or_else(|| options.building_classes.clone());
        SegmentOptions { building_classes, ..options.clone() }
    }

    /// The year in which it was recorded, if that is known.
    pub(super) fn year(&self) -> Option<i64> {
        self.about.date.as_deref()?.get(..4)?.parse().ok()
    }
}

/// A cloud without tiles.
#[cfg(test)]
pub(super) fn named(name: &str, date: Option<&str>) -> Cloud {
    let about = PointCloud { source: Some(name.to_owned()), date: date.map(str::to_owned) };
    Cloud { about, priority: 0, building_classes: None, paths: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cloud_is_named_and_dated() {
        let found = cloud("AHN4 = ahn4/*.laz, date=2020-05 ,more/,priority=-2").unwrap();
        assert_eq!(found.cloud, PointCloud { source: Some("AHN4".to_owned()), date: Some("2020-05".to_owned()) });
        assert_eq!((found.tiles, found.priority), (vec!["ahn4/*.laz".to_owned(), "more/".to_owned()], -2));
        assert_eq!(found.building_classes, None);
        let classes = |text: &str| cloud(text).unwrap().building_classes.unwrap();
        assert_eq!(classes("a=b,class=1+6"), BuildingClasses::Listed(vec![1, 6]));
        assert!(classes("a=b,class=any").is_any());
        assert_eq!(cloud("a=b=c.laz").unwrap().tiles, ["b=c.laz"]);
        for bad in
            ["", "tiles/", "=a.laz", "a=", "date=2020", "a=b,date=20", "a=b,priority=x", "a=b,class=six", "a=b,,c"]
        {
            assert!(cloud(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn clouds_are_looked_at_by_priority_and_then_the_newest_first() {
        let folder = tempfile::tempdir().unwrap();
        let tile = |name: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, "").unwrap();
            path.display().to_string()
        };
        let given = ["undated", "old", "new", "first"];
        let texts = ["", ",date=2014", ",date=2020-05", ",date=2000,priority=1"];
        let clouds =
            given.iter().zip(texts).map(|(name, rest)| cloud(&format!("{name}={}{rest}", tile(name))).unwrap());
        let job = Job { clouds: clouds.collect(), ..Job::default() };
        let order: Vec<String> = of_job(&job).unwrap().iter().map(|cloud| cloud.name().to_owned()).collect();
        assert_eq!(order, ["first", "new", "old", "undated"]);
        assert_eq!(of_job(&job).unwrap()[1].year(), Some(2020));
        let twice = Job { tiles: vec![tile("old")], ..job.clone() };
        assert!(of_job(&twice).unwrap_err().to_string().contains("a tile of two clouds"));
        let mut same = job;
        same.clouds[1].cloud.source = Some("new".to_owned());
        assert!(of_job(&same).unwrap_err().to_string().contains("two clouds called new"));
    }
}
