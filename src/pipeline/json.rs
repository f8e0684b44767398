//! JSON with comments.

use std::path::Path;

use serde_json::Value;

use crate::error::InputError;

/// Reads JSON that may hold comments as in C++ (`//` to the end of the line, `/* … */`); `file` is for messages.
///
/// # Errors
/// Where the text is no JSON.
pub fn parse(text: &str, file: &Path) -> Result<Value, InputError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let plain = blank_comments(text)
        .map_err(|line| InputError::new(file, "a comment without an end", "`*/`").at(format!("line {line}")))?;
    serde_json::from_str(&plain).map_err(|fault| {
        let reason = fault.to_string();
        let reason = reason.split(" at line ").next().unwrap_or_default();
        let reason = if fault.is_eof() { "the end of the file" } else { reason };
        InputError::new(file, reason, "JSON, in which comments are allowed").at(format!(
            "line {}, column {}",
            fault.line(),
            fault.column()
        ))
    })
}

/// The text with blanks for comments, so that lines and columns stay; the error is the line of a comment without an end.
fn blank_comments(text: &str) -> Result<String, usize> {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    let mut line = 1;
    while let Some(c) = chars.next() {
        line += usize::from(c == '\n');
        match (c, chars.peek()) {
            ('"', _) => {
                out.push('"');
                // To the quotation mark that ends the text: one without a backslash before it.
                while let Some(c) = chars.next() {
                    out.push(c);
                    line += usize::from(c == '\n');
                    match c {
                        '"' => break,
                        '\\' => out.extend(chars.next()),
                        _ => {}
                    }
                }
            }
            ('/', Some('/')) => {
                out.push(' ');
                while let Some(c) = chars.next_if(|&c| c != '\n') {
                    blank(c, &mut out);
                }
            }
            ('/', Some('*')) => {
                let start = line;
                chars.next();
                out.push_str("  ");
                let mut star = false;
                loop {
                    let Some(c) = chars.next() else { return Err(start) };
                    line += usize::from(c == '\n');
                    blank(c, &mut out);
                    if star && c == '/' {
                        break;
                    }
                    star = c == '*';
                }
            }
            _ => out.push(c),
        }
    }
    Ok(out)
}

/// As many blanks as the character has bytes, by which columns are counted.
fn blank(c: char, out: &mut String) {
    if c == '\n' {
        out.push('\n');
    } else {
        out.extend(std::iter::repeat_n(' ', c.len_utf8()));
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn comments_are_blanks() {
        let text =
            "// first\n{ /* one\n two */ \"a\": \"no // comment /* here */ \\\" //\", \"b\": [1 /**/, 2] } // end";
        let value = parse(text, Path::new("p.json")).unwrap();
        assert_eq!(value, json!({"a": "no // comment /* here */ \" //", "b": [1, 2]}));
    }

    #[test]
    fn faults_have_their_line_in_the_file() {
        let fault = parse("[\n /* é\n*/ 1,,\n]", Path::new("p.json")).unwrap_err().to_string();
        assert!(fault.starts_with("p.json, line 3, column 6:"), "{fault}");
        let fault = parse("[\n/* 1 ]", Path::new("p.json")).unwrap_err().to_string();
        assert!(fault.contains("line 2"), "{fault}");
        assert!(parse("[1", Path::new("p.json")).unwrap_err().to_string().contains("the end of the file"));
    }
}
