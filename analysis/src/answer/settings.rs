//! What a manifest sets, in the words of an answer to a question that asks for it.

use super::question::words_of;
use super::{AnswerPart, AnswerSource};
use crate::number_text::short_number;
use crate::sweep::figures::capitalized;
use kinetoscope_manifest::model::{
    DemConfig, Dissipation, GasConfig, ModelConfig, OrbitConfig, OrbitIntegrator, StepLength,
    TimeStep,
};

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
struct Setting {
    /// What it is.
    name: &'static str,
    /// The beginnings of the words by which a question asks for it.
    asked: &'static [&'static str],
    /// The value, such as "a friction of 0.5".
    value: String,
}

const RESTITUTION: &[&str] = &["restit", "bounc", "rebound", "elastic", "inelastic", "cool"];
const FRICTION: &[&str] = &["frict", "slid", "rough"];
const STEP: &[&str] = &["step", "exact", "accura", "error", "euler", "verlet", "leapfrog"];
const METHOD: &[&str] = &[
    "method",
    "integrator",
    "integration",
    "exact",
    "accura",
    "error",
    "order",
    "scheme",
    "euler",
    "verlet",
    "leapfrog",
    "runge",
    "rk4",
];

/// The name of the method.
const METHOD_NAME: &str = "method";

/// The sentences, of which the first one begins with the settings that the question asks for, if all runs have the same.
pub(super) fn with_settings(
    mut sentences: Vec<Vec<AnswerPart>>,
    source: &AnswerSource<'_>,
) -> Vec<Vec<AnswerPart>> {
    let question = source.record.map_or("", |record| &record.question).to_lowercase();
    if let Some(AnswerPart::Text(first)) = sentences.first_mut().and_then(|parts| parts.first_mut())
    {
        *first = prefixed(first, &asked_settings(&question, source));
    }
    sentences
}

/// The settings for which a question asks and that all runs have.
fn asked_settings(question: &str, source: &AnswerSource<'_>) -> Vec<Setting> {
    let mut runs = source.runs.iter().map(|run| settings_of(run.model()));
    let mut settings = runs.next().unwrap_or_default();
    for others in runs {
        settings.retain(|setting| others.contains(setting));
    }
    settings.retain(|setting| {
        let is_asked = |word: &str| setting.asked.iter().any(|asked| word.starts_with(asked));
        words_of(question).any(is_asked)
    });
    settings
}

/// A sentence that begins with settings; one about the method has its name as the subject.
fn prefixed(sentence: &str, settings: &[Setting]) -> String {
    let method = settings.iter().find(|setting| setting.name == METHOD_NAME);
    if let Some((verb, method)) = sentence.strip_prefix("The method ").zip(method) {
        return format!("{} {verb}", capitalized(&method.value));
    }
    let values: Vec<&str> = settings.iter().map(|setting| setting.value.as_str()).collect();
    let mut letters = sentence.chars();
    match letters.next().filter(|_| !values.is_empty()) {
        Some(first) => {
            format!("With {}, {}{}", values.join(" and "), first.to_lowercase(), letters.as_str())
        }
        None => sentence.to_owned(),
    }
}

fn settings_of(config: &ModelConfig) -> Vec<Setting> {
    let restitution = |value: f64| Setting {
        name: "restitution",
        asked: RESTITUTION,
        value: format!("a restitution of {}", short_number(value)),
    };
    if let ModelConfig::Gas(config) = config {
        return settings_of_gas(config);
    }
    match config {
        ModelConfig::Dem(config) => settings_of_dem(config, restitution),
        ModelConfig::Packing(config) => vec![restitution(config.restitution.get())],
        ModelConfig::Orbit(config) => settings_of_orbit(config),
        _ => Vec::new(),
    }
}

/// The size of a gas, without which its pressure means nothing.
fn settings_of_gas(config: &GasConfig) -> Vec<Setting> {
    let (particles, radius) = (config.particles, short_number(config.radius_m.get()));
    let value = format!("{particles} particles in a circle of {radius} m radius");
    vec![Setting { name: "gas", asked: &["press"], value }]
}

