//! What of a footprint a solid may stand on: not on open ground, and not where nobody looked.

use std::borrow::Cow;

use geo::{Area, BooleanOps, Euclidean, Length, MultiPolygon};

use super::open_ground::open_ground;
use super::{Failure, OpenGround, Parameters, Partial, as_block};
use crate::building::Reason;
use crate::geometry::PreparedPolygon;
use crate::site::Site;

/// What is cut off a footprint and holds fewer building points is none of the building.
const FEWEST_POINTS: usize = 3;
/// Nor is what is smaller than this, square metres.
const SMALLEST: f64 = 1.0;
/// What is thinner than this, metres, is left over by rounding.
const THINNEST: f64 = 0.02;

/// A site with a footprint of which the solid may take all.
#[derive(Debug)]
pub(super) struct Standing<'a> {
    /// The site; its footprint is the part that stands.
    pub site: Cow<'a, Site>,
    /// Open ground in the footprint, square metres; `None` without a footprint or ground points to tell.
    pub open_ground: Option<f64>,
    /// Whether a part was cut off because the tiles do not cover it.
    pub is_partial: bool,
}

impl<'a> Standing<'a> {
    /// Takes off what the parameters say, and says whether anything is left. What was found is told in `notes`.
    pub fn new(site: &'a Site, parameters: &Parameters, notes: &mut Vec<String>) -> (Self, Result<(), Failure>) {
        let mut standing = Self { site: Cow::Borrowed(site), open_ground: None, is_partial: false };
        let Some(footprint) = &site.footprint else { return (standing, Ok(())) };
        let mut rest = Cow::Borrowed(footprint);
        let is_glass = parameters.glass_attribute.as_deref().is_some_and(|name| as_block::is_on(site, name));
        if is_glass && !site.ground_points.is_empty() {
            // The laser goes through glass: ground that was seen is no proof of open sky.
            notes.push("its roof is of glass: what was scanned of the ground inside it is left out".to_owned());
            standing.site = Cow::Owned(Site { ground_points: Vec::new(), ..site.clone() });
        } else if !site.ground_points.is_empty() && !site.points.is_empty() {
            let open = open_ground(site, parameters.open_ground_area);
            // Of many corners it costs much.
            let area = if open.0.is_empty() { 0.0 } else { footprint.intersection(&open).unsigned_area() };
            standing.open_ground = Some(area);
            let carve = parameters.open_ground == OpenGround::Carve;
            if area > 0.0 {
                let done = if carve { "no solid stands there" } else { "built over all the same, as was asked for" };
                notes.push(format!("{area:.0} m² of the footprint are open ground: {done}"));
            }
            if area > 0.0 && carve {
                rest = Cow::Owned(without_scraps(footprint.difference(&open), site));
            }
        }
        if rest.0.is_empty() {
            let failure = Failure::new(Reason::OpenGround, "the footprint is open ground, nothing stands on it");
            standing.site = Cow::Owned(site.clone().with_footprint(&rest));
            return (standing, Err(failure));
        }
        if let Some(covered) = &site.covered {
            let covered = rest.intersection(covered);
            standing.is_partial = true;
            if !covered.0.is_empty() && parameters.partial == Partial::Covered {
                rest = Cow::Owned(covered);
            }
        }
        if let Cow::Owned(rest) = rest {
            standing.site = Cow::Owned(standing.site.into_owned().with_footprint(&rest));
        }
        (standing, Ok(()))
    }
}

/// The parts that are of the building: large enough, and with points on them.
fn without_scraps(mut parts: MultiPolygon<f64>, site: &Site) -> MultiPolygon<f64> {
    parts.0.retain(|part| {
        let part = MultiPolygon(vec![part.clone()]);
        let around: f64 = part.iter().map(|p| Euclidean.length(p.exterior())).sum();
        let prepared = PreparedPolygon::new(&part);
        let area = part.unsigned_area();
        let points = site.points.iter().filter(|p| prepared.contains([p.x, p.y]));
        area >= SMALLEST && 2.0 * area > THINNEST * around && points.take(FEWEST_POINTS).count() == FEWEST_POINTS
    });
    parts
}
