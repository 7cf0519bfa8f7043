//! A pool of worker processes that execute runs in parallel. Rows are delivered in the order of their points,
//! regardless of the worker.
//!
//! A worker that crashes, or whose run exceeds the time limit, is replaced. The run is repeated once by a worker that
//! keeps the output of FMUs; if that worker fails too, the run's row contains the reason, and the other runs continue.

use crate::Job;
use crate::experiment::{Detail, Experiment, Gives};
use crate::process::{Curve, End, Starter, TICK, Worker};
use crate::results::RunResult;
use crate::worker::{self, FLUSH};
use anyhow::{Context, Result, bail};
use host::child;
use host::package::Package;
use modeldescription::Table;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The target duration of a chunk of runs: much longer than the exchange of its messages, and short enough that all
/// workers finish at about the same time.
const CHUNK: Duration = Duration::from_millis(300);

/// The maximum number of runs in a chunk.
const LARGEST_CHUNK: u64 = 1 << 16;

/// The approximate maximum number of values in rows that wait for an earlier row: 8 MB, and as much again for their
/// containers.
const MOST_WAITING: u64 = 1 << 20;

/// How to execute runs.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program `plcfmu`, which the workers execute.
    pub program: PathBuf,
    /// The number of workers; at least 1.
    pub jobs: usize,
    /// The time limit for one run.
    pub limit: Duration,
    /// Stops the pool when it becomes true.
    pub interrupted: Arc<AtomicBool>,
    /// Whether each run needs new instances; if `None`, the first worker finds out by [`Worker::check_reset`].
    pub renews: Option<bool>,
    /// Whether FMUs are called through their C interface even if their block is linked into this program.
    pub exact_door: bool,
}

impl Options {
    /// The default options: a worker for each core, and 300 s for a run.
    ///
    /// # Errors
    /// The program cannot determine its own path.
    pub fn new() -> Result<Options> {
        Ok(Options {
            program: std::env::current_exe().context("plcfmu cannot find its own program file")?,
            jobs: thread::available_parallelism().map_or(1, usize::from),
            limit: Duration::from_secs(300),
            interrupted: Arc::default(),
            renews: None,
            exact_door: false,
        })
    }
}

/// A receiver of rows in the order of their numbers.
pub trait Sink {
    /// Receives the next row, with its number.
    ///
    /// # Errors
    /// The row cannot be stored. No more runs are then executed.
    fn row(&mut self, number: u64, row: RunResult) -> Result<()>;

    /// Called when no row has arrived for a while.
    ///
    /// # Errors
    /// See [`Sink::row`].
    fn idle(&mut self) -> Result<()> {
        Ok(())
    }
}

/// A callback for the next row, with its number.
pub type Receive<'a> = dyn FnMut(u64, RunResult) -> Result<()> + 'a;

/// A callback as a sink.
struct Each<'a>(&'a mut Receive<'a>);

impl Sink for Each<'_> {
    fn row(&mut self, number: u64, row: RunResult) -> Result<()> {
        (self.0)(number, row)
    }
}

/// Worker processes for one job. They end when the pool is dropped.
#[derive(Debug)]
pub struct Pool {
    experiment: Experiment,
    tables: Vec<Option<Table>>,
    starter: Starter,
    slots: Vec<Slot>,
    /// For the first run whose FMU crashed or was stopped after printing something: its index, and the message with the
    /// output.
    printed: Mutex<Option<(u64, String)>>,
}

/// The slot of one worker.
#[derive(Debug, Default)]
struct Slot {
    worker: Option<Worker>,
    /// The mean duration of a run in the last chunk, if known.
    run: Option<Duration>,
}

impl Pool {
    /// Starts the first worker, which checks the job and, unless [`Options::renews`] is given, whether reset instances
    /// compute the same results as new ones; if not, a warning is added to the experiment and each run uses new
    /// instances. The other workers start on demand.
    ///
    /// # Errors
    /// The job or an FMU is faulty.
    pub fn start(job: &Job, options: &Options) -> Result<Pool> {
        let mut starter = Starter {
            child: child::Starter {
                program: options.program.clone(),
                limit: options.limit,
                interrupted: options.interrupted.clone(),
            },
            job: serde_json::to_string(job)?,
            members: job.system.members.iter().map(|member| member.name.clone()).collect(),
            renews: options.renews.unwrap_or_default(),
            exact_door: options.exact_door,
        };
        let (mut worker, ready) = starter.start(false)?;
        let tables = ready.interfaces.iter().map(|of| of.as_deref().map(worker::table).transpose());
        let tables: Vec<Option<Table>> = tables.collect::<Result<_>>()?;
        let descriptions = job.system.members.iter().map(|member| Ok(Package::open(&member.path)?.description));
        let descriptions = descriptions.collect::<Result<Vec<_>>>()?;
        let mut experiment =
            worker::experiment(job, &descriptions.iter().collect::<Vec<_>>(), tables.first().and_then(Option::as_ref))?;
        experiment.warnings.extend(ready.warning);
        let mut slots: Vec<Slot> = (0..options.jobs.max(1)).map(|_| Slot::default()).collect();
        let checked = if options.renews.is_some() { Ok(None) } else { worker.check_reset() };
        match checked {
            Ok(warning) => {
                starter.renews |= warning.is_some();
                experiment.warnings.extend(warning);
                slots[0].worker = Some(worker);
            }
            // The worker ended before the outcome was known. Unless the user interrupted, the runs will show the
            // reason.
            Err(_) => starter.renews = true,
        }
        Ok(Pool { experiment, tables, starter, slots, printed: Mutex::default() })
    }

