//! Half precision.

/// The nearest number of half precision (IEEE 754 binary16), ties to even, as its bits.
pub(super) fn bits(value: f32) -> u16 {
    let (sign, bits) = ((value.to_bits() >> 16 & 0x8000) as u16, value.to_bits() & 0x7fff_ffff);
    let round =
        |kept: u32, lost: u32, half: u32| (kept + u32::from(lost > half || (lost == half && kept & 1 == 1))) as u16;
    sign | match bits {
        0x7f80_0001.. => 0x7e00,
        // From halfway between the largest number and what would be the next.
        0x477f_f000.. => 0x7c00,
        0x3880_0000.. => round((bits >> 13) - (112 << 10), bits & 0x1fff, 0x1000),
        0x3300_0000.. => {
            let (mantissa, shift) = (bits & 0x007f_ffff | 0x0080_0000, 126 - (bits >> 23));
            round(mantissa >> shift, mantissa & ((1 << shift) - 1), 1 << (shift - 1))
        }
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::bits;

    #[test]
    fn bits_are_those_of_the_standard() {
        let cases = [
            (0.0, 0x0000),
            (-0.0, 0x8000),
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (65_504.0, 0x7bff),
            (65_519.0, 0x7bff),
            (65_520.0, 0x7c00),
            (f32::INFINITY, 0x7c00),
            (6.103_515_6e-5, 0x0400),
            (5.960_464_5e-8, 0x0001),
            (2.980_232_2e-8, 0x0000),
            (3.1e-8, 0x0001),
            (0.333_333_34, 0x3555),
            // Halfway between two: the even one.
            (1.000_488_3, 0x3c00),
            (1.001_464_8, 0x3c02),
        ];
        for (value, expected) in cases {
            assert_eq!(bits(value), expected, "{value}");
        }
        assert!(bits(f32::NAN) & 0x7c00 == 0x7c00 && bits(f32::NAN) & 0x3ff != 0);
    }
}
