//! Whatever a server does, a run ends with the model that it should, or with an error that names the object.

use std::path::Path;

use tempfile::tempdir;

use super::server::{Answer, Request, Server};
use super::web::folder_with_copc;
use crate::bench::*;

/// Runs the quick start from a server that behaves like this, trying requests twice again and waiting a second for each.
fn run_from(
    folder: &Path,
    out: &Path,
    behaviour: impl Fn(&Request) -> Answer + Send + Sync + 'static,
) -> (Run, Server) {
    let server = Server::of(folder, behaviour);
    let mut command = command(["reconstruct"]);
    command.arg(server.url("delft.copc.laz")).arg("-f").arg(server.url("footprints.geojson"));
    command.arg("-o").arg(out.join("out.city.json"));
    command.env("GABLE_REMOTE_TIMEOUT", "1").env("GABLE_REMOTE_RETRIES", "4");
    (command.output().unwrap().into(), server)
}

#[test]
fn what_fails_once_is_tried_again() {
    let folder = folder_with_copc();
    let local = folder.path().join("local.city.json");
    let copc = folder.path().join("delft.copc.laz");
    let run = reconstruct(&[&copc], &folder.path().join("footprints.geojson"), &local, "");
    assert_eq!(run.code, 0, "{}", run.err);
    let expected = std::fs::read(local).unwrap();
    for fault in [Answer::Status(503), Answer::Status(429), Answer::Cut, Answer::Half, Answer::Silent] {
        let out = tempdir().unwrap();
        let answer = move |request: &Request| if request.number.is_multiple_of(3) { fault } else { Answer::Well };
        let (run, server) = run_from(folder.path(), out.path(), answer);
        assert_eq!(run.code, 0, "{fault:?}: {}", run.err);
        assert!(std::fs::read(out.path().join("out.city.json")).unwrap() == expected, "{fault:?}");
        assert!(server.requests().len() > 6, "{fault:?}");
    }
    // Without a tag the library does not go on within a body, and without ranges all is read at once.
    let untagged = |request: &Request| if request.number == 2 { Answer::Half } else { Answer::Untagged };
    let whole = |request: &Request| if request.number == 1 { Answer::Half } else { Answer::Whole };
    for behaviour in [Box::new(untagged) as Box<dyn Fn(&Request) -> Answer + Send + Sync>, Box::new(whole)] {
        let out = tempdir().unwrap();
        let (run, _) = run_from(folder.path(), out.path(), behaviour);
        assert_eq!(run.code, 0, "{}", run.err);
        assert!(std::fs::read(out.path().join("out.city.json")).unwrap() == expected);
    }
}

#[test]
fn servers_without_tags_or_ranges_do() {
    let folder = folder_with_copc();
    let local = folder.path().join("local.city.json");
    let copc = folder.path().join("delft.copc.laz");
    assert_eq!(reconstruct(&[&copc], &folder.path().join("footprints.geojson"), &local, "").code, 0);
    for answer in [Answer::Untagged, Answer::Whole] {
        let out = tempdir().unwrap();
        let (run, server) = run_from(folder.path(), out.path(), move |_| answer);
        assert_eq!(run.code, 0, "{answer:?}: {}", run.err);
        assert!(
            std::fs::read(out.path().join("out.city.json")).unwrap() == std::fs::read(&local).unwrap(),
            "{answer:?}"
        );
        let tile = server.requests().iter().filter(|request| request.file() == "delft.copc.laz").count();
        assert!(answer != Answer::Whole || tile <= 2, "it is read as a whole once, after one try: {tile}");
    }
}

#[test]
fn what_goes_on_failing_is_an_error_that_names_the_object() {
    let folder = folder_with_copc();
    let from = |first: usize, fault: Answer| {
        move |request: &Request| {
            let is_meant = request.file() == "delft.copc.laz" && request.number >= first;
            if is_meant { fault } else { Answer::Well }
        }
    };
    let changed = "another version than the one that was opened";
    for (fault, says) in [
        (Answer::Status(503), "the server answers 503"),
        (Answer::Status(403), "no access"),
        (Answer::Status(404), "no such object"),
        (Answer::Cut, "delft.copc.laz"),
        (Answer::Half, "delft.copc.laz"),
        (Answer::Silent, "timed out"),
        (Answer::Changed, changed),
    ] {
        // From the first request on; from the third, in the header; and among the points.
        for first in [0, 2, 8] {
            if fault == Answer::Changed && first == 0 {
                continue;
            }
            let out = tempdir().unwrap();
            let (run, _) = run_from(folder.path(), out.path(), from(first, fault));
            assert_ends(&run, 1, &["/delft.copc.laz", says]);
            assert!(!run.err.contains("hunter2") && !run.err.contains("Secret"), "{}", run.err);
            assert!(names_in(out.path()).is_empty(), "{fault:?} from {first}: {:?}", names_in(out.path()));
        }
    }
    // The same of footprints, once their copy is begun: each look at them before is of the version of its time.
    for (fault, says) in
        [(Answer::Status(500), "500"), (Answer::Half, "footprints.geojson"), (Answer::Changed, changed)]
    {
        let out = tempdir().unwrap();
        let meant = move |request: &Request| {
            let is_meant = request.file() == "footprints.geojson" && request.number >= 3;
            if is_meant { fault } else { Answer::Well }
        };
        let (run, _) = run_from(folder.path(), out.path(), meant);
        assert_ends(&run, 1, &["/footprints.geojson", says]);
        assert!(names_in(out.path()).is_empty(), "{fault:?}: {:?}", names_in(out.path()));
    }
}

#[test]
fn one_of_several_tiles_that_cannot_be_opened_is_told_and_left_out() {
    let folder = folder_with_copc();
    let server = Server::of(folder.path(), |_| Answer::Well);
    let out = tempdir().unwrap();
    let (tile, none) = (server.url("delft.copc.laz"), server.url("none.copc.laz"));
    let model = out.path().join("out.city.json");
    let footprints = server.url("footprints.geojson");
    let run = reconstruct(&[Path::new(&tile), Path::new(&none)], Path::new(&footprints), &model, "");
    assert_ends(&run, 2, &[&none, "no such object", "left out"]);
    assert_eq!(report_of(&model)["inputs"]["tiles"].as_array().unwrap().len(), 2);
}
