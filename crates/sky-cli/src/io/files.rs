//! Reading text with clear errors, and writing files so that nothing half-written is ever left
//! under a final name.
//!
//! A file is written to a temporary neighbor and renamed when complete. The temporary file is
//! removed when the command fails and when it is interrupted.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};
use thiserror::Error;

/// Exit status where a verdict is "not met": the command did its work, and the answer is no.
pub const EXIT_NOT_MET: u8 = 1;

/// Exit status of every failure.
pub const EXIT_FAILURE: u8 = 2;

/// The path that stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// Whether an output goes to standard output, where nothing else may be printed then.
#[must_use]
pub fn is_standard_output(path: &Path) -> bool {
    path == Path::new(STANDARD_OUTPUT)
}

/// Whether a name ends in an extension, in small letters or capitals.
#[must_use]
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// A file that cannot be read or written: which, what was expected, what was found.
#[derive(Debug, Error)]
pub enum FileError {
    /// No such file.
    #[error("{}: expected a file, found nothing there", .0.display())]
    Missing(PathBuf),
    /// A directory where a file is needed.
    #[error("{}: expected a file, found a directory", .0.display())]
    Directory(PathBuf),
    /// The file holds nothing.
    #[error("{}:1: expected a header line and rows, found an empty file", .0.display())]
    Empty(PathBuf),
    /// The bytes are not UTF-8 text.
    #[error(
        "{}:{line}: column {column}: expected UTF-8 text, found the byte 0x{byte:02x}",
        path.display()
    )]
    NotUtf8 {
        /// Which file.
        path: PathBuf,
        /// Line of the first bad byte, from 1.
        line: usize,
        /// Position of the first bad byte in its line, from 1.
        column: usize,
        /// The byte.
        byte: u8,
    },
    /// Reading failed.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Writing failed; nothing was left under the final name.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The directory of an output file does not exist.
    #[error("{}: cannot be written: expected the directory {}, found nothing there",
        path.display(), directory.display())]
    NoDirectory {
        /// The output file.
        path: PathBuf,
        /// Its directory.
        directory: PathBuf,
    },
    /// `-` where a directory is needed.
    #[error("--out: expected a directory, found -, standard output, which takes one file")]
    NotADirectory,
}

/// Reads the bytes of a file.
///
/// # Errors
/// When it is missing, a directory or unreadable.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    if path.is_dir() {
        return Err(FileError::Directory(path.to_owned()));
    }
    fs::read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => FileError::Missing(path.to_owned()),
        _ => FileError::Read {
            path: path.to_owned(),
            source,
        },
    })
}

/// Reads a text file.
///
/// # Errors
/// When it is missing, a directory, unreadable, not UTF-8, or holds nothing but blanks.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let text = String::from_utf8(read_bytes(path)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let line_start = bytes[..valid]
            .iter()
            .rposition(|&b| b == b'\n')
            .map_or(0, |newline| newline + 1);
        FileError::NotUtf8 {
            path: path.to_owned(),
            line: 1 + bytes[..valid].iter().filter(|&&b| b == b'\n').count(),
            column: 1 + valid - line_start,
            byte: bytes[valid],
        }
    })?;
    if text.trim_start_matches('\u{feff}').trim().is_empty() {
        return Err(FileError::Empty(path.to_owned()));
    }
    Ok(text)
}

/// Temporary files that exist now. Whoever creates, renames or removes one holds this lock, so an
/// interruption finds every one of them.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Directories that this run made, outer ones first.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the directories that this run made and left empty.
pub fn remove_empty_directories() {
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    for path in made.drain(..).rev() {
        // fails where there is something in it, and that is meant
        drop(fs::remove_dir(path));
    }
}

fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
    // A panic elsewhere must not keep temporary files from being removed.
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files, and the directories made for them, and ends the process with the exit code of a failure.
///
/// The lock stays held, so that no rename can follow.
fn give_up() -> ! {
    let files = temporary();
    for path in files.iter() {
        drop(fs::remove_file(path));
    }
    remove_empty_directories();
    drop(writeln!(
        io::stderr(),
        "error: interrupted; no incomplete file was left behind"
    ));
    std::process::exit(EXIT_FAILURE.into());
}

/// From now on an interruption (Ctrl-C, termination) removes the temporary files and exits with 2.
/// A second call does nothing.
pub fn clean_up_on_interrupt() {
    // The only error is that a handler exists already.
    drop(ctrlc::set_handler(|| give_up()));
}

/// An output file: written to a temporary neighbor, under its own name only when complete.
///
/// A target that is no regular file (`/dev/stdout`, a pipe) is written directly, and the path `-` is
/// standard output. Dropped without
/// [`commit`](Self::commit), it leaves nothing behind.
#[derive(Debug)]
pub struct OutputFile {
    /// As the user wrote it, for messages.
    path: PathBuf,
    /// What is replaced in the end.
    target: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Temporary(NamedTempFile),
    Direct(File),
    Standard,
    /// Committed or failed.
    Closed,
}

impl OutputFile {
    /// Opens an output; called before the work starts, so that a bad path is told at once.
    ///
    /// # Errors
    /// When the path is a directory, is read-only, lies in no directory, or its directory cannot be
    /// written to.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let failed = |source| FileError::Write {
            path: path.to_owned(),
            source,
        };
        if is_standard_output(path) {
            return Ok(Self {
                path: PathBuf::from("standard output"),
                target: path.to_owned(),
                sink: Sink::Standard,
            });
        }
        // A link is followed: the file it points to is replaced, not the link.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let old = fs::metadata(&target).ok();
        if let Some(old) = &old {
            if old.is_dir() {
                return Err(FileError::Directory(path.to_owned()));
            }
            if !old.is_file() {
                let file = File::options().write(true).open(&target).map_err(failed)?;
                return Ok(Self {
                    path: path.to_owned(),
                    target,
                    sink: Sink::Direct(file),
                });
            }
            if old.permissions().readonly() {
                return Err(failed(io::ErrorKind::PermissionDenied.into()));
            }
        }
        let directory = match target.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        if !directory.is_dir() {
            return Err(FileError::NoDirectory {
                path: path.to_owned(),
                directory: directory.to_owned(),
            });
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".utm-sky-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Like any new file: readable as the umask allows, not by the owner alone.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut files = temporary();
        let file = builder.tempfile_in(directory).map_err(failed)?;
        files.push(file.path().to_owned());
        drop(files);
        if let Some(old) = old {
            // Replacing a file keeps its permissions; failing to is no reason to stop.
            drop(fs::set_permissions(file.path(), old.permissions()));
        }
        Ok(Self {
            path: path.to_owned(),
            target,
            sink: Sink::Temporary(file),
        })
    }

    /// Writes the whole content and puts it under the final name.
    ///
    /// # Errors
    /// When writing or renaming fails; the final name is then untouched.
    pub fn commit(mut self, content: &[u8]) -> Result<(), FileError> {
        self.finish(content).map_err(|source| FileError::Write {
            path: self.path.clone(),
            source,
        })
    }

    fn finish(&mut self, content: &[u8]) -> io::Result<()> {
        match std::mem::replace(&mut self.sink, Sink::Closed) {
            Sink::Direct(mut file) => file.write_all(content).and_then(|()| file.flush()),
            Sink::Standard => to_standard_output(content),
            Sink::Temporary(mut file) => {
                let written = file
                    .write_all(content)
                    .and_then(|()| file.as_file().sync_all());
                let temporary_path = file.into_temp_path();
                match written {
                    Ok(()) => rename(temporary_path, &self.target),
                    Err(error) => {
                        remove(temporary_path);
                        Err(error)
                    }
                }
            }
            Sink::Closed => Ok(()),
        }
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let Sink::Temporary(file) = std::mem::replace(&mut self.sink, Sink::Closed) {
            remove(file.into_temp_path());
        }
    }
}

