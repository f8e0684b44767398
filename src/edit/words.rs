//! Edits in words, for the list of what was done.

use crate::edits::{Action, Lie, Region};

/// What an edit does, in a few words.
pub(super) fn words(action: &Action) -> String {
    match action {
        Action::SwitchPlane { on: true, .. } => "Plane switched on".to_owned(),
        Action::SwitchPlane { on: false, .. } => "Plane switched off".to_owned(),
        Action::AddPlane { places, lie, unseen } => {
            let lies = lie.as_ref().map_or(String::new(), |lie| format!(", {}", lying(lie)));
            let seen = if *unseen { ", that was not scanned" } else { "" };
            format!("Plane added through {} places{lies}{seen}", places.len())
        }
        Action::AlignPlane { lie, .. } => format!("Plane made {}", lying(lie)),
        Action::MovePlane { .. } => "Plane moved".to_owned(),
        Action::MarkPlace { inside: true, .. } => "Place marked inside".to_owned(),
        Action::MarkPlace { inside: false, .. } => "Place marked outside".to_owned(),
        Action::SetFloor { height } => format!("Floor set to {height:.2}"),
        Action::SetParameters { lambda, minimum_feature } => {
            let lambda = lambda.map(|lambda| format!("λ {lambda}"));
            let feature = minimum_feature.map(|feature| format!("smallest feature {feature} m"));
            let both: Vec<String> = lambda.into_iter().chain(feature).collect();
            if both.is_empty() { "No parameter set".to_owned() } else { format!("Own {}", both.join(", ")) }
        }
        Action::ExcludePoints { region } => match region {
            Region::Near { places, radius } => format!("Points within {radius} m of {} places left out", places.len()),
            Region::Box { .. } => "Points in a box left out".to_owned(),
            Region::Polygon { ring, .. } => format!("Points over a polygon of {} corners left out", ring.len()),
        },
        Action::RedrawFootprint { .. } => "Footprint redrawn".to_owned(),
        Action::OffsetEdge { distance, .. } => {
            let way = if *distance < 0.0 { "inwards" } else { "outwards" };
            format!("Edge moved {:.2} m {way}", distance.abs())
        }
        Action::SplitParts { .. } => "Split in parts".to_owned(),
        Action::MergeParts { gap } => format!("Parts closer than {gap} m merged"),
    }
}

fn lying(lie: &Lie) -> &'static str {
    match lie {
        Lie::Level => "level",
        Lie::Vertical => "vertical",
        Lie::Parallel(_) => "parallel to another",
    }
}
