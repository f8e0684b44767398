//! Efficient RANSAC for planes (Schnabel, Wahl, Klein 2007), the detector that the paper uses.
//!
//! Samples are drawn from cells of an octree, candidates are scored on random subsets with bounds on their full score,
//! the score of a plane is its largest connected component, and the search ends when a plane of the minimum size would
//! have been found with the stated probability. Section numbers below are those of Schnabel et al.

use nalgebra::{Point3, Unit};

use super::moments::Moments;
use super::neighbours::Neighbours;
use super::normals::LocalPlanes;
use super::octree::Octree;
use super::segmentation::{NONE, Segmentation, Tolerances};
use crate::geometry::{Plane, Random};

/// Candidates drawn between two looks at the best.
const BATCH: usize = 64;
/// Share of the level weights that follows the scores; the rest stays uniform (section 4.3.1).
const LEARNED: f64 = 0.9;
/// No more candidates than this are kept.
const MOST_CANDIDATES: usize = 256;
/// Even a cloud without any plane is given up after so many samples.
const MOST_SAMPLES: f64 = 2e5;

/// Segments a cloud of distinct points; `probability` is that of not overlooking a plane.
pub(super) fn segment(
    points: &[Point3<f64>],
    neighbours: &Neighbours,
    local: &LocalPlanes,
    tolerances: &Tolerances,
    probability: f64,
    seed: u64,
) -> Segmentation {
    let mut search = Search::new(points, neighbours, local, tolerances, seed);
    let probability = probability.clamp(0.5, 0.9999);
    let mut drawn = 0.0;
    let mut total = 0.0;
    while search.octree.len() >= tolerances.inliers && total < MOST_SAMPLES {
        for _ in 0..BATCH {
            search.draw();
        }
        drawn += BATCH as f64;
        total += BATCH as f64;
        search.prune();
        while let Some(best) = search.best() {
            let size = search.candidates[best].bounds.expected;
            if size < tolerances.inliers as f64 || search.found(size, drawn) <= probability {
                break;
            }
            let before = search.octree.len() as f64;
            if search.extract(best) {
                // Of the candidates drawn so far, so many have all three points left (section 4.4).
                drawn *= (search.octree.len() as f64 / before).powi(3);
            }
        }
        if search.found(tolerances.inliers as f64, drawn) > probability {
            break;
        }
    }
    let mut segmentation = search.segmentation;
    segmentation.settle_borders(points, neighbours, tolerances);
    segmentation.dissolve_redundant(points, neighbours, tolerances);
    segmentation.refit(points, tolerances, tolerances.inliers);
    segmentation
}

/// How many points a candidate explains, as far as is known (section 4.5.1).
#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: f64,
    expected: f64,
    high: f64,
}

impl Bounds {
    /// From `hits` inliers in a random sample of `sampled` of `total` points, by the hypergeometric distribution.
    fn new(total: usize, sampled: usize, hits: usize) -> Self {
        let (total, sampled, hits) = (total as f64, sampled as f64, hits as f64);
        let mean = (total + 2.0) * (hits + 1.0);
        let spread = (mean * (total - sampled).max(0.0) * (sampled + 1.0 - hits) / (sampled + 3.0)).sqrt();
        let at = |sum: f64| (sum / (sampled + 2.0) - 1.0).max(hits);
        Self { low: at(mean - spread), expected: at(mean), high: at(mean + spread) }
    }
}

#[derive(Debug, Clone)]
struct Candidate {
    plane: Plane,
    /// How many of the subsets it has been scored on, the points in them, and the inliers among those.
    subsets: usize,
    sampled: usize,
    hits: usize,
    bounds: Bounds,
}

struct Search<'a> {
    points: &'a [Point3<f64>],
    neighbours: &'a Neighbours,
    local: &'a LocalPlanes,
    tolerances: &'a Tolerances,
    random: Random,
    octree: Octree,
    /// Sum of the scores of the candidates drawn on each level.
    level_scores: Vec<f64>,
    /// The points that are left in random order, and where each subset ends.
    order: Vec<u32>,
    ends: Vec<usize>,
    candidates: Vec<Candidate>,
    segmentation: Segmentation,
}

