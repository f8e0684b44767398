//! One building from points: no files, no threads, no clock in the call that matters.
//!
//! ```text
//! cargo run --release --example one_building
//! ```
//!
//! Whoever has the points and the outline of a building makes a `Site` of them and asks for its model. Here they come out of
//! the bundled corner of Delft, but they may come from anywhere.

use std::error::Error;
use std::path::Path;

use gable::building::Outcome;
use gable::geo::{Contains, CoordsIter, MapCoords, coord};
use gable::network::FieldOptions;
use gable::reconstruct::{Parameters, reconstruct};
use gable::site::{Frame, Site};
use gable::solid::SurfaceType;
use gable::source::footprints::{self, FootprintOptions};
use gable::source::points::Tile;

const ID: &str = "NL.IMBAG.Pand.0503100000017304";

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data");
    let layer = footprints::read(&data.join("footprints.geojson"), &FootprintOptions::default())?;
    let outline = layer.footprints.iter().find(|footprint| footprint.id == ID).ok_or("no such footprint")?;

    // A local frame in metres near the building keeps coordinates small and exact. This CRS is in metres.
    let corner = outline.polygon.coords_iter().next().ok_or("an empty footprint")?;
    let frame = Frame::near([corner.x, corner.y, 0.0], [1.0; 3]);
    let footprint = outline.polygon.map_coords(|c| {
        let local = frame.to_local([c.x, c.y, 0.0]);
        coord! { x: local.x, y: local.y }
    });

    // The points inside the outline, and the lowest ground seen anywhere near.
    let (mut points, mut ground) = (Vec::new(), f64::INFINITY);
    Tile::open(data.join("delft_ahn3.laz"))?.stream(None, &mut |block| {
        for point in block.points() {
            let local = frame.to_local(point.position);
            if point.class == 6 && footprint.contains(&coord! { x: local.x, y: local.y }) {
                points.push(local);
            } else if point.class == 2 && local.xy().coords.norm() < 30.0 {
                ground = ground.min(local.z);
            }
        }
    })?;
    println!("{ID}: {} points, ground at {ground:.2} m", points.len());

    // The method itself: pure, so the same site gives the same model anywhere. The field is what decides which of the
    // cells between the planes are inside; load it once for all buildings.
    let site = Site::new(ID, frame, points, ground).with_footprint(&footprint);
    let field = FieldOptions::default().load()?;
    let building = reconstruct(&site, &Parameters::default(), &*field);

    assert_eq!(building.outcome, Outcome::Lod22, "a LoD 2.2 model");
    for solid in building.model.lod22() {
        let roofs = solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::Roof);
        let area: f64 = roofs.clone().map(|face| solid.area(face)).sum();
        println!("a solid of {:.0} m³ with {} roof faces, {area:.0} m² of roof", solid.volume(), roofs.count());
        assert!(solid.volume() > 50.0 && area > 20.0);
    }
    let rmse = building.measures.rmse_lod22.ok_or("no distance to the points")?;
    println!("{rmse:.2} m from the points (root mean square)");
    assert!(rmse < 1.0);
    Ok(())
}
