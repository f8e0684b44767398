//! Running a pipeline.
//!
//! Points are pulled from the last stage backwards and pushed from the readers forwards, chunk by chunk: each stage asks
//! its inputs for their points, one input after the other, and hands on what comes at once, unless it has to see all points
//! of a view first. So memory stays flat where all stages stream, and the points of several inputs come in the order in
//! which the inputs are listed.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::expression::Condition;
use super::plan::{Plan, Planned};
use super::points::{Chosen, Layout, Points};
use super::stage::{Context, Flow, Observer, Stage, Whole};
use crate::error::{Error, InputError, Result};
use crate::report::Report;

/// The exit code when not all could be done.
const PARTIAL: u8 = 2;

/// A pipeline whose files have been opened and whose options have been held against what is in them.
pub struct Prepared {
    nodes: Vec<Node>,
    leaves: Vec<usize>,
}

/// What came of a pipeline.
#[derive(Debug)]
pub struct Outcome {
    /// What the stages have to tell, as PDAL's `--metadata` writes it.
    pub metadata: Value,
    /// The reports of reconstructions.
    pub reports: Vec<Report>,
    /// The exit code: 0, or 2 when points could not be read or a reconstruction lacks buildings.
    pub exit_code: u8,
}

/// A stage with what it needs to run.
struct Node {
    name: &'static str,
    inputs: Vec<usize>,
    stage: Stage,
    /// What comes in.
    incoming: Flow,
    /// Dimensions while the stage acts, and behind it.
    layout: Arc<Layout>,
    condition: Option<Condition<usize>>,
    is_conditional: bool,
    where_merge: Option<bool>,
    metadata: Map<String, Value>,
    runs: usize,
    /// Points of a view that has to be seen as a whole.
    view: Option<Points>,
    skipped: Option<Points>,
}

/// What goes from stage to stage.
enum Item {
    Chunk(Points),
    EndOfView,
}

type Next<'a> = dyn FnMut(Item) -> Result<()> + 'a;

impl Prepared {
    /// Opens the files of a plan and holds the options of its stages against what is in them.
    ///
    /// # Errors
    /// A file that cannot be read, or an option that does not go with the points.
    pub fn new(plan: &Plan, context: &Context<'_>) -> Result<Self> {
        let leaves = plan.leaves();
        let mut nodes: Vec<Node> = Vec::with_capacity(plan.stages.len());
        let mut flows: Vec<Flow> = Vec::with_capacity(plan.stages.len());
        for (number, planned) in plan.stages.iter().enumerate() {
            let incoming = Flow::join(planned.inputs.iter().filter_map(|&i| flows.get(i).cloned()).collect());
            let mut node = Node::new(planned, incoming)?;
            flows.push(node.prepare(leaves.contains(&number), context)?);
            node.bind(planned)?;
            nodes.push(node);
        }
        Ok(Self { nodes, leaves })
    }

    /// Whether no stage has to see all points before it can hand on one.
    pub fn is_streamable(&self) -> bool {
        self.nodes.iter().all(|node| match &node.stage {
            Stage::Whole(_) => false,
            Stage::Writer(writer) => writer.streams(),
            Stage::Reader(_) | Stage::Filter(_) | Stage::Merge => true,
        })
    }

    /// Runs it.
    ///
    /// # Errors
    /// A file that cannot be read or written, points that a stage cannot handle, or an interruption.
    pub fn run(mut self, context: &Context<'_>) -> Result<Outcome> {
        let mut outcome = Outcome { metadata: Value::Null, reports: Vec::new(), exit_code: 0 };
        for leaf in std::mem::take(&mut self.leaves) {
            let reads = self.reads(leaf);
            if reads {
                context.observer.started(self.points_of(leaf));
            }
            drive(&mut self.nodes, leaf, context, &mut outcome, &mut |_| Ok(()))?;
        }
        outcome.metadata = self.metadata();
        Ok(outcome)
    }

    /// Whether the points of a leaf's readers are read at all.
    fn reads(&self, leaf: usize) -> bool {
        !matches!(&self.nodes[leaf].stage, Stage::Writer(writer) if !writer.needs_points())
    }

    /// How many points the readers before a leaf read at most.
    fn points_of(&self, leaf: usize) -> Option<u64> {
        let node = &self.nodes[leaf];
        match node.stage {
            Stage::Reader(_) => node.incoming.points,
            _ => node.inputs.iter().map(|&input| self.points_of(input)).sum(),
        }
    }