/// Contacts of materials have constants of their own, which are not stated.
fn settings_of_dem(config: &DemConfig, restitution: impl Fn(f64) -> Setting) -> Vec<Setting> {
    let step = match config.time_step {
        TimeStep::PerContact(steps) => {
            Some(format!("{} steps per contact with a wall", short_number(steps.get())))
        }
        TimeStep::Length(StepLength::Fixed(step)) => {
            Some(format!("steps of {} s", short_number(step.get())))
        }
        TimeStep::Length(StepLength::Automatic) => None,
    };
    let step = step.map(|value| Setting { name: "time step", asked: STEP, value });
    let mut settings = Vec::new();
    if config.materials.is_empty() && config.contact_pairs.is_empty() {
        let value = format!("a friction of {}", short_number(config.friction.get()));
        settings.push(Setting { name: "friction", asked: FRICTION, value });
        if let Dissipation::Restitution(value) = config.dissipation {
            settings.push(restitution(value.get()));
        }
    }
    settings.extend(step);
    settings
}

/// The exact solution has no step, and Dormand and Prince's method chooses its own.
fn settings_of_orbit(config: &OrbitConfig) -> Vec<Setting> {
    let (method, has_steps) = match config.integrator {
        OrbitIntegrator::ExplicitEuler => ("explicit Euler", true),
        OrbitIntegrator::SemiImplicitEuler => ("semi-implicit Euler", true),
        OrbitIntegrator::VelocityVerlet => ("velocity Verlet", true),
        OrbitIntegrator::Rk4 => ("RK4", true),
        OrbitIntegrator::Yoshida4 => ("Yoshida's method of order 4", true),
        OrbitIntegrator::Dop853 => ("Dormand and Prince's method of order 8", false),
        _ => return Vec::new(),
    };
    let days = config.time_step_days.get();
    let unit = if days == 1.0 { "day" } else { "days" };
    let step = format!("steps of {} {unit}", short_number(days));
    let method = Setting { name: METHOD_NAME, asked: METHOD, value: method.to_owned() };
    let step = has_steps.then_some(Setting { name: "time step", asked: STEP, value: step });
    [method].into_iter().chain(step).collect()
}

#[cfg(test)]
mod tests {
    use super::{prefixed, settings_of};
    use kinetoscope_manifest::parse;

    fn sentence(model: &str, keys: &str, name: &str) -> String {
        let manifest = format!("[model.{model}]\n{keys}\n");
        let config = parse(&manifest, "test", &[]).unwrap().runs[0].manifest.model.clone();
        let mut settings = settings_of(&config);
        settings.retain(|setting| setting.name == name);
        prefixed("The error is 1.", &settings)
    }

    /// Guarantee: an answer names the restitution, the step and the method that its question asks for. Controls: the exact solution has
    /// neither, contacts of materials have no common friction, and a sentence without settings stays as it is.
    #[test]
    fn settings_that_are_asked_for_begin_the_answer() {
        let with = |words: &str| format!("With {words}, the error is 1.");
        let unchanged = "The error is 1.";
        let euler = "integrator = \"explicit-euler\"";
        assert_eq!(sentence("orbit", euler, "method"), with("explicit Euler"));
        assert_eq!(sentence("orbit", "", "time step"), with("steps of 0.25 days"));
        assert_eq!(sentence("orbit", "integrator = \"kepler\"", "method"), unchanged);
        assert_eq!(sentence("orbit", "integrator = \"dop853\"", "time step"), unchanged);
        let restitution = "restitution = 0.9";
        for model in ["dem", "packing"] {
            let found = sentence(model, restitution, "restitution");
            assert_eq!(found, with("a restitution of 0.9"));
        }
        let damping = "damping_n_s_per_m = 0.1";
        assert_eq!(sentence("dem", damping, "restitution"), unchanged);
        assert_eq!(sentence("dem", "friction = 0.5", "friction"), with("a friction of 0.5"));
        let materials = "materials = [{ name = \"glass\", friction = 0.1 }]";
        assert_eq!(sentence("dem", materials, "friction"), unchanged);
        assert_eq!(sentence("gas", "", "time step"), unchanged);
        let gas = with("1000 particles in a circle of 1 m radius");
        assert_eq!(sentence("gas", "", "gas"), gas);
    }
}
