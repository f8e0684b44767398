//! Normals, roughness and noise from the raw points.

use nalgebra::Point3;

use super::moments::Moments;
use super::neighbours::Neighbours;
use crate::geometry::Plane;

/// No sensor is better than this, metres; it keeps tolerances of synthetic clouds above zero.
const LEAST_NOISE: f64 = 0.01;

/// The local plane of every point, and the noise of the cloud.
#[derive(Debug, Clone)]
pub(super) struct LocalPlanes {
    /// For each point, the plane of the smoothest neighbourhood that it belongs to; it points up. A horizontal plane
    /// through the point when no neighbourhood determines one.
    pub planes: Vec<Plane>,
    /// For each point, the root mean square of the residuals in that neighbourhood, metres; infinite when there is
    /// none.
    pub roughness: Vec<f64>,
    /// Standard deviation of the points across the surface they sample, metres.
    pub noise: f64,
}

impl LocalPlanes {
    /// Estimates the local planes of distinct points from their neighbours.
    ///
    /// Principal component analysis on the neighbourhood of each point, then an edge-preserving step after Kuwahara:
    /// a point takes the smoothest of the neighbourhoods of its neighbours on whose plane it lies. At a ridge that is
    /// one to the side, so the two slopes keep their normals up to the last row of points.
    ///
    /// `noise` is the noise of the cloud when it is known already, as for the points that were left over.
    pub fn estimate(points: &[Point3<f64>], neighbours: &Neighbours, noise: Option<f64>) -> Self {
        let own: Vec<Option<(Plane, f64)>> =
            (0..points.len() as u32).map(|i| Self::neighbourhood(points, neighbours, i)).collect();
        let noise = noise.unwrap_or_else(|| median_noise(own.iter().flatten().map(|(_, roughness)| *roughness)));
        let mut this = Self { planes: Vec::new(), roughness: Vec::new(), noise };
        this.planes.reserve_exact(points.len());
        this.roughness.reserve_exact(points.len());
        for (i, point) in (0u32..).zip(points) {
            let mut best: Option<&(Plane, f64)> = own[i as usize].as_ref();
            for candidate in neighbours.of(i).iter().filter_map(|&j| own[j as usize].as_ref()) {
                let smoother = best.is_none_or(|(_, roughness)| candidate.1 < *roughness);
                if smoother && candidate.0.distance(point).abs() <= 2.0 * noise {
                    best = Some(candidate);
                }
            }
            let (plane, roughness) =
                best.copied().unwrap_or((Plane::through(point, nalgebra::Vector3::z_axis()), f64::INFINITY));
            this.planes.push(plane);
            this.roughness.push(roughness);
        }
        this
    }

    /// The plane of a point and its neighbours, and its residual corrected for the three parameters of the plane.
    fn neighbourhood(points: &[Point3<f64>], neighbours: &Neighbours, i: u32) -> Option<(Plane, f64)> {
        let mut moments = Moments::new(points[i as usize]);
        moments.add(&points[i as usize]);
        for &j in neighbours.of(i) {
            moments.add(&points[j as usize]);
        }
        let fit = moments.fit()?;
        let freedom = (moments.count() - 3.0).max(1.0);
        Some((fit.plane, fit.rms * (moments.count() / freedom).sqrt()))
    }

    /// Standard error of the slope of a local plane, in radians, and the standard deviation of a neighbourhood along
    /// the surface, in metres.
    pub fn quality(&self, neighbours: &Neighbours) -> (f64, f64) {
        // A disc of radius r with density ρ holds ρπr² points with standard deviation r/2 along each axis.
        let count = neighbours.width().max(1) as f64;
        let spread = (count / (std::f64::consts::PI * neighbours.density().max(1e-9))).sqrt() / 2.0;
        (self.noise / (spread * count.sqrt()), spread)
    }
}

/// The noise of a cloud from the roughness of its neighbourhoods. Those across an edge are rough for another reason:
/// the 40th percentile leaves room for six of ten to be such, and is near the median of the others where few are.
fn median_noise(roughness: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = roughness.collect();
    if all.is_empty() {
        return LEAST_NOISE;
    }
    let rank = all.len() * 2 / 5;
    let (_, value, _) = all.select_nth_unstable_by(rank, f64::total_cmp);
    value.max(LEAST_NOISE)
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Scan, gable};
    use super::*;

    #[test]
    fn normals_are_sharp_at_a_ridge_and_the_noise_is_found() {
        for sigma in [0.02, 0.06] {
            let points = gable(&Scan { density: 10.0, sigma, seed: 3 });
            let neighbours = Neighbours::new(&points, 10);
            let local = LocalPlanes::estimate(&points, &neighbours, None);
            assert!((local.noise / sigma - 1.0).abs() < 0.2, "{} for {sigma}", local.noise);
            // The gable has its ridge at y = 4 and slopes of 45°; count normals that lean to the wrong side or stand
            // between the two slopes.
            let wrong = points
                .iter()
                .zip(&local.planes)
                .filter(|(p, plane)| {
                    let side = if p.y < 4.0 { -1.0 } else { 1.0 };
                    (plane.normal.y * side - 0.5f64.sqrt()).abs() > 0.25
                })
                .count();
            assert!(wrong * 50 < points.len(), "{wrong} of {}", points.len());
        }
    }

    #[test]
    fn points_on_a_line_have_no_neighbourhood() {
        let line: Vec<_> = (0..20).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        let local = LocalPlanes::estimate(&line, &Neighbours::new(&line, 8), None);
        assert!(local.roughness.iter().all(|r| r.is_infinite()));
        assert_eq!(local.noise, LEAST_NOISE);
    }
}
