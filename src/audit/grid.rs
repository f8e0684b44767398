//! From a geometry of a file to faces on the integer grid of the file.

use std::collections::HashMap;

use crate::solid::{Face, Solid};
use crate::source::cityjson::{self, CityModel, Transform};
use crate::validate::snap::Snap;

/// How far from the origin of its feature a vertex may lie, in steps: 6 800 km at 0.1 mm, 68 km at 1 µm. Beyond, the exact
/// predicates would overflow.
const FAR: i64 = 1 << 36;

/// The finest grid for files of real coordinates, as a power of ten.
const DECIMALS: i32 = 6;

/// The index that stands for no semantic surface.
pub(super) const UNLABELLED: u32 = u32::MAX;

/// The grid of a model: that of its transform, or, where the file has real coordinates, the coarsest decimal one on which
/// all its vertices are, but no finer than six decimals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    transform: Transform,
    /// Whether the file has a transform.
    given: bool,
    /// Size of a step in metres.
    pub step: [f64; 3],
    /// The place that has the coordinates 0, in steps.
    origin: [i64; 3],
}

impl Grid {
    pub fn of(model: &CityModel, metres_per_unit: [f64; 3]) -> Self {
        let Some(transform) = model.transform else { return Self::of_real(&model.vertices, metres_per_unit) };
        let step = std::array::from_fn(|i| transform.scale[i] * metres_per_unit[i]);
        Self { transform, given: true, step, origin: [0; 3] }
    }

    /// The grid of vertices with real coordinates, in units of this many metres along each axis.
    pub fn of_real(vertices: &[[f64; 3]], metres_per_unit: [f64; 3]) -> Self {
        let scale = 10f64.powi(-decimals(vertices));
        let transform = Transform { scale: [scale; 3], translate: [0.0; 3] };
        Self { transform, given: false, step: metres_per_unit.map(|metres| metres * scale), origin: [0; 3] }
    }

    /// The same grid with its origin at a vertex.
    pub fn starting_at(self, vertex: [f64; 3]) -> Self {
        Self { origin: self.number(vertex).unwrap_or_default(), ..self }
    }

    /// A place in metres from the origin of the grid in CRS coordinates.
    pub fn to_crs(self, metres: [f64; 3]) -> [f64; 3] {
        self.transform.apply(std::array::from_fn(|i| self.origin[i] as f64 + metres[i] / self.step[i]))
    }

    /// Height of a place on the grid in the vertical unit of the CRS.
    pub fn height(&self, z: i64) -> f64 {
        (z + self.origin[2]) as f64 * self.transform.scale[2] + self.transform.translate[2]
    }

    /// Metres in the vertical unit of the CRS.
    pub fn metres_per_unit(&self) -> f64 {
        self.step[2] / self.transform.scale[2]
    }

