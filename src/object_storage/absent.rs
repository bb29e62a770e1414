//! The store of a program that was built without object storage: it cannot be opened.

use crate::address::Address;
use crate::error::StoreError;
use crate::object::{Object, Put, Upload};
use kinetoscope_console::Message;
use kinetoscope_recording::storage::{Opened, Storage};
use std::convert::Infallible;
use std::io;
use std::path::Path;

/// A store that cannot be opened.
#[derive(Debug)]
pub struct Store(Infallible);

impl Store {
    /// # Errors
    /// Always: how to build a program that opens it.
    pub fn open(address: &Address) -> Result<Self, StoreError> {
        Err(StoreError::permanent(Message::new(
            format!("{address}: this program was built without object storage"),
            "use a folder of this machine, or build it with `cargo build --release --features object-storage` in a clone; \
             released programs do not include it",
        )))
    }

    /// As with the feature.
    #[must_use]
    pub fn address(&self) -> &Address {
        match self.0 {}
    }

    /// # Errors
    /// As with the feature.
    pub fn objects(&self) -> Result<Vec<Object>, StoreError> {
        match self.0 {}
    }

    /// # Errors
    /// As with the feature.
    pub fn put_once(&self, _: Upload<'_>) -> Result<Put, StoreError> {
        match self.0 {}
    }

    /// # Errors
    /// As with the feature.
    pub fn replace(&self, _: Upload<'_>) -> Result<(), StoreError> {
        match self.0 {}
    }
}

impl Storage for Store {
    fn open(&self, _: &Path) -> io::Result<Opened> {
        match self.0 {}
    }
}
