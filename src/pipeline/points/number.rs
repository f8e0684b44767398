//! The types of numbers that a dimension can hold.

use std::fmt;

/// The type of the numbers of a dimension.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say all")]
pub enum NumberType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl NumberType {
    /// All types.
    pub const ALL: [Self; 10] =
        [Self::U8, Self::I8, Self::U16, Self::I16, Self::U32, Self::I32, Self::U64, Self::I64, Self::F32, Self::F64];

    /// Its name in options, as in PDAL.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::U32 => "uint32",
            Self::I32 => "int32",
            Self::U64 => "uint64",
            Self::I64 => "int64",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// The type that a name means: one of [`Self::name`], or another that PDAL takes, such as `uint8_t` or `float32`.
    pub fn parse(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_lowercase();
        let name = match name.as_str() {
            "float32" => "float",
            "float64" => "double",
            other => other.strip_suffix("_t").unwrap_or(other),
        };
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The number of the type in the extra bytes record of LAS (LAS 1.4 R15, table 24).
    pub fn las_code(self) -> u8 {
        match self {
            Self::U8 => 1,
            Self::I8 => 2,
            Self::U16 => 3,
            Self::I16 => 4,
            Self::U32 => 5,
            Self::I32 => 6,
            Self::U64 => 7,
            Self::I64 => 8,
            Self::F32 => 9,
            Self::F64 => 10,
        }
    }

    /// The type of a number in the extra bytes record of LAS; `None` for undocumented bytes.
    pub fn of_las_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.las_code() == code)
    }
}

impl fmt::Display for NumberType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A number of one of the types.
pub(super) trait Number: Copy + Default {
    /// As a double; whole numbers from 2⁵³ on lose their last digits.
    fn widen(self) -> f64;

    /// The nearest number of this type; `None` when the type does not reach that far.
    fn narrow(value: f64) -> Option<Self>;
}

macro_rules! whole {
    ($($kind:ty),*) => {$(
        impl Number for $kind {
            #[expect(clippy::allow_attributes, reason = "whether a cast loses anything depends on the type")]
            #[allow(clippy::cast_lossless, reason = "one macro for narrow and wide types")]
            fn widen(self) -> f64 {
                self as f64
            }

            #[expect(clippy::allow_attributes, reason = "whether a cast loses anything depends on the type")]
            #[allow(clippy::cast_lossless, reason = "one macro for narrow and wide types")]
            fn narrow(value: f64) -> Option<Self> {
                let value = value.round();
                (value >= Self::MIN as f64 && value <= Self::MAX as f64).then_some(value as Self)
            }
        }
    )*};
}

whole!(u8, i8, u16, i16, u32, i32, u64, i64);

impl Number for f32 {
    fn widen(self) -> f64 {
        f64::from(self)
    }

    fn narrow(value: f64) -> Option<Self> {
        (!value.is_finite() || value.abs() <= f64::from(Self::MAX)).then_some(value as Self)
    }
}

impl Number for f64 {
    fn widen(self) -> f64 {
        self
    }

    fn narrow(value: f64) -> Option<Self> {
        Some(value)
    }
}
