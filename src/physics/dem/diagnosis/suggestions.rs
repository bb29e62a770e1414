//! Suggestions for a rejected start: for each key of the manifest, the nearest value that is accepted.
//!
//! A value is found by diagnosing the changed manifest, with the value as it will be printed. Therefore, every suggestion is
//! accepted as it is printed.

use crate::dem::diagnosis::Diagnosis;
use crate::dem::parameters::Parameters;
use crate::dem::restitution;
use kinetoscope_manifest::model::{
    DemConfig, DiscRadius, Dissipation, Elasticity, Placement, StepLength, TimeStep,
};
use kinetoscope_manifest::quantity::{Fraction, NonNegative, Positive};
use std::f64::consts::PI;

/// Writes a value into a manifest; `None` if it is out of range.
type Change = fn(&mut DemConfig, f64) -> Option<()>;

/// One key that may be changed: its name, the value in use or at which the search begins, and the change.
type Key = (&'static str, f64, Change);

/// Doublings and halvings that are tried.
const DOUBLINGS: u32 = 100;
/// Packing fraction above which larger discs may not fit.
const ROOMY_PACKING_FRACTION: f64 = 0.4;

/// The nearest accepted values, as lines of a manifest; each one is sufficient.
pub(crate) fn find(config: &DemConfig) -> Vec<String> {
    keys(config).into_iter().filter_map(|key| nearest_accepted(config, key)).collect()
}

fn keys(config: &DemConfig) -> Vec<Key> {
    let parameters = Parameters::new(config);
    let ratio = parameters.strongest_damping_ratio(parameters.lightest_pair_mass());
    let present = restitution::restitution(ratio, config.limit_damping);
    // An overdamped dashpot has no restitution at which the search could begin.
    let restitution = if present > 1e-3 { present } else { 1e-3 };
    let contact_time = parameters.law.contact_time(parameters.smallest_mass);
    let steps_per_wall_contact = contact_time / parameters.time_step;
    let (Elasticity::Spring(stiffness) | Elasticity::Hertz(stiffness)) = config.elasticity;
    let mut keys: Vec<Key> = vec![
        ("time_step_s", parameters.time_step, |config, value| {
            config.time_step = TimeStep::Length(StepLength::Fixed(Positive::new(value)?));
            Some(())
        }),
        ("steps_per_wall_contact", steps_per_wall_contact, |config, value| {
            config.time_step = TimeStep::PerContact(Positive::new(value)?);
            Some(())
        }),
        ("damping_n_s_per_m", parameters.strongest_damping(), |config, value| {
            // That of Hertz's law cannot be given, nor one next to restitutions of materials.
            let Elasticity::Spring(_) = config.elasticity else { return None };
            if config.has_own_restitution() {
                return None;
            }
            config.dissipation = Dissipation::Damping(NonNegative::new(value)?);
            Some(())
        }),
        ("restitution", restitution, |config, value| {
            config.dissipation = Dissipation::Restitution(Fraction::new(value)?);
            Some(())
        }),
        (parameters.law.normal.key(), stiffness.get(), |config, value| {
            let value = Positive::new(value)?;
            config.elasticity = match config.elasticity {
                Elasticity::Spring(_) => Elasticity::Spring(value),
                Elasticity::Hertz(_) => Elasticity::Hertz(value),
            };
            Some(())
        }),
        ("radius_m", parameters.radius, set_radius),
    ];
    if config.cohesion_n.get() > 0.0 {
        keys.push(("cohesion_n", config.cohesion_n.get(), |config, value| {
            config.cohesion_n = NonNegative::new(value)?;
            Some(())
        }));
    }
    keys
}

/// Equal discs of another radius, if they leave enough room for a new placement.
fn set_radius(config: &mut DemConfig, radius: f64) -> Option<()> {
    let (smallest, largest) = config.radius_m.range();
    let box_area = config.width_m.get() * config.height_m.get();
    let covered = f64::from(config.discs.get()) * PI * radius * radius;
    let is_given = matches!(config.placement, Placement::Given(_) | Placement::Recorded(_));
    if smallest < largest || is_given || covered > ROOMY_PACKING_FRACTION * box_area {
        return None;
    }
    config.radius_m = DiscRadius::Equal(Positive::new(radius)?);
    Some(())
}

/// Searches from the present value in both directions until a value is accepted, then bisects to the limit.
fn nearest_accepted(config: &DemConfig, (name, current, change): Key) -> Option<String> {
    let is_accepted = |value: f64| {
        let mut changed = config.clone();
        change(&mut changed, value).is_some_and(|()| !Diagnosis::of(&changed).is_rejected())
    };
    if is_accepted(current) {
        return rounded(name, current, 1.0, is_accepted);
    }
    let mut factor = 1.0;
    for _ in 0..DOUBLINGS {
        for (inner, outer) in [(factor, 2.0 * factor), (1.0 / factor, 0.5 / factor)] {
            if is_accepted(current * outer) {
                let (mut rejected, mut accepted) = (current * inner, current * outer);
                for _ in 0..60 {
                    let middle = (rejected * accepted).sqrt();
                    if is_accepted(middle) {
                        accepted = middle;
                    } else {
                        rejected = middle;
                    }
                }
                return rounded(name, accepted, outer, is_accepted);
            }
        }
        factor *= 2.0;
    }
    None
}

/// The value with three digits, moved in the direction of `outward` until the printed value is accepted.
fn rounded(
    name: &str,
    value: f64,
    outward: f64,
    is_accepted: impl Fn(f64) -> bool,
) -> Option<String> {
    (0..10).find_map(|nudge| {
        let factor = 1.0 + 0.005 * f64::from(nudge);
        let nudged = if outward >= 1.0 { value * factor } else { value / factor };
        let printed: f64 = format!("{nudged:.2e}").parse().ok()?;
        let plain = (1e-3..1e5).contains(&printed);
        let text = if plain { format!("{printed}") } else { format!("{printed:e}") };
        is_accepted(printed).then(|| format!("{name} = {text}"))
    })
}
