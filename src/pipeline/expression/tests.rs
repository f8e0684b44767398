use std::sync::Arc;

use super::*;
use crate::pipeline::points::{Column, Layout, NumberType};

/// Points with X = 0, 1, 2, … and a class.
fn points(classes: &[u8]) -> Points {
    let mut layout = Layout::default();
    layout.add("Classification", NumberType::U8);
    let x: Vec<f64> = (0..classes.len()).map(|i| i as f64).collect();
    let zeros = Column::zeros(NumberType::F64, classes.len());
    let columns = vec![Column::F64(x), zeros.clone(), zeros, Column::U8(classes.to_vec())];
    Points::of_columns(Arc::new(layout), columns, None)
}

fn chosen(expression: &str, classes: &[u8]) -> Vec<usize> {
    let points = points(classes);
    let condition = Condition::parse(expression).unwrap().bind(points.layout()).unwrap();
    (0..points.len()).filter(|&i| condition.holds(&points, i)).collect()
}

#[test]
fn conditions_choose_points() {
    let classes = [1, 2, 6, 2, 6, 9];
    assert_eq!(chosen("Classification == 6", &classes), [2, 4]);
    assert_eq!(chosen("classification==6", &classes), [2, 4]);
    assert_eq!(chosen("Classification != 2 && X >= 2", &classes), [2, 4, 5]);
    // && binds more tightly than ||, comparisons more tightly than both.
    assert_eq!(chosen("Classification == 1 || Classification == 6 && X > 2", &classes), [0, 4]);
    assert_eq!(chosen("(Classification == 1 || Classification == 6) && X > 2", &classes), [4]);
    assert_eq!(chosen("!(Classification == 2) && !(X < 3)", &classes), [4, 5]);
    // * binds more tightly than +, and - is left-associative: 10 - 4 - 3 = 3.
    assert_eq!(chosen("X + 1 * 2 == 5", &classes), [3]);
    assert_eq!(chosen("10 - 4 - 3 == X", &classes), [3]);
    assert_eq!(chosen("X / 2 == 2", &classes), [4]);
    assert_eq!(chosen("X == -1e0 + 1.5e+0 * 2", &classes), [2]);
    assert_eq!(chosen("-X < -4", &classes), [5]);
}

#[test]
fn assignments_have_a_value_and_perhaps_a_condition() {
    let assignment = Assignment::parse("Red = Red / 256").unwrap();
    assert_eq!((assignment.dimension.as_str(), assignment.condition), ("Red", None));
    let assignment = Assignment::parse("Classification = 2 where X<5").unwrap();
    assert_eq!(assignment.value, Number::Constant(2.0));
    assert_eq!(assignment.condition, Condition::parse("X < 5").ok());
    for bad in ["", "Red", "Red == 2", "= 2", "Red = X > 2", "Red = 2 WHERE", "Red = 2 WHERE X", "Red = 2 3"] {
        assert!(Assignment::parse(bad).is_err(), "{bad}");
    }
}

#[test]
fn what_cannot_be_meant_is_told_with_its_place() {
    let misfit = |text: &str| Condition::parse(text).unwrap_err();
    assert_eq!(misfit("Z > 1 & X < 2").found, "`&` at character 7");
    assert_eq!(misfit("(Z > 1").found, "the end of the expression");
    assert_eq!(misfit("(Z > 1) && X").found, "a number at character 12");
    assert_eq!(misfit("(Z > 1) + 2 > 3").found, "a condition at character 1");
    assert_eq!(misfit("Z > 1 Z").found, "`Z` at character 7");
    assert_eq!(misfit("Z > 1.2.3").found, "`1.2.3` at character 5");
    assert!(misfit(&"(".repeat(100_000)).found.contains("parentheses"));
    assert!(Condition::parse("").is_err());

    let layout = points(&[1]).layout().clone();
    let missing = Condition::parse("Clasification == 2").unwrap().bind(&layout).unwrap_err();
    assert!(
        missing.found.contains("`Clasification`") && missing.expected.starts_with("`Classification`"),
        "{missing:?}"
    );
}
