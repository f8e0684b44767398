//! The page that a payload is put into, and the name that it gets.

use std::path::{Path, PathBuf};

/// The page: made from `src/view/page` by `make page`.
pub(super) const TEMPLATE: &str = include_str!("page/dist/page.html");

/// Where the name of the model goes.
const NAME: &str = "<!--gable:name-->";
/// Where the payload goes.
const PAYLOAD: &str = "<!--gable:payload-->";

/// The page of a model of this name.
pub(super) fn fill(name: &str, payload: &str) -> Vec<u8> {
    let mut html = String::with_capacity(TEMPLATE.len() + payload.len() + name.len());
    let (before, rest) = TEMPLATE.split_once(NAME).unwrap_or((TEMPLATE, ""));
    let (between, after) = rest.split_once(PAYLOAD).unwrap_or((rest, ""));
    html.push_str(before);
    html.push_str(&escaped(name));
    html.push_str(between);
    html.push_str(payload);
    html.push_str(after);
    html.into_bytes()
}

/// Text for HTML: nothing in it begins a tag or an entity.
fn escaped(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(c),
        }
        out
    })
}

/// The page of a model unless another is named: beside it, with `.html` in the place of its extension.
pub fn path_for(model: &Path) -> PathBuf {
    let name = model.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let lower = name.to_lowercase();
    let known = [".city.jsonl", ".city.json", ".jsonl", ".json"].into_iter().find(|end| lower.ends_with(end));
    let stem = known.and_then(|end| name.get(..name.len() - end.len())).filter(|stem| !stem.is_empty());
    model.with_file_name(format!("{}.html", stem.unwrap_or(&name)))
}
