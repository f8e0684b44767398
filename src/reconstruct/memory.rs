//! What an editing session keeps of the road between solves: the answers of pure steps, each with all that was asked.
//!
//! The same question gets the same answer, so that a building comes out the same to the last bit, with a memory or without.
//! What an edit does not touch is asked the same again, and is not done again.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use geo::MultiPolygon;
use nalgebra::Point3;

use super::complex::Complex;
use super::labelling::LabellingParameters;
use super::primitives::{Detection, DetectionParameters};
use super::surface::SurfaceParameters;
use super::{Detected, Failure, Hypotheses, Parameters, Partitioned};
use crate::site::{Eaves, Ground, Site};

/// So many answers of each step are kept: those of the rounds of a few edits.
const KEPT: usize = 12;

/// What a session keeps of one building. It must be asked with the same field always.
#[derive(Debug, Default)]
pub struct Memory {
    detections: Recent<DetectionAsked, Arc<Detection>>,
    partitions: Recent<PartitionAsked, Result<Arc<Cells>, Failure>>,
    answers: Recent<(u64, bool), Arc<Vec<f64>>>,
}

/// How far a detection goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extent {
    /// To the planes as they are found.
    Found,
    /// To those that are merged and regularised.
    Refined,
}

/// All that a detection depends on.
#[derive(Debug, PartialEq)]
struct DetectionAsked {
    extent: Extent,
    points: Vec<Point3<f64>>,
    parameters: DetectionParameters,
    seed: u64,
}

/// All that the cells of a building depend on.
#[derive(Debug, PartialEq)]
struct PartitionAsked {
    id: String,
    footprint: Option<MultiPolygon<f64>>,
    points: Vec<Point3<f64>>,
    ground_points: Vec<Point3<f64>>,
    ground: Ground,
    eaves: Option<Eaves>,
    detected: Detected,
    parameters: Parameters,
}

/// The cells of a building, with a number of their own.
#[derive(Debug)]
struct Cells {
    number: u64,
    hypotheses: Hypotheses,
    complex: Complex,
    volumes: Vec<f64>,
    fixed: Vec<Option<bool>>,
}

impl Memory {
    /// The detection in some points, made by `detect` where it is not known.
    pub(super) fn detection(
        &self,
        extent: Extent,
        points: &[Point3<f64>],
        parameters: &Parameters,
        seed: u64,
        detect: impl FnOnce() -> Detection,
    ) -> Arc<Detection> {
        let parameters = &parameters.detection;
        let is_it = |asked: &DetectionAsked| {
            asked.extent == extent && asked.seed == seed && asked.parameters == *parameters && asked.points == points
        };
        let asked = || DetectionAsked { extent, points: points.to_vec(), parameters: parameters.clone(), seed };
        self.detections.get(is_it, asked, || Arc::new(detect()))
    }

    /// The cells of a building, made by `cut` where they are not known.
    pub(super) fn partition<'a>(
        &self,
        site: &'a Site,
        detected: &Detected,
        parameters: &Parameters,
        cut: impl FnOnce() -> Result<Partitioned<'a>, Failure>,
    ) -> Result<Partitioned<'a>, Failure> {
        // What comes after the cells is no matter of theirs.
        let parameters = Parameters {
            labelling: LabellingParameters::default(),
            surface: SurfaceParameters::default(),
            ..parameters.clone()
        };
        let is_it = |asked: &PartitionAsked| {
            asked.id == site.id
                && asked.ground == site.ground
                && asked.parameters == parameters
                && asked.footprint == site.footprint
                && asked.eaves == site.eaves
                && asked.points == site.points
                && asked.ground_points == site.ground_points
                && asked.detected == *detected
        };
        let asked = || PartitionAsked {
            id: site.id.clone(),
            footprint: site.footprint.clone(),
            points: site.points.clone(),
            ground_points: site.ground_points.clone(),
            ground: site.ground,
            eaves: site.eaves.clone(),
            detected: detected.clone(),
            parameters: parameters.clone(),
        };
        let cells = self.partitions.get(is_it, asked, || {
            let Partitioned { hypotheses, complex, volumes, fixed, .. } = cut()?;
            Ok(Arc::new(Cells { number: self.partitions.made(), hypotheses, complex, volumes, fixed }))
        })?;
        Ok(Partitioned {
            site,
            hypotheses: cells.hypotheses.clone(),
            complex: cells.complex.clone(),
            volumes: cells.volumes.clone(),
            fixed: cells.fixed.clone(),
            marked: Vec::new(),
            number: Some(cells.number),
        })
    }

    /// How much the cells of a building are inside by a field, asked by `ask` where it is not known.
    pub(super) fn answer<E>(
        &self,
        building: &Partitioned,
        is_height_field: bool,
        ask: impl FnOnce() -> Result<Vec<f64>, E>,
    ) -> Result<Vec<f64>, E> {
        let Some(number) = building.number else { return ask() };
        if let Some(known) = self.answers.find(|asked| *asked == (number, is_height_field)) {
            return Ok(known.to_vec());
        }
        let answer = ask()?;
        self.answers.keep((number, is_height_field), Arc::new(answer.clone()));
        Ok(answer)
    }
}

/// The latest answers of a step.
#[derive(Debug)]
struct Recent<K, V>(Mutex<Kept<K, V>>);

#[derive(Debug)]
struct Kept<K, V> {
    answers: VecDeque<(K, V)>,
    /// How many there have been.
    made: u64,
}

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self(Mutex::new(Kept { answers: VecDeque::new(), made: 0 }))
    }
}

impl<K, V: Clone> Recent<K, V> {
    /// The answer to the question that `is_it` knows; else it is made and kept, with the question.
    fn get(&self, is_it: impl Fn(&K) -> bool, asked: impl FnOnce() -> K, make: impl FnOnce() -> V) -> V {
        if let Some(known) = self.find(is_it) {
            return known;
        }
        let made = make();
        self.keep(asked(), made.clone());
        made
    }

    fn find(&self, is_it: impl Fn(&K) -> bool) -> Option<V> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = kept.answers.iter().position(|(asked, _)| is_it(asked))?;
        // The one that was asked for last is forgotten last.
        let found = kept.answers.remove(at)?;
        let answer = found.1.clone();
        kept.answers.push_back(found);
        Some(answer)
    }

    fn keep(&self, asked: K, answer: V) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.answers.len() >= KEPT {
            kept.answers.pop_front();
        }
        kept.answers.push_back((asked, answer));
        kept.made += 1;
    }

    fn made(&self) -> u64 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).made
    }
}
