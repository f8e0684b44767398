//! Work that flows: parts are read, items that are ready with them are worked on, and neither waits for all of the other.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use crate::error::Result;

/// Items start in the order of their places by so many at a time, the largest of them first: then results need not wait
/// long for those before them.
const WINDOW: usize = 1024;
/// Items of this size start before all others, wherever they stand: none of them shall be left for last while the other
/// threads idle.
const LARGE: usize = 100_000;
/// With fewer items per thread that are ready, the next part is read.
const FEW: usize = 8;

/// An item that is ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ready {
    /// Its place in the order of the results.
    pub(super) place: usize,
    /// How much work it is.
    pub(super) size: usize,
}

/// Where items come from.
pub(super) trait Source: Sync {
    /// What reading a part gives.
    type Part: Send;
    /// What is worked on.
    type Item: Send;

    /// How many parts there are.
    fn parts(&self) -> usize;

    /// Reads a part, on any thread.
    fn read(&self, part: usize) -> Result<Self::Part>;

    /// Takes the parts one after the other in their order; the items that are ready with each.
    fn take(&self, part: usize, read: Self::Part) -> Result<Vec<Ready>>;

    /// The items that are ready once all parts have been taken and all items that were ready have been asked for.
    fn rest(&self) -> Vec<Ready>;

    /// An item that is ready, on any thread; `None` where it needs no work, or is one of [`Self::rest`].
    fn item(&self, place: usize) -> Result<Option<Self::Item>>;
}

/// What a task tells.
enum Told<P, R> {
    /// A part was read.
    Read(usize, Result<P>),
    /// An item was worked on, or none was there.
    Done(usize, Result<Option<R>>),
    /// It had nothing to do any more, or it panicked.
    Nothing,
}

/// Reads all parts of `source` and does `work` on all items in `pool`; `each` takes the results on the calling thread as they get
/// done. An item is dropped as soon as `work` is done with it.
///
/// Once `stop` says yes nothing more starts, and what is under way is completed. `is_first` are the places of items that start before all others.
///
/// # Errors
/// The first of the source or of `each`; nothing more starts after it.
pub(super) fn flow<S: Source, R: Send>(
    pool: &rayon::ThreadPool,
    source: &S,
    is_first: impl Fn(usize) -> bool,
    work: impl Fn(usize, S::Item) -> R + Sync,
    stop: impl Fn() -> bool + Sync,
    mut each: impl FnMut(usize, R) -> Result<()>,
) -> Result<()> {
    let threads = pool.current_num_threads();
    let failed = AtomicBool::new(false);
    let (work, stop, failed) = (&work, &stop, &failed);
    let (sender, receiver) = mpsc::channel();
    let parts = source.parts();
    let mut read: BTreeMap<usize, S::Part> = BTreeMap::new();
    let (mut next_part, mut next_taken) = (0, 0);
    let (mut reading, mut working) = (0, 0);
    let mut ready: BinaryHeap<(bool, Reverse<usize>, usize, Reverse<usize>)> = BinaryHeap::new();
    let mut is_rest = false;
    let key = |item: Ready| {
        let is_first = is_first(item.place) || item.size >= LARGE;
        (is_first, Reverse(item.place / WINDOW), item.size, Reverse(item.place))
    };
    // Tasks spawned from outside the pool queue up in one first-in-first-out line, so the order of spawning is the order of
    // starting.
    pool.in_place_scope_fifo(|scope| {
        let mut run = || -> Result<()> {
            loop {
                let is_over = failed.load(Ordering::Relaxed) || stop();
                // One more than there are threads, so that none waits for this one.
                while reading + working <= threads && !is_over {
                    let most_parts = if ready.is_empty() { threads } else { threads.div_ceil(2) };
                    let may_read = next_part < parts && reading + read.len() < most_parts;
                    if may_read && ready.len() < FEW * threads {
                        let mut answer = Answer { sender: sender.clone(), is_part: true, told: Told::Nothing };
                        let part = next_part;
                        scope.spawn_fifo(move |_| {
                            if !failed.load(Ordering::Relaxed) && !stop() {
                                answer.give(Told::Read(part, source.read(part)));
                            }
                        });
                        next_part += 1;
                        reading += 1;
                    } else if let Some((.., Reverse(place))) = ready.pop() {
                        let mut answer = Answer { sender: sender.clone(), is_part: false, told: Told::Nothing };
                        scope.spawn_fifo(move |_| {
                            if !failed.load(Ordering::Relaxed) && !stop() {
                                let item = source.item(place);
                                answer.give(Told::Done(place, item.map(|item| item.map(|item| work(place, item)))));
                            }
                        });
                        working += 1;
                    } else {
                        break;
                    }
                }
                if reading + working == 0 {
                    if is_over || next_taken < parts || is_rest {
                        return Ok(());
                    }
                    is_rest = true;
                    ready.extend(source.rest().into_iter().map(key));
                    continue;
                }
                // Every task answers and `sender` is alive: this cannot fail.
                let Ok((is_part, told)) = receiver.recv() else { return Ok(()) };
                *if is_part { &mut reading } else { &mut working } -= 1;
                match told {
                    Told::Read(part, taken) => {
                        read.insert(part, taken?);
                        while let Some(part) = read.remove(&next_taken) {
                            ready.extend(source.take(next_taken, part)?.into_iter().map(key));
                            next_taken += 1;
                        }
                    }
                    Told::Done(place, result) => {
                        if let Some(result) = result? {
                            each(place, result)?;
                        }
                    }
                    // Where it was not stopped it has panicked, and rayon resumes that at the end of the scope.
                    Told::Nothing => failed.store(true, Ordering::Relaxed),
                }
            }
        };
        let outcome = run();
        if outcome.is_err() {
            failed.store(true, Ordering::Relaxed);
        }
        outcome
    })
}

