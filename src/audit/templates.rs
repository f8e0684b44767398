//! Geometry templates, checked as large as they stand in their places.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Matrix3;

use super::Options;
use super::feature::{geometry_faults, name};
use super::grid::Grid;
use super::report::Finding;
use crate::source::cityjson::{CityModel, CityObject, Geometry, GeometryKind, Instance, Templates as Geometries};

/// Columns of a matrix whose directions are no farther from a right angle than this turn and scale, and do nothing else.
const UPRIGHT: f64 = 1e-9;

/// A template and what its matrix does but move it.
type Key = (u32, [u64; 9]);

/// The templates of a file with what is known of them: most are used many times.
#[derive(Debug)]
pub(super) struct Templates<'a> {
    geometries: &'a Geometries,
    metres_per_unit: [f64; 3],
    known: Mutex<HashMap<Key, Arc<Checked>>>,
}

/// A template that was checked.
#[derive(Debug)]
pub(super) struct Checked {
    /// The type of its geometry, or `GeometryInstance` where it has no faces or there is none.
    pub kind: &'static str,
    /// Its faults; their ids lack the place where it stands.
    pub faults: Vec<Finding>,
}

impl<'a> Templates<'a> {
    pub fn of(head: &'a CityModel, metres_per_unit: [f64; 3]) -> Self {
        Self { geometries: &head.templates, metres_per_unit, known: Mutex::default() }
    }

    /// Checks what an instance is an instance of.
    pub fn check(&self, geometry: &Geometry, options: &Options) -> Arc<Checked> {
        let counted = |faults| Arc::new(Checked { kind: "GeometryInstance", faults });
        let refused = |reason: &str| counted(vec![Finding::new(901, "", reason)]);
        let Some(instance) = &geometry.instance else {
            return refused("an instance without a template, or without a matrix of 16 numbers");
        };
        let Some(template) = self.geometries.geometries.get(instance.template as usize) else {
            return refused(&format!("an instance of template {}, which does not exist", instance.template));
        };
        if let GeometryKind::Other(_) = template.kind {
            return counted(Vec::new());
        }
        let key = (instance.template, linear(instance).map(f64::to_bits));
        if let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return Arc::clone(known);
        }
        let checked = match self.in_place(instance) {
            Err(reason) => return refused(reason),
            Ok((model, grid)) => {
                let (mut faults, mut of_labels) = (Vec::new(), Vec::new());
                // What its faces are called depends on what it is used for, which labels of templates do not say.
                let object = CityObject::default();
                geometry_faults(&model, &grid, (&object, template), "", options, [&mut faults, &mut of_labels]);
                Arc::new(Checked { kind: name(&template.kind), faults })
            }
        };
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(key, Arc::clone(&checked));
        checked
    }

    /// The vertices of the templates as an instance has them, up to where it stands, and their grid.
    ///
    /// A matrix that turns and scales along the axes of the template leaves its numbers whole, on a grid as many times as
    /// coarse: nothing is rounded. What a skew one makes is rounded to six decimals.
    fn in_place(&self, instance: &Instance) -> Result<(CityModel, Grid), &'static str> {
        let units = self.metres_per_unit;
        let matrix = Matrix3::from_row_slice(&linear(instance));
        let metres = Matrix3::from_fn(|row, column| matrix[(row, column)] * units[row]);
        let determinant = metres.determinant();
        if !determinant.is_finite() || determinant == 0.0 {
            return Err("the matrix of the instance makes its template flat");
        }
        let [x, y, z] = [0, 1, 2].map(|column| metres.column(column).into_owned());
        let upright =
            |a: &nalgebra::Vector3<f64>, b: &nalgebra::Vector3<f64>| a.dot(b).abs() <= UPRIGHT * a.norm() * b.norm();
        let mut vertices = self.geometries.vertices.clone();
        let scale = if upright(&x, &y) && upright(&y, &z) && upright(&z, &x) {
            if determinant < 0.0 {
                for vertex in &mut vertices {
                    vertex[0] = -vertex[0];
                }
            }
            [x.norm(), y.norm(), z.norm()]
        } else {
            for vertex in &mut vertices {
                *vertex = (metres * nalgebra::Vector3::from(*vertex)).into();
            }
            [1.0; 3]
        };
        let grid = Grid::of_real(&vertices, scale);
        let grid = grid.starting_at(vertices.first().copied().unwrap_or_default());
        Ok((CityModel { vertices, ..CityModel::default() }, grid))
    }
}

/// The upper left of the matrix, row by row.
fn linear(instance: &Instance) -> [f64; 9] {
    std::array::from_fn(|i| instance.matrix[i / 3 * 4 + i % 3])
}
