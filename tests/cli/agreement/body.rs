//! Bodies with one fault, and the files that they stand in.

use serde_json::{Value, json};

/// Steps of the grid in a metre.
const STEPS: f64 = 1e6;

/// Vertices in metres and faces, each its rings.
#[derive(Debug, Clone, Default)]
pub struct Body {
    pub vertices: Vec<[f64; 3]>,
    pub faces: Vec<Vec<Vec<usize>>>,
}

/// A house of 10 by 8 by 6 m: floor, roof, and the walls from the south on. Vertices 0 to 3 are the floor's, 4 to 7 are above.
pub fn house() -> Body {
    Body::block([0.0; 3], [10.0, 8.0, 6.0])
}

impl Body {
    /// A block from corner to corner.
    pub fn block(low: [f64; 3], high: [f64; 3]) -> Self {
        let [a, b] = [low, high];
        let plan = [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]];
        let vertices = [a[2], b[2]].into_iter().flat_map(|z| plan.map(|[x, y]| [x, y, z])).collect();
        let rings = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        Self { vertices, faces: rings.map(|ring| vec![ring.to_vec()]).to_vec() }
    }

    /// A pyramid over three points of a floor, its faces outwards.
    pub fn tetrahedron(corners: [[f64; 3]; 4]) -> Self {
        let rings = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        Self { vertices: corners.to_vec(), faces: rings.map(|ring| vec![ring.to_vec()]).to_vec() }
    }

    /// With further vertices.
    pub fn and(mut self, vertices: &[[f64; 3]]) -> Self {
        self.vertices.extend(vertices);
        self
    }

    /// With these rings in the place of a face.
    pub fn with(mut self, face: usize, rings: &[&[usize]]) -> Self {
        self.faces[face] = rings.iter().map(|ring| ring.to_vec()).collect();
        self
    }

    /// With a further face.
    pub fn plus(mut self, rings: &[&[usize]]) -> Self {
        self.faces.push(rings.iter().map(|ring| ring.to_vec()).collect());
        self
    }

    /// Without a face.
    pub fn without(mut self, face: usize) -> Self {
        self.faces.remove(face);
        self
    }

    /// With all faces turned the other way.
    pub fn turned(mut self) -> Self {
        self.faces.iter_mut().flatten().for_each(|ring| ring.reverse());
        self
    }

    /// Moved, in metres.
    pub fn moved(mut self, by: [f64; 3]) -> Self {
        self.vertices.iter_mut().for_each(|vertex| (0..3).for_each(|axis| vertex[axis] += by[axis]));
        self
    }

    /// With the vertices of another beside its own, and its faces.
    pub fn joined(mut self, other: &Self) -> Self {
        let first = self.vertices.len();
        self.vertices.extend(&other.vertices);
        self.faces.extend(other.boundaries(first));
        self
    }

    fn boundaries(&self, first: usize) -> Vec<Vec<Vec<usize>>> {
        self.faces
            .iter()
            .map(|face| face.iter().map(|ring| ring.iter().map(|v| v + first).collect()).collect())
            .collect()
    }
}

/// A file under way: its objects and vertices.
#[derive(Debug, Default)]
pub struct File {
    vertices: Vec<[f64; 3]>,
    objects: serde_json::Map<String, Value>,
}

impl File {
    fn shell(&mut self, body: &Body) -> Value {
        let first = self.vertices.len();
        self.vertices.extend(&body.vertices);
        json!(body.boundaries(first))
    }

    fn shells(&mut self, bodies: &[Body]) -> Value {
        bodies.iter().map(|body| self.shell(body)).collect()
    }

    #[expect(clippy::needless_pass_by_value, reason = "every caller makes it on the spot")]
    fn object(&mut self, id: &str, kind: &str, geometry: Value) -> &mut Value {
        self.objects.insert(id.to_owned(), json!({"type": kind, "geometry": [geometry]}));
        &mut self.objects[id]
    }

    /// CityJSON 2.0 on a grid of a micrometre.
    pub fn whole(self) -> Value {
        let on_grid = |vertex: &[f64; 3]| vertex.map(|c| (c * STEPS).round() as i64);
        json!({
            "type": "CityJSON", "version": "2.0",
            "transform": {"scale": [1.0 / STEPS, 1.0 / STEPS, 1.0 / STEPS], "translate": [85_000.0, 447_000.0, 0.0]},
            "CityObjects": self.objects, "vertices": self.vertices.iter().map(on_grid).collect::<Vec<_>>(),
        })
    }

    /// CityJSON 1.0 with real coordinates.
    pub fn real(self) -> Value {
        json!({"type": "CityJSON", "version": "1.0", "CityObjects": self.objects, "vertices": self.vertices})
    }
}

/// One object with one geometry.
fn single(kind: &str, boundaries: impl FnOnce(&mut File) -> Value) -> File {
    let mut file = File::default();
    let boundaries = boundaries(&mut file);
    file.object("a", "GenericCityObject", json!({"type": kind, "lod": "2", "boundaries": boundaries}));
    file
}

/// A solid of an exterior shell and its voids, whose faces look into them.
pub fn solid_of(shells: &[Body]) -> File {
    single("Solid", |file| file.shells(shells))
}

/// A solid of one shell.
pub fn solid(body: Body) -> Value {
    solid_of(&[body]).whole()
}

/// A house with voids.
pub fn with_voids(voids: &[Body]) -> Value {
    let shells: Vec<Body> = std::iter::once(house()).chain(voids.iter().cloned().map(Body::turned)).collect();
    solid_of(&shells).whole()
}

/// Faces that need not be closed.
pub fn surface(kind: &str, body: &Body) -> Value {
    single(kind, |file| file.shell(body)).whole()
}

/// Several solids, each its shells.
pub fn solids(kind: &str, each: &[&[Body]]) -> File {
    single(kind, |file| each.iter().map(|shells| file.shells(shells)).collect())
}

/// A building with a part of each body.
pub fn parts(bodies: &[Body]) -> File {
    let mut file = File::default();
    let ids: Vec<String> = (0..bodies.len()).map(|i| format!("b-{i}")).collect();
    for (id, body) in ids.iter().zip(bodies) {
        let boundaries = json!([file.shell(body)]);
        let geometry = json!({"type": "Solid", "lod": "2", "boundaries": boundaries});
        file.object(id, "BuildingPart", geometry)["parents"] = json!(["b"]);
    }
    file.objects.insert("b".to_owned(), json!({"type": "Building", "children": ids}));
    file
}

/// A template of a body, and an instance of it that is as many times as large along each axis.
pub fn template(body: &Body, scale: [f64; 3]) -> Value {
    let shell = body.boundaries(0);
    let matrix: Vec<f64> =
        (0..16).map(|i| if i % 5 == 0 { scale.get(i / 5).copied().unwrap_or(1.0) } else { 0.0 }).collect();
    let instance =
        json!({"type": "GeometryInstance", "template": 0, "boundaries": [0], "transformationMatrix": matrix});
    let mut file = File { vertices: vec![[0.0; 3]], ..File::default() };
    file.object("a", "GenericCityObject", instance);
    let mut whole = file.whole();
    whole["geometry-templates"] = json!({
        "templates": [{"type": "Solid", "lod": "2", "boundaries": [shell]}], "vertices-templates": body.vertices,
    });
    whole
}
