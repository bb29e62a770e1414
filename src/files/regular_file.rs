//! The only place that opens files for reading: regular files only, opened without waiting, and of bounded size.
//!
//! A named pipe without a writer would block `open` itself, and a device such as `/dev/zero` has no end. Therefore, a file is
//! opened non-blocking, and its type is checked on the open file, which nothing can exchange any more.

#[cfg(not(windows))]
use std::fs::TryLockError;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read as _};
use std::path::{Component, Path, PathBuf};

/// Maximum size of a manifest, and of its canonical text in a recording.
pub const MAX_MANIFEST_BYTES: u64 = 16 << 20;
/// Maximum size of `experiment.toml`: the runs of the largest sweep, 100,000, with up to 600 bytes each.
pub const MAX_EXPERIMENT_RECORD_BYTES: u64 = 64 << 20;
/// Maximum size of a lock file: tens of thousands of manifests.
pub const MAX_LOCK_FILE_BYTES: u64 = 64 << 20;
/// Maximum size of other side files: timing tables, reports of failures, checks, baselines.
pub const MAX_SIDE_FILE_BYTES: u64 = 16 << 20;

/// Opens a regular file for reading.
///
/// # Errors
/// A file that cannot be opened, or is a folder, a named pipe, a socket or a device.
pub fn open(path: &Path) -> io::Result<(File, Metadata)> {
    checked(without_waiting(OpenOptions::new().read(true)).open(path)?)
}

/// A folder that stays the same, even if another one takes its place.
#[derive(Debug)]
pub struct OpenFolder {
    #[cfg(unix)]
    descriptor: std::os::fd::OwnedFd,
    #[cfg(not(unix))]
    path: PathBuf,
}

#[cfg(unix)]
impl OpenFolder {
    /// A descriptor that only leads to the files of a folder needs no right to list it.
    #[cfg(any(target_os = "linux", target_os = "android"))]
    const FOLDER: rustix::fs::OFlags =
        rustix::fs::OFlags::PATH.union(rustix::fs::OFlags::DIRECTORY);
    #[cfg(not(any(target_os = "linux", target_os = "android")))]
    const FOLDER: rustix::fs::OFlags = rustix::fs::OFlags::DIRECTORY;
    const NO_LINK: rustix::fs::OFlags =
        rustix::fs::OFlags::NOFOLLOW.union(rustix::fs::OFlags::CLOEXEC);

    /// Opens a folder.
    ///
    /// # Errors
    /// A folder that cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        let flags = Self::FOLDER | Self::NO_LINK;
        Ok(Self { descriptor: rustix::fs::open(path, flags, rustix::fs::Mode::empty())? })
    }

    /// Opens a regular file below the folder without following any link on the way, also one that is exchanged during the call.
    /// Elsewhere than on Unix, links are found before the file is opened.
    ///
    /// # Errors
    /// As [`open`], a link on the way, or a path with other parts than names.
    pub fn file(&self, path: &Path) -> io::Result<(File, Metadata)> {
        use rustix::fs::{Mode, OFlags, openat};
        let mut opened: Option<std::os::fd::OwnedFd> = None;
        let mut parts = path.components().peekable();
        while let Some(part) = parts.next() {
            let Component::Normal(name) = part else {
                return Err(io::Error::from(io::ErrorKind::InvalidInput));
            };
            let is_folder = parts.peek().is_some();
            let kind = if is_folder { Self::FOLDER } else { OFlags::RDONLY | OFlags::NONBLOCK };
            let from = opened.as_ref().unwrap_or(&self.descriptor);
            opened = Some(openat(from, name, kind | Self::NO_LINK, Mode::empty())?);
        }
        let opened = opened.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        checked(File::from(opened))
    }
}

