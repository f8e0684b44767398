use super::super::{Extent, Placement, Reading, ScanPoint, Tile, Unit, UpAxis};
use std::fmt::Write as _;
use std::path::Path;

fn read(tile: &Tile) -> (Vec<ScanPoint>, Reading) {
    let mut points = Vec::new();
    let reading = tile.stream(None, &mut |block| points.extend(block.points())).unwrap();
    (points, reading)
}

/// A place and a class.
type Plain = ([f64; 3], u8);

/// The points of a file with this name and content, and what is wrong with it.
fn points_of(name: &str, content: &[u8]) -> Result<(Vec<Plain>, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    let tile = Tile::open(&path).map_err(|e| e.to_string())?;
    let (points, reading) = read(&tile);
    let problems = reading.problems(&tile).iter().map(ToString::to_string).collect();
    Ok((points.iter().map(|p| (p.position, p.class)).collect(), problems))
}

fn message(name: &str, content: &[u8]) -> String {
    points_of(name, content).unwrap_err()
}

const POINTS: [([f64; 3], u8); 3] = [([1.5, -2.0, 3.25], 6), ([85_000.125, 447_000.5, 12.0], 2), ([0.0, 1e-3, 7.0], 0)];

/// The points as PLY with colours and normals around the coordinates, which stand in no order, and faces behind.
fn ply(encoding: &str) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat {encoding} 1.0\ncomment made here\nelement camera 2\nproperty list uchar float view\nproperty int id\n\
         element vertex 3\nproperty uchar red\nproperty double z\nproperty float nx\nproperty double x\n\
         property float scalar_Classification\nproperty list uchar short seen\nproperty double y\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let big = encoding == "binary_big_endian";
    let mut put = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        if big {
            bytes.reverse();
        }
        out.extend(bytes);
    };
    if encoding == "ascii" {
        let mut text = "2 0.5 1.5 7\n0 8\n".to_owned();
        for ([x, y, z], class) in POINTS {
            writeln!(text, "255 {z} nan {x} {class} 3 -1 -2 -3 {y}").unwrap();
        }
        text += "3 0 1 2\n";
        out.extend(text.bytes());
        return out;
    }
    for views in [2_u8, 0] {
        put(&[views]);
        (0..views).for_each(|view| put(&f32::from(view).to_le_bytes()));
        put(&7_i32.to_le_bytes());
    }
    for ([x, y, z], class) in POINTS {
        put(&[255]);
        put(&z.to_le_bytes());
        put(&f32::NAN.to_le_bytes());
        put(&x.to_le_bytes());
        put(&f32::from(class).to_le_bytes());
        put(&[3]);
        (0..3_i16).for_each(|i| put(&i.to_le_bytes()));
        put(&y.to_le_bytes());
    }
    out.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    out
}

#[test]
fn vertices_come_out_of_any_ply_whatever_stands_around_them() {
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        assert_eq!(points_of("a.ply", &ply(encoding)), Ok((POINTS.to_vec(), Vec::new())), "{encoding}");
        // The content decides where the extension says nothing.
        assert_eq!(points_of("a.dat", &ply(encoding)).unwrap().0.len(), 3);
    }
    let types =
        [("char", 1), ("uint8", 1), ("short", 2), ("uint16", 2), ("int", 4), ("uint32", 4), ("int64", 8), ("ulong", 8)];
    for (kind, size) in types {
        let mut file = format!(
            "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty {kind} x\r\n\
             property {kind} y\r\nproperty {kind} z\r\nend_header\r\n"
        )
        .into_bytes();
        for value in [10, 11, 12] {
            file.extend(std::iter::once(value).chain(std::iter::repeat_n(0, size - 1)));
        }
        assert_eq!(points_of("b.ply", &file).unwrap().0, [([10.0, 11.0, 12.0], 0)], "{kind}");
    }
}

