//! Vertex groups: points that are grouped into planar primitives already, as `.vg` (text) and `.bvg` (binary) files
//! of the 3D reconstruction tools around `PolyFit`.
//!
//! Both hold the same: points, colours, normals, then groups of a type with parameters, a label, a colour, the indices
//! of its points, and child groups of the same form. The binary form is little-endian with 32-bit integers and floats.
//! Only points and indices are used: planes are refitted, because the stored ones are often zero.

use std::path::Path;

use nalgebra::Point3;

use crate::error::{InputError, Result};
use crate::reconstruct::primitives::Primitive;
use crate::source::open;

/// Points and the groups they form.
#[derive(Debug, Clone, PartialEq)]
pub struct PointGroups {
    /// The points, in the units of the file.
    pub points: Vec<Point3<f64>>,
    /// Indices into `points`, one list per group, children after their parent; every index is in range.
    pub groups: Vec<Vec<u32>>,
}

impl PointGroups {
    /// A detected primitive per group, its plane fitted by least squares, and how many groups were skipped because they
    /// have fewer than three points or lie on a line.
    pub fn primitives(&self) -> (Vec<Primitive>, usize) {
        let primitives: Vec<Primitive> =
            self.groups.iter().filter_map(|group| Primitive::from_inliers(&self.points, group.clone())).collect();
        let skipped = self.groups.len() - primitives.len();
        (primitives, skipped)
    }
}

/// Reads a `.vg` or `.bvg` file; the extension tells which (`.bvg` is binary, anything else text).
///
/// # Errors
/// When the file cannot be read, ends early, holds something other than the form asks for, or refers to points that
/// are not there; the error says where.
pub fn read(path: impl AsRef<Path>) -> Result<PointGroups> {
    let path = path.as_ref();
    let bytes = open::whole(path, "groups of points (.vg, .bvg)")?;
    let is_binary = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bvg"));
    let parsed = if is_binary {
        parse(&mut Binary { bytes: &bytes, at: 0 })
    } else {
        let text = String::from_utf8_lossy(&bytes);
        parse(&mut Text { words: text.split_whitespace().peekable(), words_read: 0 })
    };
    parsed.map_err(|fault| {
        let remedy = "check that the file is whole and that its extension is .vg for text or .bvg for binary";
        InputError::new(path, fault.found, fault.expected).at(fault.place).remedy(remedy).into()
    })
}

/// What is wrong with the contents.
#[derive(Debug)]
struct Fault {
    place: String,
    found: String,
    expected: String,
}

/// The two encodings of the same sequence of values.
trait Encoding {
    /// Where the next value stands.
    fn place(&self) -> String;
    /// A count, named in the text form.
    fn count(&mut self, name: &str) -> Result<usize, Fault>;
    /// A name in the text form; nothing in the binary one.
    fn name(&mut self, name: &str) -> Result<(), Fault>;
    /// A number without a name.
    fn number(&mut self) -> Result<f64, Fault>;
    /// An index without a name.
    fn index(&mut self) -> Result<u32, Fault>;
    /// The label of a group.
    fn skip_label(&mut self) -> Result<(), Fault>;
    /// Whether nothing is left.
    fn is_at_end(&mut self) -> bool;

    /// Skips numbers that are not used.
    fn skip_numbers(&mut self, count: usize) -> Result<(), Fault> {
        (0..count).try_for_each(|_| self.number().map(|_| ()))
    }
}

fn parse(input: &mut impl Encoding) -> Result<PointGroups, Fault> {
    let count = input.count("num_points")?;
    let mut points = Vec::new();
    for _ in 0..count {
        let place = input.place();
        let point = Point3::new(input.number()?, input.number()?, input.number()?);
        if !point.coords.iter().all(|c| c.is_finite()) {
            return Err(Fault { place, found: format!("the point {point}"), expected: "finite coordinates".into() });
        }
        points.push(point);
    }
    for name in ["num_colors", "num_normals"] {
        let count = input.count(name)?;
        (0..count).try_for_each(|_| input.skip_numbers(3))?;
    }
    let mut groups = Vec::new();
    // Children follow their parent in the same form: a count of open groups stands in for recursion, which a hostile
    // file could make arbitrarily deep.
    let mut open = input.count("num_groups")?;
    while open > 0 {
        // Some writers leave out the last count of children.
        open -= 1;
        let (group, children) = parse_group(input, points.len())?;
        groups.push(group);
        open = open.saturating_add(children);
    }
    Ok(PointGroups { points, groups })
}

