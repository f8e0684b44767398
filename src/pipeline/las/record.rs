//! What the bytes of a point record mean (LAS 1.4 R15, section 2.6).

use las::{Header, Transform};

use super::ExtraDimension;
use crate::pipeline::points::{Column, Dimension, Layout, NumberType, Points, usual_type};

/// Degrees per unit of the scan angle in the point formats 6 to 10.
const ANGLE_STEP: f64 = 0.006;
/// Bytes of a waveform packet.
const WAVEFORM: usize = 29;

/// How a dimension stands in a record.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Field {
    /// X, Y or Z: a whole number that is scaled.
    Coordinate(usize),
    /// So many bits of the byte at `at`, the lowest of them `shift`.
    Bits { at: usize, shift: u8, bits: u8 },
    /// A number of two bytes.
    Short(usize),
    /// Degrees in one byte.
    Degrees(usize),
    /// Steps of 0.006° in two bytes.
    Angle(usize),
    /// A double.
    Double(usize),
    /// In the extra bytes.
    Extra { at: usize, kind: NumberType, scaled: Option<(f64, f64)> },
    /// Not stored: always zero.
    Absent,
}

/// The point records of a file: which dimensions they hold, and where.
#[derive(Debug, Clone)]
pub struct Record {
    fields: Vec<(Dimension, Field)>,
    transforms: [Transform; 3],
    /// Bytes of a record.
    len: usize,
    format: u8,
}

/// A value that a record cannot hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Unfit {
    /// The dimension.
    pub dimension: String,
    /// Its value.
    pub value: f64,
}

impl Record {
    /// The records of a file with this header.
    pub fn of_header(header: &Header) -> Self {
        Self::new(header, &ExtraDimension::of_header(header))
    }

