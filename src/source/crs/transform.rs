//! From the horizontal part of one CRS to that of another.

use super::Crs;
use super::proj_ffi::{Context, Grids, Kind, Object};

/// From this expected error on, in metres, a transformation comes with a warning: footprints and points that lie
/// further apart than a decimetre disagree by more than their own accuracy.
pub(super) const WARN_FROM_METRES: f64 = 0.1;

/// Takes x and y of one CRS to x and y of another, always in this order (longitude before latitude, in degrees).
///
/// Heights are not touched. It belongs to the thread that made it.
pub struct Transformer {
    /// `None` when the horizontal parts are the same.
    operation: Option<Object>,
    accuracy: Option<f64>,
    warning: Option<String>,
}

impl Transformer {
    /// The best transformation that can be carried out here; `extent` (min x, min y, max x, max y, in units of `from`)
    /// says where it must hold.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(from: &Crs, to: &Crs, extent: Option<[f64; 4]>) -> Result<Self, String> {
        let identity = Self { operation: None, accuracy: Some(0.0), warning: None };
        if from == to {
            return Ok(identity);
        }
        let context = Context::new()?;
        let source = horizontal(Object::from_wkt(&context, &from.wkt)?).ok_or_else(|| no_horizontal(from))?;
        let target = horizontal(Object::from_wkt(&context, &to.wkt)?).ok_or_else(|| no_horizontal(to))?;
        if source.is_equivalent(&target) {
            return Ok(identity);
        }
        let area = extent.and_then(|extent| degrees(&source, extent));
        let trial = extent.map(corners_and_centre).unwrap_or_default();
        let usable = source
            .operations_to(&target, area, Grids::Installed)
            .into_iter()
            .find_map(|found| normalized_if_usable(&found, &trial).map(|operation| (found, operation)));
        let Some((found, operation)) = usable else {
            return Err(format!("PROJ knows no transformation from {from} to {to} that holds for these coordinates"));
        };
        let accuracy = if found.is_ballpark() { None } else { found.accuracy() };
        let warning = accuracy.is_none_or(|metres| metres > WARN_FROM_METRES).then(|| {
            let best = source.operations_to(&target, area, Grids::AnyKnown).into_iter().next();
            inaccuracy(from, to, accuracy, found.is_ballpark(), best.as_ref())
        });
        Ok(Self { operation: Some(operation), accuracy, warning })
    }

    /// Whether coordinates stay as they are.
    pub fn is_identity(&self) -> bool {
        self.operation.is_none()
    }

    /// The expected error in metres; `None` when nobody knows it.
    pub fn accuracy(&self) -> Option<f64> {
        self.accuracy
    }

    /// What the user must know of the accuracy; `None` when it is a decimetre or better.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Transforms points in place; what cannot be transformed becomes infinite.
    pub fn transform(&self, points: &mut [[f64; 2]]) {
        if let Some(operation) = &self.operation {
            operation.transform(points);
        }
    }
}

/// See [`Crs::is_same_horizontally`].
pub(super) fn is_same_horizontally(a: &Crs, b: &Crs) -> bool {
    let Ok(context) = Context::new() else { return false };
    let part = |crs: &Crs| horizontal(Object::from_wkt(&context, &crs.wkt).ok()?);
    matches!((part(a), part(b)), (Some(a), Some(b)) if a.is_equivalent(&b))
}

/// The two-dimensional part of a CRS.
pub(super) fn horizontal(crs: Object) -> Option<Object> {
    match crs.kind() {
        Kind::Compound => horizontal(crs.sub_crs(0)?),
        Kind::Bound => Some(crs),
        _ => crs.demoted_to_2d(),
    }
}

fn no_horizontal(crs: &Crs) -> String {
    format!("{crs} has no horizontal part")
}

fn normalized_if_usable(operation: &Object, trial: &[[f64; 2]]) -> Option<Object> {
    let normalized = operation.normalized()?;
    let mut points = trial.to_vec();
    normalized.transform(&mut points);
    points.iter().flatten().all(|c| c.is_finite()).then_some(normalized)
}

fn corners_and_centre([x0, y0, x1, y1]: [f64; 4]) -> Vec<[f64; 2]> {
    vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1], [f64::midpoint(x0, x1), f64::midpoint(y0, y1)]]
}

/// West, south, east, north of an extent, by the geographic CRS beneath: near enough to choose an operation by area.
pub(super) fn degrees(crs: &Object, extent: [f64; 4]) -> Option<[f64; 4]> {
    let geographic = match crs.kind() {
        Kind::Bound => crs.source_crs()?.geodetic_crs()?,
        _ => crs.geodetic_crs()?,
    };
    let mut points = corners_and_centre(extent);
    if !matches!(crs.kind(), Kind::Geographic2D | Kind::Geographic3D) {
        let inverse = crs.operations_to(&geographic, None, Grids::Installed);
        inverse.first()?.normalized()?.transform(&mut points);
    }
    let bounds = points.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, p| {
        [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])]
    });
    let holds = bounds[0] >= -180.0 && bounds[1] >= -90.0 && bounds[2] <= 180.0 && bounds[3] <= 90.0;
    holds.then_some(bounds)
}

fn inaccuracy(from: &Crs, to: &Crs, accuracy: Option<f64>, is_ballpark: bool, best: Option<&Object>) -> String {
    let error = match accuracy {
        Some(metres) => format!("is expected to be off by up to {metres} m"),
        None if is_ballpark => "leaves out the shift between the datums and may be off by hundreds of metres".into(),
        None => "has an unknown accuracy".into(),
    };
    let remedy = best
        .filter(|best| {
            !best.is_ballpark() && best.accuracy().is_some_and(|better| accuracy.is_none_or(|have| better < have))
        })
        .and_then(|best| {
            let missing: Vec<_> = best.grids().into_iter().filter(|g| !g.is_available).map(|g| g.name).collect();
            let better = best.accuracy().unwrap_or_default();
            (!missing.is_empty()).then(|| format!(" for want of the grid {} (then {better} m)", missing.join(", ")))
        })
        .unwrap_or_default();
    format!(
        "the horizontal transformation from {from} to {to} {error}{remedy}; give footprints in the CRS of the points where this matters"
    )
}
