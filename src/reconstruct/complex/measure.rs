//! Sizes and neighbours. Floating point, each relative to a corner nearby: nothing topological hangs on them.

use nalgebra::{Point3, Vector3};

use super::{CellId, Complex, FacetId, OUTSIDE, VertexId};
use crate::geometry::Aabb;

impl Complex {
    /// The corners of a facet in local metres, counter-clockwise seen from the positive side of its plane.
    pub fn facet_positions(&self, facet: FacetId) -> impl ExactSizeIterator<Item = Point3<f64>> + Clone {
        self.facets[facet as usize].corners.iter().map(|&v| self.vertices[v as usize].position)
    }

    /// The area vector of a facet, m²: its length is the area, its direction that of the plane's normal.
    pub fn facet_area_vector(&self, facet: FacetId) -> Vector3<f64> {
        let mut corners = self.facet_positions(facet);
        let Some(first) = corners.next() else { return Vector3::zeros() };
        let spokes = corners.map(|p| p - first);
        spokes.clone().zip(spokes.skip(1)).fold(Vector3::zeros(), |sum, (a, b)| sum + a.cross(&b)) / 2.0
    }

    /// Area of a facet, m².
    pub fn facet_area(&self, facet: FacetId) -> f64 {
        self.facet_area_vector(facet).norm()
    }

    /// The areas of all facets, m².
    pub fn facet_areas(&self) -> Vec<f64> {
        (0..self.facets.len() as FacetId).map(|facet| self.facet_area(facet)).collect()
    }

    /// The cell on the other side of a facet of `cell`; [`OUTSIDE`] at the box.
    pub fn across(&self, facet: FacetId, cell: CellId) -> CellId {
        let [negative, positive] = self.facets[facet as usize].cells;
        if negative == cell { positive } else { negative }
    }

    /// The facets of a cell with the neighbour behind each, without those on the box. A neighbour comes once for
    /// every facet that it shares with the cell.
    pub fn neighbours(&self, cell: CellId) -> impl Iterator<Item = (FacetId, CellId)> {
        let facets = self.cells[cell as usize].facets.iter();
        facets.map(move |&facet| (facet, self.across(facet, cell))).filter(|&(_, neighbour)| neighbour != OUTSIDE)
    }

    /// Whether a cell has a facet on the box.
    pub fn touches_box(&self, cell: CellId) -> bool {
        self.cells[cell as usize].facets.iter().any(|&facet| self.across(facet, cell) == OUTSIDE)
    }

    /// The corners of all facets of a cell, ascending, each once.
    pub fn cell_vertices(&self, cell: CellId) -> Vec<VertexId> {
        let facets = self.cells[cell as usize].facets.iter();
        let mut vertices: Vec<_> = facets.flat_map(|&f| self.facets[f as usize].corners.iter().copied()).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// The axis-aligned box of a cell, local metres.
    pub fn cell_aabb(&self, cell: CellId) -> Aabb {
        self.aabb_of(&self.cell_vertices(cell))
    }

    fn aabb_of(&self, vertices: &[VertexId]) -> Aabb {
        Aabb::of(vertices.iter().map(|&v| &self.vertices[v as usize].position))
            .unwrap_or(Aabb { min: [0.0; 3], max: [0.0; 3] })
    }

    /// Volume of a cell, m³.
    pub fn cell_volume(&self, cell: CellId) -> f64 {
        self.cell_moments(cell).0
    }

    /// Centroid of a cell, local metres.
    pub fn cell_centroid(&self, cell: CellId) -> Point3<f64> {
        self.cell_moments(cell).1
    }

    /// The median of the volumes of all cells, m³; 0 without cells.
    pub fn median_volume(&self) -> f64 {
        let mut volumes: Vec<f64> = (0..self.cells.len() as CellId).map(|cell| self.cell_volume(cell)).collect();
        let middle = volumes.len() / 2;
        if volumes.is_empty() { 0.0 } else { *volumes.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }

    /// The tetrahedra between a point and the facets of a cell, each as its three corners on a facet (outward seen
    /// counter-clockwise) and its volume, m³; positive for every point inside.
    pub(super) fn tetrahedra(
        &self,
        cell: CellId,
        apex: Point3<f64>,
    ) -> impl Iterator<Item = ([Point3<f64>; 3], f64)> + '_ {
        self.cells[cell as usize].facets.iter().flat_map(move |&facet| {
            let outward = self.facets[facet as usize].cells[0] == cell;
            let mut corners = self.facet_positions(facet);
            let first = corners.next().unwrap_or(apex);
            corners.clone().zip(corners.skip(1)).map(move |(second, third)| {
                let triangle = if outward { [first, second, third] } else { [first, third, second] };
                let [a, b, c] = triangle.map(|p| p - apex);
                (triangle, a.dot(&b.cross(&c)) / 6.0)
            })
        })
    }

    /// Volume and centroid of a cell: [`Self::cell_volume`] and [`Self::cell_centroid`] at the cost of one.
    pub(crate) fn cell_moments(&self, cell: CellId) -> (f64, Point3<f64>) {
        let vertices = self.cell_vertices(cell);
        let count = vertices.len().max(1) as f64;
        let positions = vertices.iter().map(|&v| self.vertices[v as usize].position.coords);
        let middle = Point3::from(positions.sum::<Vector3<f64>>() / count);
        let (mut volume, mut moment) = (0.0, Vector3::zeros());
        for (triangle, part) in self.tetrahedra(cell, middle) {
            volume += part;
            moment += triangle.iter().fold(Vector3::zeros(), |sum, p| sum + (p - middle)) * (part / 4.0);
        }
        // The volume of a sliver drowns in rounding errors, and its centroid with it: the mean of its vertices is
        // inside whatever happens.
        let offset = moment / volume;
        let aabb = self.aabb_of(&vertices);
        let inside = (0..3).all(|axis| (aabb.min[axis]..=aabb.max[axis]).contains(&(middle[axis] + offset[axis])));
        (volume.max(0.0), if inside { middle + offset } else { middle })
    }
}
