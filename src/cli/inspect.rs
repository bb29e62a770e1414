//! What the command line asks of recordings that are there: verify, compare, look at the attestation.

use crate::cli::exit::Exit;
use crate::executor::progress::{ProgressDisplay, Verbosity};
use crate::interrupt::Interrupt;
use crate::run::RunError;
use crate::verify::attestation::{
    Attestation, AttestationStatus, Verdict, attestation_path, attestation_status,
};
use crate::verify::compare::{CompareError, RecordingComparison, compare_recordings};
use crate::verify::diff::Comparison;
use crate::verify::{Finding, Verification, VerifyError, verify};
use clap::Args;
use kinetoscope_recording::reader::Outcome;
use std::path::{Path, PathBuf};

/// What is asked of recordings that are there.
#[derive(Debug, Args)]
#[group(
    id = "evidence",
    multiple = false,
    conflicts_with_all = ["manifest", "output", "jobs", "overrides", "force", "dry_run", "why", "time", "live"]
)]
pub struct Evidence {
    /// Do the run of a recording again and compare
    #[arg(long, value_name = "RECORDING")]
    verify: Option<PathBuf>,
    /// Compare two recordings: manifests, versions, messages
    #[arg(long, num_args = 2, value_names = ["RECORDING", "OTHER"])]
    compare: Option<Vec<PathBuf>>,
    /// Check that a recording is the one that --verify found good, without a re-run
    #[arg(long, value_name = "RECORDING")]
    attested: Option<PathBuf>,
}

/// What is said of recordings, and how the program ends.
#[derive(Debug)]
pub struct Report {
    /// What was found.
    pub text: String,
    /// What is wrong, to be said in any case.
    pub complaint: Option<String>,
    /// The exit code.
    pub exit: Exit,
}

impl Report {
    fn complaint(exit: Exit, complaint: impl ToString) -> Self {
        Self { text: String::new(), complaint: Some(complaint.to_string()), exit }
    }
}

impl Evidence {
    /// Does what was asked; `None` where nothing was.
    #[must_use]
    pub fn execute(&self, verbosity: Verbosity) -> Option<Report> {
        if let Some(path) = &self.verify {
            return Some(verified(path, verbosity));
        }
        if let Some([left, right]) = self.compare.as_deref() {
            return Some(match compare_recordings(left, right) {
                Ok(comparison) => compared(&comparison, left, right),
                Err(error @ CompareError::Read(_)) => Report::complaint(Exit::Unreadable, error),
                Err(error @ CompareError::Io(_)) => Report::complaint(Exit::Retryable, error),
            });
        }
        self.attested.as_deref().map(attested)
    }
}

fn verified(path: &Path, verbosity: Verbosity) -> Report {
    let interrupt = match Interrupt::listen() {
        Ok(interrupt) => interrupt,
        Err(error) => {
            let complaint = format!("cannot listen to Ctrl-C: {error}");
            return Report::complaint(Exit::Retryable, complaint);
        }
    };
    let progress = ProgressDisplay::new(1, verbosity);
    let bar = progress.start_run(&path.display().to_string());
    let result = verify(path, &interrupt, &|done, of| bar.frame(done, of));
    progress.close();
    match result {
        Ok(verification) => describe(&verification, path),
        Err(error) => {
            let exit = match &error {
                VerifyError::Read(_) | VerifyError::Manifest(_) | VerifyError::Start(_) => {
                    Exit::Unreadable
                }
                VerifyError::Run(RunError::Record(error)) if error.is_retryable() => {
                    Exit::Retryable
                }
                VerifyError::Run(_) => Exit::RunFailed,
                VerifyError::Temporary(_) => Exit::Retryable,
                VerifyError::Interrupted(code) => Exit::Signal(*code),
            };
            Report::complaint(exit, error)
        }
    }
}