impl<'a> Search<'a> {
    fn new(
        points: &'a [Point3<f64>],
        neighbours: &'a Neighbours,
        local: &'a LocalPlanes,
        tolerances: &'a Tolerances,
        seed: u64,
    ) -> Self {
        // Leaves of about a dozen points.
        let octree = Octree::new(points, 3.5 / neighbours.density().max(1e-6).sqrt());
        let mut search = Self {
            points,
            neighbours,
            local,
            tolerances,
            random: Random::new(seed),
            level_scores: vec![1.0; octree.levels()],
            octree,
            order: Vec::new(),
            ends: Vec::new(),
            candidates: Vec::new(),
            segmentation: Segmentation::empty(points.len()),
        };
        search.divide();
        search
    }

    /// Probability that a plane of `size` points has been drawn among `drawn` candidates (equations 7 and 8).
    fn found(&self, size: f64, drawn: f64) -> f64 {
        // Three points: once the first is on the plane, the other two are with probability 1/2² on the right level.
        let chance = size / (self.octree.len().max(1) as f64 * self.octree.levels() as f64 * 4.0);
        1.0 - (1.0 - chance.clamp(0.0, 1.0)).powf(drawn)
    }

    /// Divides the points that are left into random subsets, each as large as all before it.
    fn divide(&mut self) {
        /// Subsets smaller than this tell nothing.
        const SMALLEST: usize = 64;
        self.order = (0..self.octree.len()).map(|place| self.octree.point(place)).collect();
        // Morton order would leave whole parts of the building out of a subset.
        self.random.shuffle(&mut self.order);
        self.ends = vec![self.order.len()];
        while let Some(&first) = self.ends.first()
            && first >= 2 * SMALLEST
        {
            self.ends.insert(0, first / 2);
        }
    }

    /// Draws three points from a cell of a random level; a plane that fits their normals becomes a candidate.
    fn draw(&mut self) {
        let first = self.octree.point(self.random.below(self.octree.len()));
        let level = self.level();
        let cell = self.octree.cell(first, level);
        if cell.len() < 3 {
            return;
        }
        let [second, third] = [(); 2].map(|()| self.octree.point(cell.start + self.random.below(cell.len())));
        let [a, b, c] = [first, second, third].map(|i| self.points[i as usize]);
        let cross = (b - a).cross(&(c - a));
        // Points nearly on a line determine no plane: the least height of the triangle must exceed the noise.
        let longest = (b - a).norm().max((c - a).norm()).max((c - b).norm());
        let Some(normal) = Unit::try_new(cross, self.tolerances.noise * longest) else { return };
        let normal = if normal.z < 0.0 { -normal } else { normal };
        let plane = Plane::through(&a, normal);
        let agrees = |i: u32| plane.normal.dot(&self.local.planes[i as usize].normal).abs() >= self.tolerances.cosine;
        if [first, second, third].into_iter().all(agrees) {
            let bounds = Bounds { low: 0.0, expected: 0.0, high: 0.0 };
            let mut candidate = Candidate { plane, subsets: 0, sampled: 0, hits: 0, bounds };
            self.score(&mut candidate);
            self.level_scores[level] += candidate.bounds.expected;
            if candidate.bounds.high >= self.tolerances.inliers as f64 {
                self.candidates.push(candidate);
            }
        }
    }

    /// A level of the octree, by the scores that the levels have earned (section 4.3.1).
    fn level(&mut self) -> usize {
        let total: f64 = self.level_scores.iter().sum();
        let uniform = (1.0 - LEARNED) / self.level_scores.len() as f64;
        let mut draw = self.random.unit();
        for (level, score) in self.level_scores.iter().enumerate() {
            draw -= LEARNED * score / total + uniform;
            if draw < 0.0 {
                return level;
            }
        }
        self.level_scores.len() - 1
    }

    /// Scores a candidate on one more subset; false when it has seen them all.
    fn score(&self, candidate: &mut Candidate) -> bool {
        let Some(&end) = self.ends.get(candidate.subsets) else { return false };
        let subset = &self.order[candidate.sampled..end];
        candidate.hits += subset.iter().filter(|&&i| self.belongs(i, &candidate.plane)).count();
        candidate.sampled = end;
        candidate.subsets += 1;
        candidate.bounds = Bounds::new(self.order.len(), end, candidate.hits);
        true
    }

    /// Keeps the most promising candidates: of a hall with hundreds of planes every one is drawn again and again.
    fn prune(&mut self) {
        if self.candidates.len() > MOST_CANDIDATES {
            self.candidates.sort_by(|a, b| b.bounds.expected.total_cmp(&a.bounds.expected));
            self.candidates.truncate(MOST_CANDIDATES / 2);
        }
    }