    /// The records of a file with this header, whose extra bytes hold these dimensions.
    pub fn new(header: &Header, extra: &[ExtraDimension]) -> Self {
        let format = header.point_format();
        let mut fields: Vec<(Dimension, Field)> = Vec::new();
        let mut add = |name: &str, field| fields.push((Dimension::new(name, usual_type(name)), field));
        let bits = |at, shift, bits| Field::Bits { at, shift, bits };
        for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            add(name, Field::Coordinate(axis));
        }
        add("Intensity", Field::Short(12));
        let mut at;
        if format.is_extended {
            add("ReturnNumber", bits(14, 0, 4));
            add("NumberOfReturns", bits(14, 4, 4));
            add("ScanDirectionFlag", bits(15, 6, 1));
            add("EdgeOfFlightLine", bits(15, 7, 1));
            add("Classification", bits(16, 0, 8));
            for (shift, name) in ["Synthetic", "KeyPoint", "Withheld", "Overlap"].into_iter().enumerate() {
                add(name, bits(15, shift as u8, 1));
            }
            add("ScanAngleRank", Field::Angle(18));
            add("UserData", bits(17, 0, 8));
            add("PointSourceId", Field::Short(20));
            add("GpsTime", Field::Double(22));
            add("ScanChannel", bits(15, 4, 2));
            at = 30;
        } else {
            add("ReturnNumber", bits(14, 0, 3));
            add("NumberOfReturns", bits(14, 3, 3));
            add("ScanDirectionFlag", bits(14, 6, 1));
            add("EdgeOfFlightLine", bits(14, 7, 1));
            add("Classification", bits(15, 0, 5));
            add("Synthetic", bits(15, 5, 1));
            add("KeyPoint", bits(15, 6, 1));
            add("Withheld", bits(15, 7, 1));
            add("Overlap", Field::Absent);
            add("ScanAngleRank", Field::Degrees(16));
            add("UserData", bits(17, 0, 8));
            add("PointSourceId", Field::Short(18));
            at = 20;
            if format.has_gps_time {
                add("GpsTime", Field::Double(at));
                at += 8;
            }
        }
        if format.has_color {
            for name in ["Red", "Green", "Blue"] {
                add(name, Field::Short(at));
                at += 2;
            }
        }
        if format.has_nir {
            add("Infrared", Field::Short(at));
            at += 2;
        }
        if format.has_waveform {
            at += WAVEFORM;
        }
        for one in extra {
            let kind = if one.scaled.is_some() { NumberType::F64 } else { one.kind };
            let field = Field::Extra { at: at + one.at, kind: one.kind, scaled: one.scaled };
            // A file may describe a dimension that the format has anyway, or one twice; the first counts.
            if !fields.iter().any(|(own, _)| own.name.eq_ignore_ascii_case(&one.name)) {
                fields.push((Dimension::new(one.name.clone(), kind), field));
            }
        }
        let transforms = *header.transforms();
        Self {
            fields,
            transforms: [transforms.x, transforms.y, transforms.z],
            len: usize::from(format.len()),
            format: format.to_u8().unwrap_or_default(),
        }
    }

    /// The dimensions that the records hold.
    pub fn layout(&self) -> Layout {
        let mut layout = Layout::default();
        for (dimension, _) in &self.fields {
            layout.add(&dimension.name, dimension.kind);
        }
        layout
    }

    /// Whether the records hold a dimension.
    pub fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|(own, field)| own.name.eq_ignore_ascii_case(name) && *field != Field::Absent)
    }

    /// The largest number of a return that the records can hold.
    pub fn most_returns(&self) -> f64 {
        if self.format >= 6 { 15.0 } else { 7.0 }
    }

    /// The columns of records, in the order of [`Self::layout`].
    pub fn decode(&self, records: &[&[u8]]) -> Vec<Column> {
        self.fields.iter().map(|(dimension, field)| self.decode_field(*field, dimension.kind, records)).collect()
    }

    fn decode_field(&self, field: Field, kind: NumberType, records: &[&[u8]]) -> Column {
        match field {
            Field::Coordinate(axis) => {
                let transform = self.transforms[axis];
                let stored = |record: &&[u8]| i32::from_le_bytes(bytes(record, 4 * axis));
                Column::F64(records.iter().map(|record| transform.direct(stored(record))).collect())
            }
            Field::Bits { at, shift, bits } => {
                let mask = 0xff_u8 >> (8 - bits);
                Column::U8(records.iter().map(|record| bytes::<1>(record, at)[0] >> shift & mask).collect())
            }
            Field::Short(at) => Column::U16(records.iter().map(|r| u16::from_le_bytes(bytes(r, at))).collect()),
            Field::Degrees(at) => {
                Column::F32(records.iter().map(|r| f32::from(i8::from_le_bytes(bytes(r, at)))).collect())
            }
            Field::Angle(at) => {
                let degrees = |record: &&[u8]| f64::from(i16::from_le_bytes(bytes(record, at))) * ANGLE_STEP;
                Column::F32(records.iter().map(|record| degrees(record) as f32).collect())
            }
            Field::Double(at) => Column::F64(records.iter().map(|r| f64::from_le_bytes(bytes(r, at))).collect()),
            Field::Extra { at, kind, scaled } => {
                let mut column = Column::zeros(kind, 0);
                for record in records {
                    column.push_bytes(record.get(at..).unwrap_or_default());
                }
                match scaled {
                    None => column,
                    Some((scale, offset)) => {
                        Column::F64((0..column.len()).map(|i| column.get(i) * scale + offset).collect())
                    }
                }
            }
            Field::Absent => Column::zeros(kind, records.len()),
        }
    }

    /// Appends the records of points to `out`. Dimensions that the points lack are zero, those that records do not hold
    /// are dropped.
    ///
    /// # Errors
    /// The first value that a record cannot hold.
    pub fn encode(&self, points: &Points, out: &mut Vec<u8>) -> Result<(), Unfit> {
        let places: Vec<Option<usize>> = self.fields.iter().map(|(own, _)| points.layout().find(&own.name)).collect();
        for i in 0..points.len() {
            let start = out.len();
            out.resize(start + self.len, 0);
            let record = &mut out[start..];
            for ((dimension, field), place) in self.fields.iter().zip(&places) {
                let Some(column) = place.map(|place| points.column(place)) else { continue };
                let unfit = || Unfit { dimension: dimension.name.clone(), value: column.get(i) };
                self.encode_field(*field, column, i, record).ok_or_else(unfit)?;
            }
        }
        Ok(())
    }

    fn encode_field(&self, field: Field, column: &Column, i: usize, record: &mut [u8]) -> Option<()> {
        match field {
            Field::Coordinate(axis) => {
                let Transform { scale, offset } = self.transforms[axis];
                let stored = ((column.get(i) - offset) / scale).round();
                let fits = stored >= f64::from(i32::MIN) && stored <= f64::from(i32::MAX);
                put(record, 4 * axis, (fits.then_some(stored as i32)?).to_le_bytes())
            }
            Field::Bits { at, shift, bits } => {
                let value = column.get(i).round();
                let most = f64::from(0xff_u8 >> (8 - bits));
                let byte = record.get_mut(at)?;
                *byte |= ((0.0..=most).contains(&value).then_some(value as u8)?) << shift;
                Some(())
            }
            Field::Short(at) => {
                let value = column.get(i).round();
                put(record, at, ((0.0..=65_535.0).contains(&value).then_some(value as u16)?).to_le_bytes())
            }
            Field::Degrees(at) => {
                let value = column.get(i).round();
                put(record, at, ((-128.0..=127.0).contains(&value).then_some(value as i8)?).to_le_bytes())
            }
            Field::Angle(at) => {
                let value = (column.get(i) / ANGLE_STEP).round();
                put(record, at, ((-32_768.0..=32_767.0).contains(&value).then_some(value as i16)?).to_le_bytes())
            }
            Field::Double(at) => put(record, at, column.get(i).to_le_bytes()),
            Field::Extra { at, kind, .. } => {
                let mut stored = Vec::with_capacity(8);
                if column.kind() == kind {
                    column.write_bytes(i, &mut stored);
                } else {
                    let mut one = Column::zeros(kind, 1);
                    if !one.set(0, column.get(i)) {
                        return None;
                    }
                    one.write_bytes(0, &mut stored);
                }
                record.get_mut(at..at + stored.len())?.copy_from_slice(&stored);
                Some(())
            }
            Field::Absent => Some(()),
        }
    }
}

