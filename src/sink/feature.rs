//! What every sink takes, wherever it comes from.

use std::vec::IntoIter;

use crate::source::cityjson::{CityModel, CityObject, Face, Geometry};

/// A top-level object with its children and the vertices of their geometries: a building that was
/// [reconstructed](super::Encoder::feature), or any object of a CityJSON file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Feature {
    /// The id of the top-level object.
    pub id: String,
    /// The objects, the top-level one first.
    pub objects: Vec<CityObject>,
    /// Vertices in CRS coordinates, each used by some geometry.
    pub vertices: Vec<[f64; 3]>,
}

impl Feature {
    /// The top-level object; `None` only where there are no objects.
    pub fn root(&self) -> Option<&CityObject> {
        self.objects.first()
    }

    /// A vertex; the origin where there is none.
    pub fn vertex(&self, index: u32) -> [f64; 3] {
        self.vertices.get(index as usize).copied().unwrap_or_default()
    }

    /// The smallest box around the vertices in CRS coordinates; `None` without any.
    pub fn extent(&self) -> Option<[[f64; 3]; 2]> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold([first; 2], |[min, max], v| {
            [std::array::from_fn(|i| min[i].min(v[i])), std::array::from_fn(|i| max[i].max(v[i]))]
        }))
    }

    /// The features of a model in the order of the file. The model is used up as they are taken.
    pub fn split(model: CityModel) -> Split {
        Split { groups: model.groups().into_iter(), model }
    }
}

/// The features of a model; see [`Feature::split`].
#[derive(Debug)]
pub struct Split {
    groups: IntoIter<Vec<usize>>,
    model: CityModel,
}

impl Iterator for Split {
    type Item = Feature;

    fn next(&mut self) -> Option<Feature> {
        let group = self.groups.next()?;
        let objects = group.into_iter().filter_map(|i| self.model.objects.get_mut(i).map(std::mem::take));
        let mut objects: Vec<CityObject> = objects.collect();
        let mut used: Vec<u32> = indices(&mut objects).map(|index| *index).collect();
        used.sort_unstable();
        used.dedup();
        let vertex = |&index: &u32| self.model.vertices.get(index as usize).copied().unwrap_or_default();
        let vertices = used.iter().map(vertex).collect();
        for index in indices(&mut objects) {
            *index = used.binary_search(index).unwrap_or_default() as u32;
        }
        let id = objects.first().map(|root| root.id.clone()).unwrap_or_default();
        Some(Feature { id, objects, vertices })
    }
}

/// All vertex indices of some objects.
fn indices(objects: &mut [CityObject]) -> impl Iterator<Item = &mut u32> {
    let geometries = objects.iter_mut().flat_map(|object| &mut object.geometries);
    let shells = geometries.flat_map(|geometry: &mut Geometry| &mut geometry.shells);
    shells.flat_map(|shell| &mut shell.faces).flat_map(|face: &mut Face| &mut face.rings).flatten()
}
