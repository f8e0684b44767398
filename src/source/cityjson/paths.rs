//! The files of city models that arguments name.

use std::path::{Path, PathBuf};

use crate::error::{InputError, Result};
use crate::source::expand::{Kind, expand as expand_kind};
use crate::source::objects;
use crate::source::reread::is_standard_input;

/// City models. In folders only what is called so by the end of its name: reports and footprints are JSON as well.
const MODELS: Kind = Kind {
    name: "models",
    wanted: "CityJSON or CityJSONSeq files, folders of them, or glob patterns",
    extensions: &["city.json", "city.jsonl"],
    meant: &["json", "jsonl"],
};
/// The end of the name of a report, which a pattern for models may match.
const REPORT: &str = ".report.json";

/// Whether a name stands for those that match it.
fn is_pattern(text: &str) -> bool {
    text.contains(['*', '?', '['])
}

/// The model files that `args` name: files, folders (the `.city.json` and `.city.jsonl` directly in them) and glob patterns,
/// in the order of the arguments and each once; what a folder or pattern stands for is sorted. Standard input (`-`) stays, and
/// so does a file that is not there: whoever opens it says so, and goes on with the others if that can be done.
///
/// # Errors
/// A pattern that is malformed or matches no file, a folder without models, or one that
/// cannot be read.
pub fn expand(args: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found: Vec<PathBuf> = Vec::new();
    for arg in args {
        let files = match arg.to_str() {
            Some(text) if objects::is_object(arg) => expand_kind(&[text.to_owned()], &MODELS)?,
            Some(text) if !is_standard_input(arg) && (arg.is_dir() || !arg.exists() && is_pattern(text)) => {
                expand_kind(&[text.to_owned()], &MODELS)?
            }
            _ => vec![arg.clone()],
        };
        let is_several = files.len() > 1 || files.first() != Some(arg);
        let is_model = |file: &PathBuf| !is_several || !file.to_string_lossy().ends_with(REPORT);
        for file in files.into_iter().filter(is_model) {
            if !found.contains(&file) {
                found.push(file);
            }
        }
    }
    Ok(found)
}

/// The only model file that an argument names, as [`expand`] does.
///
/// # Errors
/// As [`expand`], and if there are several.
pub fn only(arg: &Path) -> Result<PathBuf> {
    let mut found = expand(&[arg.to_path_buf()])?;
    match found.pop() {
        Some(one) if found.is_empty() => Ok(one),
        _ => {
            let fault = InputError::new(arg, format!("{} city models", found.len() + 1), "one city model");
            Err(fault.remedy("Name one of them, or join them with `gable merge`").into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_patterns_name_models_and_the_order_of_arguments_stays() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        for name in ["b.city.json", "a.city.jsonl", "a.city.json.report.json", "f.geojson", "x.json"] {
            std::fs::write(file(name), "").unwrap();
        }
        let all = [file("a.city.jsonl"), file("b.city.json")];
        assert_eq!(expand(&[folder.path().to_path_buf()]).unwrap(), all);
        let again = expand(&[file("x.json"), file("*.city.json*"), file("b.city.json")]).unwrap();
        assert_eq!(again, [file("x.json"), file("a.city.jsonl"), file("b.city.json")]);
        assert_eq!(expand(&["-".into()]).unwrap(), [PathBuf::from("-")]);
        // Whoever opens it says that it is not there.
        assert_eq!(expand(&[file("none.city.json")]).unwrap(), [file("none.city.json")]);
        let message = expand(&[file("none*.json")]).unwrap_err().to_string();
        assert!(message.contains("none*.json") && message.contains("CityJSON or CityJSONSeq"), "{message}");
        assert_eq!(only(&file("b.*")).unwrap(), file("b.city.json"));
        let message = only(folder.path()).unwrap_err().to_string();
        assert!(message.contains("2 city models") && message.contains("gable merge"), "{message}");
    }
}
