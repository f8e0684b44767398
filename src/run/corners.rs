//! Where the number 0 of a model's coordinates is, unless the job says it. It depends on the footprints alone, as each frame does.

/// The corner of the frames of the buildings in each file of a model.
pub(super) struct Corners(Vec<[f64; 3]>);

impl Corners {
    /// Of so many files, in which there is nothing yet.
    pub(super) fn new(files: usize) -> Self {
        Self(vec![[f64::INFINITY; 3]; files])
    }

    /// Takes the origin of a frame, of a building in this file.
    pub(super) fn see(&mut self, file: usize, origin: [f64; 3]) {
        if let Some(corner) = self.0.get_mut(file) {
            *corner = lower(*corner, origin);
        }
    }

    /// The corner of each file, in whole CRS units; 0 of an empty one.
    pub(super) fn of_files(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.0.iter().copied().map(whole)
    }

    /// The corner of all of them.
    pub(super) fn of_all(&self) -> [f64; 3] {
        whole(self.0.iter().copied().fold([f64::INFINITY; 3], lower))
    }
}

fn lower(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis].min(b[axis]))
}

fn whole(corner: [f64; 3]) -> [f64; 3] {
    corner.map(|c| if c.is_finite() { c.round() } else { 0.0 })
}
