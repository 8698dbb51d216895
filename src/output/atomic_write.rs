//! A file is written beside its place and renamed when it is complete, so that its name never stands
//! for half of it.

use super::OutputError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};
use tempfile::{NamedTempFile, TempDir};

/// Files and folders that will not stay, for the case that the process must go at once. Whoever makes one holds the lock
/// meanwhile, so that none is made that is not listed.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what is half written; to be called before the process is ended by force, which must follow: nobody can begin a
/// file any more. Gives up after `patience` where another thread is making a file and the system lets it wait.
pub fn remove_unfinished(patience: Duration) {
    let begun = Instant::now();
    let mut files = loop {
        match UNFINISHED.try_lock() {
            Ok(files) => break files,
            Err(TryLockError::Poisoned(files)) => break files.into_inner(),
            Err(TryLockError::WouldBlock) if begun.elapsed() >= patience => return,
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    for path in files.iter() {
        if std::fs::remove_file(path).is_err() {
            let _ = std::fs::remove_dir_all(path);
        }
    }
    files.clear();
    std::mem::forget(files);
}

/// An entry of [`UNFINISHED`]: what lies at a place until this is dropped is removed if the process must go at once.
pub struct Passing(PathBuf);

impl Passing {
    /// For a file that is about to be made.
    pub fn file(path: &Path) -> Self {
        Self::listed(&mut unfinished(), path)
    }

    /// A new folder beside a file, which is gone when both parts are dropped.
    ///
    /// # Errors
    /// The system refuses.
    pub fn temporary_folder(path: &Path) -> std::io::Result<(TempDir, Self)> {
        let mut files = unfinished();
        let folder = tempfile::tempdir_in(folder_of(path))?;
        let listed = Self::listed(&mut files, folder.path());
        Ok((folder, listed))
    }

    fn listed(files: &mut Vec<PathBuf>, path: &Path) -> Self {
        files.push(path.into());
        Self(path.into())
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        unfinished().retain(|file| *file != self.0);
    }
}

/// The system's reason in words, without an error number.
pub(super) fn plain(error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::NotFound => "there is no such file or folder".into(),
        ErrorKind::PermissionDenied => "permission denied".into(),
        ErrorKind::StorageFull => "the disk is full".into(),
        ErrorKind::QuotaExceeded => "the disk quota is used up".into(),
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only".into(),
        ErrorKind::InvalidFilename => "the name is too long".into(),
        _ => error.to_string(),
    }
}

/// Where the bytes go in the end: through a symbolic link to what it names.
fn destination(path: &Path) -> PathBuf {
    match std::fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_symlink() => {
            std::fs::canonicalize(path).unwrap_or_else(|_| path.into())
        }
        _ => path.into(),
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A file that is being written, and its entry, which goes last.
struct Temporary {
    file: NamedTempFile,
    listed: Passing,
}

/// Whether the system keeps this user from replacing a file: in a folder with the sticky bit (such as /tmp) only the owners
/// of the file and of the folder may.
fn is_kept_by_another(file: &std::fs::Metadata, folder: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let user = rustix::process::geteuid();
    folder.mode() & STICKY != 0
        && !user.is_root()
        && user.as_raw() != file.uid()
        && user.as_raw() != folder.uid()
}

fn create_temporary(path: &Path) -> Result<Temporary, OutputError> {
    let not_writable = |reason: String| OutputError::NotWritable {
        path: path.display().to_string(),
        reason,
    };
    let there = std::fs::metadata(path);
    match &there {
        Ok(metadata) if metadata.is_dir() => {
            return Err(not_writable(
                "it is a folder; give the name of a file".into(),
            ));
        }
        // A rename would replace the device itself.
        Ok(metadata) if !metadata.is_file() => {
            return Err(not_writable("it is not a regular file".into()));
        }
        // The file beside has a short name: only the rename at the end would tell.
        Err(error) if error.kind() == std::io::ErrorKind::InvalidFilename => {
            return Err(not_writable(format!(
                "{}; give a shorter one",
                plain(error)
            )));
        }
        _ => {}
    }
    let folder = folder_of(path);
    match std::fs::metadata(folder) {
        Err(_) => {
            return Err(not_writable(format!(
                "there is no folder {}; create it first",
                folder.display()
            )));
        }
        Ok(metadata) if !metadata.is_dir() => {
            return Err(not_writable(format!(
                "{} is not a folder",
                folder.display()
            )));
        }
        Ok(folder) => {
            if there.is_ok_and(|file| is_kept_by_another(&file, &folder)) {
                return Err(not_writable(
                    "it belongs to another user, and its folder lets nobody else replace it".into(),
                ));
            }
        }
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".sundog-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file (the process's umask still applies), not as a secret temporary one.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut files = unfinished();
    let file = builder.tempfile_in(folder).map_err(|error| {
        let reason = plain(
            error
                .get_ref()
                .and_then(|e| e.downcast_ref())
                .unwrap_or(&error),
        );
        not_writable(format!("{reason} in the folder {}", folder.display()))
    })?;
    let listed = Passing::listed(&mut files, file.path());
    Ok(Temporary { file, listed })
}

/// Finds out, before the work is done, whether a file could be written. Leaves nothing behind.
///
/// # Errors
/// The folder does not exist or does not let files be created; the name is too long, or that of a folder or device.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    create_temporary(&destination(path)).map(drop)
}

/// Where a file of this name is or would be, whichever way the name is spelled; the path itself where there is no such folder.
fn place(path: &Path) -> PathBuf {
    let target = destination(path);
    match (
        std::fs::canonicalize(folder_of(&target)),
        target.file_name(),
    ) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => target,
    }
}

/// Whether two names stand for one place, so that what is written to the one replaces the other: by links and other spellings.
pub fn same_place(one: &Path, other: &Path) -> bool {
    place(one) == place(other)
}

/// Whether two names stand for one file that is there, also by hard links.
pub fn same_file(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (std::fs::metadata(one), std::fs::metadata(other)) {
        (Ok(one), Ok(other)) => (one.dev(), one.ino()) == (other.dev(), other.ino()),
        _ => false,
    }
}

/// Writes a file through `write`, makes sure that it has reached the disk, and only then gives it its name.
///
/// # Errors
/// Anything fails; then what was at `path` before is still there, and nothing else.
pub fn atomic_write<E: std::fmt::Display>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), OutputError> {
    write_and_rename(path, true, write)
}

