//! How much a building needs a person, and why.

use serde_json::{Map, Value};

use super::Figures;
use crate::building::Reason;
use crate::sink::own;

/// Areas smaller than this that are missing or in excess are within what the method does not see, square metres.
const UNSEEN_AREA: f64 = 2.0;
/// A confidence from here on needs nobody.
const SURE: f64 = 0.7;
/// Points are within this of a sound model, metres, root mean square.
const LARGE_RMSE: f64 = 0.25;

/// How much a building needs a person: 0 where it needs none.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Need {
    pub urgency: f64,
    /// Why, the most urgent first.
    pub why: Vec<String>,
}

/// What is known of a model of a building, whoever tells.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Condition {
    pub lod: String,
    pub rmse: Option<f64>,
    pub missing: Option<f64>,
    pub excess: Option<f64>,
    pub confidence: Option<f64>,
    pub faces: Option<usize>,
    /// Why LoD 2.2 of the whole building was not reached: as a keyword, and in words.
    pub failure: Option<(String, String)>,
    /// val3dity codes of what is wrong with it.
    pub codes: Vec<u64>,
    /// How many edits do not apply.
    pub refused: u64,
}

impl Condition {
    /// What the attributes of a model say.
    pub fn of_attributes(attributes: &Map<String, Value>, prefix: &str, faces: usize) -> Self {
        let get = |name: &str| own(attributes, prefix, name);
        let number = |name: &str| get(name).and_then(Value::as_f64);
        let text = |name: &str| get(name).and_then(Value::as_str).unwrap_or_default().to_owned();
        let reason = text("fallback_reason");
        let codes = get("validity_lod22").and_then(Value::as_array);
        Self {
            lod: text("lod"),
            rmse: number("rmse_lod22"),
            missing: number("missing_area"),
            excess: number("excess_area"),
            confidence: number("confidence"),
            faces: Some(faces),
            failure: (!reason.is_empty()).then(|| (reason, text("fallback_detail"))),
            codes: codes.into_iter().flatten().filter_map(Value::as_u64).collect(),
            refused: get("edits_refused").and_then(Value::as_u64).unwrap_or(0),
        }
    }

    /// What a solve says.
    pub fn of_figures(figures: &Figures, reason: Option<Reason>, refused: usize) -> Self {
        let keyword = reason.and_then(|reason| serde_json::to_value(reason).ok());
        let keyword = keyword.as_ref().and_then(Value::as_str).unwrap_or_default().to_owned();
        Self {
            lod: figures.lod.to_owned(),
            rmse: figures.rmse,
            missing: figures.missing,
            excess: figures.excess,
            confidence: figures.confidence,
            faces: Some(figures.faces),
            failure: figures.failure.clone().map(|detail| (keyword, detail)),
            codes: Vec::new(),
            refused: refused as u64,
        }
    }

    /// How much that needs a person.
    pub fn need(&self) -> Need {
        let mut reasons: Vec<(f64, String)> = Vec::new();
        if let Some((keyword, detail)) = &self.failure {
            reasons.push((weight(keyword), format!("no LoD 2.2: {detail}")));
        } else if !self.codes.is_empty() {
            let codes: Vec<String> = self.codes.iter().map(u64::to_string).collect();
            reasons.push((8.0, format!("invalid: {}", codes.join(", "))));
        }
        if self.refused > 0 {
            reasons.push((5.0, format!("{} edit(s) do not apply", self.refused)));
        }
        let area = |area: Option<f64>, what: &str, reasons: &mut Vec<(f64, String)>| {
            if let Some(area) = area.filter(|area| *area >= UNSEEN_AREA) {
                reasons.push(((area / 4.0).min(8.0), format!("{what} {area:.0} m²")));
            }
        };
        area(self.missing, "missing part", &mut reasons);
        area(self.excess, "excess part", &mut reasons);
        if let Some(confidence) = self.confidence.filter(|confidence| *confidence < SURE) {
            reasons.push((10.0 * (SURE - confidence), format!("confidence {confidence:.2}")));
        }
        if let Some(rmse) = self.rmse.filter(|rmse| *rmse > LARGE_RMSE) {
            reasons.push((((rmse - LARGE_RMSE) * 10.0).min(8.0), format!("RMSE {rmse:.2} m")));
        }
        reasons.sort_by(|a, b| b.0.total_cmp(&a.0));
        let urgency = reasons.iter().map(|(weight, _)| weight).sum::<f64>();
        Need { urgency: (urgency * 100.0).round() / 100.0, why: reasons.into_iter().map(|(_, why)| why).collect() }
    }
}

/// How much a building without LoD 2.2 needs a person: little where nobody could do much about it.
fn weight(keyword: &str) -> f64 {
    match keyword {
        "no-points" | "outdated" | "open-ground" | "no-polygon" => 0.5,
        "as-asked" | "low-density" | "missing-data" | "incomplete" | "too-few-points" | "too-low" => 2.0,
        _ => 10.0,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn of(attributes: &Value) -> Need {
        Condition::of_attributes(attributes.as_object().unwrap(), "gable_", 10).need()
    }

    #[test]
    fn what_is_sound_needs_nobody_and_the_worst_needs_most() {
        let sound = json!({
            "gable_lod": "2.2", "gable_rmse_lod22": 0.1, "gable_missing_area": 0.5, "gable_confidence": 0.95,
            "gable_validity_lod22": [],
        });
        assert_eq!(of(&sound), Need::default());
        let missing = of(&json!({ "gable_missing_area": 12.2, "gable_confidence": 0.31 }));
        assert_eq!(missing.why, ["confidence 0.31", "missing part 12 m²"]);
        let block =
            of(&json!({ "gable_fallback_reason": "worse-than-block", "gable_fallback_detail": "it fits worse" }));
        assert_eq!(block.why, ["no LoD 2.2: it fits worse"]);
        let unseen = of(&json!({ "gable_fallback_reason": "no-points", "gable_fallback_detail": "nothing" }));
        assert!(block.urgency > missing.urgency && missing.urgency > unseen.urgency && unseen.urgency > 0.0);
        assert!(of(&json!({ "gable_rmse_lod22": 0.6 })).why[0].contains("RMSE 0.60"));
        assert!(of(&json!({ "gable_validity_lod22": [203] })).why[0].contains("invalid: 203"));
    }
}
