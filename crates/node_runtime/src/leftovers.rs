//! What processes leave behind in shared memory when they crash, and its removal.
//!
//! iceoryx2 removes most of a dead process' objects by itself as soon as somebody opens a node. What it keeps by design (a
//! counter per domain) or cannot attribute (objects of a process that was killed while making them) is removed here, once
//! nobody in the domain lives.

use std::{
    collections::HashSet,
    io::ErrorKind,
    ops::Deref,
    os::unix::fs::{MetadataExt, PermissionsExt},
    path::{Path, PathBuf},
    time::Duration,
};

use iceoryx2::{
    node::{Node, NodeState, NodeView},
    prelude::CallbackProgression,
    service::ipc_threadsafe::Service,
};

use rustix::time::{ClockId, clock_gettime};

use crate::{Domain, domain::quieten, iceoryx::StillbornWatch};

/// Where Linux keeps POSIX shared memory.
pub(crate) const SHARED_MEMORY_FOLDER: &str = "/dev/shm";
/// How long to wait for another process that is cleaning up after the same dead one.
const CLEANER_PATIENCE: Duration = Duration::from_secs(1);

/// Age at which an empty folder is certainly nobody's, s.
const ABANDONED_AFTER_S: i64 = 10;

/// A file, in shared memory or in iceoryx2's folder, that belongs to a domain.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Leftover {
    /// Where it lies.
    pub path: PathBuf,
    /// Its length, bytes; what it occupies may be less.
    pub bytes: u64,
}

/// A process that has joined a stack, or had when it died.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// `instance/process`, or another name if the program is not part of this project.
    pub name: String,
    /// Operating-system process id; 0 if unknown.
    pub pid: u32,
    /// Whether it lives.
    pub alive: bool,
}

/// Why leftovers could not be listed or removed.
#[derive(Debug, thiserror::Error)]
pub enum CleanUpError {
    /// iceoryx2 could not say who lives.
    #[error(
        "cannot list the processes in shared memory ({cause}); may this user read iceoryx2's folder in /tmp?"
    )]
    List {
        /// What iceoryx2 says.
        cause: String,
    },
    /// A file could not be read or removed.
    #[error("cannot clear `{path}`: {source}; does it belong to another user?")]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Everyone in `domain`, the dead whom nobody has swept included.
///
/// # Errors
/// [`CleanUpError::List`].
pub fn members(domain: &Domain) -> Result<Vec<Member>, CleanUpError> {
    let mut members = Vec::new();
    let describe = |view: &dyn NodeView, alive| Member {
        name: view
            .details()
            .as_ref()
            .map_or_else(|| "?".to_owned(), |details| details.name().as_str().to_owned()),
        pid: view.details().as_ref().map_or(0, |details| details.process_id().value().unsigned_abs()),
        alive,
    };
    each_node(domain, |state| match state {
        NodeState::Alive(view) => members.push(describe(&view, true)),
        NodeState::Dead(view) => members.push(describe(&view, false)),
        NodeState::Inaccessible(_) | NodeState::Undefined(_) => {
            members.push(Member { name: "?".to_owned(), pid: 0, alive: true });
        }
    })?;
    Ok(members)
}

/// Files of `domain` that no living process owns.
///
/// While somebody in the domain lives, only the files of dead members count, since the others may be in use.
///
/// # Errors
/// [`CleanUpError`].
pub fn leftovers(domain: &Domain) -> Result<Vec<Leftover>, CleanUpError> {
    let members = members(domain)?;
    if members.iter().all(|member| !member.alive) {
        return files(domain);
    }
    let mut dead = Vec::new();
    each_node(domain, |state| {
        if let NodeState::Dead(view) = state {
            dead.push(view.id().value().to_string());
        }
    })?;
    let mut found = files(domain)?;
    found.retain(|leftover| {
        dead.iter()
            .any(|id| leftover.path.components().any(|part| part.as_os_str().to_string_lossy().contains(id)))
    });
    Ok(found)
}

/// Removes what dead members of `domain` left behind and, if nobody in it lives, every file that carries its prefix.
/// Returns what is gone.
///
/// Call it after a stack has ended, never on a control path. It must not race with the start of another process in the
/// same domain: one that has not registered yet counts as absent.
///
/// # Errors
/// [`CleanUpError`]; what was removed before stays removed.
pub fn clean_up(domain: &Domain) -> Result<Vec<Leftover>, CleanUpError> {
    let _watch = StillbornWatch::start(domain);
    let before = leftovers(domain)?;
    each_node(domain, |state| {
        if let NodeState::Dead(view) = state
            && let Err(error) = view.blocking_remove_stale_resources(CLEANER_PATIENCE)
        {
            tracing::debug!(?error, "iceoryx2 could not sweep a dead process; its files are removed by name");
        }
    })?;
    if members(domain)?.iter().all(|member| !member.alive) {
        for file in files(domain)? {
            remove(&file.path)?;
        }
    }
    remove_abandoned_folders(domain);
    let after: HashSet<_> = files(domain)?.into_iter().map(|file| file.path).collect();
    Ok(before.into_iter().filter(|file| !after.contains(&file.path)).collect())
}

