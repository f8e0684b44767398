//! From a web server the same comes out as from files, and no more is read than is needed.

use std::fmt::Write;
use std::path::Path;

use tempfile::tempdir;

use super::server::{Answer, Server};
use crate::bench::*;

/// Bytes of a COPC of which something is needed: the nodes that touch boxes of footprints and what is looked at around them.
fn needed(copc: &Path, footprints: &Path, reach: f64) -> u64 {
    let bytes = std::fs::read(copc).unwrap();
    let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let f64_at = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let i32_at = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    // The record `info` is the first, behind the header of 375 bytes and its own of 54 (COPC 1.0).
    let info = 375 + 54;
    let (centre, half) = ([f64_at(info), f64_at(info + 8)], f64_at(info + 24));
    let (page, length) = (u64_at(info + 40) as usize, u64_at(info + 48) as usize);
    let json = json_of(footprints);
    let boxes: Vec<[f64; 4]> = json["features"]
        .as_array()
        .unwrap()
        .iter()
        .map(|feature| {
            let numbers = feature["geometry"]["coordinates"].to_string();
            let numbers: Vec<f64> = numbers.split(|c| "[],".contains(c)).filter_map(|n| n.parse().ok()).collect();
            let bound = |offset: usize, of: fn(f64, f64) -> f64| {
                numbers.iter().skip(offset).step_by(2).copied().reduce(of).unwrap()
            };
            [bound(0, f64::min), bound(1, f64::min), bound(0, f64::max), bound(1, f64::max)]
        })
        .collect();
    let mut sum = 0;
    for at in (page..page + length).step_by(32) {
        assert_ne!(i32_at(at + 28), -1, "a hierarchy of one page");
        let cell = 2.0 * half / f64::from(1 << i32_at(at));
        let low = [0, 1].map(|axis| centre[axis] - half + cell * f64::from(i32_at(at + 4 + 4 * axis)));
        let is_near =
            |b: &[f64; 4]| (0..2).all(|axis| low[axis] - reach <= b[axis + 2] && b[axis] <= low[axis] + cell + reach);
        if boxes.iter().any(is_near) {
            sum += i32_at(at + 24) as u64;
        }
    }
    sum
}

/// A folder with the quick start's tile as COPC, `delft.copc.laz`, its footprints, and some of them alone, `corner.geojson`.
pub fn folder_with_copc() -> tempfile::TempDir {
    let folder = tempdir().unwrap();
    let pipeline = serde_json::json!([
        data("delft_ahn3.laz").to_str().unwrap(),
        {"type": "writers.copc", "filename": folder.path().join("delft.copc.laz").to_str().unwrap()}
    ]);
    let file = folder.path().join("copc.json");
    std::fs::write(&file, pipeline.to_string()).unwrap();
    let run = gable(["pipeline", file.to_str().unwrap()]);
    assert_eq!(run.code, 0, "{}", run.err);
    std::fs::remove_file(file).unwrap();
    std::fs::copy(data("footprints.geojson"), folder.path().join("footprints.geojson")).unwrap();
    let mut some = json_of(data("footprints.geojson"));
    some["features"].as_array_mut().unwrap().truncate(6);
    std::fs::write(folder.path().join("corner.geojson"), some.to_string()).unwrap();
    folder
}

/// Asserts that a run from a server and one from files write the same bytes; gives what the server sent.
fn same(folder: &Path, tile: &str, footprints: &str, rest: &str) -> Server {
    let out = tempdir().unwrap();
    let local = out.path().join("local.city.json");
    let run = reconstruct(&[&folder.join(tile)], &folder.join(footprints), &local, rest);
    assert_eq!(run.code, 0, "{}", run.err);
    let server = Server::of(folder, |_| Answer::Well);
    let remote = out.path().join("remote.city.json");
    let (tile, footprints) = (server.url(tile), server.url(footprints));
    let run = reconstruct(&[Path::new(&tile)], Path::new(&footprints), &remote, rest);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(std::fs::read(&local).unwrap() == std::fs::read(&remote).unwrap(), "{tile}");
    assert_eq!(report_of(&remote)["inputs"]["tiles"][0]["file"], tile.as_str());
    server
}

#[test]
fn of_a_copc_only_the_nodes_that_matter_are_fetched() {
    let folder = folder_with_copc();
    let copc = folder.path().join("delft.copc.laz");
    let whole = std::fs::metadata(&copc).unwrap().len();
    for footprints in ["corner.geojson", "footprints.geojson"] {
        let server = same(folder.path(), "delft.copc.laz", footprints, "");
        let sent = server.sent()["delft.copc.laz"] as u64;
        let needed = needed(&copc, &folder.path().join(footprints), 2.0);
        println!("{footprints}: {sent} bytes read, {needed} needed, of {whole}");
        assert!(sent as f64 <= 1.3 * needed as f64, "{footprints}: {sent} of {needed} bytes, of {whole}");
    }
}