    /// The experiment of the job.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// The block tables of the members' libraries, where they have one.
    pub fn tables(&self) -> &[Option<Table>] {
        &self.tables
    }

    /// Whether each run uses new instances.
    pub fn renews(&self) -> bool {
        self.starter.renews
    }

    /// How an FMU crashed or was stopped, with its last output; `None` if no FMU did, or if none of these had printed
    /// anything.
    pub fn printed(&self) -> Option<String> {
        let printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        printed.as_ref().map(|(_, text)| text.clone())
    }

    /// Whether the runs were interrupted.
    pub fn is_interrupted(&self) -> bool {
        self.starter.child.interrupted.load(Ordering::Relaxed)
    }

    /// Executes `count` runs. `point` returns the point of each by its 0-based index; `each` receives the rows in
    /// order. After an interruption, it receives the rows that exist, with gaps.
    ///
    /// # Errors
    /// A worker cannot be started, or `each` fails.
    pub fn rows(&mut self, count: u64, point: &(dyn Fn(u64) -> Vec<f64> + Sync), each: &mut Receive<'_>) -> Result<()> {
        self.rows_into(count, point, &mut Each(each))
    }

    /// Like [`Pool::rows`], for a sink that is also called when no rows arrive for a while.
    ///
    /// # Errors
    /// A worker cannot be started, or the sink fails.
    pub fn rows_into(
        &mut self,
        count: u64,
        point: &(dyn Fn(u64) -> Vec<f64> + Sync),
        sink: &mut dyn Sink,
    ) -> Result<()> {
        self.make(count, point, Gives::Figures, sink)
    }

    /// Like [`Pool::rows`], but each run uses new instances, and each row has, after the figures, the process value at
    /// [`Experiment::trace_times`].
    ///
    /// # Errors
    /// A worker cannot be started, or `each` fails.
    pub fn traces(
        &mut self,
        count: u64,
        point: &(dyn Fn(u64) -> Vec<f64> + Sync),
        each: &mut Receive<'_>,
    ) -> Result<()> {
        self.make(count, point, Gives::Trace, &mut Each(each))
    }

    fn make(
        &mut self,
        count: u64,
        point: &(dyn Fn(u64) -> Vec<f64> + Sync),
        gives: Gives,
        sink: &mut dyn Sink,
    ) -> Result<()> {
        let width = (self.experiment.coordinates.len() + self.experiment.figures.len()).max(1) as u64;
        let shared = Shared {
            next: Mutex::new(Next { first: 0, delivered: 0, is_over: false }),
            moved: Condvar::new(),
            count,
            jobs: self.slots.len() as u64,
            most_waiting: MOST_WAITING / width + 1,
        };
        let figures = self.experiment.figures.len();
        let (starter, slots, printed) = (&self.starter, &mut self.slots, &self.printed);
        thread::scope(|scope| {
            let (sender, batches) = mpsc::channel::<Result<Batch>>();
            for slot in slots.iter_mut().take(usize::try_from(count).unwrap_or(usize::MAX)) {
                let (sender, shared) = (sender.clone(), &shared);
                scope.spawn(move || {
                    let made = Maker { starter, slot, gives, figures, sender: &sender, printed }.work(shared, point);
                    if let Err(error) = made
                        && !starter.child.interrupted.load(Ordering::Relaxed)
                    {
                        // If the receiver is gone, an error has already occurred.
                        let _ = sender.send(Err(error));
                    }
                });
            }
            drop(sender);
            let result = deliver(&batches, &shared, sink);
            shared.stop();
            result
        })
    }

    /// Executes the run of a point with new instances and records it. Returns its figures as well, unless an FMU ended
    /// it.
    ///
    /// # Errors
    /// An FMU rejects a call or crashes, or the user interrupts.
    pub fn curve(&mut self, point: &[f64], detail: Detail) -> Result<Curve> {
        let slot = &mut self.slots[0];
        let worker = slot.worker(&self.starter)?;
        match worker.curve(point, detail) {
            Ok(made) => made,
            Err(end) => {
                let text = worker.text(&end, &self.starter);
                slot.worker = None;
                bail!("{text}")
            }
        }
    }
}

