//! The table under construction: every row is on disk as soon as it is there, and none is made twice.
//!
//! A row is first written to a file of its own in `FILE.parts/`; now and then, and at the end, all are gathered in FILE.
//! Both are written beside and renamed, so a killed run leaves whole rows only. A lock keeps a second writer out.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use crate::row::{Key, Row};
use crate::table_file::{TableError, read_table, write_table};

/// Rows in files of their own before all are gathered.
const GATHER_EVERY: usize = 64;

/// Why a table cannot be kept.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Reading or writing failed.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The folder of parts or the lock could not be made or removed.
    #[error("cannot write {}: {source}; name another file with --out", path.display())]
    Unwritable {
        /// The path.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Somebody else writes this table.
    #[error(
        "another process is writing {}; wait for it, or give every one its own --out and merge them afterwards",
        path.display()
    )]
    Locked {
        /// The table.
        path: PathBuf,
    },
    /// The same run is there twice and differs.
    #[error(
        "{} and another table or part both have the run ({key}), and {what} differs; they are of different \
         builds, settings or scenarios and make no table together",
        path.display()
    )]
    Contradiction {
        /// The file.
        path: PathBuf,
        /// The run.
        key: Box<Key>,
        /// What differs.
        what: &'static str,
    },
}

/// A table file with what belongs to it.
#[derive(Debug)]
pub struct Store {
    file: PathBuf,
    parts: PathBuf,
    lock_file: PathBuf,
    lock: File,
    rows: BTreeMap<Key, Row>,
    loose: Vec<PathBuf>,
    next_part: u64,
}

impl Store {
    /// Opens the table in `file`, with what an interrupted run left beside it, or begins one.
    ///
    /// # Errors
    /// [`StoreError`] if it cannot be read, written or locked.
    pub fn open(file: &Path) -> Result<Self, StoreError> {
        let parts = beside(file, ".parts");
        let lock_file = beside(file, ".lock");
        let lock = File::options()
            .create(true)
            .append(true)
            .open(&lock_file)
            .map_err(|source| StoreError::Unwritable { path: file.to_owned(), source })?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StoreError::Locked { path: file.to_owned() }),
            Err(TryLockError::Error(source)) => {
                return Err(StoreError::Unwritable { path: lock_file, source });
            }
        }
        std::fs::create_dir_all(&parts)
            .map_err(|source| StoreError::Unwritable { path: parts.clone(), source })?;
        let mut store = Self {
            rows: BTreeMap::new(),
            loose: Vec::new(),
            next_part: 0,
            file: file.to_owned(),
            parts,
            lock_file,
            lock,
        };
        store.read_all()?;
        Ok(store)
    }

    fn read_all(&mut self) -> Result<(), StoreError> {
        let mut tables = Vec::new();
        if self.file.exists() {
            tables.push(self.file.clone());
        }
        let unreadable = |source| StoreError::Unwritable { path: self.parts.clone(), source };
        for entry in std::fs::read_dir(&self.parts).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            // What was cut off while it was written has another ending.
            if path.extension().is_some_and(|ending| ending == "parquet") {
                self.loose.push(path);
            }
        }
        self.loose.sort();
        tables.extend(self.loose.iter().cloned());
        for table in tables {
            for row in read_table(&table)? {
                insert(&mut self.rows, row, &table)?;
            }
        }
        self.next_part =
            self.loose.iter().filter_map(|path| part_number(path)).max().map_or(0, |last| last + 1);
        Ok(())
    }

    /// The row of a run, if it is there.
    pub fn row(&self, key: &Key) -> Option<&Row> {
        self.rows.get(key)
    }

    /// All rows in the order of their keys.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.rows.values()
    }

    /// Adds a row. When this returns, it is on disk.
    ///
    /// # Errors
    /// [`StoreError`] if it cannot be written, or contradicts one that is there.
    pub fn add(&mut self, row: Row) -> Result<(), StoreError> {
        let part = self.parts.join(format!("{:08}.parquet", self.next_part));
        write_table(&part, &[&row])?;
        self.next_part += 1;
        insert(&mut self.rows, row, &part)?;
        self.loose.push(part);
        if self.loose.len() >= GATHER_EVERY { self.gather() } else { Ok(()) }
    }

    /// Writes all rows to the table and removes the parts.
    fn gather(&mut self) -> Result<(), StoreError> {
        write_table(&self.file, &self.rows.values().collect::<Vec<_>>())?;
        for part in self.loose.drain(..) {
            std::fs::remove_file(&part).map_err(|source| StoreError::Unwritable { path: part, source })?;
        }
        Ok(())
    }

    /// Writes the table and removes everything beside it; gives the rows back in the order of their keys.
    ///
    /// # Errors
    /// [`StoreError`] if it cannot be written.
    pub fn finish(mut self) -> Result<Vec<Row>, StoreError> {
        if !self.loose.is_empty() || !self.file.exists() {
            self.gather()?;
        }
        for cut_off in std::fs::read_dir(&self.parts).into_iter().flatten().flatten() {
            let path = cut_off.path();
            std::fs::remove_file(&path).map_err(|source| StoreError::Unwritable { path, source })?;
        }
        std::fs::remove_dir(&self.parts)
            .map_err(|source| StoreError::Unwritable { path: self.parts.clone(), source })?;
        std::fs::remove_file(&self.lock_file)
            .map_err(|source| StoreError::Unwritable { path: self.lock_file.clone(), source })?;
        drop(self.lock);
        Ok(self.rows.into_values().collect())
    }
}

