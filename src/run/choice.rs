//! Which of several point clouds a building is made from.
//!
//! Clouds are looked at in their [order](super::clouds): by priority, then the newest first. One that is older than the
//! building is out. The first that covers the footprint, is dense enough and leaves little of it without data is taken. One
//! that was passed over as too thin may still show that the building has changed since an older one: then that is out as
//! well. Of clouds that are all too thin the one that leaves least without data is taken.

use rayon::prelude::*;

use super::clouds::Cloud;
use crate::record::{Change, Choice, CloudOf, PointCloud};
use crate::segment::{Scanned, SegmentOptions, between};
use crate::site::Site;
use crate::source::footprints::attribute;

/// What a cloud gives to all buildings: its sites in the order of the footprints, and the notes on each.
pub(super) struct Offer<'a> {
    pub(super) cloud: &'a Cloud,
    pub(super) sites: Vec<Site>,
    pub(super) notes: Vec<Vec<String>>,
}

/// What one cloud gives to one building.
struct Candidate<'a> {
    cloud: &'a Cloud,
    site: Site,
    notes: Vec<String>,
    scanned: Scanned,
}

/// Takes the best cloud of each building.
pub(super) fn choose(offers: Vec<Offer<'_>>, options: &SegmentOptions) -> (Vec<Site>, Vec<Vec<String>>) {
    let count = offers.first().map_or(0, |offer| offer.sites.len());
    let mut columns: Vec<_> =
        offers.into_iter().map(|Offer { cloud, sites, notes }| (cloud, sites.into_iter().zip(notes))).collect();
    // Each building with what all clouds give to it.
    let rows: Vec<Vec<(&Cloud, Site, Vec<String>)>> = (0..count)
        .map(|_| {
            let next = columns.iter_mut().filter_map(|(cloud, column)| Some((*cloud, column.next()?)));
            next.map(|(cloud, (site, notes))| (cloud, site, notes)).collect()
        })
        .collect();
    rows.into_par_iter().filter_map(|row| one(row, options)).unzip()
}

/// The site of a building from the best of its clouds; `None` without any.
fn one(row: Vec<(&Cloud, Site, Vec<String>)>, options: &SegmentOptions) -> Option<(Site, Vec<String>)> {
    let year = row.first().and_then(|(_, site, _)| year_of(site, options));
    let is_too_old = |cloud: &Cloud| year.zip(cloud.year()).is_some_and(|(built, flown)| flown < built);
    let candidate = |(cloud, site, notes)| Candidate { cloud, scanned: Scanned::of(&site), site, notes };
    let all: Vec<Candidate<'_>> = row.into_iter().map(candidate).collect();
    // What was there before a building is told by a cloud that it cannot be made from.
    let change = newest_change(&all);
    let (old, mut new): (Vec<_>, Vec<_>) = all.into_iter().partition(|candidate| is_too_old(candidate.cloud));
    if new.is_empty() {
        let date = old.iter().filter_map(|candidate| candidate.cloud.about.date.as_deref()).max().unwrap_or_default();
        let outdated = format!("built in {}, and the newest point cloud is of {date}", year.unwrap_or_default());
        let Candidate { mut site, notes, .. } = old.into_iter().next()?;
        site.points.clear();
        site.ground_points.clear();
        site.record.cloud =
            Some(CloudOf { cloud: PointCloud::default(), choice: Choice::NoneNewEnough, outdated: Some(outdated) });
        return Some((site, notes));
    }
    let (chosen, choice) = chosen(&new, options);
    let Candidate { cloud, mut site, notes, .. } = new.swap_remove(chosen);
    site.record.cloud = Some(CloudOf { cloud: cloud.about.clone(), choice, outdated: None });
    site.record.change = change;
    Some((site, notes))
}

/// The place of the cloud that is taken, and why.
fn chosen(candidates: &[Candidate<'_>], options: &SegmentOptions) -> (usize, Choice) {
    let is_good = |candidate: &Candidate<'_>| {
        let Scanned { density, no_data, .. } = candidate.scanned;
        candidate.site.coverage.is_complete() && density >= options.cloud_density && no_data <= options.cloud_no_data
    };
    let mut best: Option<(usize, f64)> = None;
    let mut others_are_outdated = false;
    for (place, candidate) in candidates.iter().enumerate() {
        let newer = candidates.iter().take(place).filter(|other| is_newer(other, candidate));
        let mut changes = newer.filter_map(|other| between(&candidate.site, &other.site));
        if changes.any(|change| change.mutation.is_some()) {
            others_are_outdated = true;
            continue;
        }
        if is_good(candidate) {
            return (place, if place == 0 { Choice::First } else { Choice::OthersTooThin });
        }
        let no_data = candidate.scanned.no_data;
        if best.is_none_or(|(_, least)| no_data < least) {
            best = Some((place, no_data));
        }
    }
    let place = best.map_or(0, |(place, _)| place);
    (place, if others_are_outdated { Choice::OthersOutdated } else { Choice::BestOfThin })
}

/// Whether the date of one cloud is after that of another; of clouds without dates, which come first or last, none is.
fn is_newer(one: &Candidate<'_>, other: &Candidate<'_>) -> bool {
    let [one, other] = [one, other].map(|candidate| candidate.cloud.about.date.as_deref());
    one.zip(other).is_some_and(|(one, other)| one > other)
}

