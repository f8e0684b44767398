//! What a stage is to the rest of the pipeline.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Value};

use super::options::{Kind, OptionSpec, Values};
use super::points::{Chosen, Layout, Points};
use crate::error::Result;
use crate::report::Report;
use crate::run;
use crate::source::crs::Crs;
use crate::source::points::Extent;

/// Whether a stage gives points, changes them or takes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Gives points.
    Reader,
    /// Changes or drops points.
    Filter,
    /// Writes points and passes them on.
    Writer,
}

/// A type of stages.
#[derive(Debug, Clone, Copy)]
pub struct StageKind {
    /// Its name, such as `filters.crop`.
    pub name: &'static str,
    /// What it does, as a sentence without a full stop.
    pub summary: &'static str,
    /// Its role.
    pub role: Role,
    /// Its own options; those that all stages of a role have come on top.
    pub options: fn() -> Vec<OptionSpec>,
    /// The options that PDAL's stage of that name has and this one has not.
    pub elsewhere: &'static [&'static str],
    /// When it needs to see all points before it can give one, in words; `""` for never.
    pub collects: &'static str,
    /// Makes a stage with these options.
    pub build: fn(&Values) -> Result<Stage>,
}

impl StageKind {
    /// All its options.
    pub fn table(&self) -> Vec<OptionSpec> {
        let mut table = (self.options)();
        if self.role != Role::Reader {
            let help = match self.role {
                Role::Writer => "Writes only points that satisfy this expression, such as `Classification == 6`",
                _ => "Acts only on points that satisfy this expression, such as `Classification == 6`; others pass by",
            };
            table.push(OptionSpec::new("where", Kind::Text, help));
        }
        if self.role == Role::Filter {
            let ways = Kind::choice(&[
                ("auto", "behind the points of the stage where it gave as many as it got, else on their own"),
                ("true", "behind the first points that the stage gave"),
                ("false", "on their own"),
            ]);
            let help = "Where points that `where` leaves out go, for stages that collect points";
            table.push(OptionSpec::new("where_merge", ways, help).or("auto"));
        }
        table.push(OptionSpec::new("user_data", Kind::Anything, "Anything; it goes into the serialization only"));
        table
    }

    /// Its name without what stands before the dot.
    pub fn short_name(&self) -> &'static str {
        self.name.split_once('.').map_or(self.name, |(_, name)| name)
    }
}

/// A stage, ready to be prepared and run.
pub enum Stage {
    /// Gives points.
    Reader(Box<dyn Reader>),
    /// Changes points chunk by chunk.
    Filter(Box<dyn Filter>),
    /// Needs all points of a view at once.
    Whole(Box<dyn Whole>),
    /// Makes one view of all.
    Merge,
    /// Writes points.
    Writer(Box<dyn Writer>),
}

/// What is known of the points between two stages before one of them was read.
#[derive(Debug, Clone, Default)]
pub struct Flow {
    /// Their dimensions.
    pub layout: Layout,
    /// Their CRS; `None` where it is not known or not all have the same.
    pub crs: Option<Arc<Crs>>,
    /// Whether not all have the same CRS.
    pub is_mixed: bool,
    /// The areas that were scanned, CRS units; `None` where nobody knows, so that the extent of the points must do.
    pub areas: Option<Vec<Extent>>,
    /// How many points there are at most; `None` where nobody knows.
    pub points: Option<u64>,
    /// The headers of the files that they came from.
    pub headers: Vec<Arc<las::Header>>,
    /// The files whose contents they are, whole and unchanged; `None` once anything may have been changed.
    pub files: Option<Vec<SourceFile>>,
}

/// A file that stages may read on their own instead of having its points handed to them.
#[derive(Debug, Clone, PartialEq)]
pub enum SourceFile {
    /// A LAS, LAZ or COPC file.
    Tile {
        /// The file.
        path: PathBuf,
        /// The CRS that it is to have, whatever it says.
        crs: Option<String>,
    },
    /// A CityJSON file, which has no points at all.
    Model(PathBuf),
}

impl Flow {
    /// The first city model among the files.
    pub fn model(&self) -> Option<&Path> {
        self.files.iter().flatten().find_map(|file| match file {
            SourceFile::Model(path) => Some(path.as_path()),
            SourceFile::Tile { .. } => None,
        })
    }

    /// What several flows are together.
    pub fn join(flows: Vec<Self>) -> Self {
        let mut flows = flows.into_iter();
        let Some(mut all) = flows.next() else { return Self::default() };
        for flow in flows {
            all.layout.join(&flow.layout);
            all.is_mixed |= flow.is_mixed || all.crs != flow.crs;
            all.areas = both(all.areas, flow.areas);
            all.points = all.points.zip(flow.points).map(|(a, b)| a + b);
            all.headers.extend(flow.headers);
            all.files = both(all.files, flow.files);
        }
        if all.is_mixed {
            all.crs = None;
        }
        all
    }
}

/// Two lists as one, when both are known.
fn both<T>(first: Option<Vec<T>>, second: Option<Vec<T>>) -> Option<Vec<T>> {
    let (mut first, second) = first.zip(second)?;
    first.extend(second);
    Some(first)
}

