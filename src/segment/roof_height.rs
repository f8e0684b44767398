//! Heights of roofs that the user states.

use super::ground::number;
use super::options::{HeightAbove, SegmentOptions};
use crate::site::{Frame, Ground};
use crate::source::footprints::Footprint;

/// The height of the roof that an attribute of a footprint gives, local metres; what is no number gives none. `ground` is
/// that of the footprint.
pub(super) fn stated(footprint: &Footprint, frame: &Frame, ground: &Ground, options: &SegmentOptions) -> Option<f64> {
    let height = footprint.attribute(options.roof_height_attribute.as_ref()?).as_ref().and_then(number)?;
    Some(match options.roof_height_above {
        HeightAbove::Datum => (height - frame.origin[2]) * frame.metres_per_unit[2],
        HeightAbove::Ground => ground.height + height * frame.metres_per_unit[2],
    })
}
