//! Points that come one by one, gathered into chunks: those of readers of text and PLY.

use std::sync::Arc;

use super::points::{Column, Layout, Points};
use crate::source::crs::Crs;

/// Points of a chunk.
const CHUNK: usize = 1 << 16;

/// Gathers points.
pub(super) struct Rows {
    layout: Arc<Layout>,
    crs: Option<Arc<Crs>>,
    /// The place in the layout of each value of a row.
    places: Vec<usize>,
    columns: Vec<Column>,
    len: usize,
}

impl Rows {
    /// Of rows whose values have these places in the layout.
    pub fn new(layout: Arc<Layout>, crs: Option<Arc<Crs>>, places: Vec<usize>) -> Self {
        let columns = empty(&layout);
        Self { layout, crs, places, columns, len: 0 }
    }

    /// Takes a point; dimensions without a value are zero, as is what a dimension cannot hold. Gives the points when they
    /// are enough for a chunk.
    pub fn push(&mut self, values: &[f64]) -> Option<Points> {
        self.len += 1;
        for column in &mut self.columns {
            column.pad(self.len);
        }
        for (place, value) in self.places.iter().zip(values) {
            // The columns have the types that the file states.
            let _ = self.columns[*place].set(self.len - 1, *value);
        }
        (self.len >= CHUNK).then(|| self.take())
    }

    /// The points since the last chunk, perhaps none.
    pub fn take(&mut self) -> Points {
        self.len = 0;
        let columns = std::mem::replace(&mut self.columns, empty(&self.layout));
        Points::of_columns(Arc::clone(&self.layout), columns, self.crs.clone())
    }
}

fn empty(layout: &Layout) -> Vec<Column> {
    layout.dimensions().iter().map(|dimension| Column::zeros(dimension.kind, 0)).collect()
}