/// Puts the tables in `files` together. Runs that are in several of them have to agree, measured times aside.
///
/// # Errors
/// [`StoreError`] if one cannot be read, or two contradict each other.
pub fn merged(files: &[PathBuf]) -> Result<Vec<Row>, StoreError> {
    let mut rows = BTreeMap::new();
    for file in files {
        for row in read_table(file)? {
            insert(&mut rows, row, file)?;
        }
    }
    // One method under two settings, or two builds, make no table even where no run is there twice.
    let mut methods: BTreeMap<(&str, &str), &Row> = BTreeMap::new();
    for row in rows.values() {
        let first = *methods.entry((&row.robot, &row.method)).or_insert(row);
        if let Some(what) = differing_origin(first, row) {
            let path = files.first().cloned().unwrap_or_default();
            return Err(StoreError::Contradiction { path, key: Box::new(row.key()), what });
        }
    }
    Ok(rows.into_values().collect())
}

/// What of build, settings and kernel two rows of one method do not share.
fn differing_origin(one: &Row, other: &Row) -> Option<&'static str> {
    [
        ("the build", one.build_hash == other.build_hash),
        ("the method's settings", one.settings_hash == other.settings_hash),
        ("the kernel (set filter.kernel for all machines)", one.kernel == other.kernel),
    ]
    .into_iter()
    .find_map(|(what, equal)| (!equal).then_some(what))
}

/// Adds `row`, read from `file`, unless it is there already.
fn insert(rows: &mut BTreeMap<Key, Row>, row: Row, file: &Path) -> Result<(), StoreError> {
    let key = row.key();
    let Some(known) = rows.get(&key) else {
        rows.insert(key, row);
        return Ok(());
    };
    let what = differing_origin(known, &row)
        .or_else(|| (known.scenario_hash != row.scenario_hash).then_some("the scenario"))
        .or_else(|| (known.clone().without_times() != row.without_times()).then_some("the result"));
    match what {
        None => Ok(()),
        Some(what) => Err(StoreError::Contradiction { path: file.to_owned(), key: Box::new(key), what }),
    }
}

/// `file` with `ending` after its name.
fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    file.with_file_name(name)
}

fn part_number(path: &Path) -> Option<u64> {
    path.file_stem()?.to_str()?.parse().ok()
}