#[cfg(not(unix))]
#[expect(missing_docs, reason = "as above")]
impl OpenFolder {
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.canonicalize()? })
    }

    pub fn file(&self, path: &Path) -> io::Result<(File, Metadata)> {
        let whole = self.path.join(path);
        let is_name = |part: Component<'_>| matches!(part, Component::Normal(_));
        if !path.components().all(is_name) || whole.canonicalize()? != whole {
            return Err(io::Error::from(io::ErrorKind::InvalidInput));
        }
        open(&whole)
    }
}

/// A path that opens an open file again: by its descriptor, because another process may have exchanged the file for a link. Elsewhere
/// than on Unix, it is the given path.
#[cfg(unix)]
#[must_use]
pub fn path_of_open(file: &File, _: &Path) -> PathBuf {
    use std::os::fd::AsRawFd as _;
    PathBuf::from(format!("/dev/fd/{}", file.as_raw_fd()))
}

#[cfg(not(unix))]
#[expect(missing_docs, reason = "as above")]
#[must_use]
pub fn path_of_open(_: &File, path: &Path) -> PathBuf {
    path.to_owned()
}

/// Reads a regular file of at most `max_bytes`. A larger file is not read.
///
/// # Errors
/// As [`open`], a file that is too large, or one that cannot be read.
pub fn read(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let (file, metadata) = open(path)?;
    read_opened(file, metadata.len(), max_bytes)
}

/// Reads a file as [`read`], if only the user who runs the program, or root, can have written it. Elsewhere than on Unix, owners
/// are not checked.
///
/// # Errors
/// As [`read`], or a file that belongs to another user or that others can write.
pub fn read_own(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let (file, metadata) = open(path)?;
    if !is_own(&metadata) {
        let what = "another user can have written it";
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, what));
    }
    read_opened(file, metadata.len(), max_bytes)
}

#[cfg(unix)]
fn is_own(metadata: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    /// The permissions of the group and of all others to write.
    const OTHERS_WRITE: u32 = 0o022;
    let is_trusted = [rustix::process::geteuid().as_raw(), 0].contains(&metadata.uid());
    is_trusted && metadata.mode() & OTHERS_WRITE == 0
}

#[cfg(not(unix))]
fn is_own(_metadata: &Metadata) -> bool {
    true
}

/// Reads a regular file of at most `max_bytes` in UTF-8.
///
/// # Errors
/// As [`read`], or bytes that are not UTF-8.
pub fn read_text(path: &Path, max_bytes: u64) -> io::Result<String> {
    let bytes = read(path, max_bytes)?;
    String::from_utf8(bytes)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not a text in UTF-8"))
}

/// Whether an error of reading follows from the path or from the content of the file, so that the same command fails again. Any other is
/// one of the machine, such as a disk that fails.
#[must_use]
pub fn is_of_file(error: &io::Error) -> bool {
    use io::ErrorKind as Kind;
    matches!(
        error.kind(),
        Kind::NotFound
            | Kind::PermissionDenied
            | Kind::NotADirectory
            | Kind::IsADirectory
            | Kind::InvalidFilename
            | Kind::InvalidInput
            | Kind::InvalidData
            | Kind::FileTooLarge
    ) || is_loop_of_links(error)
}

#[cfg(unix)]
fn is_loop_of_links(error: &io::Error) -> bool {
    error.raw_os_error() == Some(rustix::io::Errno::LOOP.raw_os_error())
}

#[cfg(not(unix))]
fn is_loop_of_links(_: &io::Error) -> bool {
    false
}

/// Opens a regular file for reading and writing, and creates it if it does not exist. A symbolic link is not followed, because
/// it could lead to any file of the user.
///
/// # Errors
/// As [`open`], or a symbolic link.
pub fn open_or_create(path: &Path) -> io::Result<(File, Metadata)> {
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).read(true).write(true);
    match without_following(&mut options).open(path) {
        Ok(file) => checked(file),
        Err(_) if path.is_symlink() => {
            Err(io::Error::new(io::ErrorKind::InvalidInput, "it is a symbolic link: remove it"))
        }
        Err(error) => Err(error),
    }
}

