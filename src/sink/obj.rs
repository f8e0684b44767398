//! Wavefront OBJ with an MTL file beside it.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use super::colour::colour;
use super::faces::{finest, is_convex, points, surfaces, triangles};
use super::header::Metadata;
use super::output::Output;
use super::{Feature, Format, Sink, Written};
use crate::error::{InputError, Result};

/// What a round offset is a multiple of, in units of the CRS.
const ROUND: f64 = 100.0;

/// Writes an object a feature, and in it a group and a material for each class of its surfaces.
///
/// Of every object the finest geometry is written. Coordinates are those of the CRS less an offset, which a comment at
/// the head of the file tells, in the units of the CRS with z up. Faces with holes and faces that are not convex are cut into
/// triangles, because many readers fill every polygon as a fan.
pub(super) struct Obj {
    output: Output,
    materials: Output,
    /// The name of the MTL file, without its folder.
    library: String,
    crs: String,
    metres: [f64; 3],
    /// Decimals that tell the grid of the source.
    decimals: usize,
    /// Known with the first vertex.
    offset: Option<[f64; 3]>,
    /// How many vertices there are in the file.
    vertices: u64,
    classes: BTreeSet<String>,
    features: usize,
    objects: usize,
    text: String,
}

impl Obj {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: &Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        if let Some(crs) = metadata.crs.as_ref().filter(|crs| crs.is_geographic) {
            return Err(InputError::new(path, format!("coordinates in degrees ({crs})"), "lengths: OBJ knows no CRS")
                .remedy("Reproject the model first, or write another format.")
                .into());
        }
        let beside = path.with_extension("mtl");
        let library = beside.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let finest = metadata.transform.scale.into_iter().fold(1.0, f64::min);
        Ok(Self {
            output: Output::create(path, overwrite, scratch)?,
            materials: Output::create(&beside, overwrite, scratch)?,
            library,
            crs: metadata.crs.as_ref().map_or_else(|| "an unknown CRS".to_owned(), ToString::to_string),
            metres: metadata.crs.as_ref().map_or([1.0; 3], |crs| crs.metres_per_unit),
            decimals: (-finest.log10()).ceil().clamp(0.0, 9.0) as usize,
            offset: None,
            vertices: 0,
            classes: BTreeSet::new(),
            features: 0,
            objects: 0,
            text: String::new(),
        })
    }

    /// The head of the file, once the offset is known.
    fn begin(&mut self, offset: [f64; 3]) {
        let [x, y, z] = offset;
        let (crs, library) = (&self.crs, &self.library);
        // Writing to a string cannot fail.
        let _ = write!(
            self.text,
            "# gable {}\n# z is up. Add the offset to every vertex for coordinates in {crs}\n# offset {x} {y} {z}\n\
             mtllib {}\n",
            env!("CARGO_PKG_VERSION"),
            name(library),
        );
        self.offset = Some(offset);
    }
}

impl Sink for Obj {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        self.text.clear();
        self.features += 1;
        self.objects += feature.objects.len();
        if self.offset.is_none() {
            let Some(first) = feature.vertices.first() else { return Ok(()) };
            // Heights are small enough as they are.
            self.begin([(first[0] / ROUND).floor() * ROUND, (first[1] / ROUND).floor() * ROUND, 0.0]);
        }
        let offset = self.offset.unwrap_or_default();
        let text = &mut self.text;
        let _ = writeln!(text, "o {}", name(&feature.id));
        // Only what the finest geometries use.
        let mut numbers = vec![0; feature.vertices.len()];
        let chosen = finest(feature);
        let all = chosen.iter().flat_map(|(_, geometry)| &geometry.shells).flat_map(|shell| &shell.faces);
        for &v in all.flat_map(|face| &face.rings).flatten() {
            let (Some(number), Some(vertex)) = (numbers.get_mut(v as usize), feature.vertices.get(v as usize)) else {
                continue;
            };
            if *number == 0 {
                self.vertices += 1;
                *number = self.vertices;
                let [x, y, z]: [f64; 3] = std::array::from_fn(|i| vertex[i] - offset[i]);
                let decimals = self.decimals;
                let _ = writeln!(text, "v {x:.decimals$} {y:.decimals$} {z:.decimals$}");
            }
        }
        let number = |v: &u32| numbers.get(*v as usize).copied().unwrap_or_default();
        for (object, geometry) in chosen {
            let mut all = surfaces(feature, object, geometry, self.metres);
            all.sort_by_key(|surface| surface.class);
            let mut group = None;
            for surface in all {
                if group != Some(surface.class) {
                    group = Some(surface.class);
                    let class = name(surface.class);
                    let _ = write!(text, "g {} {class}\nusemtl {class}\n", name(&object.id));
                }
                for face in &surface.faces {
                    let [ring] = face.rings.as_slice() else {
                        write_triangles(text, &triangles(feature, face, self.metres), number);
                        continue;
                    };
                    if points(feature, face, self.metres).first().is_some_and(|ring| is_convex(ring)) {
                        text.push('f');
                        for v in ring {
                            let _ = write!(text, " {}", number(v));
                        }
                        text.push('\n');
                    } else {
                        write_triangles(text, &triangles(feature, face, self.metres), number);
                    }
                }
                if !self.classes.contains(surface.class) {
                    self.classes.insert(surface.class.to_owned());
                }
            }
        }
        self.output.write(self.text.as_bytes())
    }

    fn finish(mut self: Box<Self>) -> Result<Written> {
        if self.offset.is_none() {
            self.text.clear();
            self.begin([0.0; 3]);
            self.output.write(self.text.as_bytes())?;
        }
        let mut library = format!("# gable {}\n", env!("CARGO_PKG_VERSION"));
        for class in &self.classes {
            let [r, g, b] = colour(class);
            let _ = write!(library, "newmtl {}\nKd {r} {g} {b}\nillum 1\n", name(class));
        }
        self.materials.write(library.as_bytes())?;
        let path = self.output.path().to_path_buf();
        // Whoever finds the OBJ finds its materials.
        let bytes = self.materials.commit(&[])? + self.output.commit(&[])?;
        let Self { features, objects, .. } = *self;
        Ok(Written { path, format: Format::Obj, features, objects, bytes, notes: Vec::new() })
    }
}

fn write_triangles(text: &mut String, triangles: &[[u32; 3]], number: impl Fn(&u32) -> u64) {
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", number(a), number(b), number(c));
    }
}

/// A name as OBJ holds it: one word.
fn name(text: &str) -> String {
    let word: String = text.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();
    if word.is_empty() { "_".to_owned() } else { word }
}