/// The bytes of a record from `at` on; zeros where it is too short, which the header's check rules out.
#[inline]
fn bytes<const N: usize>(record: &[u8], at: usize) -> [u8; N] {
    record.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

#[inline]
fn put<const N: usize>(record: &mut [u8], at: usize, value: [u8; N]) -> Option<()> {
    record.get_mut(at..at + N)?.copy_from_slice(&value);
    Some(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    /// Records of every format come back as they were, bit by bit.
    #[test]
    fn records_survive_the_way_there_and_back() {
        for format in [0, 1, 2, 3, 6, 7, 8] {
            let mut builder = las::Builder::from((1, 4));
            builder.point_format = las::point::Format::new(format).unwrap();
            builder.point_format.extra_bytes = 9;
            builder.transforms = las::Vector {
                x: Transform { scale: 0.01, offset: 100.0 },
                y: Transform { scale: 0.02, offset: -5.0 },
                z: Transform { scale: 0.5, offset: 0.0 },
            };
            let extra = [
                ExtraDimension { name: "Building".into(), kind: NumberType::U64, at: 0, scaled: None },
                ExtraDimension { name: "Mark".into(), kind: NumberType::I8, at: 8, scaled: None },
            ];
            builder.vlrs.push(ExtraDimension::describe(&extra));
            let header = builder.into_header().unwrap();
            assert_eq!(ExtraDimension::of_header(&header), extra);
            let record = Record::of_header(&header);
            // A pattern that differs from byte to byte; the double of the time is made finite.
            let mut bytes: Vec<u8> = (0..record.len as u8).map(|i| i.wrapping_mul(37).wrapping_add(11)).collect();
            if let Some((_, Field::Double(at))) = record.fields.iter().find(|(_, f)| matches!(f, Field::Double(_))) {
                bytes[*at..at + 8].copy_from_slice(&123_456.789_f64.to_le_bytes());
            }
            let points = Points::of_columns(Arc::new(record.layout()), record.decode(&[&bytes]), None);
            let mut again = Vec::new();
            record.encode(&points, &mut again).unwrap();
            assert_eq!(again, bytes, "format {format}");
            let building = points.layout().find("Building").unwrap();
            let from = record.len - 9;
            let Column::U64(values) = points.column(building) else { panic!("{:?}", points.column(building)) };
            assert_eq!(values[0].to_le_bytes(), bytes[from..from + 8], "all 64 bits of an identifier");
        }
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let mut builder = las::Builder::from((1, 2));
        builder.point_format = las::point::Format::new(0).unwrap();
        let record = Record::of_header(&builder.into_header().unwrap());
        let mut points = Points::of_columns(Arc::new(record.layout()), record.decode(&[&[0; 20]]), None);
        let class = points.layout().find("Classification").unwrap();
        assert!(points.column_mut(class).set(0, 40.0));
        let unfit = record.encode(&points, &mut Vec::new()).unwrap_err();
        assert_eq!(unfit, Unfit { dimension: "Classification".into(), value: 40.0 });
    }
}
