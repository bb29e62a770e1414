//! The description of a bundle in the formats that archives read: RO-Crate, Citation File Format, Zenodo and CodeMeta.

use super::archive::{BUNDLE, Content, PACKAGES, RECORDINGS};
use crate::locking::lock::USUAL;
use crate::messages::{Failure, bad};
use kinetoscope_console::text::one_line;
use serde_json::{Value as Json, json};
use std::collections::BTreeMap;
use std::fs;
use std::io;

/// The profiles of the description; see <https://www.researchobject.org/workflow-run-crate/profiles/process_run_crate>.
const RO_CRATE: &str = "https://w3id.org/ro/crate/1.1";
const PROCESS_RUN: &str = "https://w3id.org/ro/wfrun/process/0.5";
const PROCESS_RUN_TERMS: &str = "https://w3id.org/ro/terms/workflow-run/context";

/// Formats of files by their ending: media type, name of the format, page that defines it.
const FORMATS: [(&str, &str, &str, &str); 8] = [
    (".mcap", "application/octet-stream", "MCAP", "https://mcap.dev/spec"),
    (".toml", "application/toml", "TOML", "https://toml.io/en/v1.0.0"),
    (".lock", "application/toml", "TOML", "https://toml.io/en/v1.0.0"),
    (".json", "application/json", "JSON", "https://www.rfc-editor.org/rfc/rfc8259"),
    (".csv", "text/csv", "CSV", "https://www.rfc-editor.org/rfc/rfc4180"),
    (".html", "text/html", "HTML", "https://html.spec.whatwg.org/"),
    (
        ".parquet",
        "application/vnd.apache.parquet",
        "Apache Parquet",
        "https://parquet.apache.org/docs/file-format/",
    ),
    (".svg", "image/svg+xml", "SVG", "https://www.w3.org/TR/SVG11/"),
];

/// A person or an organization, with a page that identifies it.
#[derive(Clone, Debug)]
pub(super) struct Named {
    name: String,
    page: Option<String>,
}

impl Named {
    /// Reads "NAME" or "NAME <https://…>".
    pub(super) fn parse(text: &str) -> Result<Self, Failure> {
        let (name, page) = match text.split_once('<') {
            None => (text.trim(), None),
            Some((name, rest)) => (name.trim(), Some(rest.trim().strip_suffix('>').unwrap_or(""))),
        };
        let is_page = |page: &str| {
            page.starts_with("https://")
                && !page.contains(|letter: char| {
                    letter.is_whitespace() || letter.is_control() || "\"<>".contains(letter)
                })
        };
        if name.is_empty()
            || name.chars().any(char::is_control)
            || page.is_some_and(|page| !is_page(page))
        {
            let what = format!("\"{}\" is not a name", one_line(text));
            return Err(bad(what).help("write \"NAME\", or \"NAME <https://…>\" with the address of an ORCID record or a home page"));
        }
        Ok(Self { name: name.to_owned(), page: page.map(str::to_owned) })
    }

    /// The text that [`Named::parse`] reads.
    fn text(&self) -> String {
        match &self.page {
            None => self.name.clone(),
            Some(page) => format!("{} <{page}>", self.name),
        }
    }

    fn id(&self, number: usize) -> String {
        self.page.clone().unwrap_or_else(|| format!("#author-{number}"))
    }
}

/// Who is responsible for a bundle, and what others may do with it.
#[derive(Clone, Debug)]
pub(super) struct Description {
    pub(super) authors: Vec<Named>,
    pub(super) affiliation: Option<Named>,
    /// SPDX identifier.
    pub(super) license: String,
}

impl Description {
    /// The description that a bundle states.
    pub(super) fn of_bundle(bundle: &Json) -> Result<Self, Failure> {
        let authors = bundle["authors"].as_array().into_iter().flatten();
        let description = Self {
            authors: authors
                .map(|author| Named::parse(author.as_str().unwrap_or_default()))
                .collect::<Result<_, _>>()?,
            affiliation: bundle["affiliation"].as_str().map(Named::parse).transpose()?,
            license: bundle["license"].as_str().unwrap_or_default().to_owned(),
        };
        description.reject_incomplete()?;
        Ok(description)
    }

    /// Rejects a license that is none, and a description without authors.
    pub(super) fn reject_incomplete(&self) -> Result<(), Failure> {
        if spdx::license_id(&self.license).is_none() {
            let what =
                format!("the license \"{}\" is not an SPDX identifier", one_line(&self.license));
            return Err(bad(what)
                .help("name one of https://spdx.org/licenses, such as CC-BY-4.0 or CC0-1.0"));
        }
        match self.authors.is_empty() {
            true => Err(bad("no author is named").help("name one with --author")),
            false => Ok(()),
        }
    }

