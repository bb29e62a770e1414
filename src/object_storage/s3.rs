//! S3 and compatible stores through `object_store`, whose requests, signatures and retries are used behind a blocking interface.

use crate::address::Address;
use crate::error::StoreError;
use crate::object::{Object, Put, Upload};
use crate::ranged_input::RangedInput;
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file;
use kinetoscope_recording::storage::{Opened, Storage};
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path as Key;
use object_store::{
    Attribute, Attributes, BackoffConfig, ClientConfigKey, Error, GetOptions, MultipartUpload,
    ObjectStore as _, ObjectStoreExt as _, PutMode, PutMultipartOptions, PutOptions, RetryConfig,
};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::future::Future;
use std::io::{self, Read, Seek as _};
use std::path::Path;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::Runtime;
use tokio::time::timeout;

/// Size up to which a file is uploaded by one request, and size of the parts of a larger file. It bounds the memory of an upload.
const PART_BYTES: u64 = 8 << 20;
/// Maximum number of parts of an object; a larger file has larger parts.
const MAX_PARTS: u64 = 10_000;
/// Attribute with the SHA-256 of an object, so that two objects are compared without a download.
const HASH: &str = "sha256";
/// Size of the parts in which a file is hashed.
const HASH_BUFFER_BYTES: usize = 64 << 10;
/// Interval at which a stop is checked.
const STOP_INTERVAL: Duration = Duration::from_millis(100);
/// Time limit for the removal of the parts of a failed upload.
const CLEAN_UP_TIMEOUT: Duration = Duration::from_secs(5);
/// Time after which an idle connection is closed, because the store may have closed it.
const IDLE_TIMEOUT: &str = "5 seconds";
/// Retries of a request: for some seconds without an answer, for at most a minute with error answers.
const RETRIES: RetryConfig = RetryConfig {
    backoff: BackoffConfig {
        init_backoff: Duration::from_millis(100),
        max_backoff: Duration::from_secs(10),
        base: 3.0,
    },
    max_retries: 8,
    retry_timeout: Duration::from_secs(60),
};

/// An open location on object storage, for use by several threads.
#[derive(Debug)]
pub struct Store(Arc<Location>);

#[derive(Debug)]
struct Location {
    address: Address,
    bucket: AmazonS3,
    prefix: Key,
    runtime: Runtime,
}

/// Size and hash of a file, to compare two files.
#[derive(PartialEq, Eq)]
struct Fingerprint {
    bytes: u64,
    /// SHA-256 in hexadecimal digits.
    hash: String,
}