/// Services of `domain` whose creation has begun and not ended.
pub(crate) fn unfinished_services(domain: &Domain) -> Vec<PathBuf> {
    let folder = PathBuf::from(domain.config().global.service_dir().to_string());
    let mut services = entries(&folder).unwrap_or_default();
    services.retain(|path| {
        // iceoryx2 takes the right to write away when the description is complete.
        carries_prefix(path, domain)
            && path.metadata().is_ok_and(|metadata| metadata.permissions().mode() & 0o200 != 0)
    });
    services
}

/// A [`Domain::isolated`] that takes every file of its own along when it is dropped: for tests and short private stacks.
///
/// Declare it before nodes and ports, so that it is dropped after them.
#[derive(Debug)]
pub struct ScopedDomain(Domain);

impl ScopedDomain {
    /// A domain that nobody else uses.
    #[allow(clippy::new_without_default)] // a default that differs each time would surprise
    pub fn new() -> Self {
        Self(Domain::isolated())
    }
}

impl Deref for ScopedDomain {
    type Target = Domain;

    fn deref(&self) -> &Domain {
        &self.0
    }
}

impl Drop for ScopedDomain {
    fn drop(&mut self) {
        if let Err(error) = clean_up(&self.0) {
            tracing::warn!(%error, "a private domain could not be cleared");
        }
    }
}

fn each_node(domain: &Domain, mut visit: impl FnMut(NodeState<Service>)) -> Result<(), CleanUpError> {
    quieten();
    Node::<Service>::list(&domain.config(), |state| {
        visit(state);
        CallbackProgression::Continue
    })
    .map_err(|error| CleanUpError::List { cause: format!("{error:?}") })
}

/// Whether the file's name says that it belongs to `domain`.
pub(crate) fn carries_prefix(path: &Path, domain: &Domain) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(domain.prefix()))
}

/// Every file that carries the prefix, sorted.
fn files(domain: &Domain) -> Result<Vec<Leftover>, CleanUpError> {
    let config = domain.config();
    let node_folder = PathBuf::from(config.global.node_dir().to_string());
    let mut folders = vec![
        PathBuf::from(SHARED_MEMORY_FOLDER),
        PathBuf::from(config.global.root_path().to_string()),
        PathBuf::from(config.global.service_dir().to_string()),
    ];
    folders.extend(entries(&node_folder)?.into_iter().filter(|path| path.is_dir()));
    folders.push(node_folder);

    let mut found = Vec::new();
    for folder in folders {
        for path in entries(&folder)? {
            // A file may vanish between listing and looking; then it is no leftover.
            if carries_prefix(&path, domain)
                && let Ok(metadata) = path.symlink_metadata()
            {
                found.push(Leftover { path, bytes: metadata.len() });
            }
        }
    }
    found.sort();
    Ok(found)
}

pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>, CleanUpError> {
    let failed = |source| CleanUpError::File { path: folder.to_owned(), source };
    match std::fs::read_dir(folder) {
        Ok(listing) => Ok(listing.filter_map(|entry| Some(entry.ok()?.path())).collect()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(failed(error)),
    }
}

/// Removes members' folders that have stayed empty: their owners were killed before they wrote anything that would tell
/// the domain. A living process fills its folder within milliseconds.
fn remove_abandoned_folders(domain: &Domain) {
    let now_s = clock_gettime(ClockId::Realtime).tv_sec;
    let node_folder = PathBuf::from(domain.config().global.node_dir().to_string());
    for folder in entries(&node_folder).unwrap_or_default() {
        let old = folder.metadata().is_ok_and(|metadata| now_s - metadata.mtime() > ABANDONED_AFTER_S);
        if old && is_members_folder(&folder) {
            // Refused while it holds something.
            let _ = std::fs::remove_dir(&folder);
        }
    }
}

/// Whether this is the folder of one member, named by its id.
fn is_members_folder(path: &Path) -> bool {
    path.is_dir()
        && path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().bytes().all(|byte| byte.is_ascii_digit()))
}

/// Removes a file and its folder, if that is one member's own and now empty.
pub(crate) fn remove(path: &Path) -> Result<(), CleanUpError> {
    match std::fs::remove_file(path) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(source) => return Err(CleanUpError::File { path: path.to_owned(), source }),
    }
    if let Some(folder) = path.parent()
        && is_members_folder(folder)
    {
        // Refused while it still holds something, which is then removed in its turn.
        let _ = std::fs::remove_dir(folder);
    }
    Ok(())
}
