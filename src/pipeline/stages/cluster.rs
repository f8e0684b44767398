//! `filters.cluster`: numbers groups of points that hang together.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::error::{Error, Result};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{NumberType, Points};
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.cluster",
    summary: "Numbers groups of points that hang together, as ClusterID; 0 is none",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

/// The dimension that it makes.
const CLUSTER: &str = "ClusterID";
/// Points between two looks at whether to stop.
const BLOCK: usize = 1 << 12;

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new("min_points", Kind::count(), "Points of the smallest group that gets a number").or(1),
        OptionSpec::new(
            "max_points",
            Kind::count(),
            "Points of the largest group that gets a number; no limit when not given",
        ),
        OptionSpec::new(
            "tolerance",
            Kind::at_least(0.0),
            "Points that are nearer to one another than this hang together; CRS units",
        )
        .or(1.0),
        OptionSpec::new("is3d", Kind::Boolean, "Whether distances are in space, not in the plan").or(true),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    Ok(Stage::Whole(Box::new(Cluster {
        values: values.clone(),
        sizes: [values.whole("min_points").unwrap_or(1), values.whole("max_points").unwrap_or(u64::MAX)],
        tolerance: values.number("tolerance").unwrap_or(1.0),
        is_flat: !values.is_on("is3d"),
        place: 0,
    })))
}

struct Cluster {
    values: Values,
    /// Points of the smallest and of the largest group.
    sizes: [u64; 2],
    tolerance: f64,
    /// Whether distances are those in the plan.
    is_flat: bool,
    /// The place of the numbers.
    place: usize,
}

/// The groups of points that hang together, in the order of their first points; each point is in one. `None` when
/// interrupted.
fn groups(positions: &[[f64; 3]], tolerance: f64, interrupted: &dyn Fn() -> bool) -> Option<Vec<Vec<usize>>> {
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(positions) else { return Some(Vec::new()) };
    let mut is_taken = vec![false; positions.len()];
    let mut groups = Vec::new();
    let mut asked = 0;
    for seed in 0..positions.len() {
        if std::mem::replace(&mut is_taken[seed], true) {
            continue;
        }
        let mut group = vec![seed];
        let mut at = 0;
        while let Some(&member) = group.get(at) {
            at += 1;
            asked += 1;
            if asked % BLOCK == 0 && interrupted() {
                return None;
            }
            let near = tree
                .query(&positions[member])
                .within::<SquaredEuclidean<f64>>(tolerance * tolerance)
                .exclusive_boundaries()
                .unsorted()
                .execute();
            for hit in near {
                let other = hit.item as usize;
                if !std::mem::replace(&mut is_taken[other], true) {
                    group.push(other);
                }
            }
        }
        groups.push(group);
    }
    Some(groups)
}

impl Whole for Cluster {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.place = flow.layout.add(CLUSTER, NumberType::I64);
        Ok(())
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        let mut positions = points.finite_positions().map_err(|i| self.values.place().not_finite(i))?;
        if self.is_flat {
            for position in &mut positions {
                position[2] = 0.0;
            }
        }
        let groups =
            groups(&positions, self.tolerance, &|| context.observer.interrupted()).ok_or(Error::Interrupted)?;
        let [least, most] = self.sizes;
        let numbered = groups.into_iter().filter(|group| (least..=most).contains(&(group.len() as u64)));
        for (number, group) in (1_u32..).zip(numbered) {
            for i in group {
                if !points.column_mut(self.place).set(i, f64::from(number)) {
                    let found = format!("the number {number} for {CLUSTER}");
                    let kind = points.layout().dimensions()[self.place].kind;
                    let expected = format!("fewer groups, for it has the type {kind} already");
                    return Err(self.values.place().fault(found, expected).into());
                }
            }
        }
        Ok(vec![points])
    }
}

#[cfg(test)]
mod tests {
    use super::groups;

    #[test]
    fn what_is_nearer_than_the_tolerance_hangs_together() {
        // Steps of 1, 1, 3, 0.5: points at exactly the tolerance are apart.
        let positions = [0.0, 1.0, 2.0, 5.0, 5.5].map(|x| [x, 0.0, 0.0]);
        let of = |tolerance| groups(&positions, tolerance, &|| false).unwrap();
        assert_eq!(of(1.1), [vec![0, 1, 2], vec![3, 4]]);
        assert_eq!(of(1.0), [vec![0], vec![1], vec![2], vec![3, 4]]);
        assert_eq!(of(3.1).len(), 1);
        assert_eq!(of(0.0).len(), 5);
        let many = vec![[0.0; 3]; 5000];
        assert_eq!(groups(&many, 1.0, &|| true), None);
    }
}
