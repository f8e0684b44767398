//! Edits: what a person has decided about a building, on the road that every building takes.
//!
//! - `site`: points that are none of the building, its floor, its footprint, parameters of its own.
//! - `outline`: what is done to a footprint.
//! - `planes`: planes that are switched off, added, turned and moved, right after detection.
//! - `marks`: cells that are inside or outside, once it is known which cells there are.
//!
//! An edit that no longer applies is left out and told in the [`Tally`]; it never stops the others.

mod marks;
mod outline;
mod planes;
mod site;

use std::borrow::Cow;
use std::collections::BTreeMap;

use nalgebra::{Point3, Unit, Vector3};

pub(super) use outline::parts;
pub(super) use site::{of_site, parameters};

use super::Parameters;
use super::complex::REACH;
use crate::building::{EditTally, RefusedEdit};
use crate::edits::{Edit, Place};
use crate::geometry::Plane;
use crate::site::{Frame, Site};

/// What became of the edits of a building, by their places in its list: nothing where they apply, else why not.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Tally(BTreeMap<usize, Option<String>>);

impl Tally {
    /// Notes what became of an edit.
    fn note(&mut self, index: usize, outcome: Result<(), String>) {
        self.0.insert(index, outcome.err());
    }

    /// Takes over what is noted in another.
    pub(super) fn merge(&mut self, other: &Self) {
        self.0.extend(other.0.iter().map(|(index, why)| (*index, why.clone())));
    }

    /// What is told of the edits of a site; `None` where it has none. Those that the method did not get to apply as little as
    /// those that were refused.
    pub(super) fn told(&self, site: &Site) -> Option<EditTally> {
        if site.edits.is_empty() {
            return None;
        }
        let mut told = EditTally::default();
        for (index, edit) in site.edits.iter().enumerate() {
            let why = match self.0.get(&index) {
                Some(None) => {
                    told.applied += 1;
                    continue;
                }
                Some(Some(why)) => why.clone(),
                None => "the method did not get so far".to_owned(),
            };
            told.refused.push(RefusedEdit { number: index + 1, action: edit.action.name().to_owned(), why });
        }
        Some(told)
    }
}

/// The edits of a site that `pick` takes, each with its place in the list.
fn picked<'a, T: 'a>(
    edits: &'a [Edit],
    pick: impl Fn(&'a Edit) -> Option<T> + 'a,
) -> impl Iterator<Item = (usize, T)> + 'a {
    edits.iter().enumerate().filter_map(move |(index, edit)| Some((index, pick(edit)?)))
}

/// A place in the local frame.
fn local(frame: &Frame, place: Place) -> Result<Point3<f64>, String> {
    let p = frame.to_local(place);
    let is_near = p.iter().all(|c| c.abs() <= REACH);
    is_near.then_some(p).ok_or_else(|| {
        let [x, y, z] = place;
        format!("the place ({x}, {y}, {z}) is more than {REACH} m from the building")
    })
}

/// A plane in the local frame from its equation in the CRS, its normal as given.
fn plane(frame: &Frame, [a, b, c, d]: [f64; 4]) -> Result<Plane, String> {
    // a x + b y + c z + d = 0 with x = origin + local / metres.
    let normal = Vector3::new(a, b, c);
    let offset = d + normal.dot(&Vector3::from(frame.origin));
    let normal = normal.component_div(&Vector3::from(frame.metres_per_unit));
    let (unit, length) = Unit::try_new_and_get(normal, 1e-12)
        .ok_or_else(|| format!("the equation [{a}, {b}, {c}, {d}] is that of no plane"))?;
    let plane = Plane { normal: unit, offset: offset / length };
    // Numbers that are too large have no length.
    let is_near = plane.offset.abs() <= REACH && length.is_finite();
    is_near.then_some(plane).ok_or_else(|| format!("the plane lies more than {REACH} m from the building"))
}

/// A site as its edits make it, without the points that are none of it and in its own footprint, and the parameters that it
/// is made by: what the method starts from.
pub fn as_edited<'a>(site: &'a Site, of_all: &'a Parameters) -> (Cow<'a, Site>, Cow<'a, Parameters>) {
    (of_site(site, &mut Tally::default()), parameters(site, of_all))
}

/// The equation in the CRS of a plane of the local frame: what `plane` takes.
pub fn equation(frame: &Frame, plane: &Plane) -> [f64; 4] {
    let normal = plane.normal.component_mul(&Vector3::from(frame.metres_per_unit));
    let offset = plane.offset - normal.dot(&Vector3::from(frame.origin));
    [normal.x, normal.y, normal.z, offset]
}

#[cfg(test)]
mod tests;
