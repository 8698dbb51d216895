//! A file is written beside its place and renamed when it is complete, so that its name never stands
//! for half of it.

use super::OutputError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tempfile::NamedTempFile;

/// Files that are being written, for the case that the process must go at once.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes what is half written; to be called before the process is ended by force.
pub fn remove_unfinished() {
    if let Ok(mut files) = UNFINISHED.lock() {
        for file in files.drain(..) {
            let _ = std::fs::remove_file(file);
        }
    }
}

/// An entry of [`UNFINISHED`].
struct Registered(PathBuf);

impl Registered {
    fn new(path: &Path) -> Self {
        if let Ok(mut files) = UNFINISHED.lock() {
            files.push(path.into());
        }
        Self(path.into())
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        if let Ok(mut files) = UNFINISHED.lock() {
            files.retain(|file| *file != self.0);
        }
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

fn create_beside(path: &Path) -> Result<NamedTempFile, OutputError> {
    let not_writable = |reason: String| OutputError::NotWritable {
        path: path.display().to_string(),
        reason,
    };
    if let Ok(metadata) = std::fs::metadata(path) {
        if metadata.is_dir() {
            return Err(not_writable(
                "it is a folder; give the name of a file".into(),
            ));
        }
        // A rename would replace the device itself.
        if !metadata.is_file() {
            return Err(not_writable("it is not a regular file".into()));
        }
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
        Ok(_) => {}
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".sundog-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file (the process's umask still applies), not as a secret temporary one.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|error| {
        let reason = plain(
            error
                .get_ref()
                .and_then(|e| e.downcast_ref())
                .unwrap_or(&error),
        );
        not_writable(format!("{reason} in the folder {}", folder.display()))
    })
}

/// Finds out, before the work is done, whether a file could be written. Leaves nothing behind.
///
/// # Errors
/// The folder does not exist or does not let files be created; or the name is that of a folder or device.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    create_beside(&destination(path)).map(drop)
}

/// Writes a file through `write`, makes sure that it has reached the disk, and only then gives it its name.
///
/// # Errors
/// Anything fails; then what was at `path` before is still there, and nothing else.
pub fn write_beside<E: std::fmt::Display>(
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
    let temporary = create_beside(&target)?;
    let _registered = Registered::new(temporary.path());
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
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failing_write_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, "old").unwrap();
        let result = write_beside(&path, |file| {
            file.write_all(b"half").unwrap();
            file.flush().unwrap();
            Err("no more ink")
        });
        assert_eq!(
            result.unwrap_err().to_string(),
            format!("cannot write {}: no more ink", path.display())
        );
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_complete_write_replaces_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, "old").unwrap();
        write_beside(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (
            folder.path().join("real.exr"),
            folder.path().join("link.exr"),
        );
        std::fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_beside(&link, |file| file.write_all(b"new")).unwrap();
        assert_eq!(std::fs::read_to_string(&real).unwrap(), "new");
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(
            check_writable(Path::new("/dev/null"))
                .unwrap_err()
                .to_string()
                .contains("not a regular file")
        );
    }

    #[test]
    fn checking_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(&folder.path().join("a.exr")).unwrap();
        assert!(names(folder.path()).is_empty());
        let missing = check_writable(&folder.path().join("no/a.exr"))
            .unwrap_err()
            .to_string();
        assert!(missing.ends_with("create it first"), "{missing}");
        assert!(
            check_writable(folder.path())
                .unwrap_err()
                .to_string()
                .contains("it is a folder")
        );
    }
}
