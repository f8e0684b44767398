//! The known name that someone probably meant.

/// How different a name may be and still be taken for a slip of another: as similar as `reader.las` and `readers.las`,
/// not as `filters.crop` and `filters.csf`.
const SIMILAR: f64 = 0.75;

/// The known name most like `name`, when one is like it at all.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    known
        .into_iter()
        .map(|other| (strsim::jaro_winkler(&name, &other.to_lowercase()), other))
        .filter(|(likeness, _)| *likeness >= SIMILAR)
        .reduce(|best, next| if next.0 > best.0 { next } else { best })
        .map(|(_, other)| other)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn slips_are_recognised_and_other_words_are_not() {
        let known = ["filters.crop", "filters.range", "readers.las"];
        assert_eq!(nearest("filters.corp", known), Some("filters.crop"));
        assert_eq!(nearest("reader.las", known), Some("readers.las"));
        assert_eq!(nearest("xyz", known), None);
    }
}
