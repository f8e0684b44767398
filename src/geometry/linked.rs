//! Closed lines that lose vertices.

/// The vertices of a closed line by their indices, each of which knows its neighbours: one is taken out at once, however
/// many there are.
#[derive(Debug, Clone)]
pub(crate) struct Linked {
    neighbours: Vec<[usize; 2]>,
    kept: Vec<bool>,
    count: usize,
}

impl Linked {
    /// A line of so many vertices.
    pub fn new(count: usize) -> Self {
        let neighbours = (0..count).map(|i| [(i + count - 1) % count, (i + 1) % count]).collect();
        Self { neighbours, kept: vec![true; count], count }
    }

    /// How many are left.
    pub fn len(&self) -> usize {
        self.count
    }

    /// The vertices before and after one.
    pub fn around(&self, vertex: usize) -> [usize; 2] {
        self.neighbours[vertex]
    }

    /// Whether a vertex is left.
    pub fn keeps(&self, vertex: usize) -> bool {
        self.kept[vertex]
    }

    /// Takes a vertex out.
    pub fn remove(&mut self, vertex: usize) {
        let [before, after] = self.neighbours[vertex];
        self.neighbours[before][1] = after;
        self.neighbours[after][0] = before;
        self.count -= usize::from(std::mem::replace(&mut self.kept[vertex], false));
    }

    /// What is left, ascending.
    pub fn left(&self) -> Vec<usize> {
        (0..self.kept.len()).filter(|&i| self.kept[i]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_close_ranks() {
        let mut line = Linked::new(5);
        line.remove(0);
        line.remove(3);
        assert_eq!((line.around(1), line.around(2), line.around(4)), ([4, 2], [1, 4], [2, 1]));
        assert_eq!((line.len(), line.left()), (3, vec![1, 2, 4]));
        assert!(line.keeps(1) && !line.keeps(3));
        assert!(Linked::new(0).left().is_empty());
    }
}