fn describe(verification: &Verification, path: &Path) -> Report {
    let mut lines = notes(verification, path);
    let (verdict, mut report) = match &verification.finding {
        Finding::SameBytes { frames } => {
            lines.push(format!("{frames} frames done again: equal in every byte"));
            (
                Some(Verdict::Bytes),
                Report { text: String::new(), complaint: None, exit: Exit::Done },
            )
        }
        Finding::Messages(comparison) => {
            let report = judge(comparison, "the file", "the re-run");
            if comparison.difference.is_none() {
                let frames = comparison.equal_frames;
                lines.push(format!(
                    "{frames} frames done again: equal in every message, not in every byte"
                ));
            }
            let verdict = (report.exit == Exit::Done).then_some(Verdict::Messages);
            (verdict, report)
        }
    };
    let outcome = verification.recording.provenance().outcome.as_ref();
    match outcome {
        Some(Outcome::Fault(fault)) if verdict.is_some() => {
            lines.push(format!("Both end in the same fault: {fault}"));
        }
        Some(Outcome::Interrupted) if verdict.is_some() => {
            report.complaint =
                Some("The run was interrupted: what is missing can't be compared".to_owned());
            report.exit = Exit::Unreadable;
        }
        _ => {}
    }
    if !verification.key_fits {
        let complaint =
            "The run key in the file is not that of its manifest: one of them was changed";
        let rest = report.complaint.map(|rest| format!("\n{rest}")).unwrap_or_default();
        report.complaint = Some(format!("{complaint}{rest}"));
        report.exit = Exit::Differs;
    }
    if let (Some(verdict), Exit::Done) = (verdict, report.exit) {
        lines.push(attest(verification, verdict));
    }
    report.text = lines.join("\n");
    report
}

/// What is to be known of the file before the verdict.
fn notes(verification: &Verification, path: &Path) -> Vec<String> {
    let mut lines = vec![path.display().to_string()];
    let provenance = verification.recording.provenance();
    let (recorded, ours) = (&provenance.program_version, env!("CARGO_PKG_VERSION"));
    if recorded != ours {
        lines.push(format!("Recorded by version {recorded} of the program; this is {ours}"));
    }
    let (recorded, ours) = (provenance.physics_version, verification.physics_version);
    if recorded != ours {
        lines.push(format!(
            "Recorded with physics version {recorded} of {}; this is {ours}: other numbers are to be expected",
            provenance.model
        ));
    }
    for key in &verification.reinterpreted {
        lines.push(format!("This version reads the manifest otherwise: {key}"));
    }
    lines
}

fn attest(verification: &Verification, verdict: Verdict) -> String {
    let recording = &verification.recording;
    let written = Attestation::of(recording, verification.physics_version, verdict)
        .and_then(|attestation| attestation.write(recording.path()));
    match written {
        Ok(path) => format!("Attested in {}", path.display()),
        Err(error) => format!(
            "No attestation could be written to {}: {error}",
            attestation_path(recording.path()).display()
        ),
    }
}

/// The verdict on messages: a difference weighs more than an unreadable rest.
fn judge(comparison: &Comparison, left: &str, right: &str) -> Report {
    if let Some(difference) = &comparison.difference {
        let complaint = format!("First difference: {}", difference.describe(left, right));
        return Report::complaint(Exit::Differs, complaint);
    }
    if let Some(error) = &comparison.unreadable {
        return Report::complaint(Exit::Unreadable, error);
    }
    Report { text: String::new(), complaint: None, exit: Exit::Done }
}

fn compared(comparison: &RecordingComparison, left: &Path, right: &Path) -> Report {
    let (left, right) = (left.display().to_string(), right.display().to_string());
    let mut lines = vec![format!("{left} → {right}")];
    if comparison.keys.is_empty() {
        lines.push("Equal manifests".to_owned());
    } else {
        lines.push("The manifests differ:".to_owned());
        lines.extend(comparison.keys.iter().map(|key| format!("  {key}")));
    }
    for (what, [one, other]) in &comparison.versions {
        lines.push(format!("{what}: {one} → {other}"));
    }
    let mut report = judge(&comparison.messages, &left, &right);
    let frames = comparison.messages.equal_frames;
    if comparison.same_bytes {
        lines.push(format!("{frames} frames: equal in every byte"));
    } else if comparison.messages.difference.is_none() {
        lines.push(format!("{frames} frames: equal in every message, not in every byte"));
    }
    report.text = lines.join("\n");
    report
}

fn attested(path: &Path) -> Report {
    let shown = path.display();
    match attestation_status(path) {
        Ok(AttestationStatus::Attested(attestation)) => {
            let equal = match attestation.verdict {
                Verdict::Bytes => "byte",
                Verdict::Messages => "message",
            };
            let text = format!(
                "{shown} is the file whose run version {} did again ({} {}), equal in every {equal}",
                attestation.verified_by_program_version,
                attestation.operating_system,
                attestation.architecture
            );
            Report { text, complaint: None, exit: Exit::Done }
        }
        Ok(AttestationStatus::Changed(what)) => Report::complaint(
            Exit::Differs,
            format!("{shown} has changed since it was verified: another {what}"),
        ),
        Ok(AttestationStatus::Unattested(why)) => Report::complaint(
            Exit::Unreadable,
            format!(
                "{shown} has no attestation ({why}). Write one: run-experiment --verify {shown}"
            ),
        ),
        Err(error) => Report::complaint(Exit::Unreadable, format!("{shown}: {error}")),
    }
}
