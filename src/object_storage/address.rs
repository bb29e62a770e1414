//! An address on object storage: a bucket and the prefix of the objects' names.

use crate::error::StoreError;
use kinetoscope_console::Message;
use std::fmt;
use std::path::Path;

/// Scheme of an address.
const SCHEME: &str = "s3://";

/// `s3://BUCKET/PREFIX`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    bucket: String,
    prefix: String,
}

impl Address {
    /// Whether a path has the scheme of an address. The address may still be invalid.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        path.to_str().is_some_and(|text| text.starts_with(SCHEME))
    }

    /// Reads `s3://BUCKET/PREFIX`; the prefix may be empty or have slashes.
    ///
    /// # Errors
    /// An address without a bucket, or with a part that cannot be the name of a folder: empty, `.` or `..`.
    pub fn parse(text: &str) -> Result<Self, StoreError> {
        let wrong = |why: &str| {
            StoreError::permanent(Message::new(
                format!("{text}: {why}"),
                "write s3://BUCKET/PREFIX",
            ))
        };
        let location =
            text.strip_prefix(SCHEME).ok_or_else(|| wrong("not an address of object storage"))?;
        let location = location.strip_suffix('/').unwrap_or(location);
        let (bucket, prefix) = location.split_once('/').unwrap_or((location, ""));
        if bucket.is_empty() {
            return Err(wrong("the bucket is missing"));
        }
        if location.split('/').any(|part| matches!(part, "" | "." | "..")) {
            return Err(wrong("a part is empty, `.` or `..`"));
        }
        Ok(Self { bucket: bucket.to_owned(), prefix: prefix.to_owned() })
    }

    /// The address one level below.
    #[must_use]
    pub fn below(&self, name: &str) -> Self {
        let prefix = if self.prefix.is_empty() {
            name.to_owned()
        } else {
            format!("{}/{name}", self.prefix)
        };
        Self { bucket: self.bucket.clone(), prefix }
    }

    /// The bucket's name.
    #[must_use]
    pub fn bucket(&self) -> &str {
        &self.bucket
    }

    /// The prefix of the objects' names, without a slash at the end.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.prefix
    }
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slash = if self.prefix.is_empty() { "" } else { "/" };
        write!(formatter, "{SCHEME}{}{slash}{}", self.bucket, self.prefix)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::Address;

    #[test]
    fn address_round_trips() {
        for text in ["s3://bucket", "s3://bucket/a", "s3://bucket/a/b c"] {
            assert_eq!(Address::parse(text).unwrap().to_string(), text);
            assert_eq!(Address::parse(&format!("{text}/")).unwrap().to_string(), text);
        }
        let below = Address::parse("s3://bucket/a").unwrap().below("b");
        assert_eq!((below.bucket(), below.prefix()), ("bucket", "a/b"));
        assert_eq!(Address::parse("s3://bucket").unwrap().below("b").prefix(), "b");
    }

    #[test]
    fn invalid_addresses_are_rejected() {
        for text in
            ["s3://", "s3:///a", "s3://bucket//a", "s3://bucket/../a", "s3://bucket/.", "bucket/a"]
        {
            let error = Address::parse(text).unwrap_err();
            assert!(!error.is_retryable && error.to_string().starts_with(text), "{error}");
        }
    }
}