impl Store {
    /// Opens a location without a request. Credentials, region and endpoint are read from the standard variables of S3:
    /// `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_REGION`, `AWS_ENDPOINT_URL` …
    ///
    /// # Errors
    /// Invalid settings.
    pub fn open(address: &Address) -> Result<Self, StoreError> {
        // An error means that a provider was installed before.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let wrong = |why: String| StoreError::permanent(format!("{address}: {why}"));
        let unused = AmazonS3ConfigKey::Client(ClientConfigKey::PoolIdleTimeout);
        let bucket = AmazonS3Builder::from_env()
            .with_bucket_name(address.bucket())
            .with_config(unused, IDLE_TIMEOUT)
            .with_retry(RETRIES)
            .build()
            .map_err(|error| wrong(error.to_string()))?;
        let prefix = Key::parse(address.prefix()).map_err(|error| wrong(error.to_string()))?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| wrong(error.to_string()))?;
        Ok(Self(Arc::new(Location { address: address.clone(), bucket, prefix, runtime })))
    }

    /// The address.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.0.address
    }

    /// Lists all objects below the location, in the order of their names.
    ///
    /// # Errors
    /// A store that does not answer, or has no such bucket.
    pub fn objects(&self) -> Result<Vec<Object>, StoreError> {
        let Location { bucket, prefix, .. } = self.0.as_ref();
        let listed = self.0.wait(&|| false, async {
            let (mut found, mut rest) = (Vec::new(), vec![prefix.clone()]);
            while let Some(prefix) = rest.pop() {
                let level = bucket.list_with_delimiter(Some(&prefix)).await?;
                found.extend(level.objects);
                rest.extend(level.common_prefixes);
            }
            Ok(found)
        })?;
        let below = |object: object_store::ObjectMeta| {
            let parts: Vec<_> = object.location.prefix_match(prefix)?.collect();
            let names: Vec<&str> = parts.iter().map(AsRef::as_ref).collect();
            Some(Object { name: names.join("/"), bytes: object.size })
        };
        let mut objects: Vec<Object> = listed.into_iter().filter_map(below).collect();
        objects.sort();
        Ok(objects)
    }

    /// Uploads a file if its name is free, and checks the object afterward. An existing object is compared and never replaced.
    /// A small file is uploaded by one conditional request (`If-None-Match: *`). The name of a large file is checked before its
    /// first part; the object appears after its last part.
    ///
    /// # Errors
    /// A file that cannot be read, a store that rejects the upload or returns other bytes, or a stop.
    pub fn put_once(&self, upload: Upload<'_>) -> Result<Put, StoreError> {
        let (key, mut file) = (self.0.key(upload.name)?, opened(upload.file)?);
        let local = fingerprint(&mut file).map_err(|error| cannot_read(upload.file, &error))?;
        if let Some(remote) = self.0.fingerprint(&key, upload.stop)? {
            return Ok(if remote == local { Put::Same } else { Put::Differs });
        }
        let put = if local.bytes > PART_BYTES {
            self.0.upload_in_parts(&key, file, &local, upload)
        } else {
            self.0.upload_whole(&key, file, &local, upload, PutMode::Create)
        };
        let put = put?;
        match self.0.fingerprint(&key, upload.stop)? {
            Some(remote) if remote == local => Ok(put),
            Some(_) if put == Put::Same => Ok(Put::Differs),
            Some(_) | None => Err(StoreError::retryable(Message::new(
                format!(
                    "{}/{} differs from the uploaded file, which was kept",
                    self.0.address, upload.name
                ),
                "run the same command again",
            ))),
        }
    }

    /// Uploads a small file and replaces an existing object of this name.
    ///
    /// # Errors
    /// A file that cannot be read, a store that rejects the upload, or a stop.
    pub fn replace(&self, upload: Upload<'_>) -> Result<(), StoreError> {
        let (key, mut file) = (self.0.key(upload.name)?, opened(upload.file)?);
        let local = fingerprint(&mut file).map_err(|error| cannot_read(upload.file, &error))?;
        self.0.upload_whole(&key, file, &local, upload, PutMode::Overwrite).map(drop)
    }
}

impl Storage for Store {
    fn open(&self, path: &Path) -> io::Result<Opened> {
        let name = path.strip_prefix(self.0.address.to_string()).ok().and_then(Path::to_str);
        let name = name.ok_or_else(|| {
            StoreError::permanent(format!("{} is not below {}", shown_path(path), self.0.address))
        })?;
        let key = self.0.key(name)?;
        let object =
            self.0.runtime.block_on(self.0.bucket.head(&key)).map_err(|error| match error {
                Error::NotFound { .. } => io::Error::from(io::ErrorKind::NotFound),
                error => self.0.failure(&error).into(),
            })?;
        let location = Arc::clone(&self.0);
        let fetch = move |range| {
            let bytes = location.wait(&|| false, location.bucket.get_range(&key, range))?;
            Ok(Vec::from(bytes))
        };
        Ok(Opened {
            input: Box::new(RangedInput::new(object.size, fetch)),
            bytes: object.size,
            changed: Some(object.last_modified.into()),
        })
    }
}

impl Location {
    fn key(&self, name: &str) -> Result<Key, StoreError> {
        Key::parse(self.address.below(name).prefix())
            .map_err(|error| StoreError::permanent(format!("{}: {error}", self.address)))
    }

    /// Waits for the store's answer or for a stop.
    fn wait<T>(
        &self,
        stop: &dyn Fn() -> bool,
        answer: impl Future<Output = Result<T, Error>>,
    ) -> Result<T, StoreError> {
        self.runtime.block_on(async {
            let mut answer = pin!(answer);
            loop {
                match timeout(STOP_INTERVAL, answer.as_mut()).await {
                    Ok(answer) => return answer.map_err(|error| self.failure(&error)),
                    Err(_) if stop() => return Err(self.stopped()),
                    Err(_) => {}
                }
            }
        })
    }

    fn stopped(&self) -> StoreError {
        StoreError::retryable(format!("{}: stopped; the file was kept", self.address))
    }