/// One group without its children, and how many there are.
fn parse_group(input: &mut impl Encoding, points: usize) -> Result<(Vec<u32>, usize), Fault> {
    input.count("group_type")?;
    let parameters = input.count("num_group_parameters")?;
    input.name("group_parameters")?;
    input.skip_numbers(parameters)?;
    input.skip_label()?;
    input.name("group_color")?;
    input.skip_numbers(3)?;
    let count = input.count("group_num_point")?;
    let mut group = Vec::new();
    for _ in 0..count {
        let place = input.place();
        let index = input.index()?;
        if index as usize >= points {
            let found = format!("the point index {index}");
            return Err(Fault { place, found, expected: format!("an index below {points}, the number of points") });
        }
        group.push(index);
    }
    let children = if input.is_at_end() { 0 } else { input.count("num_children")? };
    Ok((group, children))
}

struct Binary<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Binary<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let taken = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let Some(taken) = taken else {
            let expected = format!("{N} more bytes");
            return Err(Fault { place: self.place(), found: "the end of the file".into(), expected });
        };
        self.at += N;
        Ok(*taken)
    }
}

impl Encoding for Binary<'_> {
    fn place(&self) -> String {
        format!("byte {}", self.at)
    }

    fn count(&mut self, name: &str) -> Result<usize, Fault> {
        let place = self.place();
        let count = u32::from_le_bytes(self.take()?) as usize;
        // Whatever is counted takes at least a byte, but for the type of a group, which counts nothing.
        let left = self.bytes.len() - self.at;
        if count > left {
            let expected = format!("{name} to be at most {left}, the bytes that are left");
            return Err(Fault { place, found: count.to_string(), expected });
        }
        Ok(count)
    }

    fn name(&mut self, _: &str) -> Result<(), Fault> {
        Ok(())
    }

    fn number(&mut self) -> Result<f64, Fault> {
        self.take().map(|bytes| f64::from(f32::from_le_bytes(bytes)))
    }

    fn index(&mut self) -> Result<u32, Fault> {
        self.take().map(u32::from_le_bytes)
    }

    fn skip_label(&mut self) -> Result<(), Fault> {
        self.at += self.count("length of group_label")?;
        Ok(())
    }

    fn is_at_end(&mut self) -> bool {
        self.at >= self.bytes.len()
    }
}

struct Text<'a> {
    words: std::iter::Peekable<std::str::SplitWhitespace<'a>>,
    words_read: usize,
}

impl<'a> Text<'a> {
    fn word(&mut self, expected: &str) -> Result<&'a str, Fault> {
        let place = self.place();
        self.words_read += 1;
        let word = self.words.next();
        word.ok_or_else(|| Fault { place, found: "the end of the file".into(), expected: expected.into() })
    }

    fn value<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, Fault> {
        let place = self.place();
        let word = self.word(expected)?;
        word.parse().map_err(|_| Fault { place, found: format!("`{word}`"), expected: expected.into() })
    }
}

