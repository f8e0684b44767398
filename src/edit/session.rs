//! One building while it is edited.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Figures;
use crate::building::Building;
use crate::edits::Edit;
use crate::guard::guarded;
use crate::reconstruct::occupancy::Occupancy;
use crate::reconstruct::{Memory, Parameters, Steps, reconstruct_again};
use crate::site::Site;

/// One building while it is edited: its site, what was made of it, and all edits that were done and undone.
#[derive(Debug)]
pub struct Session {
    /// What is known of the building, with the edits that are done.
    site: Site,
    notes: Vec<String>,
    parameters: Parameters,
    field: Arc<dyn Occupancy>,
    memory: Memory,
    /// The edits that were undone, the last one undone at the end.
    undone: Vec<Edit>,
    /// What the building was without any edit.
    before: Figures,
    now: Solved,
}

/// What was made of a building.
#[derive(Debug, Clone)]
pub struct Solved {
    /// The building: that of a run with these edits, to the last bit.
    pub building: Building,
    /// How it was made.
    pub steps: Steps,
    /// How long that took.
    pub took: Duration,
}

impl Session {
    /// Takes up a building as it was scanned, with edits from before; `notes` are those of its site.
    ///
    /// # Errors
    /// The method breaks on it; the message says where.
    pub fn open(
        site: Site,
        notes: Vec<String>,
        parameters: Parameters,
        field: Arc<dyn Occupancy>,
        edits: Vec<Edit>,
    ) -> Result<Self, String> {
        let memory = Memory::default();
        let site = Site { edits: Vec::new(), ..site };
        let first = solve(&site, &notes, &parameters, &*field, &memory)?;
        let before = Figures::of(&first.building);
        let mut session = Self { site, notes, parameters, field, memory, undone: Vec::new(), before, now: first };
        if !edits.is_empty() {
            session.site.edits = edits;
            session.now = session.solve()?;
        }
        Ok(session)
    }

    /// Does an edit. What was undone can no longer be done again.
    ///
    /// # Errors
    /// The method breaks on it; then nothing has changed.
    pub fn edit(&mut self, edit: Edit) -> Result<&Solved, String> {
        self.site.edits.push(edit);
        match self.solve() {
            Ok(solved) => {
                self.now = solved;
                self.undone.clear();
                Ok(&self.now)
            }
            Err(why) => {
                self.site.edits.pop();
                Err(why)
            }
        }
    }

    /// Undoes the last edit; `false` where there is none.
    ///
    /// # Errors
    /// Never in practice: the method did not break on what was before.
    pub fn undo(&mut self) -> Result<bool, String> {
        let Some(last) = self.site.edits.pop() else { return Ok(false) };
        self.undone.push(last);
        self.now = self.solve()?;
        Ok(true)
    }

    /// Does the edit again that was undone last; `false` where there is none.
    ///
    /// # Errors
    /// Never in practice: the method did not break on it before.
    pub fn redo(&mut self) -> Result<bool, String> {
        let Some(next) = self.undone.pop() else { return Ok(false) };
        self.site.edits.push(next);
        self.now = self.solve()?;
        Ok(true)
    }

    /// The edits that are done, first to last.
    pub fn edits(&self) -> &[Edit] {
        &self.site.edits
    }

    /// How many edits can be done again.
    pub fn undone(&self) -> usize {
        self.undone.len()
    }

    /// What is known of the building.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// What was made of it.
    pub fn now(&self) -> &Solved {
        &self.now
    }

    /// The figures of the building without any edit.
    pub fn before(&self) -> &Figures {
        &self.before
    }

    fn solve(&self) -> Result<Solved, String> {
        solve(&self.site, &self.notes, &self.parameters, &*self.field, &self.memory)
    }
}

fn solve(
    site: &Site,
    notes: &[String],
    parameters: &Parameters,
    field: &dyn Occupancy,
    memory: &Memory,
) -> Result<Solved, String> {
    let started = Instant::now();
    let (mut building, steps) = guarded(|| reconstruct_again(site, parameters, field, memory))?;
    building.notes.splice(0..0, notes.iter().cloned());
    Ok(Solved { building, steps, took: started.elapsed() })
}
