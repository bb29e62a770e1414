//! What the command line says of where recordings go: a folder, or object storage by way of one.

use crate::executor::cluster::task::quoted;
use crate::outputs::upload::Uploader;
use clap::Args;
use kinetoscope_object_storage::address::Address;
use kinetoscope_object_storage::error::StoreError;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Where recordings go.
#[derive(Debug, Args)]
pub struct Destination {
    /// Folder of the recordings: they go to DIR/NAME. Or s3://BUCKET/PREFIX, in a program built with
    /// `--features object-storage` [default: recordings]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Folder where runs are recorded whose recordings go to s3://: each is removed here when it is there
    #[arg(long, value_name = "DIR", default_value = "spool")]
    spool: PathBuf,
    /// Leave recordings in the spool when they are on s3://
    #[arg(long)]
    keep_local: bool,
}

/// Where recordings go unless the command line says otherwise.
const USUAL: &str = "recordings";

impl Destination {
    fn output(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new(USUAL))
    }

    fn address(&self) -> Result<Option<Address>, StoreError> {
        let text = self.output().to_string_lossy();
        Address::is_one(self.output()).then(|| Address::parse(&text)).transpose()
    }

    /// The folder that the command line names, if it does: a table of times goes there.
    ///
    /// # Errors
    /// An address: a table is no recording.
    pub fn named_folder(&self) -> Result<Option<&Path>, String> {
        match self.output.as_deref() {
            Some(output) if Address::is_one(output) => Err(format!(
                "a table of times goes into a folder, not to {}: give --output DIR, or leave it out",
                output.display()
            )),
            folder => Ok(folder),
        }
    }

    /// The folder of this machine below which runs are recorded: of the spool, one for each address.
    ///
    /// # Errors
    /// An address that makes no sense.
    pub fn folder(&self) -> Result<PathBuf, StoreError> {
        Ok(match self.address()? {
            None => self.output().to_owned(),
            Some(address) if address.prefix().is_empty() => self.spool.join(address.bucket()),
            Some(address) => self.spool.join(address.bucket()).join(address.prefix()),
        })
    }

    /// Where the recordings of an experiment go from that folder, if anywhere.
    ///
    /// # Errors
    /// An address that makes no sense, or a program that was built without object storage.
    pub fn depot(&self, experiment: &str) -> Result<Option<Uploader>, StoreError> {
        let address = self.address()?.map(|address| address.below(experiment));
        address.map(|address| Uploader::open(&address, self.keep_local)).transpose()
    }

    /// The option that names the folder of this machine.
    #[must_use]
    pub fn option_of_folder(&self) -> &'static str {
        if Address::is_one(self.output()) { "--spool" } else { "--output" }
    }

    /// The part of a shell's command line that says the same from any working folder.
    ///
    /// # Errors
    /// A path that can't be followed. The folder must be there.
    pub fn words(&self) -> io::Result<String> {
        if !Address::is_one(self.output()) {
            return Ok(format!("--output {}", absolute(self.output())?));
        }
        let (address, spool) = (self.output().display().to_string(), absolute(&self.spool)?);
        let keep = if self.keep_local { " --keep-local" } else { "" };
        Ok(format!("--output {} --spool {spool}{keep}", quoted(&address)))
    }
}

/// A path for a shell, from any working folder.
fn absolute(path: &Path) -> io::Result<String> {
    Ok(quoted(&fs::canonicalize(path)?.display().to_string()))
}
