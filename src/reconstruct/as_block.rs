//! Which buildings become blocks although more might be made of their points: because the user says so, or because there
//! are too few of them.

use serde_json::Value;

use super::{Failure, Parameters, area, density};
use crate::building::{Measures, Reason};
use crate::site::Site;

/// Why a building is to be a block before anything is made of its points; `None` where it is not. What its solid may stand
/// on is the footprint of `standing`.
pub(super) fn asked(site: &Site, standing: &Site, parameters: &Parameters) -> Option<Failure> {
    if let Some(name) = parameters.block_attribute.as_deref().filter(|name| is_on(site, name)) {
        return Some(Failure::new(Reason::AsAsked, format!("the attribute {name:?} asks for a block")));
    }
    let area = area(site.footprint.as_ref())?;
    if let Some(most) = parameters.block_above.filter(|most| area > *most) {
        let detail =
            format!("the footprint has {area:.0} m², more than the {most} m² above which a block was asked for");
        return Some(Failure::new(Reason::AsAsked, detail));
    }
    let density = density(standing)?;
    (density < parameters.minimum_density).then(|| {
        let detail = format!("{density:.2} points per square metre, fewer than {}", parameters.minimum_density);
        Failure::new(Reason::LowDensity, detail)
    })
}

/// Refuses a building of which too much was not scanned.
pub(super) fn check(measures: &Measures, parameters: &Parameters) -> Result<(), Failure> {
    match measures.no_data_share {
        Some(share) if share > parameters.maximum_no_data => {
            let [share, most] = [share, parameters.maximum_no_data].map(|share| 100.0 * share);
            let detail =
                format!("{share:.0} % of the footprint are farther than 1 m from any point, more than {most:.0} %");
            Err(Failure::new(Reason::MissingData, detail))
        }
        _ => Ok(()),
    }
}

/// Whether an attribute of a footprint is true, yes, or a number other than 0.
pub(super) fn is_on(site: &Site, name: &str) -> bool {
    let attributes = &site.attributes;
    let any_case = || attributes.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value);
    match attributes.get(name).or_else(any_case) {
        Some(Value::Bool(is_on)) => *is_on,
        Some(Value::Number(number)) => number.as_f64().is_some_and(|number| number != 0.0),
        Some(Value::String(text)) => match text.trim().to_ascii_lowercase().as_str() {
            "true" | "yes" | "t" | "y" => true,
            text => text.parse::<f64>().is_ok_and(|number| number.is_finite() && number != 0.0),
        },
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use geo::{MultiPolygon, polygon};
    use nalgebra::Point3;
    use serde_json::json;

    use super::super::{occupancy::HeightField, reconstruct};
    use super::*;
    use crate::building::{Building, Outcome};
    use crate::site::Frame;

    /// A gable of 10 m by 8 m with 4 points per square metre west of `until`.
    fn gable(until: f64, parameters: &Parameters, attribute: Value) -> Building {
        let place = |i: u32| (0.25 + 0.5 * f64::from(i % 20), 0.25 + 0.5 * f64::from(i / 20));
        let places = (0..20 * 16).map(place).filter(|(x, _)| *x < until);
        let points = places.map(|(x, y)| Point3::new(x, y, 8.0 - (y - 4.0).abs())).collect();
        let footprint = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 8.0), (x: 0.0, y: 8.0)];
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let mut site = Site::new("gable", frame, points, 0.0).with_footprint(&MultiPolygon(vec![footprint]));
        site.attributes.insert("Block".to_owned(), attribute);
        reconstruct(&site, parameters, &HeightField)
    }

    fn reason(building: &Building) -> Option<Reason> {
        let is_block = matches!(building.outcome, Outcome::Lod12 { .. }) && building.model.lod12().count() == 1;
        building.outcome.reason().filter(|_| is_block).map(|(reason, _)| reason)
    }

    #[test]
    fn a_building_is_a_block_where_the_user_says_so() {
        let parameters = Parameters { block_attribute: Some("block".to_owned()), ..Parameters::default() };
        for on in [json!(true), json!(1), json!("Yes"), json!("1"), json!(-2.5)] {
            assert_eq!(reason(&gable(10.0, &parameters, on.clone())), Some(Reason::AsAsked), "{on}");
        }
        for off in [json!(false), json!(0), json!("no"), json!(""), json!(null), json!([1])] {
            assert_eq!(gable(10.0, &parameters, off.clone()).outcome, Outcome::Lod22, "{off}");
        }
        let above = |area| Parameters { block_above: Some(area), ..Parameters::default() };
        assert_eq!(reason(&gable(10.0, &above(79.0), json!(null))), Some(Reason::AsAsked));
        assert_eq!(gable(10.0, &above(80.0), json!(null)).outcome, Outcome::Lod22);
        // The block is the one that every building has beside its roof.
        let [asked, usual] = [above(79.0), above(80.0)].map(|parameters| gable(10.0, &parameters, json!(null)));
        let block = |building: &Building| building.model.lod12().cloned().collect::<Vec<_>>();
        assert_eq!(block(&asked), block(&usual));
        assert_eq!(asked.measures.setbacks.len(), 1, "nothing coarser is tried");
    }

    #[test]
    fn a_building_is_a_block_where_it_was_hardly_scanned() {
        let least = |minimum_density| Parameters { minimum_density, ..Parameters::default() };
        assert_eq!(reason(&gable(10.0, &least(4.1), json!(null))), Some(Reason::LowDensity));
        assert_eq!(gable(10.0, &least(4.0), json!(null)).outcome, Outcome::Lod22);
        let most = |maximum_no_data| Parameters { maximum_no_data, ..Parameters::default() };
        let half = gable(5.0, &most(0.3), json!(null));
        assert_eq!(reason(&half), Some(Reason::MissingData));
        assert!(half.measures.no_data_share.is_some_and(|share| (0.35..0.45).contains(&share)));
        assert_ne!(reason(&gable(5.0, &most(0.5), json!(null))), Some(Reason::MissingData));
    }
}
