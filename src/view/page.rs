//! The page that a payload is put into, and the name that it gets.

use std::path::{Path, PathBuf};

/// The page: made from `src/view/page` by `make page`.
pub(super) const TEMPLATE: &str = include_str!("page/dist/page.html");

/// Where the name of the model goes.
const NAME: &str = "<!--gable:name-->";
/// Where the payload goes.
const PAYLOAD: &str = "<!--gable:payload-->";

/// A page with its name and its payload.
pub(crate) fn fill(template: &str, name: &str, payload: &str) -> Vec<u8> {
    let mut html = String::with_capacity(template.len() + payload.len() + name.len());
    let (before, rest) = template.split_once(NAME).unwrap_or((template, ""));
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

#[cfg(test)]
pub(crate) mod tests {
    use std::path::Path;

    /// What a page says of its sources: FNV-1a over those of its `folder` and of the folders whose modules and style it
    /// shares, in the order of `src/view/page/build.mjs`.
    pub fn named(folder: &str, shares: &[&str]) -> String {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let of = |place: &str| -> Vec<String> {
            let entries = std::fs::read_dir(root.join(place).join("src")).unwrap();
            let mut scripts: Vec<String> =
                entries.map(|entry| format!("{place}/src/{}", entry.unwrap().file_name().to_string_lossy())).collect();
            scripts.sort();
            scripts.push(format!("{place}/style.css"));
            scripts
        };
        let common = ["build.mjs", "package-lock.json", "package.json"].map(|name| format!("src/view/page/{name}"));
        let mut sources: Vec<String> = common.into();
        sources.extend(shares.iter().flat_map(|place| of(place)));
        sources.push(format!("{folder}/index.html"));
        sources.extend(of(folder));
        let bytes = sources.iter().flat_map(|name| std::fs::read(root.join(name)).unwrap());
        let hash =
            bytes.fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        format!("sources {hash:016x}\n")
    }
}
