//! Whether the labels of the faces say what the faces are: codes 801 to 805, gable's own.

use nalgebra::Vector3;

use super::predicates::edges;
use super::{Fault, Place};
use crate::solid::{Face, Solid, SurfaceType};

/// A face whose unit normal rises or falls by less than this stands: 80° of slope, where roofs end and walls begin.
const STANDS: f64 = 0.173_648;
/// A roof faces up up to this slope, 89°: some makers label steep parts of a roof as roof.
const FACES_UP: f64 = 0.017_452;

/// The faults of the labels of a sound shell that looks outwards: 801 a face has none, 802 a roof does not face up, 803 a wall
/// does not stand, 804 a ground or an outer ceiling does not face down.
///
/// What the rounding of the vertices may have turned is given the benefit of the doubt.
pub fn check(shell: &Solid, label: impl Fn(&Face) -> Label) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (face, f) in shell.faces.iter().zip(0..) {
        let kind = match label(face) {
            Label::None => {
                faults.push(Fault::new(801, Place::Face(f), "the face has no label"));
                continue;
            }
            Label::Other => continue,
            Label::Known(kind) => kind,
        };
        let Some((up, doubt)) = rise(shell, face) else { continue };
        let degrees = up.clamp(-1.0, 1.0).acos().to_degrees();
        let fault = match kind {
            SurfaceType::Roof if up < FACES_UP - doubt => {
                (802, format!("the roof does not face up: it looks {degrees:.0}° from upwards"))
            }
            SurfaceType::Wall if up.abs() > STANDS + doubt => {
                (803, format!("the wall does not stand: it looks {degrees:.0}° from upwards"))
            }
            SurfaceType::Ground if up > -STANDS + doubt => {
                (804, format!("the ground does not face down: {degrees:.0}° from upwards"))
            }
            SurfaceType::OuterCeiling if up > doubt => {
                (804, format!("the outer ceiling does not face down: {degrees:.0}° from upwards"))
            }
            _ => continue,
        };
        faults.push(Fault::new(fault.0, Place::Face(f), fault.1));
    }
    faults
}

/// What is known of a face from its label.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// There is none.
    None,
    /// One that says nothing of where the face looks.
    Other,
    /// One that does.
    Known(SurfaceType),
}

/// The vertical part of the unit normal of a face, and how much of it may be rounding: vertices are off by half a step, and
/// a face of area A and circumference l turns by about l · step / 2A.
fn rise(shell: &Solid, face: &Face) -> Option<(f64, f64)> {
    let twice: Vector3<f64> = face.rings.iter().map(|ring| shell.newell(ring)).sum();
    let normal = twice.try_normalize(0.0)?;
    let around: f64 =
        face.rings.iter().flat_map(|ring| edges(ring)).map(|(a, b)| (shell.point(a) - shell.point(b)).norm()).sum();
    let step = shell.step.iter().fold(0.0f64, |m, s| m.max(*s));
    Some((normal.z, around * step / twice.norm()))
}

/// 805 if the ground faces of a shell are in several pieces, which must hang together by edges.
pub fn check_ground(shell: &Solid, label: impl Fn(&Face) -> Label) -> Option<Fault> {
    let is_ground = |face: &Face| label(face) == Label::Known(SurfaceType::Ground);
    let grounds: Vec<&Face> = shell.faces.iter().filter(|face| is_ground(face)).collect();
    let place = |v: u32| shell.vertices.get(v as usize).copied().unwrap_or_default();
    let mut sides: Vec<([[i64; 3]; 2], usize)> = Vec::new();
    for (i, face) in grounds.iter().enumerate() {
        for (a, b) in face.rings.iter().flat_map(|ring| edges(ring)) {
            let (a, b) = (place(a), place(b));
            sides.push(([a.min(b), a.max(b)], i));
        }
    }
    sides.sort_unstable();
    let mut set: Vec<usize> = (0..grounds.len()).collect();
    let root = |set: &[usize], mut i: usize| {
        while set[i] != i {
            i = set[i];
        }
        i
    };
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (a, b) = (root(&set, pair[0].1), root(&set, pair[1].1));
        set[a.max(b)] = a.min(b);
    }
    let pieces = (0..set.len()).filter(|&i| set[i] == i).count();
    (pieces > 1).then(|| Fault::new(805, Place::Solid, format!("the ground is in {pieces} pieces; it must be one")))
}
