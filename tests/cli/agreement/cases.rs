//! The table.

use serde_json::{Value, json};

use super::body::{Body, house, parts, solid, solid_of, solids, surface, template, with_voids};

/// A kind of fault.
pub struct Case {
    /// The file of val3dity's tests that has it, or what it is.
    pub name: &'static str,
    /// The same kind of fault in a house.
    pub model: Value,
    /// The codes of val3dity 2.6 by its default tolerances.
    pub val3dity: &'static [u16],
    /// The codes of gable by its own.
    pub gable: &'static [u16],
    /// Why gable says something else than val3dity even by its rules; empty where it does not.
    pub why: &'static str,
}

fn case(name: &'static str, model: Value, val3dity: &'static [u16], gable: &'static [u16]) -> Case {
    Case { name, model, val3dity, gable, why: "" }
}

fn differs(name: &'static str, model: Value, codes: [&'static [u16]; 2], why: &'static str) -> Case {
    Case { name, model, val3dity: codes[0], gable: codes[1], why }
}

/// All of them.
pub fn cases() -> Vec<Case> {
    [rings(), polygons(), shells(), voids(), composites(), files()].into_iter().flatten().collect()
}

/// The tip of a pyramid within the house, over a floor of three.
fn void(tip: [f64; 3]) -> Body {
    Body::tetrahedron([[2.0, 2.0, 1.0], [8.0, 2.0, 1.0], [5.0, 6.0, 1.0], tip])
}

/// The roof with one hole.
fn holed(hole: &[[f64; 3]]) -> Body {
    let ring: Vec<usize> = (8..8 + hole.len()).collect();
    house().and(hole).with(1, &[&[4, 5, 6, 7], &ring])
}

fn rings() -> Vec<Case> {
    let half = [[10.0, 4.0, 0.0], [10.0, 4.0, 6.0]];
    vec![
        case("101", solid(house().with(1, &[&[4, 5]])), &[101], &[101, 302]),
        case("102", solid(house().with(2, &[&[0, 1, 1, 5, 4]])), &[102], &[102]),
        case("104", solid(house().with(0, &[&[0, 3, 1, 2]])), &[104], &[104, 302, 307]),
        // Over one corner twice, and back along an edge.
        case(
            "104_2",
            solid(
                house()
                    .and(&half)
                    .with(0, &[&[0, 3, 2, 8, 1]])
                    .with(1, &[&[4, 5, 9, 6, 7]])
                    .with(3, &[&[5, 1, 8, 2, 8, 9, 6]]),
            ),
            &[104],
            &[104, 302, 307],
        ),
        case("104_3", solid(house().with(1, &[&[6, 7, 4, 5, 7]])), &[104], &[104, 302]),
        case(
            "104_flat",
            solid(house().and(&[[5.0, 0.0, 0.0]]).with(2, &[&[0, 8, 1, 5, 4]]).plus(&[&[0, 1, 8]])),
            &[104],
            &[104],
        ),
    ]
}