#[test]
fn a_ply_that_claims_too_much_or_is_cut_off_gives_what_it_holds() {
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let whole = ply(encoding);
        let text = String::from_utf8_lossy(&whole).into_owned();
        let place = text.find("vertex 3").unwrap();
        let mut claims = whole[..place].to_vec();
        claims.extend(b"vertex 1000000000000000000");
        // Behind the vertices nothing is.
        claims.extend(&whole[place + 8..whole.len() - if encoding == "ascii" { 8 } else { 13 }]);
        let (points, problems) = points_of("a.ply", &claims).unwrap();
        assert_eq!(points, POINTS, "{encoding}");
        assert!(problems[0].contains("999999999999999997 of 1000000000000000000 points are missing"), "{problems:?}");
        assert!(problems[0].contains("the end of the file"), "{problems:?}");
        // However it is cut, there is a message or some points, and no panic.
        for end in 0..whole.len() {
            match points_of("a.ply", &whole[..end]) {
                Ok((points, _)) => assert_eq!(points, POINTS[..points.len()]),
                Err(message) => assert!(message.contains("a.ply") && message.contains("found"), "{message}"),
            }
        }
    }
}

#[test]
fn what_is_wrong_with_a_ply_is_said_with_its_place() {
    let with = |header: &str| message("a.ply", format!("ply\n{header}end_header\n").as_bytes());
    let vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let cases = [
        (message("a.ply", b""), "an empty file (0 bytes)"),
        (message("a.ply", b"PLY of something"), "line 1: found another beginning, expected `ply`"),
        (message("a.ply", b"ply\nformat ascii 1.0\n"), "line 3: found the end of the file, expected `end_header`"),
        (with("format bits 1.0\n"), "line 2: found `bits`, expected ascii, binary_little_endian"),
        (with("format ascii 1.0\nelement vertex many\n"), "line 3: found `many`"),
        (with("format ascii 1.0\nproperty float x\n"), "expected an element before its properties"),
        (with("format ascii 1.0\nelement vertex 1\nproperty quad x\n"), "line 4: found `quad`"),
        (with("format ascii 1.0\nelement face 1\n"), "no element `vertex`"),
        (with("format ascii 1.0\nelement vertex 1\nproperty float x\n"), "0 properties `y` of a vertex"),
        (with(vertex), "no line `format`"),
        (with(&format!("format ascii 1.0\n{vertex}")), "line 8: found the end of the file, expected 1 vertices"),
        (with(&format!("format ascii 1.0\ncomment {}\n{vertex}", "x".repeat(70_000))), "more than 65536 bytes"),
        (
            message("a.ply", format!("ply\nformat ascii 1.0\n{vertex}end_header\n1 2,5 3\n").as_bytes()),
            "line 8: found `2,5` where a number stands",
        ),
    ];
    for (message, part) in cases {
        assert!(message.contains(part), "{message}\nwithout {part}");
    }
    let endless = format!("ply\nformat ascii 1.0\n{vertex}end_header\n{}", "1".repeat(1 << 20));
    assert!(message("a.ply", endless.as_bytes()).contains("more than 65536 bytes without the end of a line"));
}

#[test]
fn text_is_read_with_any_mark_between_numbers_and_with_names_or_without() {
    let expected = [([1.5, -2.0, 3.25], 0), ([4.0, 5.0, 6e1], 0)];
    let classed = [([1.5, -2.0, 3.25], 6), ([4.0, 5.0, 60.0], 2)];
    let plain = [
        "1.5 -2 3.25\n4 5 6e1\n",
        "# a comment\n\n1.5\t-2.0\t3.25\t255\t0\t0\r\n4 5 60 1 1 1\r\n",
        "2\n1.5 -2 3.25 -120 1 2 3\n4 5 60 8 1 2 3\n",
        "X;Y;Z;R\n1.5;-2;3.25;red\n4; 5; 60;blue",
        "\u{feff}\"x\",\"y\",\"z\"\n1.5, -2, 3.25\n4,5,60,\n",
        "//Z X Y Intensity\n3.25 1.5 -2 7\n60 4 5 8\n",
        "id,Height (m),Northing (m),Easting (m)\na,3.25,-2,1.5\nb,60,5,4\n",
    ];
    for text in plain {
        for name in ["a.xyz", "a.txt", "a.asc", "a.csv", "a.PTS"] {
            assert_eq!(points_of(name, text.as_bytes()), Ok((expected.to_vec(), Vec::new())), "{name}: {text}");
        }
    }
    let text = "//X Y Z Scalar_Classification\n1.5 -2 3.25 6.000000\n4 5 60 2.0\n";
    assert_eq!(points_of("a.xyz", text.as_bytes()).unwrap().0, classed);
}

