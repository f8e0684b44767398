//! `gable view` and `gable reconstruct --view`. What the page shows is tested in a browser: tests/platforms/view.test.js.

use tempfile::tempdir;

use crate::bench::*;

const REFERENCE: &str = "reference_3dbag_lod22.city.jsonl";

#[test]
fn a_page_of_the_points_and_the_model_of_another_maker() {
    let folder = tempdir().unwrap();
    let page = folder.path().join("new/page.html");
    let view = |rest: &[&str]| -> Run {
        let mut command = command(["view"]);
        command.arg(data(REFERENCE)).arg("-o").arg(&page).args(rest).output().unwrap().into()
    };
    let tile = data("delft_ahn3.laz").display().to_string();
    let run = view(&["--points", &tile, "--max-points", "2000"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["buildings", "up to LoD 2.2", "11", "2 000 of", "page.html"]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
    assert!(html.contains("<title>reference_3dbag_lod22.city.jsonl"));

    let run = view(&[]);
    assert_eq!(run.code, 1, "an existing file is kept");
    assert_says(&run.err, &["page.html", "--overwrite"]);
    assert_eq!(std::fs::read_to_string(&page).unwrap(), html);
    assert_eq!(view(&["--points", &tile, "--max-points", "2000", "--overwrite"]).code, 0);
    assert_eq!(std::fs::read_to_string(&page).unwrap(), html, "the same every time");
}

#[test]
fn a_run_writes_its_page_and_its_report_is_in_it() {
    let folder = tempdir().unwrap();
    let model = folder.path().join("delft.city.json");
    let run = delft(&model, "--view");
    assert!(matches!(run.code, 0 | 2), "{}", run.err);
    assert_says(&run.out, &["page", "delft.html"]);
    let with_run = std::fs::read(folder.path().join("delft.html")).unwrap();
    let run: Run = command(["view"]).arg(&model).output().unwrap().into();
    assert_eq!(run.code, 0, "a page beside the model is replaced: {}", run.err);
    let without = std::fs::read(folder.path().join("delft.html")).unwrap();
    assert!(with_run.len() > without.len() + 100_000, "the points and the report of the run");
}

#[test]
fn what_cannot_be_shown_is_said() {
    let folder = tempdir().unwrap();
    let page = folder.path().join("page.txt");
    let run: Run = command(["view"]).arg(data(REFERENCE)).arg("-o").arg(&page).output().unwrap().into();
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["page.txt", "PAGE.html"]);
    let run: Run = command(["view"]).arg(data("footprints.geojson")).output().unwrap().into();
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["footprints.geojson", "CityJSON"]);
    assert!(!page.exists());
}