fn polygons() -> Vec<Case> {
    let hole = [[2.0, 2.0, 6.0], [2.0, 6.0, 6.0], [8.0, 6.0, 6.0], [8.0, 2.0, 6.0]];
    let turned: Vec<[f64; 3]> = hole.into_iter().rev().collect();
    // A fold across the roof: up by a millimetre and down again within two.
    let folded = |by: f64| {
        house()
            .and(&[[10.0, 3.999, 6.0 + by], [10.0, 4.001, 6.0 - by], [0.0, 4.001, 6.0 - by], [0.0, 3.999, 6.0 + by]])
            .with(1, &[&[4, 5, 8, 9, 6, 7, 10, 11]])
            .with(3, &[&[1, 2, 6, 9, 8, 5]])
            .with(5, &[&[3, 0, 4, 11, 10, 7]])
    };
    // A ridge so low that the roof may be one face.
    let ridged = |height: f64| {
        house()
            .and(&[[5.0, 0.0, 6.0 + height], [5.0, 8.0, 6.0 + height]])
            .with(1, &[&[4, 8, 5, 6, 9, 7]])
            .with(2, &[&[0, 1, 5, 8, 4]])
            .with(4, &[&[2, 3, 7, 9, 6]])
    };
    let twisted = Body {
        vertices: vec![[0.0, 0.0, 0.0], [-3.0, 0.0, 0.0], [-1.5, -6.0, 9.0], [-2.0, -1.0, 9.0]],
        faces: vec![vec![vec![0, 1, 2, 3]]],
    };
    let second = |more: &[[f64; 3]]| {
        let rings: [Vec<usize>; 2] = [(8..12).collect(), (12..12 + more.len()).collect()];
        house().and(&hole).and(more).with(1, &[&[4, 5, 6, 7], &rings[0], &rings[1]])
    };
    vec![
        case("201", solid(second(&[[7.0, 3.0, 6.0], [7.0, 5.0, 6.0], [9.0, 4.0, 6.0]])), &[201], &[201, 302]),
        case(
            "201_1",
            surface("MultiSurface", &holed(&[[8.0, 2.0, 6.0], [8.0, 6.0, 6.0], [14.0, 4.0, 6.0]])),
            &[201],
            &[201],
        ),
        differs(
            "202",
            solid(second(&hole)),
            [&[201], &[202, 307]],
            "a ring that is there twice is that, and no intersection",
        ),
        case("203", solid(ridged(1.5)), &[203], &[203]),
        case("203_2", solid(ridged(0.1)), &[203], &[203]),
        // One of its edges stands upright on the projection in which most of it is seen.
        case("203 of a twisted face", surface("MultiSurface", &twisted), &[203], &[203]),
        case("203 between 1 mm and 1 cm", solid(ridged(0.01)), &[], &[203]),
        case("204_1", solid(folded(0.000_9)), &[204], &[204]),
        case("204_valid_1", solid(ridged(0.001)), &[], &[]),
        case("204_valid_2", solid(ridged(-0.001)), &[], &[]),
        case(
            "205",
            surface(
                "MultiSurface",
                &house()
                    .and(&[[2.0, 1.6, 6.0], [8.0, 1.6, 6.0], [5.0, 4.0, 6.0]])
                    .with(1, &[&[4, 5, 6, 7], &[4, 8, 9], &[9, 10, 6]]),
            ),
            &[205],
            &[205],
        ),
        case("206", solid(holed(&hole.map(|[x, y, z]| [x + 10.0, y, z]))), &[206], &[206, 302]),
        case(
            "206_1",
            solid(holed(&[[12.0, 0.0, 6.0], [10.0, 5.0, 6.0], [16.0, 5.0, 6.0], [18.0, 0.0, 6.0]])),
            &[206],
            &[206, 302],
        ),
        case("207", solid(second(&[[4.0, 3.0, 6.0], [4.0, 5.0, 6.0], [6.0, 4.0, 6.0]])), &[207], &[207, 302]),
        case("208", solid(holed(&turned)), &[208], &[208, 302]),
    ]
}