impl Slot {
    fn worker(&mut self, starter: &Starter) -> Result<&mut Worker> {
        let worker = match self.worker.take() {
            Some(worker) => worker,
            None => starter.start(false)?.0,
        };
        Ok(self.worker.insert(worker))
    }
}

/// The rows of consecutive runs.
struct Batch {
    /// The index of the first run.
    first: u64,
    rows: Vec<RunResult>,
}

impl Batch {
    /// Passes the rows to a sink. Returns the index of the run after the last one.
    fn hand_on(self, sink: &mut dyn Sink) -> Result<u64> {
        let mut number = self.first;
        for row in self.rows {
            sink.row(number, row)?;
            number += 1;
        }
        Ok(number)
    }
}

/// The state shared by the threads of the workers.
struct Shared {
    next: Mutex<Next>,
    moved: Condvar,
    count: u64,
    jobs: u64,
    /// The maximum number of rows that may wait for an earlier one.
    most_waiting: u64,
}

struct Next {
    /// The first run not yet assigned to a worker.
    first: u64,
    /// The first run not yet delivered.
    delivered: u64,
    is_over: bool,
}

impl Shared {
    fn next(&self) -> MutexGuard<'_, Next> {
        self.next.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the next chunk, of at most `wanted` runs. Blocks while too many rows wait for an earlier one. `None` if
    /// there are no more runs or the pool stops.
    fn take(&self, wanted: u64, interrupted: &AtomicBool) -> Option<std::ops::Range<u64>> {
        let mut next = self.next();
        loop {
            if next.is_over || next.first >= self.count || interrupted.load(Ordering::Relaxed) {
                return None;
            }
            if next.first - next.delivered < self.most_waiting {
                break;
            }
            next = self.moved.wait_timeout(next, TICK).map_or_else(|error| error.into_inner().0, |of| of.0);
        }
        // The last chunks are small, so that all workers stay busy until the end, and no chunk is so large that its
        // rows block others.
        let fair = (self.count - next.first).min(self.most_waiting).div_ceil(2 * self.jobs);
        let first = next.first;
        next.first += wanted.min(fair).max(1);
        Some(first..next.first)
    }

    fn deliver(&self, delivered: u64) {
        self.next().delivered = delivered;
        self.moved.notify_all();
    }

    fn stop(&self) {
        self.next().is_over = true;
        self.moved.notify_all();
    }
}

/// Delivers rows in order.
fn deliver(batches: &Receiver<Result<Batch>>, shared: &Shared, sink: &mut dyn Sink) -> Result<()> {
    let (mut waiting, mut next) = (BTreeMap::new(), 0);
    loop {
        match batches.recv_timeout(TICK) {
            Ok(batch) => {
                let batch = batch?;
                waiting.insert(batch.first, batch);
                while let Some(batch) = waiting.remove(&next) {
                    next = batch.hand_on(sink)?;
                }
                shared.deliver(next);
            }
            Err(RecvTimeoutError::Timeout) => sink.idle()?,
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    // Rows are left only after an interruption.
    for batch in waiting.into_values() {
        batch.hand_on(sink)?;
    }
    Ok(())
}

/// Executes runs with a worker, and with a new one whenever the last one ended.
struct Maker<'a> {
    starter: &'a Starter,
    slot: &'a mut Slot,
    gives: Gives,
    figures: usize,
    sender: &'a Sender<Result<Batch>>,
    printed: &'a Mutex<Option<(u64, String)>>,
}

impl Maker<'_> {
    fn work(&mut self, shared: &Shared, point: &(dyn Fn(u64) -> Vec<f64> + Sync)) -> Result<()> {
        while let Some(chunk) = shared.take(self.wanted(), &self.starter.child.interrupted) {
            let (points, began) = (chunk.clone().map(point).collect::<Vec<_>>(), Instant::now());
            let count = points.len();
            if !self.chunk(chunk.start, points)? {
                break;
            }
            self.slot.run = Some(began.elapsed() / u32::try_from(count).unwrap_or(u32::MAX).max(1));
        }
        Ok(())
    }

    /// The number of runs that the next chunk should have.
    fn wanted(&self) -> u64 {
        let Some(run) = self.slot.run else { return 1 };
        ((CHUNK.as_nanos() / run.as_nanos().max(1)) as u64).clamp(1, LARGEST_CHUNK)
    }

    /// Executes a chunk of runs; returns `false` after an interruption.
    fn chunk(&mut self, first: u64, mut points: Vec<Vec<f64>>) -> Result<bool> {
        let mut next = first;
        while !points.is_empty() {
            let worker = self.slot.worker(self.starter)?;
            let (sender, end) =
                (self.sender, worker.rows(&mut points, self.gives, |rows| hand_in(self.sender, &mut next, rows)));
            let Some(end) = end else { break };
            self.slot.worker = None;
            if end == End::Interrupted {
                return Ok(false);
            }
            // Which run failed is not known exactly: the worker may not have sent its last few rows. Therefore, the
            // next few runs are repeated by a worker that sends each row immediately.
            let lost = self.slot.run.map_or(64, |run| (2 * FLUSH).as_nanos() / run.as_nanos().max(1) + 1);
            let rest = points.split_off(usize::try_from(lost).unwrap_or(usize::MAX).min(points.len()));
            let mut listening = self.starter.start(true)?.0;
            match listening.rows(&mut points, self.gives, |rows| hand_in(sender, &mut next, rows)) {
                None => {}
                Some(End::Interrupted) => return Ok(false),
                Some(end) => {
                    self.keep_printed(next, &listening, &end);
                    let error = format!("{}, twice", listening.text(&end, self.starter));
                    let row = RunResult { figures: vec![f64::NAN; self.figures], error: Some(error) };
                    points.remove(0);
                    hand_in(sender, &mut next, vec![row]);
                }
            }
            points.extend(rest);
        }
        Ok(true)
    }

    /// Keeps what an FMU printed, for [`Pool::printed`]; not in the run's row, whose bytes must be reproducible.
    fn keep_printed(&self, run: u64, worker: &Worker, end: &End) {
        let lines = worker.printed();
        let mut printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        if !lines.is_empty() && printed.as_ref().is_none_or(|(first, _)| run < *first) {
            *printed = Some((run, format!("{}; it printed: {}", worker.text(end, self.starter), lines.join(" / "))));
        }
    }
}