impl Encoding for Text<'_> {
    fn place(&self) -> String {
        format!("word {}", self.words_read + 1)
    }

    fn count(&mut self, name: &str) -> Result<usize, Fault> {
        self.name(name)?;
        self.value("a whole number")
    }

    fn name(&mut self, name: &str) -> Result<(), Fault> {
        let place = self.place();
        let expected = format!("`{name}:`");
        let word = self.word(&expected)?;
        if word.trim_end_matches(':') == name {
            return Ok(());
        }
        Err(Fault { place, found: format!("`{word}`"), expected })
    }

    fn number(&mut self) -> Result<f64, Fault> {
        self.value("a number")
    }

    fn index(&mut self) -> Result<u32, Fault> {
        self.value("the index of a point")
    }

    fn skip_label(&mut self) -> Result<(), Fault> {
        self.name("group_label")?;
        // A label may be empty or hold several words.
        while self.words.peek().is_some_and(|word| word.trim_end_matches(':') != "group_color") {
            self.word("a label")?;
        }
        Ok(())
    }

    fn is_at_end(&mut self) -> bool {
        self.words.peek().is_none()
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::error::Error;

    const SQUARE: &str =
        "num_points: 5\n0 0 1 2 0 1 2 2 1 0 2 1 1 0 1\nnum_colors: 1\n1 0 0\nnum_normals: 0\nnum_groups: 3
group_type: 0\nnum_group_parameters: 4\ngroup_parameters: 0 0 0 0\ngroup_label: flat roof\ngroup_color: 1 0 0
group_num_point: 4\n0 1 2 3\nnum_children: 1
group_type: 0\nnum_group_parameters: 0\ngroup_parameters:\ngroup_label:\ngroup_color: 1 0 0
group_num_point: 3\n0 4 1\nnum_children: 0
group_type: 0\nnum_group_parameters: 0\ngroup_parameters:\ngroup_label: x\ngroup_color: 1 0 0
group_num_point: 2\n0 1\nnum_children: 0
group_type: 0\nnum_group_parameters: 0\ngroup_parameters:\ngroup_label: y\ngroup_color: 1 0 0
group_num_point: 3\n3 2 1";

    fn written(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    /// The binary form of one triangle, written by hand.
    fn triangle() -> Vec<u8> {
        let mut bytes = Vec::new();
        let int = |bytes: &mut Vec<u8>, values: &[u32]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        let real = |bytes: &mut Vec<u8>, values: &[f32]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        int(&mut bytes, &[3]);
        real(&mut bytes, &[0.0, 0.0, 2.5, 4.0, 0.0, 2.5, 0.0, 4.0, 2.5]);
        int(&mut bytes, &[0, 0, 1, 0, 1]);
        real(&mut bytes, &[9.0]);
        int(&mut bytes, &[2]);
        bytes.extend(b"ab");
        real(&mut bytes, &[0.1, 0.2, 0.3]);
        int(&mut bytes, &[3, 2, 0, 1, 0]);
        bytes
    }

    #[test]
    fn text_with_children_labels_and_degenerate_groups_is_read() {
        let (_folder, path) = written("square.vg", SQUARE.as_bytes());
        let read = read(&path).unwrap();
        assert_eq!(read.points.len(), 5);
        assert_eq!(read.groups, [vec![0, 1, 2, 3], vec![0, 4, 1], vec![0, 1], vec![3, 2, 1]]);
        let (primitives, skipped) = read.primitives();
        // The second group lies on a line and the third is too small.
        assert_eq!((primitives.len(), skipped), (2, 2));
        assert_eq!(primitives[0].plane.height_at(7.0, 7.0), Some(1.0));
    }

    #[test]
    fn binary_is_read() {
        let (_folder, path) = written("triangle.BVG", &triangle());
        let read = read(&path).unwrap();
        assert_eq!(read.points[1], Point3::new(4.0, 0.0, 2.5));
        assert_eq!(read.groups, [[2, 0, 1]]);
    }

    #[test]
    fn damage_is_reported_with_its_place() {
        let bytes = triangle();
        for length in 0..bytes.len() - 4 {
            let (_folder, path) = written("cut.bvg", &bytes[..length]);
            assert!(matches!(read(&path), Err(Error::Input(_))), "{length} bytes");
        }
        let mut wrong = bytes.clone();
        let last = wrong.len() - 8;
        wrong[last] = 3;
        let (_folder, path) = written("wrong.bvg", &wrong);
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("the point index 3") && message.contains("below 3"), "{message}");

        let (_folder, path) = written("bad.vg", SQUARE.replace("num_colors", "colours").as_bytes());
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("word 18") && message.contains("`colours:`"), "{message}");
        assert!(matches!(read("/nowhere/x.vg"), Err(Error::Io { .. })));
    }

    #[test]
    fn both_forms_of_the_church_hold_the_same_groups() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/partition"));
        if !folder.exists() {
            println!("skipped: shared data not found");
            return;
        }
        let [text, binary] = ["test_church.vg", "test_church.bvg"].map(|name| read(folder.join(name)).unwrap());
        assert_eq!((text.points.len(), text.groups.len()), (11_228, 218));
        assert_eq!((binary.points.len(), binary.groups.len()), (101_228, 218));
        let (sparse, dense) = (text.primitives().0, binary.primitives().0);
        assert_eq!((sparse.len(), dense.len()), (218, 218));
        // The same planes, sampled differently: compare them in the middle of the inliers of the sparse one.
        for (a, b) in sparse.iter().zip(&dense) {
            let angle = a.plane.normal.angle(&b.plane.normal);
            assert!(angle.min(std::f64::consts::PI - angle) < 0.02, "{angle}");
        }
    }
}
