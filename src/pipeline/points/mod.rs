//! Points in columns: what goes from stage to stage.

mod column;
mod names;
mod number;

use std::sync::Arc;

pub use column::Column;
pub use names::usual_name;
pub use number::NumberType;

use super::nearest::nearest;
use crate::source::crs::Crs;

/// A dimension of the points.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dimension {
    /// Its name, as PDAL has it.
    pub name: String,
    /// The type of its values.
    pub kind: NumberType,
}

impl Dimension {
    /// A dimension.
    pub fn new(name: impl Into<String>, kind: NumberType) -> Self {
        Self { name: name.into(), kind }
    }
}

/// The type that a dimension has by its name, for those that every program knows; others are doubles.
pub fn usual_type(name: &str) -> NumberType {
    match name {
        "Classification" | "ReturnNumber" | "NumberOfReturns" | "ScanDirectionFlag" | "EdgeOfFlightLine"
        | "UserData" | "ScanChannel" | "Synthetic" | "KeyPoint" | "Withheld" | "Overlap" => NumberType::U8,
        "Intensity" | "PointSourceId" | "Red" | "Green" | "Blue" | "Infrared" => NumberType::U16,
        "ScanAngleRank" => NumberType::F32,
        _ => NumberType::F64,
    }
}

/// The dimensions of points, X, Y and Z first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    dimensions: Vec<Dimension>,
}

impl Default for Layout {
    fn default() -> Self {
        Self { dimensions: ["X", "Y", "Z"].map(|name| Dimension::new(name, NumberType::F64)).into() }
    }
}

impl Layout {
    /// The dimensions, in the order of the columns.
    pub fn dimensions(&self) -> &[Dimension] {
        &self.dimensions
    }

    /// The names of the dimensions.
    pub fn names(&self) -> Vec<&str> {
        self.dimensions.iter().map(|dimension| dimension.name.as_str()).collect()
    }

    /// The place of a dimension: that of exactly this name, else one that differs in the case of letters only.
    pub fn find(&self, name: &str) -> Option<usize> {
        let named = |same: &dyn Fn(&str) -> bool| self.dimensions.iter().position(|d| same(&d.name));
        named(&|own| own == name).or_else(|| named(&|own| own.eq_ignore_ascii_case(name)))
    }

    /// The place of a dimension.
    ///
    /// # Errors
    /// What was expected when there is no such dimension.
    pub fn require(&self, name: &str) -> Result<usize, String> {
        self.find(name).ok_or_else(|| {
            let names: Vec<&str> = self.dimensions.iter().map(|d| d.name.as_str()).collect();
            let hint = nearest(name, names.iter().copied()).map(|near| format!("`{near}`, or another of "));
            format!("{}{}", hint.unwrap_or_default(), names.join(", "))
        })
    }

    /// The place of a dimension, which is made with this type where it is missing.
    pub fn add(&mut self, name: &str, kind: NumberType) -> usize {
        self.find(name).unwrap_or_else(|| {
            self.dimensions.push(Dimension::new(name, kind));
            self.dimensions.len() - 1
        })
    }

    /// Takes the dimensions of another in.
    pub fn join(&mut self, other: &Self) {
        for dimension in &other.dimensions {
            self.add(&dimension.name, dimension.kind);
        }
    }
}

/// Points, or a chunk of them: one column per dimension.
#[derive(Debug, Clone)]
pub struct Points {
    layout: Arc<Layout>,
    columns: Vec<Column>,
    /// The CRS of their coordinates, where it is known.
    pub crs: Option<Arc<Crs>>,
}

impl Points {
    /// No points.
    pub fn new(layout: Arc<Layout>, crs: Option<Arc<Crs>>) -> Self {
        let columns = layout.dimensions.iter().map(|d| Column::zeros(d.kind, 0)).collect();
        Self { layout, columns, crs }
    }

