//! Guarantee: the engine of a page gives the messages and metrics of the program, calls a run equal only if all messages are, and names
//! the first frame that differs.
//!
//! Setup: one small run of each model, recorded in memory by the library, and its claim.
//! Tolerance: none.
//! Control: the claim of a run whose manifest has another seed or another value is not confirmed, and the first frame is named; every
//! changed byte of a claim is reported.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope::verify::fingerprint::fingerprint;
use kinetoscope::{Experiment, run};
use kinetoscope_browser::engine::{Answer, Engine, Status, version};
use kinetoscope_recording::claim::Claim;
use serde_json::Value;

/// One run of each model; the values are arbitrary.
const MANIFESTS: [&str; 4] = [
    "seed = 3\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 20\n",
    "seed = 4\n[model.dem]\ndiscs = 12\nwidth_m = 0.2\nheight_m = 0.4\nradius_m = 0.01\nduration_s = 0.2\n[record]\nframes = 20\n",
    "seed = 5\n[model.packing]\ndiscs = 20\nevents_per_disc = 50\n[record]\nframes = 20\n",
    "seed = 6\n[model.orbit]\nduration_days = 400.0\ntime_step_days = 1.0\n[record]\nframes = 20\n",
];

fn json(answer: &Answer) -> Value {
    serde_json::from_slice(&answer.bytes).unwrap()
}

fn claim(manifest: &str) -> Claim {
    let experiment: Experiment = manifest.parse().unwrap();
    Claim::of(&run(&experiment.runs[0]).unwrap()).unwrap().unwrap()
}

/// The end of the run in progress.
fn ended(engine: &mut Engine) -> Value {
    loop {
        let answer = engine.advance(100);
        assert_ne!(answer.status, Status::Failed, "{}", json(&answer));
        if answer.status == Status::Ended {
            return json(&answer);
        }
    }
}

fn verified(claim: &Claim) -> Value {
    let mut engine = Engine::default();
    let started = engine.verify(&claim.to_bytes().unwrap());
    assert_eq!(started.status, Status::AtFrame, "{}", json(&started));
    ended(&mut engine)
}

#[test]
fn engine_gives_the_messages_and_metrics_of_the_program() {
    for manifest in MANIFESTS {
        let experiment: Experiment = manifest.parse().unwrap();
        let recording = run(&experiment.runs[0]).unwrap();
        let mut engine = Engine::default();
        assert_eq!(engine.plan(manifest.as_bytes()).status, Status::Working);
        assert_eq!(engine.start(0).status, Status::AtFrame);
        assert!(!engine.columns().bytes.is_empty());
        let end = ended(&mut engine);
        assert_eq!(end["messages"], fingerprint(&recording).unwrap().messages, "{manifest}");
        let analysis = kinetoscope_analysis::analyze(&recording).unwrap();
        let results = json(&engine.metrics());
        let metrics = results["metrics"].as_array().unwrap();
        assert_eq!(metrics.len(), analysis.measurements.len());
        for (found, expected) in metrics.iter().zip(&analysis.measurements) {
            assert_eq!(found["name"], expected.name());
            let value = Some(expected.estimate.value).filter(|value| value.is_finite());
            assert_eq!(found["value"].as_f64().map(f64::to_bits), value.map(f64::to_bits));
        }
        assert!(engine.recording().bytes.starts_with(b"\x89MCAP"));
    }
}

/// The tangential spring of an absurd stiffness overflows, and the energies of the failed run are not numbers.
#[test]
fn numbers_that_are_not_finite_have_a_reason() {
    let manifest = "[model.dem]\ndiscs = 20\nfriction = 0.5\ntangential_to_normal_stiffness = 1e308\nduration_s = 0.2\n";
    let mut engine = Engine::default();
    assert_eq!(engine.plan(manifest.as_bytes()).status, Status::Working);
    assert_eq!(engine.start(0).status, Status::AtFrame);
    assert!(ended(&mut engine)["fault"].is_string());
    let results = json(&engine.metrics());
    let metrics = results["metrics"].as_array().unwrap();
    let missing = metrics.iter().filter(|metric| metric["value"].is_null());
    assert!(missing.clone().count() > 0);
    for metric in missing {
        assert!(metric["reason"].is_string(), "{metric}");
    }
}

#[test]
fn run_of_the_claimed_manifest_is_equal() {
    for manifest in MANIFESTS {
        let end = verified(&claim(manifest));
        assert_eq!(end["difference"], Value::Null, "{manifest}");
        assert_eq!(end["frames"], 21);
    }
}

/// A run with another seed differs from the start, also one of another duration.
#[test]
fn control_claim_of_another_run_is_not_confirmed() {
    for manifest in MANIFESTS {
        let first = &manifest[..9];
        let (own, other) = (claim(manifest), claim(&manifest.replacen(first, "seed = 77\n", 1)));
        let mixed = Claim { hashes: other.hashes, ..own };
        // The orbit has no random numbers.
        let is_random = !manifest.contains("orbit");
        assert_eq!(verified(&mixed)["difference"]["first"] == 0, is_random, "{manifest}");
    }
    let [gas, ..] = MANIFESTS;
    let (own, longer) = (claim(gas), claim(&gas.replace("0.02", "0.03")));
    let difference = verified(&Claim { hashes: longer.hashes, ..own })["difference"].clone();
    // The scale of the playback is in the log of the start.
    assert_eq!((&difference["first"], &difference["topics"][0]), (&0.into(), &"/log".into()));
}

#[test]
fn damaged_claims_are_never_equal() {
    let bytes = claim(MANIFESTS[0]).to_bytes().unwrap();
    for place in (0..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 4;
        let answer = Engine::default().verify(&damaged);
        assert_eq!(answer.status, Status::Failed);
        assert!(json(&answer)["error"].as_str().unwrap().contains("damaged"));
    }
}

#[test]
fn errors_are_answers_with_the_line() {
    let mut engine = Engine::default();
    let answer = engine.plan(b"[model.gas]\nparticels = 3\n");
    assert_eq!(answer.status, Status::Failed);
    let error = json(&answer)["error"].as_str().unwrap().to_owned();
    assert!(error.contains("particels") && error.contains("particles"), "{error}");
    assert_eq!(engine.plan(&vec![b' '; 300 << 10]).status, Status::Failed);
    assert_eq!(engine.start(0).status, Status::Failed);
    assert_eq!(engine.advance(1).status, Status::Failed);
    assert_eq!(engine.metrics().status, Status::Failed);
}

#[test]
fn versions_name_every_model() {
    let physics = &json(&version())["physics"];
    for model in ["dem", "gas", "orbit", "packing"] {
        assert!(physics[model].is_u64(), "{model}");
    }
}