    /// Size and hash of an object; `None` if it does not exist. An object without a stored hash is downloaded.
    fn fingerprint(
        &self,
        key: &Key,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Fingerprint>, StoreError> {
        let head = GetOptions { head: true, ..GetOptions::default() };
        let found = self.wait(stop, async {
            match self.bucket.get_opts(key, head).await {
                Ok(found) => Ok(Some(found)),
                Err(Error::NotFound { .. }) => Ok(None),
                Err(error) => Err(error),
            }
        })?;
        let Some(found) = found else { return Ok(None) };
        let bytes = found.meta.size;
        if let Some(hash) = found.attributes.get(&Attribute::Metadata(HASH.into())) {
            return Ok(Some(Fingerprint { bytes, hash: hash.to_string() }));
        }
        let fetch = |range| {
            if stop() {
                return Err(self.stopped().into());
            }
            Ok(Vec::from(self.wait(stop, self.bucket.get_range(key, range))?))
        };
        let hash = hash(RangedInput::new(bytes, fetch));
        let hash = hash.map_err(|error| StoreError::retryable(error.to_string()))?;
        Ok(Some(Fingerprint { bytes, hash }))
    }

    fn upload_whole(
        &self,
        key: &Key,
        mut file: File,
        local: &Fingerprint,
        upload: Upload<'_>,
        mode: PutMode,
    ) -> Result<Put, StoreError> {
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|error| cannot_read(upload.file, &error))?;
        let options = PutOptions { mode, attributes: attributes(local), ..PutOptions::default() };
        self.wait(upload.stop, async {
            match self.bucket.put_opts(key, bytes.into(), options).await {
                Ok(_) => Ok(Put::Created),
                Err(Error::AlreadyExists { .. } | Error::Precondition { .. }) => Ok(Put::Same),
                Err(error) => Err(error),
            }
        })
    }

    fn upload_in_parts(
        &self,
        key: &Key,
        mut file: File,
        local: &Fingerprint,
        upload: Upload<'_>,
    ) -> Result<Put, StoreError> {
        let options =
            PutMultipartOptions { attributes: attributes(local), ..PutMultipartOptions::default() };
        let mut parts = self.wait(upload.stop, self.bucket.put_multipart_opts(key, options))?;
        let put = self.upload_parts(parts.as_mut(), &mut file, local.bytes, upload);
        if put.is_err() {
            // Remaining parts occupy storage until a rule of the bucket removes them.
            let _ = self.runtime.block_on(async { timeout(CLEAN_UP_TIMEOUT, parts.abort()).await });
        }
        put
    }

    fn upload_parts(
        &self,
        parts: &mut dyn MultipartUpload,
        file: &mut File,
        bytes: u64,
        upload: Upload<'_>,
    ) -> Result<Put, StoreError> {
        let length = PART_BYTES.max(bytes.div_ceil(MAX_PARTS));
        for _ in 0..bytes.div_ceil(length) {
            let mut part = Vec::new();
            let read = file.by_ref().take(length).read_to_end(&mut part);
            read.map_err(|error| cannot_read(upload.file, &error))?;
            self.wait(upload.stop, parts.put_part(part.into()))?;
        }
        self.wait(upload.stop, parts.complete())?;
        Ok(Put::Created)
    }

    /// Formats the store's error with the next step.
    fn failure(&self, error: &Error) -> StoreError {
        let (address, bucket) = (&self.address, self.address.bucket());
        let message = error.to_string();
        if message.contains("NoSuchBucket") {
            return StoreError::permanent(Message::new(
                format!("{address}: the bucket {bucket} does not exist"),
                "create it, or name another one",
            ));
        }
        // Servers answer with several lines of XML.
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        let step = match error {
            Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => {
                "check AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN and their permissions"
            }
            _ => {
                "check the network, AWS_ENDPOINT_URL (http:// needs AWS_ALLOW_HTTP=true), AWS_REGION and the credentials"
            }
        };
        StoreError::retryable(Message::new(
            format!("{address}: {message}"),
            format!("{step}, then run the same command again"),
        ))
    }
}

fn attributes(local: &Fingerprint) -> Attributes {
    Attributes::from_iter([(Attribute::Metadata(HASH.into()), local.hash.clone())])
}

fn opened(path: &Path) -> Result<File, StoreError> {
    let opened = regular_file::open(path).map_err(|error| cannot_read(path, &error))?;
    Ok(opened.0)
}

fn cannot_read(path: &Path, error: &io::Error) -> StoreError {
    StoreError::retryable(format!("{} cannot be read: {error}", shown_path(path)))
}

/// Size and hash of a file, which is then rewound.
fn fingerprint(file: &mut File) -> io::Result<Fingerprint> {
    let hash = hash(&mut *file)?;
    let bytes = file.stream_position()?;
    file.rewind()?;
    Ok(Fingerprint { bytes, hash })
}

fn hash(mut input: impl Read) -> io::Result<String> {
    let mut digest = Sha256::new();
    let mut part = vec![0; HASH_BUFFER_BYTES];
    loop {
        match input.read(&mut part) {
            Ok(0) => break,
            Ok(count) => digest.update(&part[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
