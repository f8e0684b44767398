use crate::source::points::expand;
use std::fs;
use std::path::PathBuf;
use tempfile::tempdir;

#[test]
fn arguments_become_sorted_tiles_without_duplicates() {
    let folder = tempdir().unwrap();
    let touch = |name: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "").unwrap();
        path
    };
    let (a, b, c) = (touch("b/a.LAS"), touch("b/b.copc.laz"), touch("c.laz"));
    touch("b/readme.txt");
    fs::create_dir(folder.path().join("empty")).unwrap();
    let arg = |path: PathBuf| path.display().to_string();
    let inside = |name: &str| arg(folder.path().join(name));
    assert_eq!(
        expand(&[arg(c.clone()), inside("b"), inside("b/../c.laz")]).unwrap(),
        [a.clone(), b.clone(), c.clone()]
    );
    assert_eq!(expand(&[inside("**/*")]).unwrap(), [a, b, c]);
    let refused = |name: &str| expand(&[inside(name)]).unwrap_err().to_string();
    assert!(refused("d.laz").contains("no such file or folder"));
    assert!(refused("d*.laz").contains("matches no .las, .laz, .ply"));
    assert!(refused("empty").contains("a folder without .las, .laz, .ply"));
    assert!(refused("[").contains("malformed"));
    assert!(expand(&[]).unwrap_err().to_string().contains("no argument"));
}

#[cfg(unix)]
#[test]
fn links_that_lead_back_do_not_make_a_pattern_endless() {
    let folder = tempdir().unwrap();
    for name in ["a", "b", "c", "d", "e", "f"] {
        let inner = folder.path().join(name);
        fs::create_dir(&inner).unwrap();
        fs::write(inner.join("tile.laz"), "").unwrap();
        for back in ["1", "2", "3"] {
            std::os::unix::fs::symlink("..", inner.join(back)).unwrap();
        }
    }
    let pattern = |tail: &str| folder.path().join(tail).display().to_string();
    assert_eq!(expand(&[pattern("**/*.laz")]).unwrap().len(), 6);
    assert_eq!(expand(&[pattern("**/tile.laz")]).unwrap().len(), 6);
    assert_eq!(expand(&[pattern("a/**/t*.laz")]).unwrap(), [folder.path().join("a/tile.laz")]);
    // A link before the first wildcard is meant.
    assert_eq!(expand(&[pattern("a/1/b/**/*.laz")]).unwrap(), [folder.path().join("a/1/b/tile.laz")]);
    assert!(expand(&[pattern("**/*.las")]).unwrap_err().to_string().contains("matches no .las, .laz, .ply"));
}
