//! What counts as building in points that have no classes.

use crate::segment::{BuildingClasses, SegmentOptions};
use crate::source::points::Tile;

/// The class of points that have none (LAS 1.4 R15, table 17: created, never classified).
const UNCLASSIFIED: u8 = 0;

/// The options as they are meant: where no tile has classes, nobody means those that buildings usually have. With footprints
/// all points can be of buildings then (`any`); without, all of them are. Also gives what is to be said of that.
pub(super) fn of_points(
    tiles: &[Tile],
    options: &SegmentOptions,
    has_footprints: bool,
) -> (SegmentOptions, Option<String>) {
    let is_meant = options.building_classes != SegmentOptions::default().building_classes
        && (has_footprints || !options.building_classes.is_any());
    if is_meant || tiles.is_empty() || tiles.iter().any(|tile| tile.has_classes) {
        return (options.clone(), None);
    }
    let (building_classes, taken) = if has_footprints {
        (
            BuildingClasses::ANY,
            "what stands out of the ground in footprints is taken for buildings, as with --building-class any",
        )
    } else {
        (BuildingClasses::Listed(vec![UNCLASSIFIED]), "all of them are taken for points of buildings")
    };
    let said = format!("the points have no classes: {taken}; a column or property `classification` would tell more");
    (SegmentOptions { building_classes, ..options.clone() }, Some(said))
}
