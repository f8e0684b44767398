//! Maximum flow and minimum cut by the augmenting-path algorithm of Boykov and Kolmogorov (2004), on integers.
//!
//! Two search trees grow from the source and from the sink; where they touch, flow is pushed, and the branches that
//! a saturated arc cuts off are adopted again. Capacities are integers, so the cut is exact and the same everywhere.

use std::collections::VecDeque;

/// Parent of a node that belongs to no tree.
const FREE: u32 = u32::MAX;
/// Parent of a node that hangs on its terminal.
const TERMINAL: u32 = u32::MAX - 1;
/// Parent of a node that was cut off and waits for adoption.
const ORPHAN: u32 = u32::MAX - 2;
/// End of the list of arcs of a node.
const NO_ARC: u32 = u32::MAX;

/// A directed arc; its reverse is its neighbour in the list (index with the last bit flipped).
#[derive(Debug, Clone, Copy)]
struct Arc {
    head: u32,
    next: u32,
    residual: i64,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    /// Residual capacity from the source where positive, to the sink where negative.
    terminal: i64,
    first: u32,
    /// Arc to the parent, or [`FREE`], [`TERMINAL`], [`ORPHAN`].
    parent: u32,
    /// Tree of the node, if it has a parent.
    sink: bool,
    queued: bool,
    /// When `distance` was last known to be right.
    stamp: u32,
    /// Arcs to the terminal.
    distance: u32,
}

/// A network of nodes between a source and a sink.
#[derive(Debug, Clone)]
pub struct Network {
    nodes: Vec<Node>,
    arcs: Vec<Arc>,
    flow: i64,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    time: u32,
}

/// A minimum cut.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cut {
    /// Its capacity, equal to the maximum flow.
    pub capacity: i64,
    /// The nodes on the source's side: the smallest such set among all minimum cuts, hence unique.
    pub source_side: Vec<bool>,
}

impl Network {
    /// A network of `nodes` nodes without arcs; `arcs` is how many pairs of arcs to make room for.
    pub fn new(nodes: usize, arcs: usize) -> Self {
        let node = Node { terminal: 0, first: NO_ARC, parent: FREE, sink: false, queued: false, stamp: 0, distance: 0 };
        Self {
            nodes: vec![node; nodes],
            arcs: Vec::with_capacity(2 * arcs),
            flow: 0,
            active: VecDeque::new(),
            orphans: VecDeque::new(),
            time: 0,
        }
    }

    /// Adds arcs source → `node` and `node` → sink. Capacities are not negative; their sum over the whole network
    /// must stay below 2⁶³.
    pub fn add_terminals(&mut self, node: usize, from_source: i64, to_sink: i64) {
        // What flows straight through never limits anything else.
        let held = self.nodes[node].terminal;
        let (source, sink) = (from_source + held.max(0), to_sink + (-held).max(0));
        self.flow += source.min(sink);
        self.nodes[node].terminal = source - sink;
    }

    /// Adds arcs `a` → `b` and `b` → `a`, both of this capacity, not negative.
    pub fn add_edge(&mut self, a: usize, b: usize, capacity: i64) {
        self.add_arcs(a, b, [capacity; 2]);
    }

    /// Adds the arc `a` → `b` of this capacity, not negative; nothing flows back. With a capacity that no flow comes near,
    /// `b` is on the source side whenever `a` is.
    pub fn add_arc(&mut self, a: usize, b: usize, capacity: i64) {
        self.add_arcs(a, b, [capacity, 0]);
    }

    fn add_arcs(&mut self, a: usize, b: usize, capacities: [i64; 2]) {
        for ((from, to), residual) in [(a, b), (b, a)].into_iter().zip(capacities) {
            let arc = self.arcs.len() as u32;
            self.arcs.push(Arc { head: to as u32, next: self.nodes[from].first, residual });
            self.nodes[from].first = arc;
        }
    }

    /// Pushes the maximum flow and returns the minimum cut.
    pub fn cut(mut self) -> Cut {
        for i in 0..self.nodes.len() {
            let node = &mut self.nodes[i];
            if node.terminal != 0 {
                node.sink = node.terminal < 0;
                node.parent = TERMINAL;
                node.distance = 1;
                self.activate(i as u32);
            }
        }
        while let Some(&i) = self.active.front() {
            // The node stays at the front while it still finds paths: its neighbourhood is warm.
            let path = if self.nodes[i as usize].parent == FREE { None } else { self.grow(i) };
            if let Some(bridge) = path {
                self.time += 1;
                self.augment(bridge);
                while let Some(orphan) = self.orphans.pop_front() {
                    self.adopt(orphan);
                }
            } else {
                self.active.pop_front();
                self.nodes[i as usize].queued = false;
            }
        }
        let source_side = self.nodes.iter().map(|n| n.parent != FREE && !n.sink).collect();
        Cut { capacity: self.flow, source_side }
    }