/// Sends the next rows to the receiving thread.
fn hand_in(sender: &Sender<Result<Batch>>, next: &mut u64, rows: Vec<RunResult>) {
    let first = *next;
    *next += rows.len() as u64;
    // If the receiver is gone, an error has already occurred, which also stops the other workers.
    let _ = sender.send(Ok(Batch { first, rows }));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shared(count: u64, jobs: u64, most_waiting: u64) -> Shared {
        let next = Mutex::new(Next { first: 0, delivered: 0, is_over: false });
        Shared { next, moved: Condvar::new(), count, jobs, most_waiting }
    }

    fn batch(first: u64, count: u64) -> Result<Batch> {
        let rows = (first..first + count).map(|run| RunResult { figures: vec![run as f64], error: None });
        Ok(Batch { first, rows: rows.collect() })
    }

    fn delivered(batches: Vec<Result<Batch>>) -> (Result<()>, Vec<u64>) {
        let (sender, receiver) = mpsc::channel();
        batches.into_iter().for_each(|batch| sender.send(batch).unwrap());
        drop(sender);
        let mut numbers = Vec::new();
        let mut each = |number: u64, row: RunResult| {
            assert_eq!(row.figures, [number as f64]);
            numbers.push(number);
            Ok(())
        };
        (deliver(&receiver, &shared(10, 2, 100), &mut Each(&mut each)), numbers)
    }

    #[test]
    fn rows_come_in_order_and_after_an_interruption_with_gaps() {
        let (result, numbers) = delivered(vec![batch(4, 2), batch(0, 3), batch(8, 2), batch(3, 1)]);
        result.unwrap();
        assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 8, 9]);
    }

    #[test]
    fn a_worker_that_cannot_be_started_ends_it_all() {
        let (result, numbers) = delivered(vec![batch(0, 1), Err(anyhow::anyhow!("no memory")), batch(1, 1)]);
        assert_eq!((result.unwrap_err().to_string(), numbers), ("no memory".into(), vec![0]));
    }

    #[test]
    fn the_last_chunks_are_small_and_each_run_is_handed_out_once() {
        let (shared, never) = (shared(100, 2, 1000), AtomicBool::new(false));
        let chunks: Vec<_> = std::iter::from_fn(|| shared.take(40, &never)).collect();
        assert_eq!(chunks[0], 0..25);
        assert!(
            chunks
                .windows(2)
                .all(|pair| pair[0].end == pair[1].start && pair[1].clone().count() <= pair[0].clone().count())
        );
        assert_eq!(chunks.last().cloned(), Some(99..100));
        // Both workers together have at most half of the rows that may wait for an earlier one.
        assert_eq!(super::tests::shared(1_000_000, 2, 20).take(40, &never), Some(0..5));
        never.store(true, Ordering::Relaxed);
        assert_eq!(super::tests::shared(100, 2, 1000).take(40, &never), None);
    }
}
