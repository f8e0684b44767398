//! Readers of text and PLY.

use serde_json::json;

use super::{Bench, line};

#[test]
fn text_has_the_dimensions_of_its_names() {
    let bench = Bench::new();
    let write = |text: &str| std::fs::write(bench.path("t.csv"), text).unwrap();
    write("X, Y, Z, intensity, class, Planarity\n1, 2, 3, 400, 6, 0.5\n\n4.25,5,6,70000,2,-1e-3\r\n");
    let rows = bench.rows(&[json!("@t.csv")], "X,Y,Z,Intensity,Classification,Planarity");
    assert_eq!(rows, [[1.0, 2.0, 3.0, 400.0, 6.0, 0.5], [4.25, 5.0, 6.0, 70_000.0, 2.0, -0.001]]);
    // What writers.text leaves can be read again.
    bench.tile("a.las", &line(&[1, 2, 6]));
    bench.run(&json!(["@a.las", "@again.txt"]));
    assert_eq!(
        bench.rows(&[json!("@again.txt")], "X,Z,Classification"),
        [[0.0, 0.0, 1.0], [1.0, 10.0, 2.0], [2.0, 20.0, 6.0]]
    );

    write("a scan of today\n1 2 3 9\n 4  5 6 8\n7 8 9 7\n");
    let reader = |options: serde_json::Value| {
        let mut stage = json!({"type": "readers.text", "filename": "@t.csv"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        stage
    };
    let named = reader(json!({"skip": 1, "header": "Y X Z Mark", "count": 2, "spatialreference": "EPSG:7415"}));
    assert_eq!(bench.rows(std::slice::from_ref(&named), "X,Y,Mark"), [[2.0, 1.0, 9.0], [5.0, 4.0, 8.0]]);
    bench.run(&json!([named, "@o.las"]));
    let tile = crate::source::points::Tile::open(bench.path("o.las")).unwrap();
    assert_eq!((tile.points, tile.crs.unwrap().code.as_deref()), (2, Some("EPSG:7415")));

    let fault = |options| bench.fault(&json!([reader(options), {"type": "writers.null"}]));
    assert!(fault(json!({"skip": 1})).contains("line 2"), "{}", fault(json!({"skip": 1})));
    assert!(fault(json!({"skip": 1})).contains("`header`"));
    assert!(fault(json!({"header": "X Y Mark Note"})).contains("without Z"));
    assert!(fault(json!({"header": "X Y Z x"})).contains("twice"));
    assert!(fault(json!({"separator": "::"})).contains("one sign"));
    assert!(fault(json!({"skip": 9})).contains("the end of the file"));
}

#[test]
fn lines_that_are_no_points_are_told() {
    let bench = Bench::new();
    std::fs::write(bench.path("t.xyz"), "X Y Z\n1 2 3\n1 2\n1 2 three\n4 5 6\n").unwrap();
    let outcome = bench.run(&json!(["@t.xyz", {"type": "writers.null"}]));
    assert_eq!(outcome.exit_code, 2);
    assert_eq!(outcome.metadata["stages"]["readers.text"]["read"], 2);
}

#[test]
fn ply_has_all_its_numbers() {
    let bench = Bench::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty double z\n\
                  property uchar red\nproperty list uchar int chain\nproperty short Mark\nproperty float nx\nend_header\n";
    std::fs::write(bench.path("a.ply"), format!("{header}1 2 3.125 255 2 7 8 -9 0.5\n4 5 6 0 0 300 1\n")).unwrap();
    let order = "X,Y,Z,Red,Mark,NormalX";
    assert_eq!(
        bench.rows(&[json!("@a.ply")], order),
        [[1.0, 2.0, 3.125, 255.0, -9.0, 0.5], [4.0, 5.0, 6.0, 0.0, 300.0, 1.0]]
    );
    // Binary, low byte first and cut off within the third vertex.
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
                      property double z\nproperty uint Mark\nend_header\n"
        .to_vec();
    for n in 0..3_u32 {
        for axis in 0..3 {
            bytes.extend(f64::from(10 * n + axis).to_le_bytes());
        }
        bytes.extend((n + 4_000_000_000).to_le_bytes());
    }
    bytes.pop();
    std::fs::write(bench.path("b.ply"), bytes).unwrap();
    let rows = bench.rows(&[json!("@b.ply")], "X,Z,Mark");
    assert_eq!(rows, [[0.0, 2.0, 4e9], [10.0, 12.0, 4_000_000_001.0]]);
    let outcome = bench.run(&json!(["@b.ply", {"type": "writers.null"}]));
    assert_eq!((outcome.exit_code, &outcome.metadata["stages"]["readers.ply"]["count"]), (2, &json!(3)));
    let outcome = bench.run(&json!([{"filename": "@b.ply", "count": 1}, {"type": "writers.null"}]));
    assert_eq!((outcome.exit_code, &outcome.metadata["stages"]["readers.ply"]["read"]), (0, &json!(1)));
    std::fs::write(bench.path("c.ply"), header.replace("Mark", "RED")).unwrap();
    assert!(bench.fault(&json!(["@c.ply", {"type": "writers.null"}])).contains("has one already"));
}