/// Where a stage hands its points.
pub type Next<'a> = dyn FnMut(Points) -> Result<()> + 'a;

/// Gives points.
pub trait Reader {
    /// Opens the file and says what it holds.
    ///
    /// # Errors
    /// The file cannot be read.
    fn prepare(&mut self, context: &Context<'_>) -> Result<Flow>;

    /// Hands all points to `next`, in the layout that [`Self::prepare`] gave.
    ///
    /// # Errors
    /// The file cannot be read, or what `next` says.
    fn read(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()>;

    /// Whether all points that there should be could be read.
    fn is_whole(&self) -> bool {
        true
    }

    /// What it has to tell.
    fn metadata(&self) -> Map<String, Value>;
}

/// Changes points chunk by chunk.
pub trait Filter {
    /// Learns what comes, says what goes, and forgets what it knew of earlier points.
    ///
    /// # Errors
    /// Dimensions that are missing, or options that do not go with the points.
    fn prepare(&mut self, flow: &mut Flow) -> Result<()>;

    /// Changes the chosen points, or drops them; they come in the layout that [`Self::prepare`] left.
    ///
    /// # Errors
    /// Points that it cannot handle.
    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()>;

    /// A view is over.
    fn end_view(&mut self) {}

    /// All points have been seen.
    fn finish(&mut self, _context: &Context<'_>) {}

    /// What it has to tell.
    fn metadata(&self) -> Map<String, Value> {
        Map::new()
    }
}

/// Needs all points of a view at once.
pub trait Whole {
    /// As [`Filter::prepare`].
    ///
    /// # Errors
    /// As [`Filter::prepare`].
    fn prepare(&mut self, flow: &mut Flow) -> Result<()>;

    /// Takes a view, which is not empty, in the layout that [`Self::prepare`] left; gives the views that are complete.
    ///
    /// # Errors
    /// Points that it cannot handle.
    fn view(&mut self, points: Points, context: &Context<'_>) -> Result<Vec<Points>>;

    /// All views have been seen: gives those that it had to keep until now.
    ///
    /// # Errors
    /// Points that it cannot handle.
    fn finish(&mut self, _context: &Context<'_>) -> Result<Vec<Points>> {
        Ok(Vec::new())
    }

    /// What it has to tell.
    fn metadata(&self) -> Map<String, Value> {
        Map::new()
    }
}

/// Writes points.
pub trait Writer {
    /// Learns what comes. `is_last` says that nobody waits for the points behind it.
    ///
    /// # Errors
    /// Dimensions that are missing, or options that do not go with the points.
    fn prepare(&mut self, flow: &Flow, is_last: bool) -> Result<()>;

    /// Whether city models, which have no points, may come in.
    fn takes_models(&self) -> bool {
        false
    }

    /// Whether points must be handed to it; a writer that reads the files itself needs none.
    fn needs_points(&self) -> bool {
        true
    }

    /// Whether it can write as points come; one that cannot must keep them.
    fn streams(&self) -> bool {
        true
    }

    /// Writes points, in the layout of the flow that it was prepared with.
    ///
    /// # Errors
    /// The file cannot be written, or cannot hold such points.
    fn write(&mut self, points: &Points, context: &Context<'_>) -> Result<()>;

    /// A view is over.
    ///
    /// # Errors
    /// As [`Self::write`].
    fn end_view(&mut self, _context: &Context<'_>) -> Result<()> {
        Ok(())
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// As [`Self::write`].
    fn finish(&mut self, context: &Context<'_>) -> Result<Finished>;
}

/// What a writer leaves.
#[derive(Debug, Default)]
pub struct Finished {
    /// What it has to tell.
    pub metadata: Map<String, Value>,
    /// The report of a reconstruction.
    pub report: Option<Report>,
    /// The exit code that it asks for: 0, or 2 when not all could be done.
    pub exit_code: u8,
}

/// What stages know of the run.
pub struct Context<'a> {
    /// Who listens.
    pub observer: &'a dyn Observer,
    /// The command line, for reports.
    pub command: &'a [String],
}

impl Context<'_> {
    /// Tells something that the user should know and that stops nothing.
    pub fn warn(&self, text: &str) {
        self.observer.warning(text);
    }
}

/// Listens to a pipeline.
pub trait Observer: Sync {
    /// Points are about to be read, at most so many.
    fn started(&self, _points: Option<u64>) {}

    /// So many more points have been read.
    fn advanced(&self, _points: u64) {}

    /// All points have been read.
    fn finished(&self) {}

    /// A file is about to be written.
    fn ready(&self, _file: &Path) {}

    /// A file is complete.
    fn done(&self, _file: &Path) {}

    /// Something that the user should know and that stops nothing.
    fn warning(&self, _text: &str) {}

    /// Whether to stop.
    fn interrupted(&self) -> bool {
        false
    }

    /// Listens to a reconstruction.
    fn reconstruction(&self) -> &dyn run::Observer {
        &run::Silent
    }
}

/// Listens to nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {}
