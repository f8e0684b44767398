//! Crafted solids and their codes: what is common to them, and the rules that go across.

mod mutations;
mod prisms;
mod rings;
mod shells;
mod solids;

use super::*;
use crate::solid::Face;

/// A solid of single-ring faces unless more rings are given; coordinates in centimetres.
fn solid(vertices: &[[i64; 3]], faces: &[&[&[u32]]]) -> Solid {
    Solid {
        step: [1e-4; 3],
        vertices: vertices.iter().map(|v| v.map(|c| c * 100)).collect(),
        faces: faces
            .iter()
            .map(|rings| Face { rings: rings.iter().map(|r| r.to_vec()).collect(), surface: 0 })
            .collect(),
        surfaces: Vec::new(),
    }
}

const CUBE: [[i64; 3]; 8] =
    [[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0], [0, 0, 100], [100, 0, 100], [100, 100, 100], [0, 100, 100]];
const CUBE_FACES: [&[&[u32]]; 6] =
    [&[&[3, 2, 1, 0]], &[&[4, 5, 6, 7]], &[&[0, 1, 5, 4]], &[&[1, 2, 6, 5]], &[&[2, 3, 7, 6]], &[&[3, 0, 4, 7]]];

fn cube() -> Solid {
    solid(&CUBE, &CUBE_FACES)
}

/// A block with a vertical shaft through it: vertices 8 to 15 are the shaft's, bottom then top.
fn courtyard() -> Solid {
    let mut vertices = CUBE.to_vec();
    for z in [0, 100] {
        vertices.extend([[30, 30, z], [70, 30, z], [70, 70, z], [30, 70, z]]);
    }
    let mut faces: Vec<&[&[u32]]> = CUBE_FACES.to_vec();
    faces[0] = &[&[3, 2, 1, 0], &[8, 9, 10, 11]];
    faces[1] = &[&[4, 5, 6, 7], &[15, 14, 13, 12]];
    let walls: [&[&[u32]]; 4] = [&[&[9, 8, 12, 13]], &[&[10, 9, 13, 14]], &[&[11, 10, 14, 15]], &[&[8, 11, 15, 12]]];
    faces.extend(walls);
    solid(&vertices, &faces)
}

const NONE: [u16; 0] = [];