/// What has become of a building since the survey before the newest that tells.
fn newest_change(candidates: &[Candidate<'_>]) -> Option<Change> {
    let mut dated: Vec<&Candidate<'_>> = candidates.iter().filter(|one| one.cloud.about.date.is_some()).collect();
    dated.sort_by(|a, b| b.cloud.about.date.cmp(&a.cloud.about.date));
    let pairs = (0..dated.len()).flat_map(|new| (new + 1..dated.len()).map(move |old| (new, old)));
    let mut pairs = pairs.filter(|(new, old)| dated[*new].cloud.about.date != dated[*old].cloud.about.date);
    pairs.find_map(|(new, old)| {
        let change = between(&dated[old].site, &dated[new].site)?;
        Some(Change { since: Some(dated[old].cloud.about.clone()), ..change })
    })
}

/// The year in which a building was built, as its footprint says.
fn year_of(site: &Site, options: &SegmentOptions) -> Option<i64> {
    let value = attribute(&site.attributes, options.year_attribute.as_deref()?)?;
    let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    // A date begins with its year; `1985.0` is one as well.
    let digits: String = text.trim().chars().take_while(char::is_ascii_digit).collect();
    (digits.len() == 4).then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use geo::{MultiPolygon, polygon};
    use nalgebra::Point3;
    use serde_json::json;

    use super::super::clouds::named;
    use super::*;
    use crate::record::Mutation;
    use crate::site::Frame;

    /// A flat roof of 10 m by 8 m at a height, with points at a spacing up to `until`.
    fn site(height: f64, spacing: f64, until: f64) -> Site {
        let steps = |length: f64| (0..).map(move |i| (f64::from(i) + 0.5) * spacing).take_while(move |at| *at < length);
        let places = steps(until).flat_map(|x| steps(8.0).map(move |y| (x, y)));
        let points = places.map(|(x, y)| Point3::new(x, y, height)).collect();
        let footprint = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 8.0), (x: 0.0, y: 8.0)];
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let mut site = Site::new("house", frame, points, 0.0).with_footprint(&MultiPolygon(vec![footprint]));
        site.attributes.insert("year".to_owned(), json!("2016-05"));
        site
    }

    fn choice(clouds: &[(&str, Option<&str>, Site)], year: bool) -> (String, Choice, Option<Mutation>) {
        let known: Vec<Cloud> = clouds.iter().map(|(name, date, _)| named(name, *date)).collect();
        let offers = known.iter().zip(clouds).map(|(cloud, (.., site))| Offer {
            cloud,
            sites: vec![site.clone()],
            notes: vec![Vec::new()],
        });
        let year_attribute = year.then(|| "Year".to_owned());
        let options = SegmentOptions { year_attribute, ..SegmentOptions::default() };
        let (sites, _) = choose(offers.collect(), &options);
        let record = &sites[0].record;
        let CloudOf { cloud, choice, .. } = record.cloud.clone().unwrap();
        (cloud.source.unwrap_or_default(), choice, record.change.as_ref().and_then(|change| change.mutation))
    }

    #[test]
    fn the_first_that_is_good_enough_is_taken() {
        let (dense, thin) = (site(6.0, 0.5, 10.0), site(6.0, 2.0, 10.0));
        let part = site(6.0, 0.5, 3.0);
        let (new, old) = (Some("2020"), Some("2014"));
        let of = |a: &Site, b: &Site| choice(&[("new", new, a.clone()), ("old", old, b.clone())], false);
        assert_eq!(of(&dense, &dense), ("new".to_owned(), Choice::First, None));
        assert_eq!(of(&thin, &dense), ("old".to_owned(), Choice::OthersTooThin, None));
        assert_eq!(of(&part, &dense).0, "old", "most of it was not scanned");
        assert_eq!(of(&part, &thin), ("old".to_owned(), Choice::BestOfThin, None));
        assert_eq!(of(&thin, &part).0, "new");
        // Without points a cloud tells nothing.
        assert_eq!(of(&site(6.0, 0.5, 0.0), &thin).0, "old");
    }

    #[test]
    fn a_building_that_has_changed_is_not_made_from_what_it_was() {
        let (thin, dense) = (site(9.0, 1.2, 10.0), site(6.0, 0.4, 10.0));
        let found = choice(&[("new", Some("2020"), thin.clone()), ("old", Some("2014"), dense.clone())], false);
        assert_eq!(found, ("new".to_owned(), Choice::OthersOutdated, Some(Mutation::Raised)));
        // A priority goes before the date; what is newer is no proof against it then.
        let found = choice(&[("old", Some("2014"), dense.clone()), ("new", Some("2020"), thin)], false);
        assert_eq!(found, ("old".to_owned(), Choice::First, Some(Mutation::Raised)));
    }

    #[test]
    fn no_cloud_is_older_than_the_building() {
        let dense = site(6.0, 0.5, 10.0);
        let two = |new, old| choice(&[("new", new, dense.clone()), ("old", old, dense.clone())], true);
        assert_eq!(two(Some("2016"), Some("2015")).0, "new");
        let clouds = [("new", Some("2015"), dense.clone()), ("old", None, dense.clone())];
        assert_eq!(choice(&clouds, true).0, "old", "without a date it cannot be told");
        let (name, why, change) = two(Some("2015"), Some("2014"));
        assert_eq!((name.as_str(), why, change), ("", Choice::NoneNewEnough, None));
    }
}
