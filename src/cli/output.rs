//! What goes to standard output.

use std::io::{self, Write};

use crate::error::{Error, Result};
use crate::source::footprints::redacted;

/// Writes `text` to standard output. A reader that has heard enough (`gable info … | head`) is no error.
///
/// # Errors
/// Standard output cannot be written.
pub fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Error::io("standard output", "write", e)),
        _ => Ok(()),
    }
}

/// Writes a line to standard error, without passwords, even of an address that was given where a file belongs. It is a
/// courtesy: nobody is left to tell if that fails.
pub fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{}", redacted(text));
}

/// A whole number with its thousands apart: `45 646`.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

/// `count` with its noun: `1 tile`, `2 tiles`.
pub fn counted(count: u64, noun: &str) -> String {
    format!("{} {noun}{}", thousands(count), if count == 1 { "" } else { "s" })
}

/// A duration for a person: `850 ms`, `12.3 s`, `4 min 05 s`, `2 h 05 min`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match seconds {
        s if s < 0.9995 => format!("{:.0} ms", s * 1e3),
        s if s < 59.95 => format!("{s:.1} s"),
        _ if whole < 3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// A table: columns aligned, the first to the left and the others to the right, two blanks between them.
pub fn table(rows: &[Vec<String>], indent: &str) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|r| r.get(column)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let cell = |(column, (text, &width)): (usize, (&String, &usize))| match column {
        0 => format!("{text:<width$}"),
        _ => format!("  {text:>width$}"),
    };
    let line = |row: &Vec<String>| row.iter().zip(&widths).enumerate().map(cell).collect::<String>();
    rows.iter().flat_map(|row| [indent, line(row).trim_end(), "\n"].map(str::to_owned)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!([0, 999, 1000, 45_646, 1_234_567].map(thousands), ["0", "999", "1 000", "45 646", "1 234 567"]);
        assert_eq!(
            [0.0, 0.85, 12.34, 245.0, 7500.0].map(duration),
            ["0 ms", "850 ms", "12.3 s", "4 min 05 s", "2 h 05 min"]
        );
        assert_eq!([0.9996, 59.96, 3599.9].map(duration), ["1.0 s", "1 min 00 s", "1 h 00 min"]);
        assert_eq!((counted(1, "tile"), counted(2, "tile")), ("1 tile".into(), "2 tiles".into()));
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [vec!["a".into(), "10".into()], vec!["long".into(), "5".into(), "x".into()]];
        assert_eq!(table(&rows, " "), " a     10\n long   5  x\n");
    }
}
