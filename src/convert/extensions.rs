//! Extensions of older versions of CityJSON, which do not hold for the 2.0 that is written.
//!
//! The schema of an extension is made for one version; a file of another that declares it is invalid. So what only the
//! extension explains becomes what CityJSON itself explains, as far as it can.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use crate::sink::Feature;
use crate::source::cityjson::{CityModel, Geometry};

/// The version that is written.
const WRITTEN: &str = "2.0";
/// What an extension puts before the names of what it adds.
const MARK: char = '+';

/// What became of the extensions.
#[derive(Debug, Default)]
pub(super) struct Outdated {
    /// The types of objects that were left out, and how many.
    objects: BTreeMap<String, usize>,
    /// The types of surfaces that lost their label, and how many.
    surfaces: BTreeMap<String, usize>,
    /// The names of attributes and members that lost the mark.
    names: BTreeSet<String>,
}

/// Whether the extensions of a file of this version hold for what is written.
pub(super) fn hold(version: &str) -> bool {
    version.starts_with(WRITTEN)
}

impl Outdated {
    /// Makes of a model of an older version what needs no extension. Objects of types of their own are left to
    /// [`Self::leave_out`], which sees whole features.
    pub(super) fn take(&mut self, model: &mut CityModel) {
        if hold(&model.version) {
            return;
        }
        for object in &mut model.objects {
            self.unmark(&mut object.attributes);
            self.unmark(&mut object.members);
            for geometry in &mut object.geometries {
                self.relabel(geometry);
            }
        }
    }

    /// Takes the surfaces that only an extension knows out of a geometry; their faces lose their label.
    fn relabel(&mut self, geometry: &mut Geometry) {
        geometry.surfaces.iter_mut().for_each(|surface| self.unmark(&mut surface.attributes));
        if !geometry.surfaces.iter().any(|surface| surface.kind.starts_with(MARK)) {
            return;
        }
        let mut kept = 0;
        let places: Vec<Result<u32, String>> = geometry
            .surfaces
            .iter()
            .map(|surface| {
                if surface.kind.starts_with(MARK) {
                    return Err(surface.kind.clone());
                }
                kept += 1;
                Ok(kept - 1)
            })
            .collect();
        geometry.surfaces.retain(|surface| !surface.kind.starts_with(MARK));
        for face in geometry.shells.iter_mut().flat_map(|shell| &mut shell.faces) {
            match face.surface.and_then(|surface| places.get(surface as usize)) {
                Some(Ok(place)) => face.surface = Some(*place),
                Some(Err(kind)) => {
                    *self.surfaces.entry(kind.clone()).or_default() += 1;
                    face.surface = None;
                }
                None => {}
            }
        }
    }

    /// Leaves out the objects of a feature that only an extension of an older version knows, with all that hangs on them;
    /// whether anything is left.
    pub(super) fn leave_out(&mut self, feature: &mut Feature, version: &str) -> bool {
        if hold(version) {
            return true;
        }
        let mut gone: BTreeSet<String> = BTreeSet::new();
        // Children stand behind their parents or before: until nothing changes.
        loop {
            let before = gone.len();
            for object in &feature.objects {
                if object.kind.starts_with(MARK) || object.parents.iter().any(|parent| gone.contains(parent)) {
                    gone.insert(object.id.clone());
                }
            }
            if gone.len() == before {
                break;
            }
        }
        feature.objects.retain(|object| {
            let stays = !gone.contains(&object.id);
            if !stays {
                *self.objects.entry(object.kind.clone()).or_default() += 1;
            }
            stays
        });
        for object in &mut feature.objects {
            object.children.retain(|child| !gone.contains(child));
        }
        !gone.contains(&feature.id)
    }

    /// Takes the mark off the names of members, unless another has that name.
    fn unmark(&mut self, members: &mut Map<String, Value>) {
        if !members.keys().any(|name| name.starts_with(MARK)) {
            return;
        }
        let taken: BTreeSet<String> = members.keys().cloned().collect();
        *members = std::mem::take(members)
            .into_iter()
            .map(|(name, value)| match name.strip_prefix(MARK) {
                Some(plain) if !taken.contains(plain) => {
                    self.names.insert(name.clone());
                    (plain.to_owned(), value)
                }
                Some(plain) => {
                    self.names.insert(name.clone());
                    (format!("{plain}_extension"), value)
                }
                None => (name, value),
            })
            .collect();
    }

    /// What to tell the user.
    pub(super) fn messages(self) -> Vec<String> {
        let counted = |counts: &BTreeMap<String, usize>| {
            counts.iter().map(|(kind, n)| format!("{n} of type {kind}")).collect::<Vec<_>>().join(", ")
        };
        let mut messages = Vec::new();
        if !self.objects.is_empty() {
            let objects = counted(&self.objects);
            messages.push(format!("CityObjects that only an extension of an older CityJSON knows left out: {objects}"));
        }
        if !self.surfaces.is_empty() {
            let surfaces = counted(&self.surfaces);
            messages.push(format!("faces lose the labels of an extension of an older CityJSON: {surfaces}"));
        }
        if !self.names.is_empty() {
            let names: Vec<_> = self.names.into_iter().collect();
            messages
                .push(format!("attributes of extensions of an older CityJSON lose their {MARK}: {}", names.join(", ")));
        }
        messages
    }
}