fn forget(files: &mut Vec<PathBuf>, path: &Path) {
    files.retain(|p| p != path);
}

fn rename(temporary_path: TempPath, target: &Path) -> io::Result<()> {
    let mut files = temporary();
    forget(&mut files, &temporary_path);
    temporary_path.persist(target).map_err(|e| e.error)
}

fn remove(temporary_path: TempPath) {
    let mut files = temporary();
    forget(&mut files, &temporary_path);
    drop(temporary_path);
}

/// Makes a directory for outputs where there is none. It is removed again if the run fails or is
/// interrupted before anything is in it.
///
/// # Errors
/// When it cannot be made, or is `-`: several files do not go to standard output.
pub fn create_directory(path: &Path) -> Result<(), FileError> {
    if is_standard_output(path) {
        return Err(FileError::NotADirectory);
    }
    let missing: Vec<PathBuf> = path
        .ancestors()
        .take_while(|p| !p.as_os_str().is_empty() && !p.exists())
        .map(Path::to_owned)
        .collect();
    // held until they are there, so that an interruption finds them
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    made.extend(missing.into_iter().rev());
    fs::create_dir_all(path).map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Writes everything; a reader that has gone away (`utm-sky profile | head`) is no error.
fn to_standard_output(content: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(content).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// Writes to the terminal; a reader that has gone away (`utm-sky profile | head`) is no error.
///
/// # Errors
/// When standard output cannot be written for another reason.
pub fn print(text: &str) -> Result<(), FileError> {
    to_standard_output(text.as_bytes()).map_err(|source| FileError::Write {
        path: PathBuf::from("standard output"),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(directory)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_only_when_complete() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out.csv");
        let out = OutputFile::create(&path).unwrap();
        assert!(!path.exists());
        assert_eq!(names(dir.path()).len(), 1, "the temporary neighbor");
        out.commit(b"a,b\n1,2\n").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"a,b\n1,2\n");
        assert_eq!(names(dir.path()), ["out.csv"]);
    }

    #[test]
    fn a_file_given_up_leaves_the_old_one() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out.csv");
        fs::write(&path, "old").unwrap();
        drop(OutputFile::create(&path).unwrap());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["out.csv"]);
        assert!(temporary().iter().all(|p| !p.starts_with(dir.path())));
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_is_readable_as_any_other() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let plain = dir.path().join("plain");
        fs::write(&plain, "x").unwrap();
        let ours = dir.path().join("ours");
        OutputFile::create(&ours).unwrap().commit(b"x").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed() {
        let dir = tempfile::tempdir().unwrap();
        let real = dir.path().join("real");
        fs::write(&real, "old").unwrap();
        let link = dir.path().join("link");
        std::os::unix::fs::symlink(&real, &link).unwrap();
        OutputFile::create(&link).unwrap().commit(b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }

    #[test]
    fn bad_targets_are_told_before_the_work() {
        let dir = tempfile::tempdir().unwrap();
        assert!(matches!(
            OutputFile::create(dir.path()),
            Err(FileError::Directory(_))
        ));
        assert!(matches!(
            OutputFile::create(&dir.path().join("no/such/out.csv")),
            Err(FileError::NoDirectory { .. })
        ));
    }

    #[test]
    fn bad_texts_are_told_with_their_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("in.csv");
        assert!(matches!(read_text(&path), Err(FileError::Missing(_))));
        assert!(matches!(
            read_text(dir.path()),
            Err(FileError::Directory(_))
        ));
        fs::write(&path, " \n\n").unwrap();
        assert!(matches!(read_text(&path), Err(FileError::Empty(_))));
        fs::write(&path, b"a,b\n1,\xff\n").unwrap();
        assert!(matches!(
            read_text(&path),
            Err(FileError::NotUtf8 {
                line: 2,
                column: 3,
                byte: 0xff,
                ..
            })
        ));
    }
}
