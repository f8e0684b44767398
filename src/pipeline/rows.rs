//! Points that come one by one, gathered into chunks: those of readers of text and PLY.

use std::sync::Arc;

use super::points::{Column, Layout, Points};
use super::stage::{Context, Next};
use crate::error::Result;
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

    /// Takes a point; dimensions without a value are zero, as is what a dimension cannot hold. Hands the points on when they
    /// are enough for a chunk.
    ///
    /// # Errors
    /// As `next`.
    pub fn push(&mut self, values: &[f64], context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        self.len += 1;
        for column in &mut self.columns {
            column.pad(self.len);
        }
        for (place, value) in self.places.iter().zip(values) {
            // The columns have the types that the file states.
            let _ = self.columns[*place].set(self.len - 1, *value);
        }
        if self.len < CHUNK { Ok(()) } else { self.finish(context, next) }
    }

    /// Hands on the points since the last chunk, if there are any.
    ///
    /// # Errors
    /// As `next`.
    pub fn finish(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        if self.len == 0 {
            return Ok(());
        }
        let columns = std::mem::replace(&mut self.columns, empty(&self.layout));
        context.observer.advanced(std::mem::take(&mut self.len) as u64);
        next(Points::of_columns(Arc::clone(&self.layout), columns, self.crs.clone()))
    }
}

fn empty(layout: &Layout) -> Vec<Column> {
    layout.dimensions().iter().map(|dimension| Column::zeros(dimension.kind, 0)).collect()
}
