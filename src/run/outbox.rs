//! Results that get done in any order, handed on in that of the model.

use std::collections::BTreeMap;
use std::time::Duration;

use super::records::{Record, Records};
use crate::building::Building;
use crate::error::{Error, InputError, Result};

/// So many buildings that wait for one before them are held in memory; the others wait in a file.
const IN_MEMORY: usize = 256;

/// A building and what it cost.
pub(super) struct Done {
    pub(super) building: Building,
    pub(super) wall: Duration,
    pub(super) cpu: Option<Duration>,
    /// Whether an earlier run made it.
    pub(super) resumed: bool,
    /// The hash of what was known of it before.
    pub(super) inputs: u64,
    /// Whether it is among the records.
    pub(super) is_kept: bool,
}

/// Buildings that wait for one before them.
pub(super) struct Outbox<'a> {
    records: &'a Records,
    /// The place of the next one that is handed on.
    next: usize,
    held: BTreeMap<usize, Held>,
    in_memory: usize,
}

enum Held {
    Here(Box<Done>),
    /// Among the records; whether an earlier run made it.
    Kept(bool),
}

impl<'a> Outbox<'a> {
    /// Nothing is done yet; what there is no memory for waits among the `records`.
    pub(super) fn new(records: &'a Records) -> Self {
        Self { records, next: 0, held: BTreeMap::new(), in_memory: 0 }
    }

    /// Takes the building of a place, and hands on to `each` what then is next.
    ///
    /// # Errors
    /// What `each` says, or the records cannot be written or read.
    pub(super) fn put(
        &mut self,
        place: usize,
        done: Done,
        each: &mut impl FnMut(usize, Done) -> Result<()>,
    ) -> Result<()> {
        if place == self.next {
            self.next += 1;
            each(place, done)?;
            return self.hand_on(each);
        }
        if self.in_memory < IN_MEMORY {
            self.in_memory += 1;
            self.held.insert(place, Held::Here(Box::new(done)));
            return Ok(());
        }
        let Done { building, wall, cpu, resumed, inputs, is_kept } = done;
        if !is_kept {
            self.records.keep(&Record { index: place, inputs, wall, cpu, building: &building })?;
        }
        self.held.insert(place, Held::Kept(resumed));
        Ok(())
    }

    /// Hands on what is done behind those that will never be.
    ///
    /// # Errors
    /// As [`Self::put`].
    pub(super) fn finish(mut self, each: &mut impl FnMut(usize, Done) -> Result<()>) -> Result<()> {
        while let Some(place) = self.held.keys().next().copied() {
            self.next = place;
            self.hand_on(each)?;
        }
        Ok(())
    }

    fn hand_on(&mut self, each: &mut impl FnMut(usize, Done) -> Result<()>) -> Result<()> {
        while let Some(held) = self.held.remove(&self.next) {
            let place = self.next;
            self.next += 1;
            let done = match held {
                Held::Here(done) => {
                    self.in_memory -= 1;
                    *done
                }
                Held::Kept(resumed) => {
                    let record = self.records.recall(place).ok_or_else(|| lost(self.records))?;
                    let Record { building, wall, cpu, inputs, .. } = record;
                    Done { building, wall, cpu, resumed, inputs, is_kept: true }
                }
            };
            each(place, done)?;
        }
        Ok(())
    }
}

/// A building that was kept is not there any more.
fn lost(records: &Records) -> Error {
    let fault =
        InputError::new(records.path(), "a line that is not as it was written", "buildings as they were written");
    fault.remedy("See whether the disk is full or damaged, or something else writes there").into()
}
