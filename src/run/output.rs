//! Where the model and the report go.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::error::{Error, InputError, Result};
use crate::sink::{Format, refuse_web};
use crate::source::objects;

/// The extension of a model whose name is made up because the output is a folder.
const DEFAULT_EXTENSION: &str = ".city.json";

/// The file that the model goes to.
///
/// `output` is taken as it is if its extension asks for a format that is a folder. It is a folder to write in if it is one already, if it ends with a separator, or if its name has no extension. Then the
/// file in it is named after the tile if there is one, else after the footprints, else after the first tile, with
/// `.city.json` behind it.
pub fn model_path(output: &Path, tiles: &[PathBuf], footprints: Option<&Path>) -> PathBuf {
    if is_folder_of_a_format(output) {
        return output.to_path_buf();
    }
    let ends_with_separator = output.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    if !ends_with_separator && !output.is_dir() && output.extension().is_some() {
        return output.to_path_buf();
    }
    let source = match (tiles, footprints) {
        ([tile], _) => tile.as_path(),
        (_, Some(footprints)) => footprints,
        (tiles, None) => tiles.first().map_or(Path::new("model"), PathBuf::as_path),
    };
    // What comes before the first dot: `a.copc.laz` gives `a`.
    let name = source.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.split('.').find(|part| !part.is_empty()).unwrap_or("model");
    output.join(format!("{stem}{DEFAULT_EXTENSION}"))
}

/// The file that the report goes to unless another is named: the name of the model with `.report.json` behind it.
pub fn report_path(model: &Path) -> PathBuf {
    let mut name: OsString = model.as_os_str().to_owned();
    name.push(".report.json");
    PathBuf::from(name)
}

/// Refuses what must not be replaced; changes nothing.
///
/// # Errors
/// The file exists and `overwrite` is off, or is a folder.
pub fn spare_results(path: &Path, overwrite: bool) -> Result<()> {
    if path.is_dir() && !is_folder_of_a_format(path) {
        return Err(InputError::new(path, "a folder", "the name of a file").into());
    }
    if overwrite { Ok(()) } else { refuse_existing(path) }
}

/// Fails before hours of work rather than after them if a file is there already, and makes the folder it goes to.
///
/// # Errors
/// As [`spare_results`]; or its folder cannot be made or written to.
pub fn prepare(path: &Path, overwrite: bool) -> Result<()> {
    if objects::is_object(path) {
        refuse_web(path)?;
        // Whoever may not even ask is told so now.
        let is_there = objects::exists(path)?;
        return if is_there && !overwrite { refuse_existing(path) } else { Ok(()) };
    }
    spare_results(path, overwrite)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    // Permissions do not tell: a file system may be read-only, or have no files of one's own.
    match tempfile::tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(e) => Err(Error::io(folder, "write to", e)),
    }
}

/// Refuses a place where something is.
///
/// # Errors
/// The file, folder or object exists, or nobody can say.
pub fn refuse_existing(path: &Path) -> Result<()> {
    if !is_there(path)? {
        return Ok(());
    }
    let found = match path.is_dir() {
        _ if objects::is_object(path) => "an object of that name",
        true => "a folder of that name",
        false => "a file of that name",
    };
    let fault = InputError::new(path, found, "nothing, so that no result is lost");
    Err(fault.remedy("Give --overwrite to replace it, or another output").into())
}

/// Whether there is a file, folder or object.
fn is_there(path: &Path) -> Result<bool> {
    if objects::is_object(path) { objects::exists(path) } else { Ok(path.exists()) }
}

/// The same for many files at once, whose folders are made as they are written.
///
/// # Errors
/// As [`prepare`]; of files that exist, the first and how many there are.
pub fn prepare_all(paths: &[&Path], overwrite: bool) -> Result<()> {
    let mut there = Vec::new();
    for path in paths {
        if objects::is_object(path) {
            refuse_web(path)?;
        }
        // Objects that may be replaced need not be asked for, one by one.
        if !(overwrite && objects::is_object(path)) && is_there(path)? {
            there.push(path);
        }
    }
    if let Some(folder) = there.iter().find(|path| path.is_dir() && !is_folder_of_a_format(path)) {
        return Err(InputError::new(folder, "a folder", "the name of a file").into());
    }
    match there.first() {
        Some(first) if !overwrite => {
            let found = format!("a file of that name: {} of {} are there", there.len(), paths.len());
            let fault = InputError::new(first, found, "nothing, so that no result is lost");
            Err(fault.remedy("Give --overwrite to replace them, or another output").into())
        }
        _ => Ok(()),
    }
}

/// Whether the extension asks for a format that is a folder, such as 3D Tiles.
fn is_folder_of_a_format(path: &Path) -> bool {
    Format::of(path).is_ok_and(Format::is_folder)
}

/// Refuses outputs that would replace an input.
///
/// # Errors
/// Which one.
pub fn spare_inputs<'a>(outputs: &[&Path], inputs: impl Iterator<Item = &'a Path>) -> Result<()> {
    let same = |path: &Path| {
        if objects::is_object(path) { Some(objects::label(path)) } else { std::fs::canonicalize(path).ok() }
    };
    let outputs: Vec<_> = outputs.iter().map(|path| (*path, same(path))).collect();
    for input in inputs {
        let own = same(input);
        if let Some((path, _)) = outputs.iter().find(|(_, output)| output.is_some() && *output == own) {
            let fault = InputError::new(path, "an input of this run", "a file of its own for the output");
            return Err(fault.remedy("Give another output").into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(output: &Path, tiles: &[&str], footprints: Option<&str>) -> String {
        let tiles: Vec<PathBuf> = tiles.iter().map(PathBuf::from).collect();
        model_path(output, &tiles, footprints.map(Path::new)).to_string_lossy().into_owned()
    }

    #[test]
    fn a_file_is_taken_as_it_is_and_a_folder_named_after_the_inputs() {
        let file = Path::new("out/a.city.jsonl");
        assert_eq!(name(file, &["t.laz"], None), "out/a.city.jsonl");
        assert_eq!(name(Path::new("out/"), &["in/t.copc.laz"], Some("f.gpkg")), "out/t.city.json");
        assert_eq!(name(Path::new("out"), &["t.laz", "u.laz"], Some("in/f.gpkg")), "out/f.city.json");
        assert_eq!(name(Path::new("out/a.3dtiles/"), &["t.laz"], None), "out/a.3dtiles/");
        assert_eq!(name(Path::new("v1.2/"), &["t.laz", "u.laz"], None), "v1.2/t.city.json");
        let folder = tempfile::Builder::new().suffix(".d").tempdir().unwrap();
        let expected = folder.path().join("t.city.json");
        assert_eq!(name(folder.path(), &["t.laz"], None), expected.to_string_lossy());
    }

    #[test]
    fn the_report_stands_next_to_the_model() {
        assert_eq!(report_path(Path::new("out/a.city.json")), Path::new("out/a.city.json.report.json"));
    }

    #[test]
    fn an_existing_file_is_kept_unless_told_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/a.city.json");
        prepare(&file, false).unwrap();
        assert!(file.parent().unwrap().is_dir(), "the folder was made");
        std::fs::write(&file, "x").unwrap();
        let message = prepare(&file, false).unwrap_err().to_string();
        assert!(message.contains("--overwrite"), "{message}");
        prepare(&file, true).unwrap();
        assert!(prepare(folder.path(), true).is_err());
    }
}
