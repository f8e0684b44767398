//! Passwords in texts that are shown or kept.

/// What stands for a password.
const HIDDEN: &str = "***";

/// A text, such as an argument of a command line, with the passwords of the connection strings in it replaced by `***`.
pub fn redacted(text: &str) -> String {
    without_keywords(&without_logins(text))
}

/// Without what stands between `user:` and `@host` of a URL.
fn without_logins(text: &str) -> String {
    const WORD: &str = "postgres";
    // ASCII only, so that places in both are the same.
    let lower = text.to_ascii_lowercase();
    let mut out = String::new();
    let mut from = 0;
    while let Some(at) = lower[from..].find(WORD).map(|at| from + at) {
        let scheme = lower[at..].find(|c: char| !c.is_alphabetic()).map_or(lower.len(), |length| at + length);
        out.push_str(&text[from..scheme]);
        from = scheme;
        let Some(url) = text[scheme..].strip_prefix("://") else { continue };
        // A password may hold nearly anything if its writer forgot to escape it.
        let url = url.split('"').next().unwrap_or(url);
        out.push_str("://");
        match url.rsplit_once('@').and_then(|(login, place)| Some((login.split_once(':')?.0, place))) {
            Some((user, place)) => out.extend([user, ":", HIDDEN, "@", place]),
            None => out.push_str(url),
        }
        from = scheme + "://".len() + url.len();
    }
    out + &text[from..]
}

/// Without the values of `password=…`, quoted or not.
fn without_keywords(text: &str) -> String {
    const WORD: &str = "password";
    // ASCII only, so that places in both are the same.
    let lower = text.to_ascii_lowercase();
    let mut out = String::new();
    let mut from = 0;
    while let Some(at) = lower[from..].find(WORD).map(|at| from + at + WORD.len()) {
        let Some(value) = text[at..].trim_start().strip_prefix('=').map(str::trim_start) else {
            out.push_str(&text[from..at]);
            from = at;
            continue;
        };
        let start = text.len() - value.len();
        out.push_str(&text[from..start]);
        out.push_str(HIDDEN);
        from = start + length_of(value);
    }
    out + &text[from..]
}

/// How many bytes of a text its first value takes.
fn length_of(text: &str) -> usize {
    let is_quoted = text.starts_with('\'');
    let mut chars = text.char_indices().skip(usize::from(is_quoted));
    while let Some((at, c)) = chars.next() {
        match c {
            '\\' => drop(chars.next()),
            '\'' if is_quoted => return at + 1,
            c if !is_quoted && (c.is_whitespace() || c == '&' || c == '"') => return at,
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::redacted;

    #[test]
    fn passwords_are_hidden_and_nothing_else() {
        let cases = [
            ("PG:host=h password=hunter2 user=u", "PG:host=h password=*** user=u"),
            (r"PG:host=h PASSWORD = 'hun\' ter2' user=u", "PG:host=h PASSWORD = *** user=u"),
            (r"PG:password=hun\ ter2", "PG:password=***"),
            ("postgresql://u:hun:t@er2@h/d?x=1", "postgresql://u:***@h/d?x=1"),
            ("POSTGRES://u:hunter2@h", "POSTGRES://u:***@h"),
            ("a postgres, postgresql://u:hunter2@h", "a postgres, postgresql://u:***@h"),
            ("--writers.lod2.footprints=PG:postgres://u:hunter2@h", "--writers.lod2.footprints=PG:postgres://u:***@h"),
            ("postgresql://u@h/d?password=hunter2&sslmode=require", "postgresql://u@h/d?password=***&sslmode=require"),
            (r#"{"footprints":"PG:password=hunter2","x":1}"#, r#"{"footprints":"PG:password=***","x":1}"#),
            ("a postgres server, a password, http://x", "a postgres server, a password, http://x"),
            ("Käse.gpkg", "Käse.gpkg"),
        ];
        for (text, expected) in cases {
            assert_eq!(redacted(text), expected);
        }
    }
}