    fn activate(&mut self, node: u32) {
        if !std::mem::replace(&mut self.nodes[node as usize].queued, true) {
            self.active.push_back(node);
        }
    }

    /// Residual capacity along the arc in the direction of flow, seen from a node of the source or sink tree towards
    /// its child.
    fn towards_child(&self, arc: u32, sink: bool) -> i64 {
        self.arcs[(if sink { arc ^ 1 } else { arc }) as usize].residual
    }

    /// Grows the tree of `i` by its free neighbours; returns an arc from the source tree to the sink tree.
    fn grow(&mut self, i: u32) -> Option<u32> {
        let Node { sink, stamp, distance, first, .. } = self.nodes[i as usize];
        let mut arc = first;
        while arc != NO_ARC {
            let Arc { head, next, .. } = self.arcs[arc as usize];
            if self.towards_child(arc, sink) > 0 {
                let other = &mut self.nodes[head as usize];
                if other.parent == FREE {
                    (other.sink, other.parent, other.stamp, other.distance) = (sink, arc ^ 1, stamp, distance + 1);
                    self.activate(head);
                } else if other.sink != sink {
                    return Some(if sink { arc ^ 1 } else { arc });
                } else if other.stamp <= stamp && other.distance > distance {
                    // A shorter way to the terminal.
                    (other.parent, other.stamp, other.distance) = (arc ^ 1, stamp, distance + 1);
                }
            }
            arc = next;
        }
        None
    }

    /// Pushes as much as the path through `bridge` takes; nodes whose arc to the parent is saturated become orphans.
    fn augment(&mut self, bridge: u32) {
        let ends = [self.arcs[(bridge ^ 1) as usize].head, self.arcs[bridge as usize].head];
        let mut amount = self.arcs[bridge as usize].residual;
        for (start, sink) in [(ends[0], false), (ends[1], true)] {
            let mut i = start;
            loop {
                let node = &self.nodes[i as usize];
                if node.parent == TERMINAL {
                    amount = amount.min(node.terminal.abs());
                    break;
                }
                // The arc of flow between parent and child: down in the source tree, up in the sink tree.
                amount = amount.min(self.arcs[(if sink { node.parent } else { node.parent ^ 1 }) as usize].residual);
                i = self.arcs[node.parent as usize].head;
            }
        }
        self.push(bridge, amount);
        for (start, sink) in [(ends[0], false), (ends[1], true)] {
            let mut i = start;
            loop {
                let parent = self.nodes[i as usize].parent;
                if parent == TERMINAL {
                    let node = &mut self.nodes[i as usize];
                    node.terminal -= if sink { -amount } else { amount };
                    if node.terminal == 0 {
                        node.parent = ORPHAN;
                        self.orphans.push_front(i);
                    }
                    break;
                }
                let along = if sink { parent } else { parent ^ 1 };
                self.push(along, amount);
                if self.arcs[along as usize].residual == 0 {
                    self.nodes[i as usize].parent = ORPHAN;
                    self.orphans.push_front(i);
                }
                i = self.arcs[parent as usize].head;
            }
        }
        self.flow += amount;
    }

    fn push(&mut self, arc: u32, amount: i64) {
        self.arcs[arc as usize].residual -= amount;
        self.arcs[(arc ^ 1) as usize].residual += amount;
    }

    /// Finds a new parent for an orphan, the nearest to the terminal, or frees it and orphans its children.
    fn adopt(&mut self, i: u32) {
        let Node { sink, first, .. } = self.nodes[i as usize];
        let mut best = None;
        let mut arc = first;
        while arc != NO_ARC {
            let Arc { head, next, .. } = self.arcs[arc as usize];
            let other = &self.nodes[head as usize];
            if other.sink == sink
                && other.parent != FREE
                && self.towards_child(arc ^ 1, sink) > 0
                && let Some(distance) = self.distance(head)
                && best.is_none_or(|(_, shortest)| distance < shortest)
            {
                best = Some((arc, distance));
            }
            arc = next;
        }
        if let Some((parent, distance)) = best {
            let node = &mut self.nodes[i as usize];
            (node.parent, node.stamp, node.distance) = (parent, self.time, distance + 1);
            return;
        }
        let mut arc = first;
        while arc != NO_ARC {
            let Arc { head, next, .. } = self.arcs[arc as usize];
            let Node { sink: tree, parent, .. } = self.nodes[head as usize];
            if tree == sink && parent != FREE {
                if self.towards_child(arc ^ 1, sink) > 0 {
                    self.activate(head);
                }
                if parent < ORPHAN && self.arcs[parent as usize].head == i {
                    self.nodes[head as usize].parent = ORPHAN;
                    self.orphans.push_back(head);
                }
            }
            arc = next;
        }
        self.nodes[i as usize].parent = FREE;
    }

