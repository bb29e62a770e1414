//! `kinetoscope view`: serves recordings on this machine, and prints the address that opens them in Lichtblick with their layout.

mod connections;
mod contents;
mod server;

use crate::messages::Failure;
use crate::messages::exit::ON_FAILED_DISK;
use clap::Args;
use contents::{Contents, MAX_ENTRIES, viewer_address};
use kinetoscope_console::Exit;
use kinetoscope_console::StandardOutput;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::regular_file::is_of_file;
use kinetoscope_files::regular_file::{self, OpenFolder};
use serde_json::json;
use server::Server;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::time::Duration;

/// The port unless another is given.
const DEFAULT_PORT: u16 = 8766;
/// Addresses that are printed; the page of the server lists all.
const MAX_PRINTED: usize = 5;

/// Serve recordings to Lichtblick on this machine, and print the address that opens them with their layout
///
/// Lichtblick runs in the browser and reads the recording in parts, so that playback starts at once. Only this machine can
/// connect, and only web pages of the viewer and of this machine can read. Ctrl-C ends the server.
#[derive(Debug, Args)]
pub(crate) struct ViewArguments {
    /// Folder of recordings, or one recording
    #[arg(value_name = "PATH")]
    path: PathBuf,
    /// Address of a Lichtblick
    #[arg(long, value_name = "URL", default_value = "http://localhost:8080/", value_parser = viewer_url)]
    viewer: String,
    /// Port of this machine; 0 selects a free one
    #[arg(long, value_name = "PORT", default_value_t = DEFAULT_PORT)]
    port: u16,
    /// Open the page of the recordings in the browser
    #[arg(long)]
    open: bool,
    /// Print the addresses as JSON
    #[arg(long, help_heading = "Messages")]
    json: bool,
    #[arg(skip)]
    output: StandardOutput,
}

impl ViewArguments {
    /// Serves until the program is ended.
    pub(crate) fn execute(&self) -> Exit {
        self.serve().unwrap_or_else(|failure| {
            if self.json {
                let errors = [failure.plain_text()];
                let document = json!({ "exit_code": failure.exit.code(), "errors": errors });
                self.output.print_json(&format!("{document:#}\n"));
            }
            failure.report()
        })
    }

