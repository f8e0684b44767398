//! One building while it is edited.

use std::sync::Arc;
use std::time::{Duration, Instant};

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
    before: Building,
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
    /// Takes up a building as it was scanned, with edits from before, and those that were undone (the last one undone at the
    /// end); `notes` are those of its site.
    ///
    /// # Errors
    /// The method breaks on it; the message says where.
    pub fn open(
        site: Site,
        notes: Vec<String>,
        parameters: Parameters,
        field: Arc<dyn Occupancy>,
        edits: Vec<Edit>,
        undone: Vec<Edit>,
    ) -> Result<Self, String> {
        let memory = Memory::default();
        let site = Site { edits: Vec::new(), ..site };
        let first = solve(&site, &notes, &parameters, &*field, &memory)?;
        let before = first.building.clone();
        let mut session = Self { site, notes, parameters, field, memory, undone, before, now: first };
        if !edits.is_empty() {
            session.follow(edits)?;
        }
        Ok(session)
    }

    /// Does an edit. What was undone can no longer be done again.
    ///
    /// # Errors
    /// The method breaks on it; then nothing has changed.
    pub fn edit(&mut self, edit: Edit) -> Result<&Solved, String> {
        let mut edits = self.site.edits.clone();
        edits.push(edit);
        self.follow(edits)?;
        self.undone.clear();
        Ok(&self.now)
    }

    /// Undoes the last edit; `false` where there is none.
    ///
    /// # Errors
    /// Never in practice: the method did not break on what was before. Then nothing has changed.
    pub fn undo(&mut self) -> Result<bool, String> {
        let mut edits = self.site.edits.clone();
        let Some(last) = edits.pop() else { return Ok(false) };
        self.follow(edits)?;
        self.undone.push(last);
        Ok(true)
    }

    /// Does the edit again that was undone last; `false` where there is none.
    ///
    /// # Errors
    /// Never in practice: the method did not break on it before. Then nothing has changed.
    pub fn redo(&mut self) -> Result<bool, String> {
        let Some(next) = self.undone.last().cloned() else { return Ok(false) };
        let mut edits = self.site.edits.clone();
        edits.push(next);
        self.follow(edits)?;
        self.undone.pop();
        Ok(true)
    }

    /// Undoes all edits; `false` where there is none. Each can be done again.
    ///
    /// # Errors
    /// Never in practice: the method did not break on the building before. Then nothing has changed.
    pub fn clear(&mut self) -> Result<bool, String> {
        let edits = self.site.edits.clone();
        if edits.is_empty() {
            return Ok(false);
        }
        self.follow(Vec::new())?;
        self.undone.extend(edits.into_iter().rev());
        Ok(true)
    }

    /// The edits that are done, first to last.
    pub fn edits(&self) -> &[Edit] {
        &self.site.edits
    }

    /// The edits that were undone, the last one undone at the end.
    pub fn undone(&self) -> &[Edit] {
        &self.undone
    }

    /// What is known of the building.
    pub fn site(&self) -> &Site {
        &self.site
    }

    /// What was made of it.
    pub fn now(&self) -> &Solved {
        &self.now
    }

    /// The building without any edit.
    pub fn before(&self) -> &Building {
        &self.before
    }

    /// The parameters of all buildings, which edits may change for this one.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Makes the building by these edits and no others.
    fn follow(&mut self, edits: Vec<Edit>) -> Result<(), String> {
        let before = std::mem::replace(&mut self.site.edits, edits);
        match solve(&self.site, &self.notes, &self.parameters, &*self.field, &self.memory) {
            Ok(solved) => {
                self.now = solved;
                Ok(())
            }
            Err(why) => {
                self.site.edits = before;
                Err(why)
            }
        }
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
