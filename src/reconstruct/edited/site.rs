//! What edits do to a site before anything is made of it, and to the parameters.

use std::borrow::Cow;

use geo::{BooleanOps, LineString, MultiPolygon, Polygon};
use nalgebra::Point3;

use super::{Tally, local, outline, picked};
use crate::edits::{Action, Region};
use crate::geometry::PreparedPolygon;
use crate::reconstruct::Parameters;
use crate::reconstruct::complex::REACH;
use crate::site::{Frame, Ground, GroundSource, Site};

/// The site as its edits make it: without the points that are none of it, on its floor, in its footprint.
pub fn of_site<'a>(site: &'a Site, tally: &mut Tally) -> Cow<'a, Site> {
    if site.edits.is_empty() {
        return Cow::Borrowed(site);
    }
    let mut edited = site.clone();
    for (index, edit) in site.edits.iter().enumerate() {
        let outcome = match &edit.action {
            Action::ExcludePoints { region } => exclude(&mut edited, region),
            Action::SetFloor { height } => stand(&mut edited, *height),
            Action::RedrawFootprint { polygons } => {
                outline::redrawn(&edited.frame, polygons).and_then(|footprint| redraw(&mut edited, &footprint))
            }
            Action::OffsetEdge { edge, distance } => {
                outline::offset(&edited, *edge, *distance).and_then(|footprint| redraw(&mut edited, &footprint))
            }
            Action::MergeParts { gap } => {
                outline::merged(&edited, *gap).and_then(|footprint| redraw(&mut edited, &footprint))
            }
            Action::SetParameters { lambda, minimum_feature } => check_parameters(*lambda, *minimum_feature),
            _ => continue,
        };
        tally.note(index, outcome);
    }
    Cow::Owned(edited)
}

/// The parameters of a building: those of all, but for what its edits say.
pub fn parameters<'a>(site: &Site, parameters: &'a Parameters) -> Cow<'a, Parameters> {
    let own = picked(&site.edits, |edit| match &edit.action {
        Action::SetParameters { lambda, minimum_feature } => {
            check_parameters(*lambda, *minimum_feature).is_ok().then_some((*lambda, *minimum_feature))
        }
        _ => None,
    });
    own.fold(Cow::Borrowed(parameters), |mut parameters, (_, (lambda, minimum_feature))| {
        let own = parameters.to_mut();
        own.labelling.lambda = lambda.unwrap_or(own.labelling.lambda);
        own.surface.minimum_feature = minimum_feature.unwrap_or(own.surface.minimum_feature);
        parameters
    })
}

/// The largest λ and smallest feature that mean anything.
const MOST: f64 = 1e3;

fn check_parameters(lambda: Option<f64>, minimum_feature: Option<f64>) -> Result<(), String> {
    let is_fine = |value: &f64| (0.0..=MOST).contains(value);
    match [("lambda", lambda), ("minimum-feature", minimum_feature)] {
        [(_, None), (_, None)] => Err("it sets no parameter: lambda or minimum-feature is expected".to_owned()),
        both => both
            .iter()
            .find_map(|(name, value)| value.filter(|value| !is_fine(value)).map(|value| (name, value)))
            .map_or(Ok(()), |(name, value)| Err(format!("{name} is {value}, a number from 0 to {MOST} is expected"))),
    }
}

/// Lets the building stand on a floor at a height of the CRS.
fn stand(site: &mut Site, height: f64) -> Result<(), String> {
    let floor = site.frame.to_local([site.frame.origin[0], site.frame.origin[1], height]).z;
    if floor.is_nan() || floor.abs() > REACH {
        return Err(format!("the floor at {height} is more than {REACH} m from the building"));
    }
    site.ground = Ground { height: floor, source: GroundSource::Edit, ..site.ground };
    Ok(())
}

/// Takes the points of a region away.
fn exclude(site: &mut Site, region: &Region) -> Result<(), String> {
    let is_in = within(&site.frame, region)?;
    let before = site.points.len();
    site.points.retain(|p| !is_in(p));
    if let Some(eaves) = &mut site.eaves {
        eaves.points.retain(|p| !is_in(p));
    }
    if site.points.len() < before { Ok(()) } else { Err("no point of the building lies there".to_owned()) }
}

/// Whether it is so of a point.
type Is = Box<dyn Fn(&Point3<f64>) -> bool>;

/// Whether a point is in a region.
fn within(frame: &Frame, region: &Region) -> Result<Is, String> {
    Ok(match region {
        Region::Near { places, radius } => {
            let radius = *radius;
            if radius.is_nan() || radius <= 0.0 {
                return Err(format!("a radius of {radius} m, more than 0 is expected"));
            }
            let places = places.iter().map(|place| local(frame, *place)).collect::<Result<Vec<_>, _>>()?;
            Box::new(move |p| places.iter().any(|place| (place - p).norm_squared() <= radius * radius))
        }
        Region::Box { min, max } => {
            let (min, max) = (frame.to_local(*min), frame.to_local(*max));
            Box::new(move |p| (0..3).all(|axis| min[axis] <= p[axis] && p[axis] <= max[axis]))
        }
        Region::Polygon { ring, heights } => {
            if ring.len() < 3 {
                return Err(format!("a polygon of {} corners, at least 3 are expected", ring.len()));
            }
            let ring =
                ring.iter().map(|[x, y]| local(frame, [*x, *y, frame.origin[2]])).collect::<Result<Vec<_>, _>>()?;
            let ring: LineString<f64> = ring.iter().map(|p| (p.x, p.y)).collect();
            let prepared = PreparedPolygon::new(&MultiPolygon(vec![Polygon::new(ring, Vec::new())]));
            let at = |height: f64| (height - frame.origin[2]) * frame.metres_per_unit[2];
            let heights = heights.map(|heights| heights.map(at));
            let is_between = move |z: f64| heights.is_none_or(|[low, high]| low <= z && z <= high);
            Box::new(move |p| is_between(p.z) && prepared.contains([p.x, p.y]))
        }
    })
}

/// Gives the site another footprint. Points beyond it are none of the building any more.
fn redraw(site: &mut Site, footprint: &MultiPolygon<f64>) -> Result<(), String> {
    let prepared = PreparedPolygon::new(footprint);
    if !site.points.iter().any(|p| prepared.contains([p.x, p.y])) && !site.points.is_empty() {
        return Err("no point of the building lies in the footprint as it would be".to_owned());
    }
    site.points.retain(|p| prepared.contains([p.x, p.y]));
    site.ground_points.retain(|p| prepared.contains([p.x, p.y]));
    if let Some(covered) = &site.covered {
        site.covered = Some(covered.intersection(footprint));
    }
    *site = site.clone().with_footprint(footprint);
    Ok(())
}
