//! Real buildings with one thing wrong: the right code is found.

use std::sync::LazyLock;

use proptest::prelude::*;

use super::{NONE, codes, turn};
use crate::site::Frame;
use crate::solid::{Face, Solid};
use crate::source::cityjson;
use crate::validate::{composite, solid};

/// The LoD 1.2 to 2.2 solids of the bundled 3DBAG buildings, on a grid of a tenth of a millimetre.
static BUILDINGS: LazyLock<Vec<Solid>> = LazyLock::new(|| {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data/reference_3dbag_lod22.city.jsonl");
    let model = cityjson::read(path.as_ref()).unwrap();
    let frame = Frame { origin: model.vertices[0].map(f64::floor), metres_per_unit: [1.0; 3] };
    let solids = model.objects.iter().flat_map(|object| &object.geometries);
    solids.filter(|g| g.kind == cityjson::GeometryKind::Solid).map(|g| model.solid(g, &frame).unwrap()).collect()
});

fn building() -> impl Strategy<Value = Solid> {
    any::<prop::sample::Index>().prop_map(|index| index.get(&BUILDINGS).clone())
}

/// By how much something is moved: 5 cm to 1 m along each axis, in steps.
fn shift() -> impl Strategy<Value = [i64; 3]> {
    prop::array::uniform3((500..10_000i64, any::<bool>()).prop_map(|(by, back)| if back { -by } else { by }))
}

fn moved(solid: &Solid, by: [i64; 3]) -> Solid {
    let mut moved = solid.clone();
    moved.vertices.iter_mut().for_each(|v| (0..3).for_each(|i| v[i] += by[i]));
    moved
}

/// How far a vertex of a face is off the plane of the others, metres: by their vector area, which is another route than
/// the least squares of the check.
fn off_plane(solid: &Solid, face: &Face, vertex: u32) -> f64 {
    let rest: Vec<u32> = face.rings[0].iter().copied().filter(|&v| v != vertex).collect();
    let Some(normal) = solid.newell(&rest).try_normalize(0.0) else { return 0.0 };
    normal.dot(&(solid.point(vertex) - solid.point(rest[0]))).abs()
}

#[test]
fn the_buildings_are_sound() {
    assert_eq!(BUILDINGS.len(), 33);
    assert!(BUILDINGS.iter().all(|building| codes(building) == NONE));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn a_vertex_moved(building in building(), vertex in any::<prop::sample::Index>(), by in shift()) {
        let mut faulty = building;
        let vertex = vertex.index(faulty.vertices.len());
        (0..3).for_each(|i| faulty.vertices[vertex][i] += by[i]);
        let vertex = vertex as u32;
        let bent = |face: &&Face| face.rings[0].contains(&vertex) && face.rings[0].len() > 3 && face.rings.len() == 1;
        // Least squares spread the distance over all vertices of the face.
        let farthest = faulty.faces.iter().filter(bent).map(|face| off_plane(&faulty, face, vertex)).fold(0.0, f64::max);
        let found = codes(&faulty);
        if farthest > 0.04 {
            prop_assert!(found.contains(&203) || found.contains(&104), "{found:?}, off by {farthest}");
        }
        prop_assert!(found.iter().all(|c| ![301, 302, 305, 307].contains(c)), "{found:?}");
    }

    #[test]
    fn a_corner_of_a_face_moved(building in building(), face in any::<prop::sample::Index>(), by in shift()) {
        let mut faulty = building;
        let at = face.index(faulty.faces.len());
        let corner = faulty.faces[at].rings[0][0] as usize;
        faulty.faces[at].rings[0][0] = faulty.vertices.len() as u32;
        faulty.vertices.push(std::array::from_fn(|i| faulty.vertices[corner][i] + by[i]));
        prop_assert!(codes(&faulty).contains(&302));
    }

    #[test]
    fn a_face_dropped(building in building(), face in any::<prop::sample::Index>()) {
        let mut faulty = building;
        faulty.faces.remove(face.index(faulty.faces.len()));
        prop_assert_eq!(codes(&faulty), [302]);
    }

    #[test]
    fn a_face_flipped(building in building(), face in any::<prop::sample::Index>()) {
        let mut faulty = building;
        let at = face.index(faulty.faces.len());
        faulty.faces[at].rings.iter_mut().for_each(|ring| ring.reverse());
        prop_assert_eq!(codes(&faulty), [307]);
    }

    #[test]
    fn a_face_doubled(building in building(), face in any::<prop::sample::Index>()) {
        let mut faulty = building;
        let at = face.index(faulty.faces.len());
        faulty.faces.push(faulty.faces[at].clone());
        prop_assert_eq!(codes(&faulty), [303, 306]);
    }

    #[test]
    fn a_ring_reversed(building in building(), face in any::<prop::sample::Index>()) {
        let mut faulty = building;
        let at = face.index(faulty.faces.len());
        faulty.faces[at].rings[0].reverse();
        let expected = if faulty.faces[at].rings.len() > 1 { 208 } else { 307 };
        prop_assert!(codes(&faulty).contains(&expected));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn two_shells_overlapped(building in building(), by in shift()) {
        let other = moved(&building, by);
        let mut void = other.clone();
        turn(&mut void);
        let found = solid::check_voids(&[building.clone(), void]);
        prop_assert_eq!(found.iter().map(|f| f.fault.code).collect::<Vec<_>>(), [401]);

        let parts = composite::check_parts(std::slice::from_ref(&building), std::slice::from_ref(&other), 0.001);
        prop_assert!(parts.is_some_and(|overlap| overlap.depth > 0.001));

        let mut both = building;
        let base = both.vertices.len() as u32;
        both.vertices.extend(other.vertices);
        both.faces.extend(other.faces.into_iter().map(|mut face| {
            face.rings.iter_mut().flatten().for_each(|v| *v += base);
            face
        }));
        let found = codes(&both);
        prop_assert!(found.contains(&306), "{found:?}");
    }
}
