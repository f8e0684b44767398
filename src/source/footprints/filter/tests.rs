use serde_json::json;

use super::*;

fn passes(filter: &str) -> bool {
    let Value::Object(attributes) = json!({
        "name": "De Hoop", "quote": "it's", "a b": 5, "height": 3.5, "floors": 2, "code": "0503", "empty": null,
        "big": 9_007_199_254_740_993_i64, "listed": true
    }) else {
        unreachable!()
    };
    Filter::parse(filter, Path::new("f")).unwrap().matches(&attributes)
}

#[test]
fn comparisons_go_by_value() {
    for filter in [
        "name = 'De Hoop'",
        "NAME == 'De Hoop'",
        "quote = 'it''s'",
        "\"a b\" <> 4",
        "height > 3 and height<=3.5",
        "floors = '2'",
        "2 = floors",
        "code = 503",
        "code = '0503'",
        "big = 9007199254740993",
        "listed = TRUE",
        "height >= -1e1",
        "floors < 1.0e1 AND floors != 3",
    ] {
        assert!(passes(filter), "{filter}");
    }
    for filter in ["name = 'de hoop'", "code = '503'", "big = 9007199254740992", "name > 5", "listed = false"] {
        assert!(!passes(filter), "{filter}");
    }
}

#[test]
fn patterns_lists_and_null() {
    for filter in [
        "name LIKE 'De%'",
        "name LIKE '_e H%p'",
        "name ILIKE '%HOOP'",
        "name NOT LIKE 'Hoop%'",
        "code LIKE '0___'",
        "floors IN (1, 2, 3)",
        "name NOT IN ('x', 'y')",
        "empty IS NULL",
        "missing IS NULL",
        "name IS NOT NULL",
    ] {
        assert!(passes(filter), "{filter}");
    }
    let slow = format!("name LIKE '{}x'", "%o".repeat(200));
    assert!(!passes(&slow));
}

#[test]
fn unknown_is_neither_true_nor_false() {
    for filter in
        ["empty = 1", "NOT empty = 1", "empty != 1", "empty IN (1)", "name NOT IN ('x', NULL)", "empty LIKE '%'"]
    {
        assert!(!passes(filter), "{filter}");
    }
    assert!(passes("empty = 1 OR floors = 2") && passes("NOT (empty = 1 AND floors = 3)"));
}

#[test]
fn and_binds_tighter_than_or_and_not_tightest() {
    assert!(passes("floors = 2 OR floors = 3 AND floors = 4"));
    assert!(!passes("(floors = 2 OR floors = 3) AND floors = 4"));
    assert!(passes("NOT floors = 3 AND floors = 2"));
    let long = vec!["floors = 3"; 50_000].join(" OR ") + " OR floors = 2";
    assert!(passes(&long));
}

#[test]
fn faults_name_their_place() {
    for (filter, place) in [
        ("", 1),
        ("name", 5),
        ("name =", 7),
        ("= 3", 1),
        ("name = 'x", 8),
        ("(floors = 2", 12),
        ("floors = 2 height", 12),
        ("floors ! 2", 8),
        ("floors = 2x", 10),
        ("name LIKE 5", 11),
        ("name IN ()", 10),
        ("a IS 5", 6),
        ("a ; b", 3),
    ] {
        let error = Filter::parse(filter, Path::new("f")).unwrap_err().to_string();
        assert!(error.contains(&format!("character {place}:")), "{filter}: {error}");
    }
    let deep = format!("{}a = 1{}", "(".repeat(10_000), ")".repeat(10_000));
    assert!(Filter::parse(&deep, Path::new("f")).is_err());
}
