//! `filters.hag_delaunay`: the height of points above the triangles of the ground points near them.

use spade::{DelaunayTriangulation, FloatTriangulation, HasPosition, Point2, Triangulation};

use crate::error::Result;
use crate::pipeline::heights::{GroundPoints, Heights, Near, class_option, extrapolation_option};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.hag_delaunay",
    summary: "Gives points their height above the triangles of ground points near them, as HeightAboveGround",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new(
            "count",
            Kind::whole(3, 1_000_000),
            "Number of ground points around a point that are triangulated; outside of their triangles the height of the \
             nearest counts",
        )
        .or(10),
        extrapolation_option("Whether points outside the box around all ground points get a height, not 0"),
        class_option(),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    Ok(Stage::Whole(Box::new(HeightAboveTriangles { heights: Heights::new(KIND.name, values) })))
}

struct HeightAboveTriangles {
    heights: Heights,
}

/// A corner of a triangle: its place, from the point whose height is looked for, and the height of the ground there.
struct Corner {
    place: Point2<f64>,
    height: f64,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

/// The height at a place by the triangle of ground points that holds it; that of the nearest where none does.
fn ground_at(ground: &GroundPoints, [x, y]: [f64; 2], near: &[Near]) -> Option<f64> {
    let mut triangles = DelaunayTriangulation::<Corner>::new();
    // Of several at one place the last to come stays, which so is the first of the file.
    for near in near.iter().rev() {
        let [corner_x, corner_y] = ground.places[near.item];
        let place = Point2::new(corner_x - x, corner_y - y);
        // Only places that are as good as equal to the point are refused; the others do without them.
        let _ = triangles.insert(Corner { place, height: ground.heights[near.item] });
    }
    let inside = triangles.barycentric().interpolate(|corner| corner.data().height, Point2::new(0.0, 0.0));
    inside.or_else(|| near.first().map(|nearest| ground.heights[nearest.item]))
}

impl Whole for HeightAboveTriangles {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.heights.prepare(flow)
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        self.heights.give(&mut points, context, &ground_at)?;
        Ok(vec![points])
    }
}
