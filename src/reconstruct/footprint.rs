//! The footprint as a solid can stand on it: without holes that are noise, and nowhere touching itself.

use std::borrow::Cow;

use geo::{Area, BooleanOps, Euclidean, Length, LineString, MultiPolygon, Polygon, Rect, coord};

use super::blocks;
use crate::site::Site;

/// Holes smaller than this are noise of drawing, square metres …
const SMALLEST_HOLE: f64 = 0.05;
/// … and so are holes that are narrower than this on the whole, metres: no shaft and no gap is.
const NARROWEST_HOLE: f64 = 0.05;
/// Half the width of the gap that parts what touches at a point, metres.
const GAP: f64 = 0.02;

/// The site without the holes of its footprint that are noise of drawing. What was done is told in `notes`.
pub(super) fn without_slivers<'a>(site: &'a Site, notes: &mut Vec<String>) -> Cow<'a, Site> {
    let holes = |site: &Site| site.footprint.iter().flatten().map(|polygon| polygon.interiors().len()).sum::<usize>();
    if !site.footprint.iter().flatten().flat_map(Polygon::interiors).any(is_noise) {
        return Cow::Borrowed(site);
    }
    let mut closed = site.clone();
    for polygon in closed.footprint.iter_mut().flatten() {
        let kept = polygon.interiors().iter().filter(|hole| !is_noise(hole)).cloned().collect();
        *polygon = Polygon::new(polygon.exterior().clone(), kept);
    }
    let count = holes(site) - holes(&closed);
    notes.push(format!("{count} hole(s) of the footprint are slivers, smaller than a shaft or a gap: closed"));
    Cow::Owned(closed)
}

/// Whether a hole is noise of drawing.
fn is_noise(hole: &LineString<f64>) -> bool {
    let area = Polygon::new(hole.clone(), Vec::new()).unsigned_area();
    area < SMALLEST_HOLE || 2.0 * area < NARROWEST_HOLE * Euclidean.length(hole)
}

/// The site with gaps of a few centimetres where its footprint touches itself at a point.
///
/// The simple-feature rules let rings touch. Extruded, the point becomes an edge with four walls, which no valid shell
/// has: to get rid of it the surface would give up a whole cell, which may be a tenth of the building. `step` is the size of
/// a grid step in metres.
pub(super) fn parted(site: &Site, step: [f64; 3]) -> Cow<'_, Site> {
    let Some(footprint) = &site.footprint else { return Cow::Borrowed(site) };
    let around =
        |[x, y]: [f64; 2]| Rect::new(coord! { x: x - GAP, y: y - GAP }, coord! { x: x + GAP, y: y + GAP }).to_polygon();
    let gaps: Vec<Polygon<f64>> = blocks::touches(footprint, step).into_iter().map(around).collect();
    if gaps.is_empty() {
        return Cow::Borrowed(site);
    }
    let parted: MultiPolygon<f64> = footprint.difference(&geo::unary_union(&gaps));
    if parted.0.is_empty() {
        return Cow::Borrowed(site);
    }
    Cow::Owned(site.clone().with_footprint(&parted))
}

#[cfg(test)]
mod tests {
    use geo::{Validation, polygon};
    use nalgebra::Point3;

    use super::*;
    use crate::site::Frame;

    fn site(polygon: Polygon<f64>) -> Site {
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        Site::new("a", frame, vec![Point3::new(5.0, 5.0, 5.0)], 0.0).with_footprint(&MultiPolygon(vec![polygon]))
    }

    #[test]
    fn slivers_are_closed_and_shafts_stay() {
        let site = site(polygon!(
            exterior: [(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 8.0), (x: 0.0, y: 8.0)],
            interiors: [
                // A shaft, a speck, and a sliver 9 m long that is 18 mm wide at most.
                [(x: 1.0, y: 1.0), (x: 1.0, y: 1.6), (x: 1.6, y: 1.6), (x: 1.6, y: 1.0)],
                [(x: 5.0, y: 5.0), (x: 5.1, y: 5.1), (x: 5.2, y: 5.0)],
                [(x: 0.5, y: 7.0), (x: 9.5, y: 7.0), (x: 5.0, y: 7.018)],
            ],
        ));
        let mut notes = Vec::new();
        let closed = without_slivers(&site, &mut notes).into_owned();
        let holes = |site: &Site| site.footprint.as_ref().unwrap().0[0].interiors().to_vec();
        assert_eq!(holes(&closed), holes(&site)[..1]);
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(notes[0].starts_with("2 hole(s)"), "{notes:?}");
        assert!(matches!(without_slivers(&closed, &mut notes), Cow::Borrowed(_)));
    }

    #[test]
    fn what_touches_at_a_point_is_parted() {
        // A hole that touches the outline, and two that touch each other.
        let site = site(polygon!(
            exterior: [(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 8.0), (x: 0.0, y: 8.0)],
            interiors: [
                [(x: 0.0, y: 4.0), (x: 3.0, y: 6.0), (x: 3.0, y: 2.0)],
                [(x: 6.0, y: 4.0), (x: 7.0, y: 5.0), (x: 7.0, y: 3.0)],
                [(x: 6.0, y: 4.0), (x: 5.0, y: 3.0), (x: 5.0, y: 5.0)],
            ],
        ));
        assert!(site.footprint.as_ref().unwrap().is_valid());
        let parted = parted(&site, site.frame.step()).into_owned();
        let footprint = parted.footprint.as_ref().unwrap();
        assert!(footprint.is_valid() && (footprint.unsigned_area() - 72.0).abs() < 0.01, "{footprint:?}");
        assert_eq!((footprint.0.len(), footprint.0[0].interiors().len()), (1, 1));
        assert!(matches!(super::parted(&parted, parted.frame.step()), Cow::Borrowed(_)));
    }
}