    /// The authors as texts.
    pub(super) fn authors_text(&self) -> Vec<String> {
        self.authors.iter().map(Named::text).collect()
    }

    /// The authors' organization as a text.
    pub(super) fn affiliation_text(&self) -> Option<String> {
        self.affiliation.as_ref().map(Named::text)
    }

    /// The descriptive files of a bundle with these files, whose last run was finished at this time.
    pub(super) fn files(
        &self,
        bundle: &Json,
        files: &BTreeMap<String, Content>,
        finished: &str,
    ) -> io::Result<Vec<(&'static str, String)>> {
        let date = finished.split('T').next().unwrap_or_default();
        let text = |key: &str| bundle[key].as_str().unwrap_or_default().to_owned();
        let title = match text("question") {
            question if question.is_empty() => format!("The experiment {}", text("experiment")),
            question => question,
        };
        let summary = match text("answer") {
            answer if answer.is_empty() => {
                format!("Particle experiment with the model {}.", text("model"))
            }
            answer => answer,
        };
        let words = Words { title, summary, date: date.to_owned(), finished: finished.to_owned() };
        Ok(vec![
            ("CITATION.cff", self.citation(&words)),
            (".zenodo.json", pretty(&self.zenodo(&words))),
            ("codemeta.json", pretty(&self.codemeta(bundle))),
            ("ro-crate-metadata.json", pretty(&self.research_object(bundle, &words, files)?)),
        ])
    }

    /// Citation File Format 1.2.0. JSON strings are YAML strings.
    fn citation(&self, words: &Words) -> String {
        let quoted = |text: &str| Json::from(text).to_string();
        let authors: String = self
            .authors
            .iter()
            .map(|author| format!("  - name: {}\n", quoted(&author.name)))
            .collect();
        format!(
            "cff-version: 1.2.0\nmessage: If you use these results, please cite them.\ntype: dataset\ntitle: {}\nabstract: {}\nauthors:\n{authors}license: {}\ndate-released: {}\n",
            quoted(&words.title),
            quoted(&words.summary),
            quoted(&self.license),
            quoted(&words.date),
        )
    }

    /// The metadata of a deposit, as Zenodo reads them.
    fn zenodo(&self, words: &Words) -> Json {
        let affiliation = self.affiliation.as_ref().map(|it| it.name.as_str());
        let creator = |author: &Named| {
            let orcid =
                author.page.as_deref().and_then(|page| page.strip_prefix("https://orcid.org/"));
            without_null(json!({ "name": author.name, "orcid": orcid, "affiliation": affiliation }))
        };
        json!({
            "title": words.title,
            "description": words.summary,
            "upload_type": "dataset",
            "license": self.license.to_lowercase(),
            "publication_date": words.date,
            "creators": self.authors.iter().map(creator).collect::<Vec<_>>(),
        })
    }

    /// The program that made the results, in CodeMeta 2.0.
    fn codemeta(&self, bundle: &Json) -> Json {
        let program = &bundle["program"];
        without_null(json!({
            "@context": "https://doi.org/10.5063/schema/codemeta-2.0",
            "@type": "SoftwareSourceCode",
            "name": program["name"],
            "version": program["version"],
            "codeRepository": program["repository"],
            "identifier": bundle["software_heritage"]["source"],
            "license": env!("CARGO_PKG_LICENSE").split(" OR ").map(license_page).collect::<Vec<_>>(),
            "programmingLanguage": "Rust",
        }))
    }