#[test]
fn what_is_wrong_with_text_is_said_with_its_line() {
    let cases: [(&[u8], &str); 10] = [
        (b"1.5 2.5 3.5\n1,5 2,5 3,5\n", "a.xyz, line 2: found `5 2`, expected a number"),
        (b"1,5;2,5;3,5\n", "a.xyz, line 1: found `1,5`, expected a number"),
        (b"x y z\n1 2 3\n1 2\n", "line 3: found `1 2` with 2 numbers, expected 3 at least"),
        (b"x y z\n1 2 3\n1 two 3\n", "line 3: found `two`, expected a number"),
        (b"easting northing\n1 2\n", "line 1: found `easting northing`, expected names of columns"),
        (b"ncols 100\nnrows 100\n", "line 1: found `ncols 100`, expected names of columns"),
        (b"\n# nothing\n", "line 3: found no point"),
        (b"", "line 1: found no point"),
        (b"\xff\xfe1\x00 \x002\x00", "line 1: found"),
        (b"1 2 3\n\xff\xff\xff\n", "line 2: found"),
    ];
    for (content, part) in cases {
        let message = message("a.xyz", content);
        assert!(message.contains(part), "{message}\nwithout {part}");
        assert!(message.contains("decimals need a point"), "{message}");
    }
    let long = [b"1 2 3\n".as_slice(), &b"4 ".repeat(50_000)].concat();
    assert!(message("a.xyz", &long).contains("line 2: found more than 65536 bytes"));
    assert!(message("a.foo", b"1 2 3\n").contains("expected the signature 'LASF'"));
}

#[test]
fn impossible_coordinates_are_left_out_and_counted() {
    let (points, problems) = points_of("a.xyz", b"1 2 3\nnan 2 3\n1 inf 3\n1 2 1e300\n4 5 6\n").unwrap();
    assert_eq!(points.len(), 2);
    assert!(problems[0].contains("3 points with impossible coordinates were left out"), "{problems:?}");
}

#[test]
fn coordinates_of_another_unit_and_axis_become_metres_with_heights_along_z() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xyz");
    std::fs::write(&path, "1000 20000 -3000\n2000 0 -4000\n").unwrap();
    let tile = Tile::open(&path).unwrap().placed(Placement { unit: Unit::Millimetre, up: UpAxis::Y });
    let (points, _) = read(&tile);
    assert_eq!(points[0].position, [1.0, 3.0, 20.0]);
    assert_eq!(tile.extent, Some(Extent { min: [1.0, 3.0, 0.0], max: [2.0, 4.0, 20.0] }));
    assert!(tile.areas()[0].holds([1.5, 3.5, 0.0]) && !tile.has_classes && !tile.is_las());
    let las = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data/delft_ahn3.laz");
    let plain = Tile::open(las).unwrap();
    let (before, _) = read(&plain);
    let feet = plain.placed(Placement { unit: Unit::Foot, up: UpAxis::X });
    let (after, reading) = read(&feet);
    assert_eq!((after.len(), reading.absurd), (before.len(), 0));
    assert!((after[7].position[2] - before[7].position[0] * 0.3048).abs() < 1e-9);
    assert!(after.iter().all(|point| feet.extent.unwrap().holds(point.position)));
}

#[test]
fn many_points_come_in_blocks_and_all_of_them() {
    let mut text = String::new();
    (0..40_000).for_each(|i| writeln!(text, "{i} 0 1").unwrap());
    let (points, problems) = points_of("a.xyz", text.as_bytes()).unwrap();
    assert_eq!((points.len(), problems.len()), (40_000, 0));
    assert!((0..).zip(&points).all(|(i, point)| point.0[0] == f64::from(i)));
}

#[test]
fn damage_anywhere_ends_with_a_message_or_fewer_points() {
    let mut state = 1_u64;
    let mut random = move |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let text = b"x;y;z;class\n1.5;2;3;6\n1.5;2;3;2\n".to_vec();
    let files = [
        ("a.ply", ply("ascii")),
        ("a.ply", ply("binary_little_endian")),
        ("a.ply", ply("binary_big_endian")),
        ("a.csv", text),
    ];
    for (name, whole) in files {
        for _ in 0..400 {
            let mut damaged = whole.clone();
            for _ in 0..=random(3) {
                let at = random(damaged.len());
                damaged[at] = [0, b'9', b'-', b' ', b'\n', 0xff, random(256) as u8][random(7)];
            }
            if let Err(message) = points_of(name, &damaged) {
                assert!(message.contains(name) && message.contains("found"), "{message}");
            }
        }
    }
}
