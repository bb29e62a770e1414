//! Options for where recordings are written: a folder, or object storage through a spool folder.

use crate::messages::{Failure, bad, exit};
use clap::Args;
use kinetoscope::executor::cluster::task::quoted;
use kinetoscope::outputs::upload::Uploader;
use kinetoscope_console::Explained as _;
use kinetoscope_object_storage::address::Address;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Where recordings are written.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArguments {
    /// Folder of the recordings, which are written to DIR/NAME; or s3://BUCKET/PREFIX, in a program built with
    /// `--features object-storage` [default: recordings]
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Local folder of recordings on their way to s3://; each is removed after its upload
    #[arg(long, value_name = "DIR", default_value = SPOOL)]
    spool: PathBuf,
    /// Keep uploaded recordings in the spool folder
    #[arg(long)]
    keep_local: bool,
}

/// The default folder of recordings.
const USUAL: &str = "recordings";
/// The default folder of recordings on their way to object storage.
const SPOOL: &str = "spool";

impl OutputArguments {
    /// Recordings below a folder of this machine.
    pub(crate) fn below(folder: &Path) -> Self {
        Self { output: Some(folder.to_owned()), spool: PathBuf::from(SPOOL), keep_local: false }
    }

    fn output(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new(USUAL))
    }

    fn address(&self) -> Result<Option<Address>, Failure> {
        let text = self.output().to_string_lossy();
        Address::is_one(self.output()).then(|| Address::parse(&text)).transpose().map_err(bad)
    }

    /// The local folder below which runs are recorded; below the spool folder, each address has its own.
    ///
    /// # Errors
    /// An invalid address.
    pub(crate) fn folder(&self) -> Result<PathBuf, Failure> {
        Ok(match self.address()? {
            None => self.output().to_owned(),
            Some(address) if address.prefix().is_empty() => self.spool.join(address.bucket()),
            Some(address) => self.spool.join(address.bucket()).join(address.prefix()),
        })
    }

    /// Opens the object storage for the recordings of an experiment; `None` if they stay in the folder.
    ///
    /// # Errors
    /// An invalid address, or a program that was built without object storage.
    pub(crate) fn depot(&self, experiment: &str) -> Result<Option<Uploader>, Failure> {
        let address = self.address()?.map(|address| address.below(experiment));
        address
            .map(|address| Uploader::open(&address, self.keep_local))
            .transpose()
            .map_err(|error| Failure::of(exit::of_storage(error.is_retryable), error.message()))
    }

    /// Whether recordings are written to object storage.
    #[must_use]
    pub(crate) fn is_remote(&self) -> bool {
        Address::is_one(self.output())
    }

    /// The option that names the local folder.
    #[must_use]
    pub(crate) fn option_of_folder(&self) -> &'static str {
        if self.is_remote() { "--spool" } else { "--output" }
    }

    /// The same options for a shell, valid in any working folder.
    ///
    /// # Errors
    /// A path that cannot be resolved. The folder must exist.
    pub(crate) fn words(&self) -> io::Result<String> {
        if !self.is_remote() {
            return Ok(format!("--output {}", absolute(self.output())?));
        }
        let (address, spool) = (shell_word(self.output().as_os_str())?, absolute(&self.spool)?);
        let keep = if self.keep_local { " --keep-local" } else { "" };
        Ok(format!("--output {} --spool {spool}{keep}", quoted(address)))
    }
}

/// An absolute path, quoted for a shell.
fn absolute(path: &Path) -> io::Result<String> {
    Ok(quoted(shell_word(fs::canonicalize(path)?.as_os_str())?))
}

/// The text of a word that a line of a shell script can contain: `sh` executes the rest of a word after a line feed as another
/// command, and bytes that are not UTF-8 would be replaced.
///
/// # Errors
/// A word that no line can contain, as [`io::ErrorKind::InvalidInput`].
pub(crate) fn shell_word(word: &OsStr) -> io::Result<&str> {
    word.to_str().filter(|text| !text.contains(char::is_control)).ok_or_else(|| {
        let what = format!("{word:?} has a control character or is not UTF-8");
        io::Error::new(io::ErrorKind::InvalidInput, what)
    })
}