    /// The numbers in the file that a vertex was made from, or why there are none.
    fn number(&self, vertex: [f64; 3]) -> Result<[i64; 3], &'static str> {
        let Transform { scale, translate } = self.transform;
        let near: [f64; 3] = std::array::from_fn(|i| ((vertex[i] - translate[i]) / scale[i]).round());
        if near.iter().any(|n| n.is_nan() || n.abs() > 2f64.powi(52)) {
            return Err(
                "is more than 2^52 grid steps from the origin of the file, where not every whole number is told apart",
            );
        }
        let mut number = near;
        if self.given {
            for i in 0..3 {
                let is_it = |n: &f64| *n * scale[i] + translate[i] == vertex[i];
                let whole = [near[i], near[i] - 1.0, near[i] + 1.0].into_iter().find(is_it);
                number[i] = whole.ok_or("is not on the grid: the numbers of a file with a transform are whole")?;
            }
        }
        Ok(number.map(|n| n as i64))
    }

    /// A shell on the grid: its faces are those of the file in the same order, and their `surface` is the index of the
    /// semantic surface, or [`UNLABELLED`].
    pub fn shell(&self, model: &CityModel, faces: &[cityjson::Face], weld: &mut Weld) -> Result<Shell, String> {
        let mut index: HashMap<u32, u32> = HashMap::new();
        let mut solid = Solid { step: self.step, vertices: Vec::new(), faces: Vec::new(), surfaces: Vec::new() };
        let mut names = Vec::new();
        for face in faces {
            let mut rings = Vec::with_capacity(face.rings.len());
            for ring in &face.rings {
                let mut on_grid = Vec::with_capacity(ring.len());
                for &vertex in ring {
                    let local = if let Some(&local) = index.get(&vertex) {
                        local
                    } else {
                        let place = weld.place(self.place(model, vertex)?);
                        let local = solid.vertices.len() as u32;
                        solid.vertices.push(place);
                        names.push(vertex);
                        index.insert(vertex, local);
                        local
                    };
                    on_grid.push(local);
                }
                rings.push(on_grid);
            }
            solid.faces.push(Face { rings, surface: face.surface.unwrap_or(UNLABELLED) });
        }
        Ok(Shell { solid, names })
    }

    fn place(&self, model: &CityModel, vertex: u32) -> Result<[i64; 3], String> {
        let real = model.vertices.get(vertex as usize).copied().ok_or("a vertex that does not exist")?;
        let number = self.number(real).map_err(|reason| format!("vertex {vertex} {reason}"))?;
        let place: [i64; 3] = std::array::from_fn(|i| number[i] - self.origin[i]);
        if place.iter().any(|c| c.abs() > FAR) {
            return Err(format!("vertex {vertex} is more than {FAR} grid steps away from others of its feature"));
        }
        Ok(place)
    }
}

/// Decimals of coordinates: as many as they all need, six at most.
fn decimals(vertices: &[[f64; 3]]) -> i32 {
    let is_whole = |scale: f64| move |c: &f64| ((c * scale) - (c * scale).round()).abs() < 1e-3;
    (0..DECIMALS).find(|&d| vertices.iter().flatten().all(is_whole(10f64.powi(d)))).unwrap_or(DECIMALS)
}

/// A shell on the grid.
#[derive(Debug)]
pub(super) struct Shell {
    pub solid: Solid,
    /// The indices of its vertices in the file.
    pub names: Vec<u32>,
}

/// Draws vertices that are no farther from each other than the snap tolerance together, as val3dity does: each goes where
/// the first one near it is.
#[derive(Debug)]
pub(super) struct Weld {
    snap: Snap,
    /// Size of a cell in steps: much wider than the tolerance, so that few vertices have to look into a second one.
    cell: [i64; 3],
    /// Where vertices were drawn to, by cells. Only looked up, never walked through.
    cells: HashMap<[i64; 3], Vec<[i64; 3]>>,
}

impl Weld {
    pub fn new(step: [f64; 3], snap: f64) -> Self {
        let snap = Snap::new(step, snap);
        Self { snap, cell: snap.reach().map(|reach| 16 * reach.max(1)), cells: HashMap::new() }
    }

    fn place(&mut self, vertex: [i64; 3]) -> [i64; 3] {
        let reach = self.snap.reach();
        // Neighbours on the grid are no nearer than a step.
        if reach == [0; 3] {
            return vertex;
        }
        let cell = |shift: i64| -> [i64; 3] {
            std::array::from_fn(|i| (vertex[i] + shift * reach[i]).div_euclid(self.cell[i]))
        };
        let (low, high) = (cell(-1), cell(1));
        let mut found: Option<(f64, [i64; 3])> = None;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    for &other in self.cells.get(&[x, y, z]).into_iter().flatten() {
                        let joined = self.snap.joins(vertex, other).map(|distance| (distance, other));
                        found = match (found, joined) {
                            (Some(known), Some(new)) if known <= new => Some(known),
                            (known, new) => new.or(known),
                        };
                    }
                }
            }
        }
        if let Some((_, other)) = found {
            return other;
        }
        self.cells.entry(cell(0)).or_default().push(vertex);
        vertex
    }
}
