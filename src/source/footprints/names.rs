//! Names that are not there, and those that may have been meant.

/// The least similarity (Jaro–Winkler, 0 to 1) of a name that is proposed.
const SIMILAR: f64 = 0.7;

/// What to say to someone who asked for `wanted`: the nearest of `names`, if one is near, and all of them.
pub(super) fn remedy<'a>(wanted: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let similarity = |name: &str| strsim::jaro_winkler(&wanted.to_lowercase(), &name.to_lowercase());
    let best = names.clone().map(|name| (similarity(name), name)).max_by(|a, b| a.0.total_cmp(&b.0));
    let all = names.collect::<Vec<_>>().join(", ");
    match best {
        None => String::new(),
        Some((similarity, name)) if similarity >= SIMILAR => format!("Did you mean `{name}`? There are: {all}"),
        Some(_) => format!("There are: {all}"),
    }
}

#[cfg(test)]
mod tests {
    use super::remedy;

    #[test]
    fn the_nearest_name_is_proposed_unless_none_is_near() {
        let names = ["fid", "identificatie", "height"];
        let said = |wanted| remedy(wanted, names.into_iter());
        assert_eq!(said("Identifcatie"), "Did you mean `identificatie`? There are: fid, identificatie, height");
        assert_eq!(said("zzz"), "There are: fid, identificatie, height");
        assert_eq!(remedy("x", [].into_iter()), "");
    }
}