fn shells() -> Vec<Case> {
    let beyond = Body::block([10.0, 8.0, 6.0], [15.0, 12.0, 9.0]);
    // A shaft from floor to roof that touches a wall along a line.
    let shaft = {
        let plan = [[3.0, 2.0], [10.0, 4.0], [5.0, 6.0]];
        let corners: Vec<[f64; 3]> = [0.0, 6.0].into_iter().flat_map(|z| plan.map(|[x, y]| [x, y, z])).collect();
        house()
            .and(&corners)
            .with(0, &[&[0, 3, 2, 9, 1], &[8, 9, 10]])
            .with(1, &[&[4, 5, 12, 6, 7], &[11, 13, 12]])
            .with(3, &[&[1, 9, 2, 6, 12, 5]])
            .plus(&[&[10, 9, 12, 13]])
            .plus(&[&[8, 10, 13, 11]])
            .plus(&[&[9, 8, 11, 12]])
    };
    let dented = |depth: f64| {
        let dented = house().and(&[[5.0, 4.0, 6.0 - depth]]).with(1, &[&[4, 5, 8]]);
        dented.plus(&[&[5, 6, 8]]).plus(&[&[6, 7, 8]]).plus(&[&[7, 4, 8]])
    };
    let outer = Body { vertices: house().vertices, faces: Vec::new() };
    vec![
        case("301", solid(outer.clone().plus(&[&[0, 3, 2, 1]]).plus(&[&[0, 1, 2, 3]])), &[301], &[301, 306]),
        case(
            "301_1",
            solid(outer.plus(&[&[0, 3, 2, 1]]).plus(&[&[4, 5, 6, 7]]).plus(&[&[0, 1, 5, 4]])),
            &[301],
            &[301, 302],
        ),
        case("302", solid(house().without(0)), &[302], &[302]),
        case("302_1", solid(holed(&[[2.0, 2.0, 6.0], [2.0, 6.0, 6.0], [8.0, 6.0, 6.0]])), &[302], &[302]),
        case(
            "303",
            solid(house().and(&[[15.0, 12.0, 3.0], [15.0, 16.0, 5.0]]).plus(&[&[2, 8, 9]])),
            &[303],
            &[302, 303],
        ),
        case("303_1", solid(house().joined(&beyond)), &[303], &[303]),
        case("303_2", solid(shaft), &[303], &[303]),
        case("304_1", solid(house().plus(&[&[3, 1, 5, 7]])), &[303], &[302, 303]),
        case("303_cs", surface("CompositeSurface", &house().plus(&[&[3, 1, 5, 7]])), &[303], &[303]),
        case(
            "305",
            solid(house().and(&[[15.0; 3], [18.0, 15.0, 16.0], [15.0, 18.0, 17.0]]).plus(&[&[8, 9, 10]])),
            &[305],
            &[302, 305],
        ),
        case("305_1", solid(house().joined(&house().moved([0.0, 0.0, 20.0]))), &[305], &[305]),
        case("306", solid(dented(9.0)), &[306], &[306]),
        case("306_1", solid(dented(6.0)), &[306], &[306]),
        differs(
            "307",
            solid(house().with(0, &[&[0, 1, 2, 3]])),
            [&[303, 307], &[307]],
            "edges that two faces use the same way are told as 307 alone",
        ),
        case("405", solid(house().turned()), &[405], &[405]),
    ]
}

fn voids() -> Vec<Case> {
    let inside = || void([5.0, 4.0, 5.0]);
    // The top of a void from a fifth of its height on, as a void of its own that touches the walls along their lines.
    let funnel = Body {
        vertices: vec![[0.0, 0.0, 1.0], [10.0, 0.0, 1.0], [10.0, 8.0, 1.0], [0.0, 8.0, 1.0], [5.0, 4.0, 4.0]],
        faces: [vec![0, 3, 2, 1], vec![0, 1, 4], vec![1, 2, 4], vec![2, 3, 4], vec![3, 0, 4]]
            .map(|ring| vec![ring])
            .to_vec(),
    };
    let aside = |x: f64| void([5.0, 4.0, 5.0]).moved([x, 0.0, 0.0]);
    let from_floor_to_roof = Body::block([2.0, 2.0, 0.0], [6.0, 5.0, 6.0]);
    vec![
        case("inner_shell", with_voids(&[inside()]), &[], &[]),
        // It touches the roof at its tip.
        case("inner_shell_1", with_voids(&[void([5.0, 4.0, 6.0])]), &[], &[]),
        case("401", with_voids(&[void([5.0, 4.0, 6.01])]), &[401], &[401]),
        case("401_2", with_voids(&[inside(), aside(1.5)]), &[401], &[401]),
        case("401_3", with_voids(&[inside(), Body::block([4.5, 3.5, 1.5], [5.5, 4.5, 2.0])]), &[401], &[401]),
        // Its floor lies on the floor of the house.
        case("401_4", with_voids(&[inside().moved([0.0, 0.0, -1.0])]), &[401], &[401]),
        case("401_6", with_voids(&[from_floor_to_roof]), &[401], &[401]),
        differs(
            "402_in_1",
            with_voids(&[inside(), inside()]),
            [&[401], &[402]],
            "a shell that is there twice is that, and no intersection",
        ),
        case("403", with_voids(&[aside(20.0)]), &[403], &[403]),
        case("404", with_voids(&[funnel]), &[404], &[404]),
        case("405 of a void", solid_of(&[house(), inside()]).whole(), &[405], &[405]),
    ]
}

