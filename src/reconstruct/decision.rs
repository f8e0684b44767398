//! Which field decides: the one that was asked for, or the vote where that one cannot be believed.

use super::Partitioned;
use super::means::Means;
use super::occupancy::OccupancyError;

/// A field that calls less than this share of the volume under the roofs that were seen inside is not believed: shapes
/// that are no height field lack less, and a network that met nothing like this building in its training lacks more.
const LEAST_AGREEMENT: f64 = 0.4;

/// The occupancy of the cells of a building, and whose it is.
#[derive(Debug, Clone)]
pub(super) struct Decision {
    /// How much each cell is inside, 0 to 1.
    pub occupancy: Vec<f64>,
    /// Whether nothing may hang over.
    pub height_field: bool,
    /// Why the vote decides although another field was asked for.
    pub fallback: Option<String>,
}

impl Decision {
    /// What a height field says: the vote, or one of the caller's own.
    pub fn by_height_field(means: Means, building: &Partitioned) -> Result<Self, OccupancyError> {
        Ok(Self { occupancy: means.occupancy(building)?, height_field: true, fallback: None })
    }

    /// Asks the field, and takes `vote` where the field cannot be believed.
    pub fn new(means: Means, building: &Partitioned, vote: Self) -> Self {
        let fallback = match means.occupancy(building) {
            Err(error) => error.to_string(),
            Ok(occupancy) => {
                let [inside, under_roofs, both] = compare(building, &occupancy, &vote.occupancy);
                if inside == 0.0 {
                    "it says that everything is outside".to_owned()
                } else if both < LEAST_AGREEMENT * under_roofs {
                    let share = 100.0 * both / under_roofs;
                    format!("it calls only {share:.0} % of what lies under the roofs inside")
                } else {
                    return Self { occupancy, height_field: false, fallback: None };
                }
            }
        };
        Self { fallback: Some(fallback), ..vote }
    }
}

/// The volumes, in cubic metres, that the field calls inside, that the vote does, and that both do.
fn compare(building: &Partitioned, field: &[f64], vote: &[f64]) -> [f64; 3] {
    let mut volumes = [0.0; 3];
    for cell in building.free().map(|cell| cell as usize) {
        let [field, vote] = [field, vote].map(|occupancy| occupancy.get(cell).is_some_and(|o| *o > 0.5));
        for (sum, counts) in volumes.iter_mut().zip([field, vote, field && vote]) {
            if counts {
                *sum += building.volumes[cell];
            }
        }
    }
    volumes
}
