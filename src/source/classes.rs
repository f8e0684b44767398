//! The standard point classes of LAS.

/// The class of points in the overlap of two strips, which says nothing of what they hit.
pub const OVERLAP: u8 = 12;

/// The name of a point class (ASPRS LAS 1.4 R15, table 17).
pub fn class_name(class: u8) -> &'static str {
    match class {
        0 => "never classified",
        1 => "unclassified",
        2 => "ground",
        3 => "low vegetation",
        4 => "medium vegetation",
        5 => "high vegetation",
        6 => "building",
        7 => "low noise",
        8 => "model key point",
        9 => "water",
        10 => "rail",
        11 => "road surface",
        OVERLAP => "overlap",
        13 => "wire guard",
        14 => "wire conductor",
        15 => "transmission tower",
        16 => "wire connector",
        17 => "bridge deck",
        18 => "high noise",
        19 => "overhead structure",
        20 => "ignored ground",
        21 => "snow",
        22 => "temporal exclusion",
        23..=63 => "reserved",
        64..=255 => "defined by the producer",
    }
}
