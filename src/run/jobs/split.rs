//! Dividing footprints into jobs that lie together and cost about the same.

use std::num::NonZeroUsize;

/// Into how many jobs a run is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// Into so many, or as many as there are footprints.
    Jobs(NonZeroUsize),
    /// Into jobs of about so many footprints each.
    Footprints(NonZeroUsize),
}

impl Split {
    /// How many jobs `footprints` come to; one at least.
    pub(super) fn jobs(self, footprints: usize) -> usize {
        let jobs = match self {
            Self::Jobs(jobs) => jobs.get(),
            Self::Footprints(each) => footprints.div_ceil(each.get()),
        };
        jobs.clamp(1, footprints.max(1))
    }
}

/// A footprint that is to be in a job.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub(super) index: usize,
    /// Where it is, metres.
    pub(super) place: [f64; 2],
    pub(super) cost: f64,
}

/// Divides `items` into `jobs`, which are no more than they: over and over across the longer side, so that both halves cost
/// as much as their jobs. Each is ascending by index; none is empty unless there are no items.
pub(super) fn divide(items: Vec<Item>, jobs: usize) -> Vec<Vec<usize>> {
    let mut done = Vec::with_capacity(jobs);
    let mut waiting = vec![(items, jobs)];
    while let Some((mut items, jobs)) = waiting.pop() {
        if jobs <= 1 {
            let mut indices: Vec<usize> = items.iter().map(|item| item.index).collect();
            indices.sort_unstable();
            done.push(indices);
            continue;
        }
        let axis = longer_side(&items);
        items.sort_by(|a, b| a.place[axis].total_cmp(&b.place[axis]).then(a.index.cmp(&b.index)));
        let first_jobs = jobs / 2;
        let whole: f64 = items.iter().map(|item| item.cost).sum();
        let wanted = whole * first_jobs as f64 / jobs as f64;
        let mut sum = 0.0;
        // An item goes to the side on which most of it lies.
        let is_first = |item: &Item, sum: &mut f64| {
            let middle = *sum + item.cost / 2.0;
            *sum += item.cost;
            middle < wanted
        };
        let cut = items.iter().take_while(|item| is_first(item, &mut sum)).count();
        let second = items.split_off(cut.clamp(first_jobs, items.len() - (jobs - first_jobs)));
        waiting.push((second, jobs - first_jobs));
        waiting.push((items, first_jobs));
    }
    done
}

fn longer_side(items: &[Item]) -> usize {
    let side = |axis: usize| {
        let places = items.iter().map(|item| item.place[axis]);
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        high - low
    };
    usize::from(side(1) > side(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_item_is_in_one_job_and_jobs_cost_about_the_same() {
        let items: Vec<Item> = (0..1000)
            .map(|index| Item {
                index,
                place: [(index * 37 % 101) as f64, (index * 53 % 97) as f64],
                cost: 1.0 + (index * 7 % 5) as f64,
            })
            .collect();
        let whole: f64 = items.iter().map(|item| item.cost).sum();
        for jobs in [1, 2, 3, 7, 64, 1000] {
            let divided = divide(items.clone(), jobs);
            assert_eq!(divided.len(), jobs);
            let mut all: Vec<usize> = divided.concat();
            all.sort_unstable();
            assert_eq!(all, (0..1000).collect::<Vec<_>>());
            for job in &divided {
                let cost: f64 = job.iter().map(|&index| items[index].cost).sum();
                let fair = whole / jobs as f64;
                assert!(!job.is_empty() && (cost - fair).abs() <= 0.2 * fair + 5.0, "{jobs} jobs: {cost} of {fair}");
            }
        }
        assert_eq!(divide(Vec::new(), 1), [Vec::<usize>::new()]);
    }

    #[test]
    fn a_number_of_jobs_is_never_more_than_there_is_to_do() {
        let number = |n| NonZeroUsize::new(n).unwrap();
        assert_eq!(Split::Jobs(number(64)).jobs(10), 10);
        assert_eq!(Split::Jobs(number(64)).jobs(0), 1);
        assert_eq!(Split::Footprints(number(100)).jobs(1001), 11);
    }
}
