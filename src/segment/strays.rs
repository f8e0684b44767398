//! Points inside the footprint that are not of the building, told by the building's own points alone: a bird, a crane,
//! the higher neighbour's wall behind a party wall. Whatever a dormer, a chimney or a low extension could explain stays.

use super::options::SegmentOptions;
use crate::geometry::PreparedPolygon;
use std::collections::BTreeMap;

/// Side of the cells in plan; a cell and its neighbours make a window of 4.5 m.
const CELL: f64 = 1.5;
/// More points than this that hover together are an object of their own, and stay.
const HANDFUL: usize = 3;
/// Fewer points than this below a hovering one are no roof, and nothing can be said.
const ROOF: usize = 10;
/// Fewer points than this inside the band along the edges say nothing about the building's height.
const INTERIOR: usize = 20;

/// Drops up to three points that hover, by `options.hover_gap`, above all others in a window of 4.5 m. Gives how many.
pub(super) fn drop_hovering(points: &mut Vec<[f64; 3]>, options: &SegmentOptions) -> usize {
    let key = |point: &[f64; 3]| [(point[0] / CELL).floor() as i64, (point[1] / CELL).floor() as i64];
    // Of each cell the number of points and the highest few.
    let mut cells: BTreeMap<[i64; 2], (usize, Vec<f64>)> = BTreeMap::new();
    for point in points.iter() {
        let (count, highest) = cells.entry(key(point)).or_default();
        *count += 1;
        let place = highest.partition_point(|z| *z >= point[2]);
        if place <= HANDFUL {
            highest.insert(place, point[2]);
            highest.truncate(HANDFUL + 1);
        }
    }
    let mut ceilings = BTreeMap::new();
    for [column, row] in cells.keys() {
        let (mut count, mut highest) = (0, Vec::new());
        for neighbour in (column - 1..=column + 1).flat_map(|c| (row - 1..=row + 1).map(move |r| [c, r])) {
            if let Some((n, top)) = cells.get(&neighbour) {
                count += n;
                highest.extend_from_slice(top);
            }
        }
        highest.sort_unstable_by(|a, b| b.total_cmp(a));
        let gap = highest.windows(2).take(HANDFUL).enumerate().find(|(_, pair)| pair[0] - pair[1] > options.hover_gap);
        if let Some((index, pair)) = gap.filter(|(index, _)| count > index + ROOF) {
            debug_assert!(index < HANDFUL);
            ceilings.insert([*column, *row], pair[1]);
        }
    }
    let before = points.len();
    points.retain(|point| ceilings.get(&key(point)).is_none_or(|ceiling| point[2] <= *ceiling));
    before - points.len()
}

/// Drops points in the band along the footprint's edges that rise above everything further inside. Gives how many.
pub(super) fn drop_beyond_party_wall(
    points: &mut Vec<[f64; 3]>,
    footprint: &PreparedPolygon,
    options: &SegmentOptions,
) -> usize {
    let band = options.party_wall_band;
    let mut order: Vec<&[f64; 3]> = points.iter().collect();
    order.sort_unstable_by(|a, b| b[2].total_cmp(&a[2]));
    let mut interior = order.iter().filter(|p| footprint.boundary_distance([p[0], p[1]], band) > band);
    let Some(highest) = interior.next() else { return 0 };
    let ceiling = highest[2] + options.party_wall_rise;
    let has_interior = interior.take(INTERIOR - 1).count() == INTERIOR - 1;
    if !has_interior || order.first().is_none_or(|top| top[2] <= ceiling) {
        return 0;
    }
    let before = points.len();
    points.retain(|point| point[2] <= ceiling);
    before - points.len()
}

#[cfg(test)]
mod tests {
    use super::{drop_beyond_party_wall, drop_hovering};
    use crate::geometry::PreparedPolygon;
    use crate::segment::SegmentOptions;
    use geo::{MultiPolygon, polygon};

    /// A flat roof of 10 m by 10 m at 6 m, four points per square metre.
    fn roof() -> Vec<[f64; 3]> {
        (0..400).map(|i| [f64::from(i % 20) * 0.5 + 0.25, f64::from(i / 20) * 0.5 + 0.25, 6.0]).collect()
    }

    #[test]
    fn birds_go_and_chimneys_stay() {
        let mut points = roof();
        points.extend([[5.0, 5.0, 20.0], [5.2, 5.0, 20.3]]);
        let chimney: Vec<_> = (0..4).map(|i| [2.0 + 0.2 * f64::from(i), 2.0, 7.5]).collect();
        let tower: Vec<_> = (0..6).map(|i| [8.0 + 0.2 * f64::from(i), 8.0, 15.0]).collect();
        points.extend(chimney.iter().chain(&tower));
        assert_eq!(drop_hovering(&mut points, &SegmentOptions::default()), 2);
        assert_eq!(points.len(), 400 + 4 + 6);
        assert!(points.iter().all(|p| p[2] < 20.0));
    }

    #[test]
    fn the_neighbours_wall_goes_and_the_own_parapet_stays() {
        let square = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)];
        let footprint = PreparedPolygon::new(&MultiPolygon::new(vec![square]));
        let mut points = roof();
        let parapet = (0..20).map(|i| [f64::from(i) * 0.5, 0.2, 7.0]);
        let wall = (0..30).map(|i| [9.9, f64::from(i) / 3.0, 8.0 + f64::from(i % 7) * 0.4]);
        points.extend(parapet.chain(wall));
        assert_eq!(drop_beyond_party_wall(&mut points, &footprint, &SegmentOptions::default()), 30);
        assert_eq!(points.len(), 420);
        // A tower that reaches into the middle explains what stands at the edge.
        points.extend([[9.8, 5.0, 12.0], [8.5, 5.0, 12.0]]);
        assert_eq!(drop_beyond_party_wall(&mut points, &footprint, &SegmentOptions::default()), 0);
    }
}
