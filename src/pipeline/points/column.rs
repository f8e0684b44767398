//! The values of one dimension.

use std::cmp::Ordering;

use super::number::{Number, NumberType};

/// The values of one dimension, one per point, in the type of the dimension: a tile of 20 million points fits into
/// memory where doubles for everything would not, and 64-bit identifiers keep their last digits.
#[derive(Debug, Clone, PartialEq)]
#[expect(missing_docs, reason = "the names say all")]
pub enum Column {
    U8(Vec<u8>),
    I8(Vec<i8>),
    U16(Vec<u16>),
    I16(Vec<i16>),
    U32(Vec<u32>),
    I32(Vec<i32>),
    U64(Vec<u64>),
    I64(Vec<i64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Does the same with the values of whatever type.
macro_rules! of_any_type {
    ($column:expr, $values:ident => $body:expr) => {
        match $column {
            Column::U8($values) => $body,
            Column::I8($values) => $body,
            Column::U16($values) => $body,
            Column::I16($values) => $body,
            Column::U32($values) => $body,
            Column::I32($values) => $body,
            Column::U64($values) => $body,
            Column::I64($values) => $body,
            Column::F32($values) => $body,
            Column::F64($values) => $body,
        }
    };
}

impl Column {
    /// `len` zeros.
    pub fn zeros(kind: NumberType, len: usize) -> Self {
        match kind {
            NumberType::U8 => Self::U8(vec![0; len]),
            NumberType::I8 => Self::I8(vec![0; len]),
            NumberType::U16 => Self::U16(vec![0; len]),
            NumberType::I16 => Self::I16(vec![0; len]),
            NumberType::U32 => Self::U32(vec![0; len]),
            NumberType::I32 => Self::I32(vec![0; len]),
            NumberType::U64 => Self::U64(vec![0; len]),
            NumberType::I64 => Self::I64(vec![0; len]),
            NumberType::F32 => Self::F32(vec![0.0; len]),
            NumberType::F64 => Self::F64(vec![0.0; len]),
        }
    }

    /// The type of its values.
    pub fn kind(&self) -> NumberType {
        match self {
            Self::U8(_) => NumberType::U8,
            Self::I8(_) => NumberType::I8,
            Self::U16(_) => NumberType::U16,
            Self::I16(_) => NumberType::I16,
            Self::U32(_) => NumberType::U32,
            Self::I32(_) => NumberType::I32,
            Self::U64(_) => NumberType::U64,
            Self::I64(_) => NumberType::I64,
            Self::F32(_) => NumberType::F32,
            Self::F64(_) => NumberType::F64,
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        of_any_type!(self, values => values.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of point `i`, which exists, as a double.
    pub fn get(&self, i: usize) -> f64 {
        of_any_type!(self, values => values[i].widen())
    }

    /// Gives point `i`, which exists, the nearest value of the type; `false` when the type does not reach that far.
    #[must_use]
    pub fn set(&mut self, i: usize, value: f64) -> bool {
        fn set<T: Number>(values: &mut [T], i: usize, value: f64) -> bool {
            let fit = T::narrow(value);
            if let Some(fit) = fit {
                values[i] = fit;
            }
            fit.is_some()
        }
        of_any_type!(self, values => set(values, i, value))
    }

    /// How the values of points `i` and `j`, which exist, compare; what is no number comes after all numbers.
    pub fn compare(&self, i: usize, j: usize) -> Ordering {
        fn compare<T: Copy + PartialOrd>(a: T, b: T) -> Ordering {
            // Only what is no number differs from itself.
            let is_none = |value: T| value.partial_cmp(&value).is_none();
            a.partial_cmp(&b).unwrap_or_else(|| is_none(a).cmp(&is_none(b)))
        }
        of_any_type!(self, values => compare(values[i], values[j]))
    }

    /// Appends the bytes of the value of point `i`, which exists, low byte first.
    pub fn write_bytes(&self, i: usize, bytes: &mut Vec<u8>) {
        of_any_type!(self, values => bytes.extend_from_slice(&values[i].to_le_bytes()));
    }

    /// Appends the value that `bytes` (of [`NumberType::size`], low byte first) hold.
    pub fn push_bytes(&mut self, bytes: &[u8]) {
        macro_rules! push {
            ($values:ident, $kind:ty) => {
                $values.push(bytes.first_chunk().map_or_else(Default::default, |bytes| <$kind>::from_le_bytes(*bytes)))
            };
        }
        match self {
            Self::U8(values) => push!(values, u8),
            Self::I8(values) => push!(values, i8),
            Self::U16(values) => push!(values, u16),
            Self::I16(values) => push!(values, i16),
            Self::U32(values) => push!(values, u32),
            Self::I32(values) => push!(values, i32),
            Self::U64(values) => push!(values, u64),
            Self::I64(values) => push!(values, i64),
            Self::F32(values) => push!(values, f32),
            Self::F64(values) => push!(values, f64),
        }
    }

    /// Appends zeros until there are `len` values.
    pub fn pad(&mut self, len: usize) {
        of_any_type!(self, values => values.resize(len, Default::default()));
    }

    /// Keeps the values of points that `kept` is true for; both have one entry per point.
    pub fn retain(&mut self, kept: &[bool]) {
        fn retain<T: Copy>(values: &mut Vec<T>, kept: &[bool]) {
            let mut flags = kept.iter();
            values.retain(|_| flags.next().copied().unwrap_or(false));
        }
        of_any_type!(self, values => retain(values, kept));
    }

    /// The values of the points at `places`, which exist, in that order.
    #[must_use]
    pub fn gather(&self, places: &[usize]) -> Self {
        macro_rules! gather {
            ($($variant:ident),*) => {
                match self {
                    $(Self::$variant(values) => Self::$variant(places.iter().map(|&i| values[i]).collect()),)*
                }
            };
        }
        gather!(U8, I8, U16, I16, U32, I32, U64, I64, F32, F64)
    }

    /// Appends the values of another column; of another type, each becomes the nearest, and zero what does not fit.
    pub fn append(&mut self, other: &Self) {
        macro_rules! append {
            ($($variant:ident),*) => {
                match (&mut *self, other) {
                    $((Self::$variant(values), Self::$variant(more)) => values.extend_from_slice(more),)*
                    (column, other) => {
                        let start = column.len();
                        column.pad(start + other.len());
                        for i in 0..other.len() {
                            // What does not fit stays zero: dimensions of one name and two types have no common value.
                            let _ = column.set(start + i, other.get(i));
                        }
                    }
                }
            };
        }
        append!(U8, I8, U16, I16, U32, I32, U64, I64, F32, F64);
    }
}
