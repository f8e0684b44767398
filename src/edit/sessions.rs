//! The sessions of a few buildings at a time: those that were asked for last.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};

use super::Session;
use super::drawn::Scanned;
use crate::edits::Edit;
use crate::guard::lock;

/// So many sessions are open. Each remembers what its solves may need again, some ten megabytes.
const MOST: usize = 16;

/// The place of a building's session. Whoever works on the building holds its lock.
#[derive(Debug, Default)]
pub(super) struct Slot {
    /// Its session, once it is opened, and what the page draws of its scan.
    pub open: Option<(Session, Scanned)>,
    /// Grows with every change of the building; 0 before it was first opened.
    pub revision: u64,
    /// What was undone when it was last closed, the last one undone at the end.
    pub undone: Vec<Edit>,
}

/// What is kept of a session that is closed.
#[derive(Debug, Default)]
struct Closed {
    revision: u64,
    undone: Vec<Edit>,
}

/// The sessions of a few buildings, the one that was asked for last at the end.
#[derive(Debug, Default)]
pub(super) struct Sessions {
    open: VecDeque<(String, Arc<Mutex<Slot>>)>,
    closed: HashMap<String, Closed>,
}

impl Sessions {
    /// The place of a building's session. Where there are too many, the one that nobody has asked for longest is closed; its
    /// edits are in the file, and what was undone is kept.
    pub fn of(&mut self, id: &str) -> Arc<Mutex<Slot>> {
        if let Some(at) = self.open.iter().position(|(own, _)| own == id)
            && let Some(found) = self.open.remove(at)
        {
            let slot = found.1.clone();
            self.open.push_back(found);
            return slot;
        }
        let Closed { revision, undone } = self.closed.remove(id).unwrap_or_default();
        let slot = Arc::new(Mutex::new(Slot { open: None, revision, undone }));
        self.open.push_back((id.to_owned(), slot.clone()));
        while self.open.len() > MOST {
            // One that is worked on is not closed.
            let Some(at) = self.open.iter().position(|(_, slot)| Arc::strong_count(slot) == 1) else { break };
            if let Some((id, slot)) = self.open.remove(at) {
                let slot = std::mem::take(&mut *lock(&slot));
                let undone = slot.open.map_or(slot.undone, |(session, _)| session.undone().to_vec());
                self.closed.insert(id, Closed { revision: slot.revision, undone });
            }
        }
        slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edits::Action;

    #[test]
    fn the_one_that_was_asked_for_longest_ago_is_closed_and_what_was_undone_is_kept() {
        let mut sessions = Sessions::default();
        let held = sessions.of("held");
        let undone = vec![Edit::from(Action::MergeParts { gap: 0.1 })];
        *lock(&sessions.of("a")) = Slot { open: None, revision: 7, undone: undone.clone() };
        for number in 0..MOST {
            sessions.of(&number.to_string());
        }
        assert_eq!(sessions.open.len(), MOST);
        assert!(sessions.closed.contains_key("a") && !sessions.closed.contains_key("held"));
        assert!(Arc::ptr_eq(&held, &sessions.of("held")));
        let again = sessions.of("a");
        let again = lock(&again);
        assert_eq!((again.revision, &again.undone), (7, &undone));
    }
}
