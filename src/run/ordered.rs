//! Work in parallel, results in order: largest items first, results handed over in the order of the items.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

/// How many items may be under way or wait for an earlier one at a time. It bounds the results that are held back,
/// and with them the memory of a run over any number of buildings.
const WINDOW: usize = 1024;

/// Runs `work` on every item in `pool` and hands the results to `each` on the calling thread in the order of the items.
///
/// Items start in order of falling `size` (ties in item order) within a window of [`WINDOW`] items, so that no
/// large one is left for last while the others idle. An item is dropped as soon as `work` is done with it.
///
/// `stop` is asked before every item: once it says yes, no further item starts, those under way are completed, and
/// `each` gets `None` for those that never ran.
///
/// # Errors
/// The first error of `each`; no item starts and `each` is not called after it.
pub fn in_order<T, R, E>(
    pool: &rayon::ThreadPool,
    items: Vec<T>,
    size: impl Fn(&T) -> usize,
    work: impl Fn(T) -> R + Sync,
    stop: impl Fn() -> bool + Sync,
    each: impl FnMut(usize, Option<R>) -> Result<(), E>,
) -> Result<(), E>
where
    T: Send,
    R: Send,
{
    windowed(WINDOW, pool, items, size, work, stop, each)
}

fn windowed<T, R, E>(
    window: usize,
    pool: &rayon::ThreadPool,
    items: Vec<T>,
    size: impl Fn(&T) -> usize,
    work: impl Fn(T) -> R + Sync,
    stop: impl Fn() -> bool + Sync,
    mut each: impl FnMut(usize, Option<R>) -> Result<(), E>,
) -> Result<(), E>
where
    T: Send,
    R: Send,
{
    let total = items.len();
    let failed = AtomicBool::new(false);
    let (work, stop, failed) = (&work, &stop, &failed);
    let (sender, receiver) = mpsc::channel();
    let mut waiting = items.into_iter().enumerate();
    let mut held: BTreeMap<usize, Option<R>> = BTreeMap::new();
    let mut started = 0;
    let mut next = 0;

    // Tasks spawned from outside the pool queue up in one first-in-first-out line, so the order of spawning is the
    // order of starting.
    pool.in_place_scope_fifo(|scope| {
        while next < total {
            // Refilled by half windows: one by one, the items would start in their own order, not by size.
            if started < total && started - next <= window / 2 {
                let mut batch: Vec<(usize, T)> = waiting.by_ref().take(window - (started - next)).collect();
                started += batch.len();
                batch.sort_by_key(|(_, item)| Reverse(size(item)));
                for (index, item) in batch {
                    let mut answer = Answer { sender: sender.clone(), index, result: None };
                    scope.spawn_fifo(move |_| {
                        if !failed.load(Ordering::Relaxed) && !stop() {
                            answer.give(work(item));
                        }
                    });
                }
            }
            // Every task answers and `sender` is alive: this cannot fail.
            let Ok((index, result)) = receiver.recv() else { break };
            held.insert(index, result);
            while let Some(result) = held.remove(&next) {
                let index = next;
                next += 1;
                if let Err(error) = each(index, result) {
                    failed.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
        }
        Ok(())
    })
}

/// The answer of a task, sent when it is dropped: also a task that panics answers, so that nobody waits for it. (Rayon
/// resumes the panic at the end of the scope.)
struct Answer<R> {
    sender: mpsc::Sender<(usize, Option<R>)>,
    index: usize,
    result: Option<R>,
}

impl<R> Answer<R> {
    fn give(&mut self, result: R) {
        self.result = Some(result);
    }
}

impl<R> Drop for Answer<R> {
    fn drop(&mut self) {
        // The receiver is gone only after an error of `each`; the result is moot then.
        let _ = self.sender.send((self.index, self.result.take()));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::windowed;

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn results_come_in_item_order_for_any_number_of_threads() {
        for threads in [1, 2, 3] {
            for window in [2, 7, 1024] {
                let mut seen = Vec::new();
                let items: Vec<usize> = (0..100).map(|i| (i * 37) % 101).collect();
                windowed(
                    window,
                    &pool(threads),
                    items.clone(),
                    |&i| i,
                    |i| i * 2,
                    || false,
                    |index, result| {
                        seen.push((index, result.unwrap()));
                        Ok::<(), ()>(())
                    },
                )
                .unwrap();
                let expected: Vec<_> = items.iter().map(|i| i * 2).enumerate().collect();
                assert_eq!(seen, expected, "{threads} threads, window {window}");
            }
        }
    }

    #[test]
    fn the_largest_starts_first_within_the_window() {
        let started = Mutex::new(Vec::new());
        let items = vec![1, 5, 3, 4, 2, 9];
        windowed(4, &pool(1), items, |&i| i, |i| started.lock().unwrap().push(i), || false, |_, _| Ok::<(), ()>(()))
            .unwrap();
        let started = started.into_inner().unwrap();
        assert_eq!(started[..4], [5, 4, 3, 1], "the 2 and the 9 are beyond the first window");
        assert_eq!(started[4..], [9, 2]);
    }

    #[test]
    fn a_stop_completes_what_is_under_way_and_starts_nothing_more() {
        let done = AtomicUsize::new(0);
        let mut results = Vec::new();
        let work = |_| {
            done.fetch_add(1, Ordering::SeqCst);
        };
        windowed(
            1024,
            &pool(1),
            vec![10, 30, 20],
            |&i| i,
            work,
            || done.load(Ordering::SeqCst) == 2,
            |i, r| {
                results.push((i, r.is_some()));
                Ok::<(), ()>(())
            },
        )
        .unwrap();
        assert_eq!(results, [(0, false), (1, true), (2, true)]);
    }

    #[test]
    fn an_error_of_the_writer_ends_it() {
        let done = AtomicUsize::new(0);
        let mut calls = 0;
        let error = windowed(
            4,
            &pool(2),
            (0..1000).collect(),
            |_| 1,
            |_| done.fetch_add(1, Ordering::SeqCst),
            || false,
            |index, _| {
                calls += 1;
                if index == 3 { Err("disk full") } else { Ok(()) }
            },
        );
        assert_eq!(error, Err("disk full"));
        assert_eq!(calls, 4);
        assert!(done.load(Ordering::SeqCst) < 20, "work went on after the error");
    }
}
