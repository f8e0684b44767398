//! `gable convert` and `gable merge`: from format to format, and several files into one.

use crate::bench::*;

#[test]
fn one_run_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("delft.city.json");
    assert_eq!(delft(&model, "--quiet").code, 0);
    for extension in ["city.jsonl", "3dtiles", "gpkg", "obj"] {
        let out = folder.path().join(format!("delft.{extension}"));
        let said = gable(["convert".as_ref(), model.as_os_str(), "-o".as_ref(), out.as_os_str()]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(said.out.contains("71 features") && out.exists(), "{}", said.out);
        // Again: only when told to.
        let again = gable(["convert".as_ref(), model.as_os_str(), "-o".as_ref(), out.as_os_str()]);
        assert_eq!(again.code, 1);
        assert!(again.err.contains("--overwrite"), "{}", again.err);
        let again =
            gable(["convert".as_ref(), model.as_os_str(), "-o".as_ref(), out.as_os_str(), "--overwrite".as_ref()]);
        assert_eq!(again.code, 0, "{}", again.err);
    }
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(
        names.iter().all(|name| name.to_string_lossy().starts_with("delft.")),
        "nothing temporary is left: {names:?}"
    );
}

#[test]
fn a_model_and_its_copy_merge_into_itself() {
    let folder = tempfile::tempdir().unwrap();
    let [model, copy, out] = ["a.city.jsonl", "b.city.jsonl", "out.city.jsonl"].map(|name| folder.path().join(name));
    assert_eq!(delft(&model, "--quiet").code, 0);
    std::fs::copy(&model, &copy).unwrap();
    let said = gable(["merge".as_ref(), model.as_os_str(), copy.as_os_str(), "-o".as_ref(), out.as_os_str()]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("71 features occur again with the same geometry"), "{}", said.err);
    assert_eq!(std::fs::read(&out).unwrap(), std::fs::read(&model).unwrap());
    let alone = gable(["merge".as_ref(), model.as_os_str(), "-o".as_ref(), out.as_os_str()]);
    assert_eq!(alone.code, 1, "one file is nothing to merge");
}