/// What a task tells, sent when it is dropped: also a task that panics answers, so that nobody waits for it.
struct Answer<P, R> {
    sender: mpsc::Sender<(bool, Told<P, R>)>,
    /// Whether it reads a part.
    is_part: bool,
    told: Told<P, R>,
}

impl<P, R> Answer<P, R> {
    fn give(&mut self, told: Told<P, R>) {
        self.told = told;
    }
}

impl<P, R> Drop for Answer<P, R> {
    fn drop(&mut self) {
        // The receiver is gone only after an error; what was told is moot then.
        let _ = self.sender.send((self.is_part, std::mem::replace(&mut self.told, Told::Nothing)));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use crate::error::Error;

    /// Parts that hold ten items each, the last of which is one of the rest.
    struct Tens {
        parts: usize,
        broken: Option<usize>,
        asked: Mutex<Vec<usize>>,
        is_rest: AtomicBool,
    }

    impl Tens {
        fn new(parts: usize) -> Self {
            Self { parts, broken: None, asked: Mutex::new(Vec::new()), is_rest: AtomicBool::new(false) }
        }
    }

    impl Source for Tens {
        type Part = Vec<usize>;
        type Item = usize;

        fn parts(&self) -> usize {
            self.parts
        }

        fn read(&self, part: usize) -> Result<Vec<usize>> {
            // The earlier ones take longest.
            std::thread::sleep(std::time::Duration::from_millis((self.parts - part) as u64 / 4));
            if self.broken == Some(part) {
                return Err(Error::Interrupted);
            }
            Ok((10 * part..10 * part + 10).collect())
        }

        fn take(&self, part: usize, read: Vec<usize>) -> Result<Vec<Ready>> {
            assert_eq!(read[0], 10 * part);
            Ok(read.into_iter().map(|place| Ready { place, size: place % 7 }).collect())
        }

        fn rest(&self) -> Vec<Ready> {
            assert_eq!(self.asked.lock().unwrap().len(), 10 * self.parts);
            assert!(!self.is_rest.swap(true, Ordering::SeqCst));
            (0..self.parts).map(|part| Ready { place: 10 * part + 9, size: 1 }).collect()
        }

        fn item(&self, place: usize) -> Result<Option<usize>> {
            self.asked.lock().unwrap().push(place);
            Ok((self.is_rest.load(Ordering::SeqCst) || place % 10 < 9).then_some(place))
        }
    }

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn every_item_is_worked_on_once_for_any_number_of_threads() {
        for threads in [1, 2, 3, 8] {
            for parts in [0, 1, 2, 17] {
                let source = Tens::new(parts);
                let mut seen = Vec::new();
                flow(
                    &pool(threads),
                    &source,
                    |_| false,
                    |place, item| place + item,
                    || false,
                    |place, result| {
                        assert_eq!(result, 2 * place);
                        seen.push(place);
                        Ok(())
                    },
                )
                .unwrap();
                seen.sort_unstable();
                assert_eq!(seen, (0..10 * parts).collect::<Vec<_>>(), "{threads} threads, {parts} parts");
            }
        }
    }

    #[test]
    fn the_largest_starts_first_within_the_window_and_those_that_are_there_before_all() {
        struct All(Vec<usize>);
        impl Source for All {
            type Part = ();
            type Item = usize;
            fn parts(&self) -> usize {
                1
            }
            fn read(&self, _: usize) -> Result<()> {
                Ok(())
            }
            fn take(&self, _: usize, (): ()) -> Result<Vec<Ready>> {
                Ok(self.0.iter().enumerate().map(|(place, &size)| Ready { place, size }).collect())
            }
            fn rest(&self) -> Vec<Ready> {
                Vec::new()
            }
            fn item(&self, place: usize) -> Result<Option<usize>> {
                Ok(Some(place))
            }
        }
        let mut sizes = vec![1; WINDOW];
        (sizes[5], sizes[9]) = (7, 8);
        sizes.extend([50, LARGE, 9]);
        let mut seen = Vec::new();
        flow(
            &pool(1),
            &All(sizes),
            |place| place == 3,
            |place, _| place,
            || false,
            |_, place| {
                seen.push(place);
                Ok(())
            },
        )
        .unwrap();
        assert_eq!(seen[..5], [3, WINDOW + 1, 9, 5, 0]);
        assert_eq!(seen[WINDOW + 1..], [WINDOW, WINDOW + 2]);
    }

    #[test]
    fn a_stop_completes_what_is_under_way_and_starts_nothing_more() {
        for threads in [1, 2] {
            let done = AtomicUsize::new(0);
            let mut results = 0;
            let work = |_, _| done.fetch_add(1, Ordering::SeqCst);
            let stop = || done.load(Ordering::SeqCst) >= 12;
            flow(
                &pool(threads),
                &Tens::new(9),
                |_| false,
                work,
                stop,
                |_, _| {
                    results += 1;
                    Ok(())
                },
            )
            .unwrap();
            let done = done.into_inner();
            assert!((12..=12 + threads).contains(&done) && results <= done, "{done} {results}");
        }
    }

    #[test]
    fn an_error_ends_it() {
        for threads in [1, 2] {
            let mut calls = 0;
            let ended = flow(
                &pool(threads),
                &Tens::new(9),
                |_| false,
                |_, item| item,
                || false,
                |_, _| {
                    calls += 1;
                    if calls == 3 { Err(Error::Interrupted) } else { Ok(()) }
                },
            );
            assert!(ended.is_err() && calls == 3);
            let source = Tens { broken: Some(4), ..Tens::new(9) };
            let ended = flow(&pool(threads), &source, |_| false, |_, item| item, || false, |_, _| Ok(()));
            assert!(ended.is_err() && source.asked.lock().unwrap().len() <= 40);
        }
    }

    #[test]
    #[should_panic(expected = "at once")]
    fn a_panic_goes_on_to_the_caller() {
        let work = |place, _| assert!(place != 13, "at once");
        let _ = flow(&pool(2), &Tens::new(3), |_| false, work, || false, |_, ()| Ok(()));
    }
}
