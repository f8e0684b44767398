//! Files of edits.

use std::path::Path;

use super::open;
use crate::edits::{Edits, KIND, VERSION};
use crate::error::{InputError, Result};

/// Reads a file of edits.
///
/// # Errors
/// The file cannot be read, or is no file of edits; the message names the line.
pub fn read(path: &Path) -> Result<Edits> {
    let bytes = open::whole(path, "a file of edits")?;
    parse(&bytes, path).map_err(Into::into)
}

/// The edits in some bytes, which are those of `path`.
///
/// # Errors
/// They are no edits.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Edits, InputError> {
    let expected = || format!("edits of buildings, of \"type\": \"{KIND}\" and \"version\": {VERSION}");
    let edits: Edits = serde_json::from_slice(bytes).map_err(|error| {
        let fault = InputError::new(path, error.to_string(), expected());
        fault.remedy("See schemas/edits.schema.json for what may stand there")
    })?;
    if edits.kind != KIND || edits.version != VERSION {
        let found = format!("the type {:?} and version {}", edits.kind, edits.version);
        let fault = InputError::new(path, found, expected());
        return Err(fault.remedy("Give a file of edits, and a gable that is not older than it"));
    }
    Ok(edits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_file_of_edits_is_told_with_its_line() {
        let fault = |text: &str| parse(text.as_bytes(), Path::new("edits.json")).unwrap_err().to_string();
        let head = r#"{"type": "gable edits", "version": 1"#;
        assert!(parse(format!("{head}}}").as_bytes(), Path::new("edits.json")).unwrap().buildings.is_empty());
        assert!(fault("{").contains("line 1"), "{}", fault("{"));
        assert!(fault(r#"{"type": "gable edits", "version": 2}"#).contains("version 2"));
        assert!(fault(r#"{"type": "FeatureCollection", "version": 1}"#).contains("FeatureCollection"));
        let unknown = fault(&format!(
            "{head},\n\"buildings\": {{\"b\": {{\"edits\": [\n{{\"action\": {{\"fly\": {{}}}}}}]}}}}}}"
        ));
        assert!(unknown.contains("unknown variant `fly`") && unknown.contains("line 3"), "{unknown}");
        let misspelt = fault(&format!(
            "{head}, \"buildings\": {{\"b\": {{\"edits\": [{{\"action\": {{\"set-floor\": {{\"hight\": 1}}}}}}]}}}}}}"
        ));
        assert!(misspelt.contains("hight"), "{misspelt}");
    }
}
