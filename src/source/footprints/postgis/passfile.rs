//! The password file of libpq (PostgreSQL manual, section 34.16): lines `host:port:database:user:password`.

use std::fs;
use std::path::Path;

/// No password file is larger.
const LARGEST: u64 = 1 << 20;

/// The password for the first of some hosts with ports that the file has one for; `None` when it has none, or is not there.
///
/// # Errors
/// Why the file is not used: it is none, or others may read it.
pub(super) fn password(
    path: &Path,
    places: &[(&str, &str)],
    database: &str,
    user: &str,
) -> Result<Option<String>, String> {
    let Ok(meta) = fs::metadata(path) else { return Ok(None) };
    let unused = |why: &str| format!("the password file {} is not used: {why}", path.display());
    if !meta.is_file() || meta.len() > LARGEST {
        return Err(unused("it is not a plain file"));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = meta.permissions().mode() & 0o777;
        if mode & 0o077 != 0 {
            return Err(unused(&format!("others may read it (mode {mode:o}); chmod 600 it")));
        }
    }
    let text = fs::read_to_string(path).map_err(|error| unused(&error.to_string()))?;
    let lines: Vec<[String; 5]> = text.lines().filter(|line| !line.starts_with('#')).filter_map(fields).collect();
    let fits = |entry: &str, wanted: &str| entry == "*" || entry == wanted;
    Ok(places.iter().find_map(|(host, port)| {
        let wanted = [host, port, database, user];
        let line = lines.iter().find(|line| line.iter().zip(wanted).all(|(entry, wanted)| fits(entry, wanted)))?;
        Some(line[4].clone())
    }))
}

/// The fields of a line; `\` takes away the meaning of the colon or backslash behind it.
fn fields(line: &str) -> Option<[String; 5]> {
    let mut fields = vec![String::new()];
    let mut chars = line.chars();
    while let Some(c) = chars.next() {
        match c {
            '\\' => fields.last_mut()?.extend(chars.next()),
            ':' if fields.len() < 5 => fields.push(String::new()),
            c => fields.last_mut()?.push(c),
        }
    }
    fields.try_into().ok()
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn file(text: &str) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        file
    }

    #[test]
    fn the_first_line_that_fits_counts() {
        let file = file("# h:1:d:u:no\nh:1:d:other:no\nbroken\n\nh:*:d:u:a\\:b\\\\c:d\n*:*:*:*:last\n");
        let of = |places: &[(&str, &str)], database| password(file.path(), places, database, "u").unwrap();
        assert_eq!(of(&[("h", "1")], "d").as_deref(), Some("a:b\\c:d"));
        assert_eq!(of(&[("h", "1")], "e").as_deref(), Some("last"));
        assert_eq!(password(Path::new("/no/such/file"), &[("h", "1")], "d", "u"), Ok(None));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_others_may_read_is_not_used() {
        use std::os::unix::fs::PermissionsExt;
        let file = file("*:*:*:*:hunter2\n");
        for mode in [0o640, 0o604, 0o660] {
            fs::set_permissions(file.path(), fs::Permissions::from_mode(mode)).unwrap();
            let said = password(file.path(), &[("h", "1")], "d", "u").unwrap_err();
            assert!(said.contains("chmod 600") && !said.contains("hunter2"), "{said}");
        }
        assert!(password(Path::new("/"), &[("h", "1")], "d", "u").is_err());
    }
}