    /// The metadata of all stages: several of one type are an array.
    fn metadata(&self) -> Value {
        let mut stages: Map<String, Value> = Map::new();
        for node in &self.nodes {
            // A reader whose file a writer reads itself has its header to tell of.
            let own = match &node.stage {
                Stage::Reader(reader) if node.runs == 0 => reader.metadata(),
                _ => node.metadata.clone(),
            };
            let own = Value::Object(own);
            match stages.get_mut(node.name) {
                None => {
                    stages.insert(node.name.to_owned(), own);
                }
                Some(Value::Array(several)) => several.push(own),
                Some(one) => {
                    let first = one.take();
                    *one = Value::Array(vec![first, own]);
                }
            }
        }
        json!({ "stages": stages })
    }
}

impl Node {
    fn new(planned: &Planned, incoming: Flow) -> Result<Self> {
        let where_merge = match planned.values.text("where_merge") {
            Some("true") => Some(true),
            Some("false") => Some(false),
            _ => None,
        };
        Ok(Self {
            name: planned.kind.name,
            inputs: planned.inputs.clone(),
            stage: (planned.kind.build)(&planned.values)?,
            incoming,
            layout: Arc::default(),
            condition: None,
            is_conditional: planned.condition.is_some(),
            where_merge,
            metadata: Map::new(),
            runs: 0,
            view: None,
            skipped: None,
        })
    }

    /// Prepares the stage for what comes in, and gives what goes out.
    fn prepare(&mut self, is_last: bool, context: &Context<'_>) -> Result<Flow> {
        let mut flow = self.incoming.clone();
        let takes_models = match &self.stage {
            Stage::Writer(writer) => writer.takes_models(),
            Stage::Merge => true,
            _ => false,
        };
        if let Some(model) = flow.model().filter(|_| !takes_models) {
            let found = format!("a city model, which has no points, as an input of {}", self.name);
            let fault = InputError::new(model, found, "writers.lod2 behind readers.lod2, and nothing between");
            return Err(fault.into());
        }
        match &mut self.stage {
            Stage::Reader(reader) => {
                flow = reader.prepare(context)?;
                self.incoming = flow.clone();
            }
            Stage::Filter(filter) => {
                filter.prepare(&mut flow)?;
                flow.files = None;
            }
            Stage::Whole(whole) => {
                whole.prepare(&mut flow)?;
                flow.files = None;
            }
            Stage::Merge => {}
            Stage::Writer(writer) => writer.prepare(&flow, is_last && !self.is_conditional)?,
        }
        self.layout = Arc::new(flow.layout.clone());
        Ok(flow)
    }

    /// Finds the dimensions of the condition of the stage.
    fn bind(&mut self, planned: &Planned) -> Result<()> {
        if let Some(condition) = &planned.condition {
            let bound =
                condition.bind(&self.incoming.layout).map_err(|misfit| planned.values.misfit("where", misfit))?;
            self.condition = Some(bound);
        }
        Ok(())
    }

    /// Takes what comes from an input.
    fn take(&mut self, item: Item, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        match item {
            Item::Chunk(mut points) => {
                points.conform(&self.layout);
                self.chunk(points, context, next)
            }
            Item::EndOfView => self.end_of_view(context, next),
        }
    }

    fn chunk(&mut self, mut points: Points, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        let chosen = self.condition.as_ref().map_or(Chosen::All, |condition| condition.choose(&points));
        match &mut self.stage {
            Stage::Reader(_) | Stage::Merge => next(Item::Chunk(points)),
            Stage::Filter(filter) => {
                filter.chunk(&mut points, &chosen)?;
                if points.is_empty() { Ok(()) } else { next(Item::Chunk(points)) }
            }
            Stage::Whole(_) => {
                let Chosen::Some(mask) = chosen else {
                    gather(&mut self.view, points);
                    return Ok(());
                };
                let mut skipped = points.clone();
                skipped.retain(&mask.iter().map(|chosen| !chosen).collect::<Vec<_>>());
                points.retain(&mask);
                gather(&mut self.skipped, skipped);
                gather(&mut self.view, points);
                Ok(())
            }
            Stage::Writer(writer) => {
                if let Chosen::Some(mask) = &chosen {
                    let mut written = points.clone();
                    written.retain(mask);
                    writer.write(&written, context)?;
                } else {
                    writer.write(&points, context)?;
                }
                next(Item::Chunk(points))
            }
        }
    }