/// The same without waiting for the disk: for files that are read at once and removed.
pub(super) fn write_unsynchronised<E: std::fmt::Display>(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), OutputError> {
    write_and_rename(path, false, write)
}

fn write_and_rename<E: std::fmt::Display>(
    path: &Path,
    synchronise: bool,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>,
) -> Result<(), OutputError> {
    let failed = |reason: String| OutputError::Failed {
        path: path.display().to_string(),
        reason,
    };
    let target = destination(path);
    // (Dropped in the reverse order: the entry goes last.)
    let Temporary {
        listed: _listed,
        file: temporary,
    } = create_temporary(&target)?;
    let mut writer = BufWriter::new(temporary.as_file());
    write(&mut writer).map_err(|error| failed(error.to_string()))?;
    writer.flush().map_err(|error| failed(plain(&error)))?;
    drop(writer);
    if synchronise {
        temporary
            .as_file()
            .sync_all()
            .map_err(|error| failed(plain(&error)))?;
    }
    temporary
        .persist(&target)
        .map_err(|error| failed(plain(&error.error)))?;
    // The rename, too, should survive a power cut; where folders cannot be synchronised, that is no failure.
    if synchronise && let Ok(folder) = File::open(folder_of(&target)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

#[cfg(test)]
#[path = "../../tests/unit/output/atomic_write.rs"]
mod tests;