fn composites() -> Vec<Case> {
    let at = |x: f64| house().moved([x, 0.0, 0.0]);
    let of = |each: [Body; 3]| {
        let [a, b, c] = each.map(|body| [body]);
        solids("CompositeSolid", &[&a, &b, &c]).whole()
    };
    let inside = || void([5.0, 4.0, 5.0]);
    vec![
        case("composite_solid", of([at(0.0), at(10.0), at(20.0)]), &[], &[]),
        case("multi_solid", solids("MultiSolid", &[&[at(0.0)], &[at(5.0)]]).whole(), &[], &[]),
        case("501", of([at(0.0), at(19.9), at(10.0)]), &[501], &[501]),
        // A solid that reaches out of the void that it stands in.
        case(
            "501_1",
            solids("CompositeSolid", &[&[house(), inside().turned()], &[void([5.0, 4.0, 5.5])]]).whole(),
            &[501],
            &[501],
        ),
        case("502", of([at(0.0), at(40.0), at(40.0)]), &[502], &[502, 503]),
        case("503", of([at(0.0), at(40.0), at(10.0)]), &[503], &[503]),
        differs(
            "501 by half a millimetre",
            of([at(0.0), at(9.999_5), at(20.0)]),
            [&[501], &[]],
            "vertices no farther apart than the snap distance are one in all solids of a geometry",
        ),
        case("601", parts(&[at(0.0), at(5.0)]).whole(), &[601], &[601]),
        case("601 of one in the other", parts(&[at(0.0), inside()]).whole(), &[601], &[601]),
        case("601 of the same", parts(&[at(0.0), at(0.0)]).whole(), &[601], &[601]),
        case("601 of parts that touch", parts(&[at(0.0), at(10.0)]).whole(), &[], &[]),
        case("601 by half a millimetre", parts(&[at(0.0), at(9.999_5)]).whole(), &[601], &[]),
    ]
}

fn files() -> Vec<Case> {
    let empty = |boundaries: Value| {
        let mut model = solids("CompositeSolid", &[&[house()], &[house()]]).whole();
        model["CityObjects"]["a"]["geometry"][0]["boundaries"][1] = boundaries;
        model
    };
    let with = |change: fn(&mut Value)| {
        let mut model = solid(house());
        change(&mut model);
        model
    };
    vec![
        case("cube_v10", solid_of(&[house()]).real(), &[], &[]),
        case("cube_v20", solid(house()), &[], &[]),
        case("emptygeom", with(|model| model["CityObjects"]["a"]["geometry"] = json!([])), &[], &[]),
        case("empty_primitive", empty(json!([])), &[902], &[902]),
        case("empty_primitive_1", empty(json!([[]])), &[902], &[902]),
        differs(
            "a multi-surface without faces",
            surface("MultiSurface", &Body::default()),
            [&[], &[902]],
            "val3dity asks solids alone whether they are empty",
        ),
        case("geomtemplate_1", template(&house(), [1.0; 3]), &[], &[]),
        // Half a centimetre in the template is none in it, and five where it stands.
        case(
            "geomtemplate_2",
            template(
                &house()
                    .and(&[[5.0, 0.0, 6.02], [5.0, 8.0, 6.02]])
                    .with(1, &[&[4, 8, 5, 6, 9, 7]])
                    .with(2, &[&[0, 1, 5, 8, 4]])
                    .with(4, &[&[2, 3, 7, 9, 6]]),
                [1.0, 1.0, 10.0],
            ),
            &[203],
            &[203],
        ),
        differs(
            "notransform",
            with(|model| drop(model.as_object_mut().unwrap().remove("transform"))),
            [&[], &[901]],
            "CityJSON 2.0 requires it; val3dity asks for it in sequences alone",
        ),
        case("cube_tol_1", solid(house().and(&[[0.000_1, 0.0, 0.0]]).with(2, &[&[8, 1, 5, 4]])), &[], &[]),
        differs(
            "invalid_schema_cityjson_2",
            with(|model| model["CityObjects"]["a"]["geometry"][0]["boundaries"][0][0][0][0] = json!(99)),
            [&[], &[901]],
            "it ends without a report",
        ),
    ]
}
