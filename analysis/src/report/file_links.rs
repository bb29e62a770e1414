//! Links of `report.html` to the files in its folder.

use super::AnalysisReport;
use super::markup::breakable;
use maud::{Markup, html};
use std::path::Path;

/// Number of files of one kind that are listed openly; more are collapsed.
const LISTED_OPENLY: usize = 3;

/// The files next to the page, by kind.
#[derive(Debug, Default)]
pub(crate) struct FileLinks {
    recordings: Vec<String>,
    tables: Vec<String>,
    plots: Vec<String>,
}

impl FileLinks {
    /// The files of a report in a folder. Recordings may be elsewhere; then there is no link to them.
    pub(crate) fn in_folder(report: &AnalysisReport, folder: &Path, plots: Vec<String>) -> Self {
        let recordings = report.runs.iter().map(|run| run.file.clone());
        let recordings = recordings.filter(|file| folder.join(file).is_file()).collect();
        let mut tables = vec!["metrics.csv".to_owned(), "metrics.json".to_owned()];
        if cfg!(feature = "parquet") {
            tables.push("metrics.parquet".to_owned());
        }
        Self { recordings, tables, plots }
    }

    /// The links as a list.
    pub(super) fn list(&self) -> Markup {
        html! {
            ul class="files" {
                (kind("recording", "recordings", &self.recordings))
                (kind("table", "tables", &self.tables))
                (kind("plot", "plots", &self.plots))
            }
        }
    }
}

fn kind(one: &str, many: &str, files: &[String]) -> Markup {
    html! {
        @if files.len() > LISTED_OPENLY {
            li {
                details {
                    summary { (files.len()) " " (many) }
                    ul { @for file in files { li { (link(file)) } } }
                }
            }
        } @else if !files.is_empty() {
            li {
                (if files.len() == 1 { one } else { many }) ": "
                @for (index, file) in files.iter().enumerate() {
                    @if index > 0 { ", " }
                    (link(file))
                }
            }
        }
    }
}

fn link(file: &str) -> Markup {
    html! { a href=(address(file)) { (breakable(file)) } }
}

/// The address of a file in the page's folder. Every byte that has a meaning in an address is encoded.
pub(super) fn address(file: &str) -> String {
    let mut address = "./".to_owned();
    for byte in file.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            address.push(char::from(byte));
        } else {
            address.push_str(&format!("%{byte:02X}"));
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::{FileLinks, address, link};

    #[test]
    fn file_names_are_escaped_and_percent_encoded() {
        assert_eq!(address("a b#c?d%e&f=1.mcap"), "./a%20b%23c%3Fd%25e%26f%3D1.mcap");
        assert_eq!(address("javascript:x"), "./javascript%3Ax");
        assert_eq!(address("é\"<"), "./%C3%A9%22%3C");
        let link = link("\"><script>.mcap").into_string();
        assert!(!link.contains("<script>") && link.contains("&quot;&gt;&lt;script&gt;"), "{link}");
    }

    #[test]
    fn many_files_are_collapsed_and_few_are_not() {
        let links = |count: usize| {
            let recordings = (0..count).map(|index| format!("{index}.mcap")).collect();
            FileLinks { recordings, ..FileLinks::default() }.list().into_string()
        };
        assert!(links(500).contains("<summary>500 recordings</summary>"));
        assert!(!links(3).contains("<details>") && links(3).contains("href=\"./2.mcap\""));
        assert!(!links(0).contains("recording"));
    }
}
