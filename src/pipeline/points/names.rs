//! What dimensions are called.

/// The names of dimensions that programs know, each with others that mean it. X, Y and Z first.
const NAMES: &[(&str, &[&str])] = &[
    ("X", &[]),
    ("Y", &[]),
    ("Z", &[]),
    ("Intensity", &[]),
    ("ReturnNumber", &[]),
    ("NumberOfReturns", &[]),
    ("ScanDirectionFlag", &[]),
    ("EdgeOfFlightLine", &[]),
    ("Classification", &["class", "cls"]),
    ("ScanAngleRank", &["ScanAngle"]),
    ("ScanChannel", &[]),
    ("Synthetic", &[]),
    ("KeyPoint", &[]),
    ("Withheld", &[]),
    ("Overlap", &[]),
    ("UserData", &["user_data"]),
    ("PointSourceId", &[]),
    ("GpsTime", &[]),
    ("Red", &["diffuse_red"]),
    ("Green", &["diffuse_green"]),
    ("Blue", &["diffuse_blue"]),
    ("Infrared", &["NearInfrared"]),
    ("HeightAboveGround", &["HAG"]),
    ("ClusterID", &[]),
    ("NormalX", &["nx", "normal_x"]),
    ("NormalY", &["ny", "normal_y"]),
    ("NormalZ", &["nz", "normal_z"]),
];

/// The name that a dimension usually goes by, whatever the case of its letters and whichever of its other names it has in a
/// file; a name that nobody knows stays as it is.
pub fn usual_name(name: &str) -> &str {
    let is_meant = |own: &&str| own.eq_ignore_ascii_case(name);
    let known = NAMES.iter().find(|(usual, others)| is_meant(usual) || others.iter().any(&is_meant));
    known.map_or(name, |(usual, _)| usual)
}

#[cfg(test)]
mod tests {
    use super::usual_name;

    #[test]
    fn known_names_get_their_usual_spelling() {
        for (name, usual) in [("x", "X"), ("CLASS", "Classification"), ("gpstime", "GpsTime"), ("nz", "NormalZ")] {
            assert_eq!(usual_name(name), usual);
        }
        assert_eq!(usual_name("scalar_Dip"), "scalar_Dip");
    }
}
