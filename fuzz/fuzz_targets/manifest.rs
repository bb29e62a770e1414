//! Guarantee: any text as a manifest gives an experiment or errors that can be formatted. The canonical text of a run parses to the same
//! run.

#![no_main]

use kinetoscope_manifest::{Diagnostics, ExperimentRecord, parse, parse_checks, parse_run};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match parse(text, "fuzz.toml", &[]) {
        Ok(experiment) => {
            for run in [experiment.runs.first(), experiment.runs.last()].into_iter().flatten() {
                let canonical = run.manifest.canonical();
                let again =
                    parse_run(&canonical).unwrap_or_else(|errors| panic!("{errors}\n{canonical}"));
                assert_eq!(again.canonical(), canonical);
            }
        }
        Err(errors) => show(&errors),
    }
    for errors in [
        parse_run(text).err(),
        parse_checks(text, "fuzz.toml", None).err(),
        ExperimentRecord::from_toml(text, "fuzz.toml").err(),
    ] {
        errors.iter().for_each(show);
    }
});

fn show(errors: &Diagnostics) {
    assert!(
        !errors.is_empty() && !errors.to_string().is_empty() && !errors.render(true).is_empty()
    );
}