    /// Number of arcs to the terminal, or `None` where the way up ends at an orphan. Marks the way for later.
    fn distance(&mut self, start: u32) -> Option<u32> {
        let mut steps = 0;
        let mut i = start;
        let total = loop {
            let node = &mut self.nodes[i as usize];
            if node.stamp == self.time {
                break steps + node.distance;
            }
            steps += 1;
            match node.parent {
                TERMINAL => {
                    (node.stamp, node.distance) = (self.time, 1);
                    break steps;
                }
                ORPHAN | FREE => return None,
                parent => i = self.arcs[parent as usize].head,
            }
        };
        let mut left = total;
        let mut i = start;
        while self.nodes[i as usize].stamp != self.time {
            let node = &mut self.nodes[i as usize];
            (node.stamp, node.distance) = (self.time, left);
            left -= 1;
            i = self.arcs[node.parent as usize].head;
        }
        Some(total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, Clone)]
    struct Problem {
        terminals: Vec<(i64, i64)>,
        edges: Vec<(usize, usize, i64)>,
    }

    fn solve(problem: &Problem) -> Cut {
        let mut network = Network::new(problem.terminals.len(), problem.edges.len());
        for (i, &(source, sink)) in problem.terminals.iter().enumerate() {
            network.add_terminals(i, source, sink);
        }
        for &(a, b, capacity) in &problem.edges {
            network.add_edge(a, b, capacity);
        }
        network.cut()
    }

    fn energy(problem: &Problem, side: impl Fn(usize) -> bool) -> i64 {
        let data: i64 = problem.terminals.iter().enumerate().map(|(i, &(s, t))| if side(i) { t } else { s }).sum();
        data + problem.edges.iter().filter(|&&(a, b, _)| side(a) != side(b)).map(|&(_, _, c)| c).sum::<i64>()
    }

    fn problems() -> impl Strategy<Value = Problem> {
        (1usize..11).prop_flat_map(|n| {
            let terminals = prop::collection::vec((0i64..40, 0i64..40), n);
            let edges = prop::collection::vec((0..n, 0..n, 0i64..30), 0..3 * n);
            (terminals, edges).prop_map(|(terminals, edges)| Problem {
                terminals,
                edges: edges.into_iter().filter(|&(a, b, _)| a != b).collect(),
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn cut_is_the_least_of_all_labellings(problem in problems()) {
            let cut = solve(&problem);
            let n = problem.terminals.len();
            let energies: Vec<i64> = (0u32..1 << n).map(|mask| energy(&problem, |i| mask >> i & 1 == 1)).collect();
            let least = energies.iter().copied().min().unwrap();
            prop_assert_eq!(cut.capacity, least);
            // The source side is the intersection of all optimal source sides.
            let common = (0u32..1 << n).filter(|&m| energies[m as usize] == least).fold(u32::MAX, |a, m| a & m);
            for (i, &side) in cut.source_side.iter().enumerate() {
                prop_assert_eq!(side, common >> i & 1 == 1);
            }
        }
    }

    #[test]
    fn a_chain_breaks_at_its_weakest_link() {
        let problem = Problem { terminals: vec![(10, 0), (0, 0), (0, 10)], edges: vec![(0, 1, 5), (1, 2, 3)] };
        let cut = solve(&problem);
        assert_eq!((cut.capacity, cut.source_side), (3, vec![true, true, false]));
    }

    #[test]
    fn a_large_grid_agrees_with_its_dual() {
        // 16 × 16 × 16 nodes: capacity of the returned cut, counted anew, equals the pushed flow.
        let n = 16usize;
        let at = |x: usize, y: usize, z: usize| (x * n + y) * n + z;
        let mut state = 1u64;
        let mut random = |bound: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % bound) as i64
        };
        let mut problem = Problem { terminals: vec![], edges: vec![] };
        for x in 0..n {
            for y in 0..n {
                for z in 0..n {
                    problem.terminals.push((random(100), random(100)));
                    for (a, b, c) in [(1, 0, 0), (0, 1, 0), (0, 0, 1)] {
                        if x + a < n && y + b < n && z + c < n {
                            problem.edges.push((at(x, y, z), at(x + a, y + b, z + c), random(30)));
                        }
                    }
                }
            }
        }
        let cut = solve(&problem);
        assert_eq!(cut.capacity, energy(&problem, |i| cut.source_side[i]));
    }
}