    /// The best candidate, after scoring it and its rivals until their bounds part them (section 4.5.1).
    fn best(&mut self) -> Option<usize> {
        loop {
            let (best, low) = (0..self.candidates.len())
                .map(|i| (i, self.candidates[i].bounds))
                .max_by(|(i, a), (j, b)| a.expected.total_cmp(&b.expected).then(j.cmp(i)))
                .map(|(i, bounds)| (i, bounds.low))?;
            let mut candidates = std::mem::take(&mut self.candidates);
            let mut rescored = false;
            for (i, candidate) in candidates.iter_mut().enumerate() {
                if i == best || candidate.bounds.high > low {
                    rescored |= self.score(candidate);
                }
            }
            self.candidates = candidates;
            if !rescored {
                return Some(best);
            }
        }
    }

    /// Takes the points of a candidate's plane out, after refitting it to its largest connected component: that one and
    /// all others that are large enough, each a segment of its own, so that the gables of a hall on one plane are found
    /// together. The candidate is gone in any case; false when its component was too small.
    fn extract(&mut self, best: usize) -> bool {
        /// The component settles after a refit or two.
        const REFITS: usize = 2;
        let candidate = self.candidates.swap_remove(best);
        let mut plane = candidate.plane;
        let mut components = self.components(&plane);
        for _ in 0..REFITS {
            let Some(members) = components.first() else { return false };
            let Some(&first) = members.first() else { return false };
            let moments = Moments::of(self.points[first as usize], self.points, members);
            let Some(fit) = moments.fit().filter(|fit| fit.width >= self.tolerances.width) else { return false };
            let again = self.components(&fit.plane);
            if again.first().is_none_or(|largest| largest.len() < members.len()) {
                break;
            }
            (plane, components) = (fit.plane, again);
        }
        components.retain(|component| component.len() >= self.tolerances.inliers);
        if components.is_empty() {
            return false;
        }
        for component in &components {
            self.segmentation.push(component, plane);
        }
        let labels = &self.segmentation.labels;
        self.octree.retain(|i| labels[i as usize] == NONE);
        self.divide();
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.retain_mut(|candidate| {
            (candidate.subsets, candidate.sampled, candidate.hits) = (0, 0, 0);
            self.score(candidate) && candidate.bounds.high >= self.tolerances.inliers as f64
        });
        self.candidates = candidates;
        true
    }

    /// The connected components of the free inliers of a plane (section 4.1), the largest first, each ascending.
    fn components(&self, plane: &Plane) -> Vec<Vec<u32>> {
        let mut left: Vec<u32> = self.order.iter().copied().filter(|&i| self.belongs(i, plane)).collect();
        left.sort_unstable();
        let mut open = vec![false; self.points.len()];
        for &i in &left {
            open[i as usize] = true;
        }
        let mut components: Vec<Vec<u32>> = Vec::new();
        let reach = self.tolerances.reach.powi(2);
        for &start in &left {
            if !std::mem::take(&mut open[start as usize]) {
                continue;
            }
            let mut component = vec![start];
            let mut front = 0;
            while let Some(&point) = component.get(front) {
                front += 1;
                for &near in self.neighbours.of(point) {
                    let gap = (self.points[near as usize] - self.points[point as usize]).norm_squared();
                    if gap <= reach && std::mem::take(&mut open[near as usize]) {
                        component.push(near);
                    }
                }
            }
            component.sort_unstable();
            components.push(component);
        }
        components.sort_by(|a, b| b.len().cmp(&a.len()).then(a.cmp(b)));
        components
    }

    fn belongs(&self, point: u32, plane: &Plane) -> bool {
        let slot = point as usize;
        self.tolerances.admit(plane, &self.points[slot], &self.local.planes[slot])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_close_on_the_truth_as_more_is_sampled() {
        let half = Bounds::new(1_000, 500, 100);
        assert!(half.low < 200.0 && half.high > 200.0 && (half.expected - 200.0).abs() < 2.0, "{half:?}");
        let all = Bounds::new(1_000, 1_000, 200);
        assert!((all.low - 200.0).abs() < 1e-9 && (all.high - 200.0).abs() < 1e-9, "{all:?}");
        let none = Bounds::new(1_000, 0, 0);
        assert!(none.low < 250.0 && none.high > 750.0, "{none:?}");
    }
}
