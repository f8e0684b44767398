//! Which cells a network is asked about: those whose label it could change.

use super::height_field::{Vote, votes};
use crate::reconstruct::Partitioned;

/// The vote is sure of a cell that it calls this near to 0 or 1 …
const SURE: f64 = 0.15;
/// … if no more of it than this is in doubt.
const LITTLE_DOUBT: f64 = 0.25;
/// Where all cells of which the vote is not sure are together smaller than this, the network is not asked at all: a part of
/// 4 m² that is a metre high is about the smallest that is missed. Cubic metres.
const LITTLE: f64 = 4.0;

/// What the vote says of every cell, and the cells to ask a network about.
#[derive(Debug)]
pub(super) struct Spared {
    /// The vote, 0 to 1.
    pub vote: Vec<f64>,
    /// Those to ask about, ascending.
    pub asked: Vec<u32>,
}

impl Spared {
    /// Asks about all cells of a building without a footprint: the vote knows its outline from the same points.
    pub fn of(building: &Partitioned) -> Self {
        let votes = votes(building, true);
        let all = building.hypotheses.footprint.is_none();
        let is_sure = |vote: &Vote| vote.doubt <= LITTLE_DOUBT && !(SURE..=1.0 - SURE).contains(&vote.inside);
        let volume = |cell: u32| building.volumes.get(cell as usize).copied().unwrap_or(0.0);
        let mut asked: Vec<u32> =
            building.free().filter(|&cell| all || votes.get(cell as usize).is_none_or(|vote| !is_sure(vote))).collect();
        if !all && asked.iter().copied().map(volume).sum::<f64>() < LITTLE {
            asked.clear();
        }
        Self { vote: votes.into_iter().map(|vote| vote.inside).collect(), asked }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use geo::{LineString, MultiPolygon, Polygon};
    use nalgebra::Point3;

    use super::super::network::{Answer, Interface, Network, NetworkError, Queries};
    use super::super::{CellRule, HeightField, Neural, Occupancy};
    use super::*;
    use crate::reconstruct::Parameters;
    use crate::site::{Frame, Site};

    /// A house of 16 m by 10 m: flat at 12 m west of x = 8 m, at 6 m east of it, with a point per half metre at the height
    /// that `seen` makes of it.
    fn house(seen: impl Fn(f64, f64, f64) -> Option<f64>) -> Site {
        let places = (0..640).map(|i| (0.25 + 0.5 * f64::from(i % 32), 0.25 + 0.5 * f64::from(i / 32)));
        let points = places.filter_map(|(x, y)| {
            let roof = if x < 8.0 { 12.0 } else { 6.0 };
            Some(Point3::new(x, y, seen(x, y, roof)?))
        });
        let ring = LineString::from(vec![(0.0, 0.0), (16.0, 0.0), (16.0, 10.0), (0.0, 10.0), (0.0, 0.0)]);
        Site::new("house", Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] }, points.collect(), 0.0)
            .with_footprint(&MultiPolygon(vec![Polygon::new(ring, Vec::new())]))
    }

    /// Whether a place of the low half is in the part where something is wrong.
    fn is_wrong(x: f64, y: f64) -> bool {
        x > 9.0 && y < 7.0
    }

    fn asked(site: &Site) -> (Vec<Point3<f64>>, usize) {
        let building = Partitioned::new(site, &Parameters::default()).unwrap();
        let spared = Spared::of(&building);
        let free = building.free().count();
        assert!(spared.asked.windows(2).all(|pair| pair[0] < pair[1]));
        (spared.asked.into_iter().map(|cell| building.complex.cell_centroid(cell)).collect(), free)
    }

    #[test]
    fn nothing_is_asked_where_the_scan_shows_all() {
        assert_eq!(asked(&house(|_, _, roof| Some(roof))).0, []);
        // Noise, and a few points of an antenna, do not speak against the vote.
        let noisy =
            house(|x, y, roof| Some(roof + if x == 12.25 && y == 5.25 { 4.0 } else { 0.05 * (7.0 * x + y).sin() }));
        assert_eq!(asked(&noisy).0, []);
    }

    #[test]
    fn cells_are_asked_about_that_points_speak_against() {
        // Points at all heights over the low roof make no plane, but something stands there.
        let scatter = |x: f64, y: f64| 7.0 + 4.5 * (12.9 * x + 78.2 * y).sin().abs();
        let (cells, free) = asked(&house(|x, y, roof| Some(if is_wrong(x, y) { scatter(x, y) } else { roof })));
        assert!(!cells.is_empty() && cells.len() < free, "{} of {free}", cells.len());
        assert!(cells.iter().all(|c| c.x > 8.0 && c.z > 6.0), "{cells:?}");
    }

    #[test]
    fn cells_are_asked_about_that_nothing_was_seen_of() {
        let (cells, free) = asked(&house(|x, y, roof| (!is_wrong(x, y)).then_some(roof)));
        assert!(!cells.is_empty() && cells.len() < free, "{} of {free}", cells.len());
        // Under and over the low roof, and nothing of the high half.
        assert!(cells.iter().all(|c| c.x > 8.0) && cells.iter().any(|c| c.z < 6.0), "{cells:?}");
    }

    #[test]
    fn without_a_footprint_all_is_asked() {
        let site = Site { footprint: None, ..house(|_, _, roof| Some(roof)) };
        let (cells, free) = asked(&site);
        assert_eq!(cells.len(), free);
    }

    /// Says that everything is half inside, and counts how often it is asked.
    #[derive(Debug, Default)]
    struct Undecided {
        encoded: AtomicUsize,
        asked: AtomicUsize,
    }

    impl Network for Undecided {
        fn interface(&self) -> Interface {
            Interface::Field { grid: 8, code: 2, neighbours: 4 }
        }

        fn encode(&self, _: &[f32]) -> Result<Vec<f32>, NetworkError> {
            self.encoded.fetch_add(1, Ordering::Relaxed);
            Ok(vec![0.0; 2 * 8 * 8])
        }

        fn decode(&self, queries: &Queries) -> Result<Vec<Answer>, NetworkError> {
            self.asked.fetch_add(queries.count, Ordering::Relaxed);
            Ok(vec![Answer { inside: 0.0, distance: 0.0 }; queries.count])
        }
    }

    #[test]
    fn the_vote_stands_where_the_network_is_not_asked() {
        let network = Arc::new(Undecided::default());
        let field = Neural::new(Arc::clone(&network) as Arc<dyn Network>, CellRule::Mean);
        let site = house(|_, _, roof| Some(roof));
        let building = Partitioned::new(&site, &Parameters::default()).unwrap();
        let vote = HeightField.occupancy(&building).unwrap();
        assert_eq!(field.occupancy(&building).unwrap(), vote);
        assert_eq!(network.encoded.load(Ordering::Relaxed), 0);

        let site = house(|x, y, roof| (!is_wrong(x, y)).then_some(roof));
        let building = Partitioned::new(&site, &Parameters::default()).unwrap();
        let (vote, found) = (HeightField.occupancy(&building).unwrap(), field.occupancy(&building).unwrap());
        assert_eq!(network.encoded.load(Ordering::Relaxed), 1);
        assert!(network.asked.load(Ordering::Relaxed) > 0);
        let changed: Vec<u32> = building.free().filter(|&cell| found[cell as usize] != vote[cell as usize]).collect();
        let asked = Spared::of(&building).asked;
        assert!(!changed.is_empty() && changed.iter().all(|cell| asked.contains(cell)));
        assert!(asked.iter().all(|&cell| found[cell as usize] == 0.5));
        // The rule of the paper is for comparison: it is asked about all.
        let paper = Neural::new(Arc::clone(&network) as Arc<dyn Network>, CellRule::Paper);
        network.asked.store(0, Ordering::Relaxed);
        paper.occupancy(&building).unwrap();
        assert_eq!(network.asked.load(Ordering::Relaxed), building.free().count());
    }
}
