//! What is known of a place beside its nearest points.

use nalgebra::Point3;

use super::Inputs;

/// What is told of a place, in this order.
pub const PLACE_CHANNELS: [&str; 17] = [
    "x",
    "y",
    "z",
    "height",
    "ln_scale",
    "ln_spacing",
    "ln_noise",
    "ln_radius",
    "evidence_flag",
    "evidence_scaled",
    "evidence_coarse",
    "evidence_fine",
    "evidence_vote",
    "footprint_flag",
    "footprint_coarse",
    "footprint_fine",
    "footprint_vote",
];

impl Inputs<'_> {
    /// Appends the numbers of a place to `channels`; `radius` is that of its patch, metres.
    ///
    /// - `x`, `y`, `z`: in the field frame; `height`: above the ground, in units of 10 m.
    /// - `ln_scale`: of the scale over 20 m; `ln_spacing`: of the spacing of the points in metres; `ln_noise`: of their
    ///   distance from their planes over 5 cm; `ln_radius`: of the radius in metres.
    /// - `evidence_…`: how far the place lies below the roof that is seen over it: over the scale, and bent by tanh at
    ///   2 m and at 0.3 m. 0 where no roof is seen, which the flag tells.
    /// - `footprint_…`: how far it lies within the footprint, bent at 2 m and at 0.3 m; 0 without a footprint.
    /// - `…_vote`: how far it lies between the ground and the roof, and within the footprint, bent at 5 cm: what the
    ///   height-field vote would say, which is right to the centimetre where the scan shows all.
    pub fn place(&self, place: &Point3<f64>, radius: f64, channels: &mut Vec<f32>) {
        let field = self.to_field(place);
        let below = self.evidence.height(&place.xy()).map(|roof| roof - place.z);
        let within = self.outline.as_ref().map(|outline| outline.distance(&place.xy()));
        let height = place.z - self.origin.z;
        let flag = |known: Option<f64>| f64::from(u8::from(known.is_some()));
        let bent = |value: Option<f64>, at: f64| (value.unwrap_or(0.0) / at).tanh();
        let numbers: [f64; PLACE_CHANNELS.len()] = [
            field.x,
            field.y,
            field.z,
            height / 10.0,
            (self.scale / 20.0).ln(),
            self.spacing.ln(),
            ((self.noise + 0.005) / 0.05).ln(),
            radius.ln(),
            flag(below),
            below.unwrap_or(0.0) / self.scale,
            bent(below, 2.0),
            bent(below, 0.3),
            bent(below.map(|below| below.min(height)), 0.05),
            flag(within),
            bent(within, 2.0),
            bent(within, 0.3),
            bent(within, 0.05),
        ];
        channels.extend(numbers.map(|value| value as f32));
    }
}