fn codes(solid: &Solid) -> Vec<u16> {
    let mut codes: Vec<u16> = check(solid, &Tolerances::default()).iter().map(|f| f.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

/// A face alone: only the codes of rings and polygons.
fn face_codes(vertices: &[[i64; 3]], rings: &[&[u32]]) -> Vec<u16> {
    codes(&solid(vertices, &[rings])).into_iter().filter(|c| *c < 300).collect()
}

#[test]
fn sound_solids_have_no_faults() {
    assert_eq!(check(&cube(), &Tolerances::default()), []);
    assert_eq!(check(&courtyard(), &Tolerances::default()), []);
    assert!((courtyard().volume() - 0.84).abs() < 1e-12);
}

#[test]
fn the_walk_stops_where_it_is_told_to() {
    let tolerances = Tolerances::default();
    assert!(is_valid(&cube(), &tolerances) && first_fault(&cube(), &tolerances).is_none());
    let mut faulty = cube();
    faulty.faces[5].rings[0].truncate(2);
    faulty.faces[1].rings[0].truncate(2);
    let all = check(&faulty, &tolerances);
    assert!(all.len() > 2 && !is_valid(&faulty, &tolerances));
    assert_eq!(first_fault(&faulty, &tolerances), Some(all[0].clone()));
    assert_eq!(all[0].place, Place::Ring(1, 0));
}

#[test]
fn surfaces_may_be_open_but_not_torn() {
    let codes = |solid: &Solid, claim| {
        let mut codes = Vec::new();
        let _ = visit(solid, claim, &Tolerances::default(), &mut |fault| {
            codes.push(fault.code);
            ControlFlow::Continue(())
        });
        codes
    };
    let mut open = cube();
    open.faces.truncate(3);
    // Floor and ceiling hang together by the wall.
    assert_eq!((codes(&open, Claim::Surface), codes(&open, Claim::Faces)), (vec![], vec![]));
    open.faces.truncate(2);
    assert_eq!((codes(&open, Claim::Surface), codes(&open, Claim::Faces)), (vec![305], vec![]));
    let mut flipped = cube();
    flipped.faces.truncate(3);
    flipped.faces[2].rings[0].reverse();
    assert_eq!(codes(&flipped, Claim::Surface), [307, 307]);
}

/// A box in centimetres; the faces of a void look into it.
fn block(from: [i64; 3], to: [i64; 3], void: bool) -> Solid {
    let corners = CUBE.map(|v| std::array::from_fn(|i| if v[i] == 0 { from[i] } else { to[i] }));
    let mut block = solid(&corners, &CUBE_FACES);
    if void {
        turn(&mut block);
    }
    block
}

fn turn(solid: &mut Solid) {
    solid.faces.iter_mut().flat_map(|f| &mut f.rings).for_each(|ring| ring.reverse());
}

#[test]
fn labels_801_to_805() {
    use crate::solid::SurfaceType::{Ground, OuterCeiling, Roof, Wall};
    use semantics::Label;
    let known = |kinds: [crate::solid::SurfaceType; 6]| kinds.map(Label::Known);
    let codes = |shell: &Solid, labels: &[Label]| {
        let mut shell = shell.clone();
        shell.faces.iter_mut().zip(0..).for_each(|(face, i)| face.surface = i);
        let label = |face: &Face| labels.get(face.surface as usize).copied().unwrap_or(Label::Known(Wall));
        let faults = semantics::check(&shell, label);
        faults.into_iter().chain(semantics::check_ground(&shell, label)).map(|f| f.code).collect::<Vec<_>>()
    };
    let right = known([Ground, Roof, Wall, Wall, Wall, Wall]);
    assert_eq!(codes(&cube(), &right), NONE);
    assert_eq!(codes(&courtyard(), &right), NONE);
    let mut labels = right;
    labels[3] = Label::None;
    assert_eq!(codes(&cube(), &labels), [801]);
    labels[3] = Label::Other;
    assert_eq!(codes(&cube(), &labels), NONE);
    assert_eq!(codes(&cube(), &known([Ground, Roof, Roof, Wall, Wall, Wall])), [802]);
    assert_eq!(codes(&cube(), &known([Roof, Roof, Wall, Wall, Wall, Wall])), [802]);
    assert_eq!(codes(&cube(), &known([Wall, Roof, Wall, Wall, Wall, Wall])), [803]);
    assert_eq!(codes(&cube(), &known([OuterCeiling, Roof, Wall, Wall, Wall, Wall])), NONE);
    assert_eq!(codes(&cube(), &known([Ground, OuterCeiling, Wall, Wall, Wall, Wall])), [804]);
    assert_eq!(codes(&cube(), &known([Ground, Roof, Wall, Ground, Wall, Wall])), [804]);
    // A bridge: two feet on the ground, a ceiling between them.
    let profile = [[0, 0], [30, 0], [30, 50], [70, 50], [70, 0], [100, 0], [100, 90], [0, 90]];
    let mut vertices = Vec::new();
    for y in [0, 50] {
        vertices.extend(profile.map(|[x, z]| [x, y, z]));
    }
    let sides: Vec<Vec<u32>> = (0..8).map(|i| vec![(i + 1) % 8, i, i + 8, (i + 1) % 8 + 8]).collect();
    let mut bridge = solid(&vertices, &[&[&[0, 1, 2, 3, 4, 5, 6, 7]], &[&[15, 14, 13, 12, 11, 10, 9, 8]]]);
    bridge.faces.extend(sides.into_iter().map(|ring| Face { rings: vec![ring], surface: 0 }));
    assert_eq!(check(&bridge, &Tolerances::default()), []);
    let [g, c, r, w] = [Ground, OuterCeiling, Roof, Wall].map(Label::Known);
    assert_eq!(codes(&bridge, &[w, w, g, w, c, w, g, w, r, w]), [805]);
    assert_eq!(codes(&bridge, &[w, w, c, w, c, w, g, w, r, w]), NONE);
}
