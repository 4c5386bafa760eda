//! Many runs on all cores: what is to be done, what is done already, and doing the rest.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::partition::Partition;
use crate::row::Key;
use crate::run::{RunError, run};
use crate::scenario::Scenario;
use crate::store::{Store, StoreError};
use crate::variant::Variant;

/// Everything that is to be run.
#[derive(Debug)]
pub struct Campaign {
    /// The methods.
    pub variants: Vec<Variant>,
    /// The worlds; every method meets each of them.
    pub scenarios: Vec<Scenario>,
    /// The share of it.
    pub partition: Partition,
    /// Fingerprint of the program.
    pub build_hash: String,
    /// Threads; nothing means one per core.
    pub jobs: Option<usize>,
    /// Whether computing times enter the rows.
    pub keep_times: bool,
}

/// How far a campaign has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Runs done by this call.
    pub done: u64,
    /// Runs this call has to do.
    pub total: u64,
    /// Simulated time of those done, s.
    pub simulated_s: f64,
}

/// What a call has done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Done {
    /// Runs that were in the table before.
    pub known: u64,
    /// Runs added.
    pub added: u64,
    /// Simulated time of those added, s.
    pub simulated_s: f64,
    /// Processor time that all threads together spent on them, s.
    pub thread_s: f64,
    /// Whether it was asked to stop before the end.
    pub stopped: bool,
}

/// Why a campaign ended.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A row in the table is of another build, other settings or another scenario.
    #[error(
        "the table has the run ({key}) already, of {what}; what was is not computed again: name another file with \
         --out, or remove this one to start anew"
    )]
    Changed {
        /// The run.
        key: Box<Key>,
        /// What is not as it was.
        what: &'static str,
    },
    /// A run could not be made.
    #[error("{key}: {source}")]
    Run {
        /// Which.
        key: Box<Key>,
        /// Why.
        source: Box<RunError>,
    },
    /// A row could not be kept.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The kernel gives no threads.
    #[error("cannot start {jobs} threads ({reason}); give fewer with --jobs")]
    Threads {
        /// How many.
        jobs: usize,
        /// What the pool says.
        reason: String,
    },
}

impl Campaign {
    /// The runs of this partition that `store` lacks, scenario by scenario.
    ///
    /// # Errors
    /// [`CampaignError::Changed`] if one that it has would come out otherwise now.
    pub fn missing<'a>(&'a self, store: &Store) -> Result<Vec<(&'a Scenario, &'a Variant)>, CampaignError> {
        let mut missing = Vec::new();
        for (ordinal, scenario) in self.scenarios.iter().enumerate() {
            if !self.partition.contains(ordinal) {
                continue;
            }
            for variant in &self.variants {
                let key = key(scenario, variant);
                let Some(row) = store.row(&key) else {
                    missing.push((scenario, variant));
                    continue;
                };
                let changes = [
                    ("other settings or another model", row.settings_hash == variant.settings_hash),
                    ("another scenario", row.scenario_hash == scenario.hash()),
                    ("another build of this program", row.build_hash == self.build_hash),
                ];
                if let Some((what, _)) = changes.into_iter().find(|(_, equal)| !equal) {
                    return Err(CampaignError::Changed { key: Box::new(key), what });
                }
            }
        }
        Ok(missing)
    }

    /// Runs what `store` lacks and adds it, until all is done or `stop` says so; tells `watch` after each run.
    ///
    /// # Errors
    /// [`CampaignError`]; what was done until then is in the store.
    pub fn run(
        &self,
        store: &mut Store,
        stop: &(dyn Fn() -> bool + Sync),
        watch: &(dyn Fn(Progress) + Sync),
    ) -> Result<Done, CampaignError> {
        let missing = self.missing(store)?;
        let in_partition =
            (0..self.scenarios.len()).filter(|&ordinal| self.partition.contains(ordinal)).count();
        let known = (in_partition * self.variants.len() - missing.len()) as u64;
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(self.jobs.unwrap_or(0)).build().map_err(|error| {
                CampaignError::Threads { jobs: self.jobs.unwrap_or(0), reason: error.to_string() }
            })?;
        let (next, failed) = (AtomicU64::new(0), AtomicBool::new(false));
        let shared =
            Mutex::new((store, Progress { done: 0, total: missing.len() as u64, simulated_s: 0.0 }, 0.0));
        // Threads take runs in their order, not halves of the list, so that what is there after a stop is comparable.
        let work = || -> Result<bool, CampaignError> {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(&(scenario, variant)) = missing.get(index as usize) else { return Ok(false) };
                let stop = || stop() || failed.load(Ordering::Relaxed);
                if stop() {
                    return Ok(true);
                }
                let row = run(scenario, variant, &self.build_hash, &stop).map_err(|source| {
                    CampaignError::Run { key: Box::new(key(scenario, variant)), source: Box::new(source) }
                })?;
                let Some(row) = row else { return Ok(true) };
                let mut shared = shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                let (store, progress, thread_s) = &mut *shared;
                progress.done += 1;
                progress.simulated_s += row.time_s;
                *thread_s += row.cpu_s.unwrap_or(0.0);
                store.add(if self.keep_times { row } else { row.without_times() })?;
                watch(*progress);
            }
        };
        let worker = |_: rayon::BroadcastContext<'_>| {
            let outcome = work();
            failed.fetch_or(outcome.is_err(), Ordering::Relaxed);
            outcome
        };
        let outcomes: Vec<Result<bool, CampaignError>> = pool.broadcast(worker);
        let mut stopped = false;
        for outcome in outcomes {
            stopped |= outcome?;
        }
        let (_, progress, thread_s) = shared.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        Ok(Done { known, added: progress.done, simulated_s: progress.simulated_s, thread_s, stopped })
    }
}

fn key(scenario: &Scenario, variant: &Variant) -> Key {
    Key {
        robot: variant.robot.name().to_owned(),
        people: scenario.people,
        scenario: scenario.name.clone(),
        method: variant.name.clone(),
    }
}
