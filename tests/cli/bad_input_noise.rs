//! Damage at random: whatever a file holds, the command ends by itself, with one of its exit codes and never with a
//! panic.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::bad_input_footprints::write_shapefile;
use crate::bench::*;

/// How long a file is damaged, and how often; a slow machine does fewer rounds.
const TIME: Duration = Duration::from_secs(4);
const ROUNDS: u64 = 100;

/// A generator of which the numbers are those of every run (Steele, Lea and Flood, `SplitMix64`).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// Flips one to eight bits, one in three of them among the first 600 bytes, where the headers are.
fn damage(content: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(8) {
        let reach = if random.below(3) == 0 { content.len().min(600) } else { content.len() };
        let at = random.below(reach);
        content[at] ^= 1 << random.below(8);
    }
}

/// Runs the command on damaged copies of these files of `folder`, and on the others as they are.
fn survives(folder: &Path, tile: &str, footprints: &str, damaged: &str, seed: u64) {
    let whole = std::fs::read(folder.join(damaged)).unwrap();
    let until = Instant::now() + TIME;
    let mut random = Random(seed);
    for round in 0..ROUNDS {
        if Instant::now() > until {
            println!("{damaged}: {round} rounds in the time that there is");
            break;
        }
        let mut content = whole.clone();
        damage(&mut content, &mut random);
        if random.below(8) == 0 {
            content.truncate(random.below(whole.len()));
        }
        std::fs::write(folder.join(damaged), &content).unwrap();
        let started = Instant::now();
        let run = run_in(folder, tile, footprints, "--overwrite --jobs 1");
        assert!(matches!(run.code, 0..=2), "round {round}: {}{}", run.out, run.err);
        assert!(!run.err.contains("panicked") && !run.err.contains("RUST_BACKTRACE"), "round {round}: {}", run.err);
        assert!(
            run.code != 1 || run.err.contains("error: ") || run.err.contains("warning: "),
            "round {round}: no word"
        );
        assert!(started.elapsed() < Duration::from_secs(60), "round {round} took {:?}", started.elapsed());
        let left = names_in(folder);
        assert!(
            !left.iter().any(|name| name.ends_with("part") || name.ends_with("partial")),
            "round {round}: {left:?}"
        );
    }
}

#[test]
fn random_damage_to_the_bundled_tile() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(data("delft_ahn3.laz"), folder.path().join("t.laz")).unwrap();
    // A few footprints, so that the time goes into the reading.
    let mut footprints = json_of(data("footprints.geojson"));
    footprints["features"].as_array_mut().unwrap().truncate(2);
    std::fs::write(folder.path().join("f.geojson"), footprints.to_string()).unwrap();
    survives(folder.path(), "t.laz", "f.geojson", "t.laz", 1);
}

#[test]
fn random_damage_to_a_small_tile() {
    let folder = house_folder();
    survives(folder.path(), "house.laz", "footprints.geojson", "house.laz", 2);
    write_house(&folder.path().join("house.las"), None, 6);
    survives(folder.path(), "house.las", "footprints.geojson", "house.las", 3);
}

#[test]
fn random_damage_to_a_shapefile() {
    let folder = house_folder();
    let ring = [[0.0, 0.0], [0.0, 8.0], [10.0, 8.0], [10.0, 0.0], [0.0, 0.0]];
    write_shapefile(&folder.path().join("f.shp"), &ring.map(|c| [c[0] + CORNER[0], c[1] + CORNER[1]]));
    for (part, seed) in [("f.shp", 5), ("f.dbf", 6)] {
        let whole = std::fs::read(folder.path().join(part)).unwrap();
        survives(folder.path(), "house.laz", "f.shp", part, seed);
        std::fs::write(folder.path().join(part), whole).unwrap();
    }
}

#[test]
fn random_damage_to_footprints() {
    let folder = house_folder();
    // The bundled footprints do not lie where the house is; its own come last.
    let mut bundled = json_of(data("footprints.geojson"));
    let own = json_of(folder.path().join("footprints.geojson"))["features"][0].clone();
    bundled["features"].as_array_mut().unwrap().push(own);
    std::fs::write(folder.path().join("f.geojson"), bundled.to_string()).unwrap();
    survives(folder.path(), "house.laz", "f.geojson", "f.geojson", 4);
}