    /// Points of these columns, all of one length and of the types of the layout.
    pub fn of_columns(layout: Arc<Layout>, columns: Vec<Column>, crs: Option<Arc<Crs>>) -> Self {
        debug_assert!(columns.iter().zip(&layout.dimensions).all(|(column, d)| column.kind() == d.kind));
        debug_assert_eq!(columns.len(), layout.dimensions.len());
        Self { layout, columns, crs }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, Column::len)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their dimensions.
    pub fn layout(&self) -> &Arc<Layout> {
        &self.layout
    }

    /// The column of a dimension of the layout.
    pub fn column(&self, dimension: usize) -> &Column {
        &self.columns[dimension]
    }

    /// The column of a dimension of the layout, to change.
    pub fn column_mut(&mut self, dimension: usize) -> &mut Column {
        &mut self.columns[dimension]
    }

    /// The value of a dimension at point `i`.
    pub fn get(&self, dimension: usize, i: usize) -> f64 {
        self.columns[dimension].get(i)
    }

    /// X, Y and Z of point `i`, in the units of the CRS.
    pub fn position(&self, i: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.columns[axis].get(i))
    }

    /// The positions of all points.
    ///
    /// # Errors
    /// The number of the first point with a coordinate that is not finite, which no search for neighbours can do with.
    pub fn finite_positions(&self) -> Result<Vec<[f64; 3]>, usize> {
        let finite = |i: usize| {
            let position = self.position(i);
            if position.iter().all(|value| value.is_finite()) { Ok(position) } else { Err(i) }
        };
        (0..self.len()).map(finite).collect()
    }

    /// Brings the points into a layout: dimensions that they lack are zero, those that it lacks are dropped.
    pub fn conform(&mut self, layout: &Arc<Layout>) {
        if Arc::ptr_eq(&self.layout, layout) {
            return;
        }
        let len = self.len();
        let mut columns: Vec<Option<Column>> = std::mem::take(&mut self.columns).into_iter().map(Some).collect();
        self.columns = (layout.dimensions.iter())
            .map(|wanted| {
                let own = self.layout.find(&wanted.name).and_then(|place| columns[place].take());
                match own {
                    Some(column) if column.kind() == wanted.kind => column,
                    Some(other) => {
                        let mut column = Column::zeros(wanted.kind, 0);
                        column.append(&other);
                        column
                    }
                    None => Column::zeros(wanted.kind, len),
                }
            })
            .collect();
        self.layout = Arc::clone(layout);
    }

    /// Keeps the points that `kept` is true for; it has one entry per point.
    pub fn retain(&mut self, kept: &[bool]) {
        if kept.iter().all(|&k| k) {
            return;
        }
        for column in &mut self.columns {
            column.retain(kept);
        }
    }

    /// Keeps those of the `chosen` points that `keeps` is true for, and all others.
    pub fn retain_of(&mut self, chosen: &Chosen, mut keeps: impl FnMut(&Self, usize) -> bool) {
        let kept: Vec<bool> = (0..self.len()).map(|i| !chosen.has(i) || keeps(self, i)).collect();
        self.retain(&kept);
    }

    /// Copies of the points at `places`, which exist, in that order.
    #[must_use]
    pub fn gather(&self, places: &[usize]) -> Self {
        let columns = self.columns.iter().map(|column| column.gather(places)).collect();
        Self { layout: Arc::clone(&self.layout), columns, crs: self.crs.clone() }
    }

    /// Appends other points, brought into this layout. The CRS stays.
    pub fn append(&mut self, mut other: Self) {
        if self.is_empty() && self.crs.is_none() {
            self.crs = other.crs.clone();
        }
        other.conform(&self.layout);
        if self.is_empty() {
            self.columns = other.columns;
            return;
        }
        for (column, more) in self.columns.iter_mut().zip(&other.columns) {
            column.append(more);
        }
    }
}

/// Which points of a chunk a stage may act on.
#[derive(Debug, Clone)]
pub enum Chosen {
    /// All of them.
    All,
    /// Those that this is true for; one entry per point.
    Some(Vec<bool>),
}

impl Chosen {
    /// Whether point `i` is one of them.
    pub fn has(&self, i: usize) -> bool {
        match self {
            Self::All => true,
            Self::Some(chosen) => chosen.get(i).copied().unwrap_or(false),
        }
    }
}
