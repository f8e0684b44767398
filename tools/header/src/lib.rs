//! The header of the C interface, made from the code.

use std::path::Path;

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, ExportConfig, Language, RenameRule, Style};

const HEAD: &str = "\
/* gable: airborne laser points and building footprints in, valid LoD 2 city models out.
 *
 * Create a job from options, push points to it, run it, free it:
 *
 *     gable_job *job;
 *     if (gable_create(\"{\\\"output\\\": \\\"house.city.json\\\"}\", \"EPSG:7415\", &job) == GABLE_STATUS_OK) {
 *         gable_chunk chunk = {0};
 *         chunk.struct_size = sizeof chunk;
 *         chunk.count = n;
 *         chunk.x = x, chunk.y = y, chunk.z = z, chunk.classification = classification;
 *         gable_push(job, &chunk);                 // again for every chunk
 *         gable_run(job, NULL, NULL, NULL);
 *     }
 *     puts(gable_error(job));
 *     gable_free(job);
 *
 * Errors: every call says by its status whether it was done, and gable_error why not. Null pointers, columns that are
 * missing or misaligned, numbers that are none and text that is not UTF-8 are errors; a pointer to memory that is not
 * yours, a count larger than a column, and a job that was freed cannot be noticed.
 *
 * Threads: jobs are independent of one another. One job is used by one thread at a time; a second gets GABLE_STATUS_BUSY.
 * A run uses as many threads as the option \"jobs\" says and calls back on the thread that called gable_run only.
 *
 * Text is UTF-8 and ends with a zero. What you pass is copied or read during the call and stays yours; what you get
 * belongs to the library.
 *
 * Made from src/capi by cbindgen: do not edit. License: MIT OR Apache-2.0.
 */";

/// What `include/gable.h` must hold; `root` is the folder of gable.
///
/// # Panics
/// cbindgen cannot read the code.
pub fn header(root: &Path) -> String {
    let mut config = Config {
        language: Language::C,
        header: Some(HEAD.to_owned()),
        include_guard: Some("GABLE_H".to_owned()),
        no_includes: true,
        sys_includes: ["stddef.h", "stdint.h"].map(str::to_owned).into(),
        cpp_compat: true,
        usize_is_size_t: true,
        style: Style::Both,
        documentation_style: DocumentationStyle::C99,
        line_length: 100,
        enumeration: EnumConfig { rename_variants: RenameRule::QualifiedScreamingSnakeCase, ..EnumConfig::default() },
        export: ExportConfig::default(),
        ..Config::default()
    };
    for (rust, c) in [
        ("GableJob", "gable_job"),
        ("GableChunk", "gable_chunk"),
        ("GableStatus", "gable_status"),
        ("GableStage", "gable_stage"),
        ("GableOption", "gable_option"),
        ("GableLineCallback", "gable_line_callback"),
        ("GableProgressCallback", "gable_progress_callback"),
    ] {
        config.export.rename.insert(rust.to_owned(), c.to_owned());
    }
    let mut builder = Builder::new().with_config(config);
    for file in ["job.rs", "chunk.rs", "messages.rs", "entry.rs", "writer.rs"] {
        builder = builder.with_src(root.join("src/capi").join(file));
    }
    let mut bytes = Vec::new();
    builder.generate().unwrap().write(&mut bytes);
    // What rustdoc wants for callers from Rust is said at the head for those from C.
    let text = String::from_utf8(bytes).unwrap();
    let mut lines: Vec<&str> = Vec::new();
    let mut skips = false;
    for line in text.lines() {
        let is_comment = line.trim_start().starts_with("//");
        if line.trim() == "// # Safety" {
            skips = true;
            while lines.last().is_some_and(|line| line.trim() == "//") {
                lines.pop();
            }
        }
        skips &= is_comment;
        if !skips {
            lines.push(line);
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::Command;

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    #[test]
    fn the_checked_in_header_is_up_to_date() {
        let path = root().join("include/gable.h");
        let expected = super::header(&root());
        if std::env::var_os("GABLE_UPDATE_HEADER").is_some() {
            fs::write(&path, &expected).unwrap();
        }
        let found = fs::read_to_string(&path).unwrap_or_default();
        assert!(found == expected, "include/gable.h is stale: renew it with `make header`");
    }

    #[test]
    fn the_header_is_good_cpp_too() {
        let mut compiler = Command::new(std::env::var_os("CXX").unwrap_or_else(|| "c++".into()));
        compiler.args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c++"]);
        let output = compiler.arg(root().join("include/gable.h")).output();
        let output = output.expect("a C++ compiler, which building gable needs too");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}