/// Opens a file to read and write as [`open_or_create`], as the only one who writes it as long as the value exists; `None` if another one
/// does. On Unix by a lock, which only such programs respect; on Windows, where locks would exclude readers, by not sharing it with writers.
///
/// # Errors
/// As [`open_or_create`], or a file system without locks.
#[cfg(not(windows))]
pub fn open_as_only_writer(path: &Path) -> io::Result<Option<File>> {
    let (file, _) = open_or_create(path)?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Whether another one writes a file that it opened by [`open_as_only_writer`]. Its lock is tried for an instant.
#[cfg(not(windows))]
#[must_use]
pub fn has_writer(path: &Path) -> bool {
    open(path)
        .is_ok_and(|(file, _)| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

#[cfg(windows)]
#[expect(missing_docs, reason = "as above")]
pub fn open_as_only_writer(path: &Path) -> io::Result<Option<File>> {
    use std::os::windows::fs::OpenOptionsExt as _;
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).read(true).write(true).share_mode(READERS_MAY_OPEN);
    match options.open(path) {
        Ok(file) => checked(file).map(|(file, _)| Some(file)),
        Err(error) if error.raw_os_error() == Some(SHARING_VIOLATION) => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(windows)]
#[expect(missing_docs, reason = "as above")]
#[must_use]
pub fn has_writer(path: &Path) -> bool {
    let opened = OpenOptions::new().write(true).open(path);
    opened.is_err_and(|error| error.raw_os_error() == Some(SHARING_VIOLATION))
}

/// FILE_SHARE_READ and FILE_SHARE_DELETE, so that an open file can be read and renamed.
#[cfg(windows)]
const READERS_MAY_OPEN: u32 = 1 | 4;
/// ERROR_SHARING_VIOLATION.
#[cfg(windows)]
const SHARING_VIOLATION: i32 = 32;

/// Reads the rest of an input that has `bytes` bytes according to its storage.
///
/// # Errors
/// More than `max_bytes`, or an input that cannot be read.
pub fn read_opened(input: impl io::Read, bytes: u64, max_bytes: u64) -> io::Result<Vec<u8>> {
    let too_large = || {
        let limit = max_bytes >> 20;
        let what = format!("it is larger than {limit} MiB, the maximum for such a file");
        io::Error::new(io::ErrorKind::FileTooLarge, what)
    };
    if bytes > max_bytes {
        return Err(too_large());
    }
    let mut content = Vec::new();
    // The file may grow while it is read, and files of /proc have a size of 0.
    input.take(max_bytes + 1).read_to_end(&mut content)?;
    if content.len() as u64 > max_bytes { Err(too_large()) } else { Ok(content) }
}

fn checked(file: File) -> io::Result<(File, Metadata)> {
    let metadata = file.metadata()?;
    if metadata.is_file() {
        return Ok((file, metadata));
    }
    let what = format!("it is {}, not a regular file", type_of(&metadata));
    Err(io::Error::new(io::ErrorKind::InvalidInput, what))
}

/// What a file that is not a regular one is.
#[must_use]
pub fn type_of(metadata: &Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        let kind = metadata.file_type();
        if kind.is_fifo() {
            return "a named pipe (FIFO)";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if metadata.is_dir() { "a folder" } else { "a special file" }
}

#[cfg(unix)]
fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    use std::os::unix::fs::OpenOptionsExt as _;
    // A terminal must not become the program's own one.
    options.custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY)
}

#[cfg(unix)]
fn without_following(options: &mut OpenOptions) -> &mut OpenOptions {
    use std::os::unix::fs::OpenOptionsExt as _;
    options.custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY | libc::O_NOFOLLOW)
}

#[cfg(not(unix))]
fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}

#[cfg(not(unix))]
fn without_following(options: &mut OpenOptions) -> &mut OpenOptions {
    options
}
