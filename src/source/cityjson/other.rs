//! What a file is that is no city model, in words.

/// How files of other kinds begin.
const BEGINNINGS: [(&[u8], &str); 14] = [
    (b"LASF", "a point cloud (LAS or LAZ)"),
    (b"ply", "a point cloud (PLY)"),
    (b"SQLite format 3", "a database of SQLite, such as a GeoPackage"),
    (b"fgb", "a FlatGeobuf"),
    (b"PAR1", "a Parquet file"),
    (b"\x00\x00\x27\x0a", "a Shapefile"),
    (b"glTF", "a binary glTF"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a file that is compressed with gzip"),
    (b"II*\x00", "a TIFF"),
    (b"MM\x00*", "a TIFF"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"<", "XML or HTML; CityGML must be turned into CityJSON first"),
];

/// What begins like this and is no JSON object.
pub(super) fn kind(start: &[u8]) -> &'static str {
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start).trim_ascii_start();
    let known = BEGINNINGS.iter().find(|(beginning, _)| start.starts_with(beginning) || text.starts_with(beginning));
    if let Some((_, words)) = known {
        return words;
    }
    match text.first() {
        None => "nothing: the file is empty",
        Some(b'[') => "an array of JSON",
        Some(b'"' | b'-' | b'0'..=b'9') => "a single value, or a text that is no JSON",
        Some(byte) if byte.is_ascii_graphic() && start.is_ascii() => "a text that is no JSON",
        Some(_) => "bytes that are no JSON",
    }
}

/// What a JSON object of another `type` is.
pub(super) fn of_type(kind: &str) -> String {
    match kind {
        "" => "a JSON object without a type".to_owned(),
        "FeatureCollection" | "Feature" => format!("the type {kind:?}, which is GeoJSON"),
        "CityJSONFeature" => format!("the type {kind:?}: a sequence without its head"),
        _ => format!("the type {kind:?}"),
    }
}

/// What a JSON reader says of a fault, in words that say what is in the file.
pub(super) fn in_words(fault: &serde_json::Error) -> String {
    let text = fault.to_string();
    let said = text.split(" at line ").next().unwrap_or(&text);
    if fault.is_eof() {
        return "the end of the file in the middle of its JSON: it is cut off".to_owned();
    }
    match said {
        "expected value" | "expected ident" => "something else than JSON".to_owned(),
        "missing field `type`" => of_type(""),
        "key must be a string"
        | "expected `:`"
        | "expected `,` or `}`"
        | "expected `,` or `]`"
        | "trailing comma"
        | "trailing characters" => format!("JSON with a slip of the pen ({said})"),
        said => said.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_are_told_in_words() {
        assert_eq!(kind(b"LASF\x00\x00"), "a point cloud (LAS or LAZ)");
        assert_eq!(kind(b"  <?xml version"), "XML or HTML; CityGML must be turned into CityJSON first");
        assert_eq!(kind(b""), "nothing: the file is empty");
        assert_eq!(kind(b"\n [1, 2]"), "an array of JSON");
        assert_eq!(kind(b"# A heading"), "a text that is no JSON");
        assert_eq!(kind(b"\x00\xff"), "bytes that are no JSON");
        let fault = |text: &str| in_words(&serde_json::from_str::<serde_json::Value>(text).unwrap_err());
        assert!(fault("{\"a\": 1").contains("cut off"), "{}", fault("{\"a\": 1"));
        assert_eq!(fault("{\"a\": x}"), "something else than JSON");
        assert!(fault("{\"a\" 1}").contains("slip of the pen"));
    }
}