    fn end_of_view(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        match &mut self.stage {
            Stage::Merge => return Ok(()),
            Stage::Filter(filter) => filter.end_view(),
            Stage::Writer(writer) => writer.end_view(context)?,
            Stage::Reader(_) => {}
            Stage::Whole(whole) => {
                let view = self.view.take();
                return hand_on(&mut **whole, view, self.skipped.take(), self.where_merge, context, next);
            }
        }
        next(Item::EndOfView)
    }

    fn finish(&mut self, context: &Context<'_>, outcome: &mut Outcome, next: &mut Next<'_>) -> Result<()> {
        self.metadata = match &mut self.stage {
            Stage::Reader(reader) => {
                if !reader.is_whole() {
                    outcome.exit_code = PARTIAL;
                }
                reader.metadata()
            }
            Stage::Merge => {
                next(Item::EndOfView)?;
                Map::new()
            }
            Stage::Filter(filter) => {
                filter.finish(context);
                filter.metadata()
            }
            Stage::Whole(whole) => {
                for view in whole.finish(context)? {
                    next(Item::Chunk(view))?;
                    next(Item::EndOfView)?;
                }
                whole.metadata()
            }
            Stage::Writer(writer) => {
                if writer.needs_points() {
                    context.observer.finished();
                }
                let finished = writer.finish(context)?;
                outcome.exit_code = outcome.exit_code.max(finished.exit_code);
                outcome.reports.extend(finished.report);
                finished.metadata
            }
        };
        Ok(())
    }
}

/// Puts points behind those that are there.
fn gather(view: &mut Option<Points>, points: Points) {
    match view {
        Some(view) => view.append(points),
        None => *view = Some(points),
    }
}

/// Lets a stage act on a view, and hands on what it gives and what `where` left out.
fn hand_on(
    whole: &mut dyn Whole,
    view: Option<Points>,
    skipped: Option<Points>,
    where_merge: Option<bool>,
    context: &Context<'_>,
    next: &mut Next<'_>,
) -> Result<()> {
    let given = view.as_ref().map_or(0, Points::len);
    let mut views = match view {
        Some(view) if !view.is_empty() => whole.view(view, context)?,
        _ => Vec::new(),
    };
    if let Some(skipped) = skipped.filter(|skipped| !skipped.is_empty()) {
        let is_same = matches!(views.as_slice(), [only] if only.len() == given);
        match views.first_mut() {
            Some(first) if where_merge.unwrap_or(is_same) => first.append(skipped),
            _ => views.push(skipped),
        }
    }
    for view in views {
        if context.observer.interrupted() {
            return Err(Error::Interrupted);
        }
        next(Item::Chunk(view))?;
        next(Item::EndOfView)?;
    }
    Ok(())
}

/// Lets the points of stage `number` come, after those of its inputs.
fn drive(
    nodes: &mut [Node],
    number: usize,
    context: &Context<'_>,
    outcome: &mut Outcome,
    next: &mut Next<'_>,
) -> Result<()> {
    let (before, rest) = nodes.split_at_mut(number);
    let Some(node) = rest.first_mut() else { return Ok(()) };
    if node.runs > 0 {
        // Two stages take its points: it starts anew, as in PDAL.
        node.prepare(false, context)?;
    }
    node.runs += 1;
    if let Stage::Reader(reader) = &mut node.stage {
        reader.read(context, &mut |points| {
            if context.observer.interrupted() {
                return Err(Error::Interrupted);
            }
            next(Item::Chunk(points))
        })?;
        next(Item::EndOfView)?;
    } else if !matches!(&node.stage, Stage::Writer(writer) if !writer.needs_points()) {
        for input in node.inputs.clone() {
            drive(before, input, context, outcome, &mut |item| node.take(item, context, next))?;
        }
    }
    node.finish(context, outcome, next)
}

/// What `--validate` says of a pipeline: whether it can be run, whether it streams, and what is wrong with it.
pub fn validate(plan: Result<Plan>, observer: &dyn Observer) -> Value {
    let context = Context { observer, command: &[] };
    let prepared = plan.and_then(|plan| Prepared::new(&plan, &context));
    match prepared {
        Ok(prepared) => json!({ "valid": true, "streamable": prepared.is_streamable(), "error_detail": "" }),
        Err(error) => json!({ "valid": false, "streamable": false, "error_detail": error.to_string() }),
    }
}