    /// A Process Run Crate: the program made the results from the manifest.
    fn research_object(
        &self,
        bundle: &Json,
        words: &Words,
        files: &BTreeMap<String, Content>,
    ) -> io::Result<Json> {
        let (program, license) = (&bundle["program"], license_page(&self.license));
        let manifest = bundle["manifest"].as_str().unwrap_or_default();
        let authors: Vec<Json> =
            self.authors.iter().enumerate().map(|(at, author)| reference(&author.id(at))).collect();
        let publisher = self
            .affiliation
            .as_ref()
            .map_or_else(|| authors[0].clone(), |it| reference(&it.id(authors.len())));
        let data = files
            .iter()
            .map(|(name, content)| data_entity(name, content))
            .collect::<io::Result<Vec<_>>>()?;
        let parts: Vec<Json> = files.keys().map(|name| reference(name)).collect();
        // The manifest and what it starts from are read; what the runs gave is in the folder of results, the lock file and the summary.
        let folder = format!("{RECORDINGS}/{}/", bundle["experiment"].as_str().unwrap_or_default());
        let is_result =
            |name: &String| name.starts_with(&folder) || [USUAL, BUNDLE].contains(&name.as_str());
        let of = |is_wanted: &dyn Fn(&String) -> bool| -> Vec<Json> {
            files.keys().filter(|name| is_wanted(name)).map(|name| reference(name)).collect()
        };
        let results = of(&is_result);
        let objects = of(&|name| !is_result(name) && name != PACKAGES);
        let mut graph = vec![
            json!({ "@id": "ro-crate-metadata.json", "@type": "CreativeWork", "conformsTo": reference(RO_CRATE), "about": reference("./") }),
            json!({
                "@id": "./", "@type": "Dataset", "name": words.title, "description": words.summary, "datePublished": words.date,
                "license": reference(&license), "author": one_or_all(&authors), "publisher": publisher,
                "conformsTo": reference(PROCESS_RUN), "hasPart": parts, "mentions": reference("#run"),
            }),
            json!({ "@id": PROCESS_RUN, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5" }),
            json!({ "@id": license, "@type": "CreativeWork", "name": self.license, "description": "License of the data" }),
            without_null(json!({
                "@id": program["repository"], "@type": "SoftwareApplication", "name": program["name"], "url": program["repository"],
                "softwareVersion": program["version"], "identifier": bundle["software_heritage"]["source"],
            })),
            json!({
                "@id": "#run", "@type": "CreateAction", "name": format!("Runs and analysis of {manifest}"),
                "description": "kinetoscope reproduce repeats the runs and compares every message",
                "endTime": words.finished, "agent": authors[0], "instrument": reference(program["repository"].as_str().unwrap_or_default()),
                "object": one_or_all(&objects), "result": results,
                "actionStatus": "http://schema.org/CompletedActionStatus",
            }),
        ];
        let affiliation = self.affiliation.as_ref().map(|it| reference(&it.id(authors.len())));
        graph.extend(self.authors.iter().enumerate().map(|(at, author)| {
            without_null(json!({ "@id": author.id(at), "@type": "Person", "name": author.name, "affiliation": affiliation }))
        }));
        graph.extend(self.affiliation.iter().map(|it| {
            without_null(json!({ "@id": it.id(authors.len()), "@type": "Organization", "name": it.name, "url": it.page }))
        }));
        let pages: BTreeMap<&str, &str> =
            FORMATS.iter().map(|(_, _, name, page)| (*page, *name)).collect();
        graph.extend(
            pages
                .iter()
                .map(|(page, name)| json!({ "@id": page, "@type": "WebSite", "name": name })),
        );
        graph.extend(data);
        Ok(
            json!({ "@context": [format!("{RO_CRATE}/context"), PROCESS_RUN_TERMS], "@graph": graph }),
        )
    }
}

/// What the descriptions say about the experiment.
struct Words {
    title: String,
    summary: String,
    date: String,
    finished: String,
}

fn data_entity(name: &str, content: &Content) -> io::Result<Json> {
    let bytes = match content {
        Content::Text(text) => text.len() as u64,
        Content::File(path) => fs::metadata(path)?.len(),
    };
    let format = FORMATS.iter().find(|(ending, ..)| name.ends_with(ending));
    let format = format.map(|(_, media, _, page)| json!([media, reference(page)]));
    let last = name.rsplit('/').next().unwrap_or(name);
    Ok(without_null(json!({
        "@id": name, "@type": "File", "name": last, "contentSize": bytes.to_string(), "encodingFormat": format,
    })))
}

fn reference(id: &str) -> Json {
    json!({ "@id": id })
}

/// Items as JSON-LD writes them: a single one without brackets.
fn one_or_all(items: &[Json]) -> Json {
    match items {
        [one] => one.clone(),
        all => all.into(),
    }
}

fn license_page(identifier: &str) -> String {
    format!("https://spdx.org/licenses/{identifier}")
}

fn pretty(value: &Json) -> String {
    format!("{value:#}\n")
}

/// An object without the keys that have no value.
fn without_null(mut object: Json) -> Json {
    if let Some(map) = object.as_object_mut() {
        map.retain(|_, value| !value.is_null());
    }
    object
}

#[cfg(test)]
mod tests {
    use super::Named;

    #[test]
    fn names_have_an_address_or_none() {
        let named = Named::parse("A. Author <https://orcid.org/0000-0002-1825-0097>").unwrap();
        assert_eq!(named.name, "A. Author");
        assert_eq!(named.page.as_deref(), Some("https://orcid.org/0000-0002-1825-0097"));
        assert_eq!(Named::parse("One").unwrap().page, None);
        for wrong in [
            "",
            "<https://x.example>",
            "A <x>",
            "A <https://x.example",
            "A <https://x .example>",
            "A\nB",
        ] {
            assert!(Named::parse(wrong).is_err(), "{wrong}");
        }
    }
}
