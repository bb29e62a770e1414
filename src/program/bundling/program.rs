//! The program that made the results of a bundle: its version, the hash of its file, and the wheel that contains it.

use super::archive::{Content, hash_of};
use crate::messages::exit::unread;
use crate::messages::{Failure, bad};
use data_encoding::HEXLOWER;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file;
use serde_json::{Value as Json, json};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::Path;
use zip::ZipArchive;

/// The commit of the source, if the build names it: releases do.
const COMMIT: Option<&str> = option_env!("KINETOSCOPE_COMMIT");
/// Maximum size of the program's file, or of its list of packages, in a wheel.
const MAX_PART_BYTES: u64 = 1 << 30;

/// What made the results, and the list of its packages (CycloneDX), if the wheel has one.
pub(super) fn program(wheel: Option<&Path>) -> Result<(Json, Option<Content>), Failure> {
    let own = std::env::current_exe().and_then(|path| hash_of(&Content::File(path)));
    let own = own.map_err(|error| {
        Failure::new(Exit::Retryable, format!("cannot read the program's own file: {error}"))
    })?;
    let (wheel, packages) = match wheel {
        Some(path) => {
            let (wheel, packages) = read_wheel(path, &own)?;
            (Some(wheel), packages)
        }
        None => (None, None),
    };
    let program = json!({
        "name": "Kinetoscope",
        "version": env!("CARGO_PKG_VERSION"),
        "repository": env!("CARGO_PKG_REPOSITORY"),
        "commit": COMMIT,
        "sha256": own,
        "wheel": wheel,
    });
    Ok((program, packages))
}

/// Name and hash of a wheel that contains the program with this hash, and its list of packages.
fn read_wheel(path: &Path, own: &str) -> Result<(Json, Option<Content>), Failure> {
    let shown = shown_path(path);
    let unreadable = |error: &std::io::Error| {
        unread(error, format!("cannot read the wheel {shown}: {error}"), "check the path")
    };
    let not_a_wheel = |error| {
        bad(format!("{shown} is not a wheel: {error}")).help("name the file that pip installed")
    };
    let (file, _) = regular_file::open(path).map_err(|error| unreadable(&error))?;
    let mut zip = ZipArchive::new(BufReader::new(file)).map_err(not_a_wheel)?;
    let names: Vec<String> = zip.file_names().flatten().map(std::borrow::Cow::into_owned).collect();
    let mut part = |is_part: fn(&str) -> bool| {
        let name = names.iter().find(|name| is_part(name))?;
        read_part(&mut zip, name)
    };
    let program = part(|name| {
        name.ends_with(".data/scripts/kinetoscope")
            || name.ends_with(".data/scripts/kinetoscope.exe")
    });
    if program.map(|bytes| HEXLOWER.encode(&Sha256::digest(bytes))).as_deref() != Some(own) {
        return Err(bad(format!("{shown} does not contain this program"))
            .help("name the wheel from which the program was installed, or leave --wheel out"));
    }
    let packages = part(|name| name.contains(".dist-info/sboms/"));
    let packages = packages.and_then(|bytes| String::from_utf8(bytes).ok()).map(Content::Text);
    let hash = hash_of(&Content::File(path.to_owned())).map_err(|error| unreadable(&error))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok((json!({ "name": name, "sha256": hash }), packages))
}

fn read_part(zip: &mut ZipArchive<BufReader<File>>, name: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    zip.by_name(name).ok()?.take(MAX_PART_BYTES).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}