#[test]
fn other_tiles_are_read_once() {
    let folder = folder_with_copc();
    std::fs::copy(data("delft_ahn3.laz"), folder.path().join("delft.laz")).unwrap();
    let whole = std::fs::metadata(folder.path().join("delft.laz")).unwrap().len();
    let server = same(folder.path(), "delft.laz", "footprints.geojson", "");
    let sent = server.sent()["delft.laz"] as u64;
    assert!(sent >= whole && sent as f64 <= 1.2 * whole as f64, "{sent} of {whole} bytes");
    let mut xyz = String::new();
    let mut reader = las::Reader::from_path(data("delft_ahn3.laz")).unwrap();
    let mut header = las::Builder::from(reader.header().clone());
    header.point_format.is_compressed = false;
    let mut writer = las::Writer::from_path(folder.path().join("delft.las"), header.into_header().unwrap()).unwrap();
    for point in reader.read_all().unwrap().points().map(Result::unwrap) {
        let _ = writeln!(xyz, "{} {} {} {}", point.x, point.y, point.z, u8::from(point.classification));
        writer.write_point(point).unwrap();
    }
    drop(writer);
    std::fs::write(folder.path().join("delft.xyz"), xyz).unwrap();
    same(folder.path(), "delft.las", "footprints.geojson", "");
    same(folder.path(), "delft.xyz", "footprints.geojson", "--crs EPSG:7415 --building-class any");
}

#[test]
fn footprints_of_other_formats_come_with_what_stands_beside_them() {
    let folder = folder_with_copc();
    let server = Server::of(folder.path(), |_| Answer::Well);
    if let Some(delft) = shared("delft") {
        std::fs::copy(delft.join("bgt_pand.sqlite"), folder.path().join("pand.sqlite")).unwrap();
        let run = gable(["info", &server.url("pand.sqlite")]);
        assert_eq!(run.code, 0, "{}", run.err);
        assert_says(&run.out, &["SpatiaLite", "footprints"].map(|_| "pand"));
    }
    if let Some(rural) = shared("ign-rural") {
        let name = "870000_6618000.subset.postIA";
        for part in ["shp", "dbf", "shx", "prj"] {
            std::fs::copy(rural.join(format!("{name}.{part}")), folder.path().join(format!("ign.{part}"))).unwrap();
        }
        let [local, remote] =
            [folder.path().join("ign.shp").to_str().unwrap().to_owned(), server.url("ign.shp")].map(|path| {
                let run = gable(["info", "--json", &path]);
                assert_eq!(run.code, 0, "{}", run.err);
                run.out.replace(&path, "PATH")
            });
        assert_eq!(local, remote);
        assert!(remote.contains("PATH"));
    }
}

#[test]
fn secrets_of_an_address_are_shown_nowhere() {
    let folder = folder_with_copc();
    let server = Server::of(folder.path(), |_| Answer::Well);
    let signed = |name: &str| format!("{}?X-Amz-Signature=hunter2", server.url(name)).replace("://", "://me:hunter2@");
    let out = folder.path().join("out.city.json");
    let (tile, footprints) = (signed("delft.copc.laz"), signed("footprints.geojson"));
    let run = reconstruct(&[Path::new(&tile)], Path::new(&footprints), &out, "--verbose");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(server.requests().iter().all(|request| request.target.ends_with("?X-Amz-Signature=hunter2")));
    let report = report_of(&out).to_string();
    assert_says(&report, &["/delft.copc.laz", "/footprints.geojson"]);
    let model = std::fs::read_to_string(&out).unwrap();
    let missing = signed("none.copc.laz");
    let refused = reconstruct(&[Path::new(&missing)], Path::new(&footprints), &out, "--overwrite");
    assert_ends(&refused, 1, &["none.copc.laz", "no such object"]);
    let refusals = [
        gable(["reconstruct", &tile, "-f", &footprints, "-o", &signed("x.city.json")]),
        gable(["info", &missing]),
        gable(["info", &tile, "--nonsense"]),
    ];
    for said in [run.out, run.err, report, model, refused.err].into_iter().chain(refusals.map(|run| run.out + &run.err))
    {
        assert!(!said.contains("hunter2"), "{said}");
    }
}

#[test]
fn pipelines_and_info_take_the_same_names() {
    let folder = folder_with_copc();
    let server = Server::of(folder.path(), |_| Answer::Well);
    let run = gable(["info", &server.url("delft.copc.laz"), &server.url("footprints.geojson")]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["COPC", "delft.copc.laz"]);
    for reader in ["readers.copc", "readers.las"] {
        let [local, remote] =
            [folder.path().join("delft.copc.laz").to_str().unwrap().to_owned(), server.url("delft.copc.laz")].map(
                |name| {
                    let out = folder.path().join("out.txt");
                    let pipeline = serde_json::json!([
                        {"type": reader, "filename": name},
                        {"type": "writers.text", "filename": out.to_str().unwrap()}
                    ]);
                    std::fs::write(folder.path().join("p.json"), pipeline.to_string()).unwrap();
                    let run = gable(["pipeline", folder.path().join("p.json").to_str().unwrap()]);
                    assert_eq!(run.code, 0, "{}", run.err);
                    std::fs::read(out).unwrap()
                },
            );
        assert!(local == remote, "{reader}");
    }
    let run = gable(["info", &server.url("")]);
    assert_ends(&run, 1, &["web server", "index"]);
}