    fn serve(&self) -> Result<Exit, Failure> {
        let (folder, file) = self.folder()?;
        let opened = OpenFolder::open(&folder).map_err(|error| self.unreadable(&error))?;
        let contents = Contents::of(&folder, file.as_deref());
        if contents.recordings.is_empty() {
            let path = shown_path(&self.path);
            let what = if contents.is_cut {
                format!("{path} contains no recording among the first {MAX_ENTRIES} files")
            } else {
                format!("{path} contains no recording")
            };
            return Err(Failure::new(Exit::Unreadable, what)
                .help("name a folder with recordings (*.mcap), or run an experiment first"));
        }
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, self.port));
        let listener = TcpListener::bind(address)
            .and_then(|listener| Ok((listener.local_addr()?, listener)))
            .map_err(|error| {
                Failure::new(Exit::Retryable, format!("cannot serve at {address}: {error}"))
                    .help("another program may use this port: choose another with --port, or a free one with --port 0")
            });
        let (address, listener) = listener?;
        let server = Server { folder, opened, file, viewer: self.viewer.clone(), address };
        self.print(&contents, address);
        if let Some(failure) = self.output.failure() {
            return Err(Failure::new(Exit::Retryable, failure));
        }
        if self.open
            && let Err(error) = open::that_detached(format!("http://{address}/"))
        {
            let text =
                format!("note: no browser can be started ({error}): open the address in one");
            crate::messages::complain(&text);
        }
        server.run(listener).map_err(|error| {
            Failure::new(Exit::Retryable, format!("the server ended: {error}"))
                .help("start it again")
        })?;
        Ok(Exit::Done)
    }

    fn unreadable(&self, error: &io::Error) -> Failure {
        let what = format!("{} cannot be read: {error}", shown_path(&self.path));
        if is_of_file(error) {
            Failure::new(Exit::Unreadable, what).help("check the path")
        } else {
            Failure::new(Exit::Retryable, what).help(ON_FAILED_DISK)
        }
    }

    /// The folder to be served, and the name of the only recording if one is named.
    fn folder(&self) -> Result<(PathBuf, Option<String>), Failure> {
        let path = self.path.as_path();
        let unreadable = |error| self.unreadable(&error);
        let whole = path.canonicalize().map_err(unreadable)?;
        if whole.is_dir() {
            whole.read_dir().map_err(unreadable)?;
            return Ok((whole, None));
        }
        let name = whole.file_name().and_then(|name| name.to_str());
        match name {
            Some(name) if name.ends_with(".mcap") && whole.is_file() => {
                regular_file::open(&whole).map_err(unreadable)?;
                Ok((folder_of(&whole).to_path_buf(), Some(name.to_owned())))
            }
            _ => {
                let what = format!("{} is neither a folder nor a recording", shown_path(path));
                Err(Failure::new(Exit::Unreadable, what).help("name a recording (*.mcap)"))
            }
        }
    }

    fn print(&self, contents: &Contents, address: SocketAddr) {
        let recordings = &contents.recordings;
        let addresses = recordings.iter().map(|found| viewer_address(&self.viewer, address, found));
        if self.json {
            let viewers: Vec<_> = recordings
                .iter()
                .zip(addresses)
                .map(|(found, url)| json!({ "recording": found.path, "url": url }))
                .collect();
            let document = json!({
                "page": format!("http://{address}/"),
                "viewer": viewers,
                "is_cut": contents.is_cut,
            });
            return self.output.print_json(&format!("{document:#}\n"));
        }
        let path = shown_path(&self.path);
        let mut text = format!("{path} is served at http://{address}/ until Ctrl-C\n");
        text +=
            &format!("Open in the Lichtblick at {} (--viewer names another one):\n", self.viewer);
        for url in addresses.take(MAX_PRINTED) {
            text += &format!("{url}\n");
        }
        if recordings.len() > MAX_PRINTED {
            let more = recordings.len() - MAX_PRINTED;
            let at_least = if contents.is_cut { "at least " } else { "" };
            text += &format!("{at_least}{more} more recordings: see the page\n");
        }
        if is_unanswered(&self.viewer) {
            text += &format!(
                "\nNothing answers at {}. Without a Lichtblick, open http://{address}/ in a browser: it has the reports with their replays. \
                 docs/replay.md says how to get one.\n",
                self.viewer
            );
        }
        self.output.print(&text);
    }
}

/// Time for a viewer of this machine to accept a connection.
const PATIENCE: Duration = Duration::from_millis(300);

/// Whether the viewer should run on this machine and accepts no connection. Other machines are not asked.
fn is_unanswered(viewer: &str) -> bool {
    let Ok(address) = viewer.parse::<axum::http::Uri>() else { return false };
    let host = address.host().unwrap_or_default();
    if !matches!(host, "localhost" | "127.0.0.1") {
        return false;
    }
    let usual_port = if address.scheme_str() == Some("https") { 443 } else { 80 };
    let at = SocketAddr::from((Ipv4Addr::LOCALHOST, address.port_u16().unwrap_or(usual_port)));
    TcpStream::connect_timeout(&at, PATIENCE).is_err()
}

/// An address of a web page: `http://` or `https://` with a host.
fn viewer_url(text: &str) -> Result<String, String> {
    let address: Result<axum::http::Uri, _> = text.parse();
    let is_web = address.is_ok_and(|address| {
        address.authority().is_some() && matches!(address.scheme_str(), Some("http" | "https"))
    });
    if is_web && !text.contains('#') {
        Ok(text.to_owned())
    } else {
        Err("write an address such as http://localhost:8080/".to_owned())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn only_a_missing_viewer_of_this_machine_is_reported() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let viewer = format!("http://localhost:{}/", listener.local_addr().unwrap().port());
        assert!(!is_unanswered(&viewer));
        drop(listener);
        assert!(is_unanswered(&viewer));
        assert!(!is_unanswered("https://viewer.example:8443/x/"));
    }
}
