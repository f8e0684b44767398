//! Groups of returns: which echo of its pulse a point is.

use super::expression::Misfit;
use super::points::{Layout, Points};

/// Which echo of its pulse a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// The first of several.
    First,
    /// Neither the first nor the last.
    Intermediate,
    /// The last of several.
    Last,
    /// The only one.
    Only,
}

impl Group {
    /// All groups, in the order in which they are handed on.
    pub const ALL: [Self; 4] = [Self::First, Self::Intermediate, Self::Last, Self::Only];

    /// Its name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Intermediate => "intermediate",
            Self::Last => "last",
            Self::Only => "only",
        }
    }

    /// Reads names; each group comes once, in the order of [`Self::ALL`].
    ///
    /// # Errors
    /// A name that means none.
    pub fn parse_list(names: &[&str]) -> Result<Vec<Self>, Misfit> {
        if let Some(name) = names.iter().find(|name| !Self::ALL.iter().any(|group| group.name() == **name)) {
            return Err(Misfit::new(format!("`{name}`"), "first, intermediate, last and only, parted by commas"));
        }
        Ok(Self::ALL.into_iter().filter(|group| names.contains(&group.name())).collect())
    }

    /// The group of an echo by its number, from 1, and how many its pulse has; `None` for numbers that cannot be.
    fn of(number: f64, count: f64) -> Option<Self> {
        if count == 1.0 {
            return Some(Self::Only);
        }
        // A count of 1 is dealt with, and no count is below 1 here.
        if number < 1.0 || number > count {
            return None;
        }
        Some(match number {
            _ if number == 1.0 => Self::First,
            _ if number == count => Self::Last,
            _ => Self::Intermediate,
        })
    }
}

/// Where points say which echo they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Returns {
    number: usize,
    count: usize,
}

impl Returns {
    /// The places of the two dimensions.
    ///
    /// # Errors
    /// What was found and expected where one is missing.
    pub fn of_layout(layout: &Layout) -> Result<Self, Misfit> {
        let place = |name: &str| {
            let missing = |known| Misfit::new(format!("points without the dimension `{name}`"), known);
            layout.require(name).map_err(missing)
        };
        Ok(Self { number: place("ReturnNumber")?, count: place("NumberOfReturns")? })
    }

    /// The number of the echo and how many its pulse has, of point `i`.
    pub fn numbers(self, points: &Points, i: usize) -> [f64; 2] {
        [points.get(self.number, i), points.get(self.count, i)]
    }

    /// The group of point `i`.
    pub fn group(self, points: &Points, i: usize) -> Option<Group> {
        let [number, count] = self.numbers(points, i);
        Group::of(number, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn echoes_have_the_groups_that_pdal_gives_them() {
        let of = |number, count| Group::of(number, count).map(Group::name);
        assert_eq!(of(1.0, 1.0), Some("only"));
        assert_eq!((of(1.0, 2.0), of(2.0, 2.0)), (Some("first"), Some("last")));
        assert_eq!((of(2.0, 3.0), of(3.0, 3.0)), (Some("intermediate"), Some("last")));
        for (number, count) in [(0.0, 0.0), (0.0, 2.0), (3.0, 2.0), (1.0, 0.0)] {
            assert_eq!(of(number, count), None, "{number} of {count}");
        }
        assert_eq!(Group::parse_list(&["only", "first", "only"]).unwrap(), [Group::First, Group::Only]);
        assert!(Group::parse_list(&["frist"]).unwrap_err().found.contains("frist"));
    }
}
