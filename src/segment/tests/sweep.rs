//! Sites that are made while tiles are still to be read.

use super::*;
use crate::segment::{Meaning, Sweep};

/// Rows of houses on sloping ground, some of them without ground around, cut into columns and rows of tiles.
fn town(columns: usize, rows: usize) -> (Cloud, Vec<Footprint>) {
    let mut random = Random::new(5);
    let (mut points, mut footprints): (Vec<Plain>, Vec<Footprint>) = (Vec::new(), Vec::new());
    let floor = |x: f64, y: f64| 1.0 + (x - 1000.0) * 0.01 + (y - 5000.0) * 0.02;
    for i in 0..8 {
        for j in 0..6 {
            let (x, y) = (1002.0 + 24.0 * f64::from(i), 5002.0 + 30.0 * f64::from(j));
            footprints.push(footprint(&format!("{i}-{j}"), block([x, x + 11.0], [y, y + 9.0])));
            for _ in 0..400 {
                let place = [random.between(x, x + 11.0), random.between(y, y + 9.0)];
                points.push(([place[0], place[1], floor(x, y) + 6.0], 6));
            }
            for _ in 0..if (i + j) % 5 == 0 { 0 } else { 600 } {
                let place = [random.between(x - 6.0, x + 17.0), random.between(y - 6.0, y + 15.0)];
                points.push(([place[0], place[1], floor(place[0], place[1])], 2));
            }
        }
    }
    let mut cloud = Cloud::new();
    for column in 0..columns {
        for row in 0..rows {
            let part = |p: &&Plain| {
                let of = |value: f64, low: f64, length: f64, n: usize| {
                    (((value - low) / length * n as f64) as usize).min(n - 1)
                };
                of(p.0[0], 990.0, 210.0, columns) == column && of(p.0[1], 990.0 + 4000.0, 200.0, rows) == row
            };
            let mut own: Vec<Plain> = points.iter().filter(part).copied().collect();
            // The box of a tile is that of its cell, whatever was seen of it.
            let corner = |i: usize, j: usize| {
                [990.0 + 210.0 / columns as f64 * i as f64, 4990.0 + 200.0 / rows as f64 * j as f64, 1.0]
            };
            own.extend([corner(column, row), corner(column + 1, row + 1)].map(|corner| (corner, 7)));
            cloud = cloud.tile(&format!("{row}-{column}.las"), Style { format: 1, ..Style::default() }, &own);
        }
    }
    (cloud, footprints)
}

#[test]
fn a_site_is_made_as_soon_as_its_tiles_are_read_and_is_the_same() {
    // Ground farther away is none of theirs.
    let options = SegmentOptions { ring_width: 3.0, ring_limit: 3.0, ..SegmentOptions::default() };
    let (whole, footprints) = town(1, 1);
    let expected = whole.segment(&footprints, &options).unwrap();
    assert!(expected.sites.iter().any(|site| site.ground.source == GroundSource::Neighbours));
    for (columns, rows, budget) in [(4, 3, usize::MAX), (3, 5, 20_000), (7, 1, 0)] {
        let (cloud, footprints) = town(columns, rows);
        let tiles: Vec<Tile> = cloud.tiles.iter().map(|path| Tile::open(path).unwrap()).collect();
        let crs = crs(1.0);
        let sweep = Sweep::new(&tiles, footprints.clone(), &crs, &options, Meaning::Outlines, None, budget).unwrap();
        let mut made: Vec<Option<(Site, Vec<String>)>> = vec![None; footprints.len()];
        let mut before_last = 0;
        for tile in 0..sweep.tiles() {
            let part = sweep.read(tile, &|_| {}).unwrap();
            for (index, points) in sweep.take(tile, part).unwrap() {
                assert!(made[index].is_none());
                made[index] = sweep.site(index).unwrap();
                assert!(made[index].as_ref().is_none_or(|(site, _)| site.points.len() <= points));
                before_last += usize::from(tile + 1 < sweep.tiles());
            }
        }
        assert!(before_last > footprints.len() / 2, "{before_last} of {} before the last tile", footprints.len());
        let rest = sweep.rest();
        assert!(!rest.is_empty() && rest.len() < footprints.len() / 2);
        for (index, _) in rest {
            assert!(made[index].is_none());
            made[index] = sweep.site(index).unwrap();
        }
        let (sites, notes): (Vec<Site>, Vec<Vec<String>>) = made.into_iter().map(Option::unwrap).unzip();
        assert!(bits(&sites) == bits(&expected.sites), "{columns} × {rows}, {budget} bytes");
        assert_eq!(notes, expected.notes);
        let swept = sweep.finish().unwrap();
        assert_eq!((swept.counts.kept, swept.warnings), (expected.counts.kept, expected.warnings.clone()));
    }
}
