//! Constants of the contacts that a manifest describes: pairs of materials, effective masses and the time step.

use kinetoscope_manifest::model::{
    DISC, DemConfig, DemContactConstants, DemMaterial, Dissipation, Elasticity, StepLength,
    TimeStep, WALL,
};
use kinetoscope_manifest::quantity::{Fraction, NonNegative, Positive};
use std::f64::consts::PI;

/// A material and its name; the walls, and discs where no materials are listed, have the constants of all.
type Material<'a> = (&'a str, Option<&'a DemMaterial>);

/// The materials that a disc can have.
fn disc_materials(config: &DemConfig) -> Vec<Material<'_>> {
    if config.materials.is_empty() {
        return vec![(DISC, None)];
    }
    config.materials.iter().map(|material| (&*material.name, Some(material))).collect()
}

/// The constants that a manifest gives for a pair of materials.
pub(super) fn given_pair(config: &DemConfig, names: [&str; 2]) -> DemContactConstants {
    let mut pairs = config.contact_pairs.iter();
    let pair = pairs.find(|pair| {
        let [one, other] = [&*pair.between[0], &*pair.between[1]];
        [one, other] == names || [other, one] == names
    });
    pair.map_or_else(DemContactConstants::default, |pair| pair.constants)
}

/// Constants of the contacts of two materials.
#[derive(Clone, Copy)]
pub(super) struct PairConstants {
    /// The given restitution; `None` if the manifest gives a damping.
    pub(super) restitution: Option<f64>,
    /// Stiffness over that of the manifest.
    pub(super) stiffness: f64,
    /// Cohesion, N.
    pub(super) cohesion_n: f64,
}

/// The given constants of a pair of materials, or those of the mixing rules: springs in series, e^2 = (e_1^2 k_2 + e_2^2 k_1)/(k_1 + k_2),
/// and the geometric mean of the cohesions.
fn between(config: &DemConfig, one: Material<'_>, other: Material<'_>) -> PairConstants {
    let given = given_pair(config, [one.0, other.0]);
    let own = [one, other].map(|(_, own)| own.map(|own| own.constants).unwrap_or_default());
    let unless_equal = |[one, other]: [f64; 2], mixed: f64| if one == other { one } else { mixed };
    let [k, k_other] = own.map(|own| own.stiffness_ratio.map_or(1.0, Positive::get));
    let forces = own.map(|own| own.cohesion_n.unwrap_or(config.cohesion_n).get());
    let restitution = |common: Fraction| {
        let [e, e_other] = own.map(|own| own.restitution.unwrap_or(common).get());
        let squared = match k == k_other {
            true => (e * e + e_other * e_other) / 2.0,
            false => (e * e * k_other + e_other * e_other * k) / (k + k_other),
        };
        given.restitution.map_or(unless_equal([e, e_other], squared.sqrt()), Fraction::get)
    };
    let stiffness = unless_equal([k, k_other], 2.0 / (1.0 / k + 1.0 / k_other));
    let cohesion = unless_equal(forces, forces[0].sqrt() * forces[1].sqrt());
    PairConstants {
        restitution: match config.dissipation {
            Dissipation::Restitution(common) => Some(restitution(common)),
            Dissipation::Damping(_) => None,
        },
        stiffness: given.stiffness_ratio.map_or(stiffness, Positive::get),
        cohesion_n: given.cohesion_n.map_or(cohesion, NonNegative::get),
    }
}

/// The only value of several; `None` if there are two different ones, or none.
fn only(mut values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let first = values.next()??;
    values.all(|value| value == Some(first)).then_some(first)
}

/// Constants of the contacts of the discs with others.
fn pairs_with(config: &DemConfig, others: &[Material<'_>]) -> Vec<PairConstants> {
    let discs = disc_materials(config);
    let pairs = discs.iter().flat_map(|&one| others.iter().map(move |&other| (one, other)));
    pairs.map(|(one, other)| between(config, one, other)).collect()
}

/// A constant of the contacts with the walls; `None` if it depends on the material.
pub(super) fn with_walls(
    config: &DemConfig,
    constant: fn(PairConstants) -> Option<f64>,
) -> Option<f64> {
    only(pairs_with(config, &[(WALL, None)]).into_iter().map(constant))
}

/// A constant of the contacts between discs; `None` if it depends on the materials.
pub(super) fn of_discs(
    config: &DemConfig,
    constant: fn(PairConstants) -> Option<f64>,
) -> Option<f64> {
    only(pairs_with(config, &disc_materials(config)).into_iter().map(constant))
}

/// The largest value of a constant of all contacts.
fn largest(config: &DemConfig, constant: fn(PairConstants) -> f64) -> f64 {
    let mut others = disc_materials(config);
    others.push((WALL, None));
    pairs_with(config, &others).into_iter().map(constant).fold(0.0, f64::max)
}

/// The largest stiffness of a contact over that of the manifest.
pub(super) fn max_stiffness(config: &DemConfig) -> f64 {
    largest(config, |pair| pair.stiffness)
}

/// Whether any surfaces in contact attract each other.
pub(super) fn is_cohesive(config: &DemConfig) -> bool {
    largest(config, |pair| pair.cohesion_n) > 0.0
}

/// Mass of equal discs, kg; `None` if radii or densities differ.
pub(super) fn disc_mass_kg(config: &DemConfig) -> Option<f64> {
    let (smallest, largest) = config.radius_m.range();
    let ratio = only(density_ratios(config).map(Some))?;
    (smallest == largest).then(|| config.mass_kg.get() * ratio)
}

fn density_ratios(config: &DemConfig) -> impl Iterator<Item = f64> {
    disc_materials(config)
        .into_iter()
        .map(|(_, material)| material.map_or(1.0, |material| material.density_ratio.get()))
}

/// The time step, s; `None` for the automatic one and for that of Hertz's law, which resolve every contact.
pub(super) fn time_step_s(config: &DemConfig) -> Option<f64> {
    let ratio = config.radius_m.range().0 / config.radius_m.mean();
    let density = density_ratios(config).fold(f64::INFINITY, f64::min);
    let smallest_mass = config.mass_kg.get() * density * ratio * ratio;
    match config.time_step {
        TimeStep::PerContact(steps) => {
            let Elasticity::Spring(stiffness) = config.elasticity else { return None };
            let stiffness = max_stiffness(config) * stiffness.get();
            Some(PI * (smallest_mass / stiffness).sqrt() / steps.get())
        }
        TimeStep::Length(StepLength::Fixed(step)) => Some(step.get()),
        TimeStep::Length(StepLength::Automatic) => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

    use super::*;
    use kinetoscope_manifest::model::ModelConfig;
    use kinetoscope_manifest::parse;

    fn config(keys: &str) -> DemConfig {
        let text = format!("name = \"x\"\n[model.dem]\nrestitution = 0.9\n{keys}");
        let experiment = parse(&text, "x.toml", &[]).unwrap();
        match &*experiment.runs[0].manifest.model {
            ModelConfig::Dem(config) => config.clone(),
            _ => panic!("expected DEM"),
        }
    }

    fn restitution_with_walls(config: &DemConfig) -> Option<f64> {
        with_walls(config, |pair| pair.restitution)
    }

    fn restitution_of_discs(config: &DemConfig) -> Option<f64> {
        of_discs(config, |pair| pair.restitution)
    }

    /// Guarantee: the restitution of a contact is the pair's own, or that of the mixing rule; `None` if it depends on the drawn
    /// material.
    #[test]
    fn restitution_is_that_of_the_pair() {
        let plain = config("");
        assert_eq!([restitution_with_walls(&plain), restitution_of_discs(&plain)], [Some(0.9); 2]);
        let walls =
            config("contact_pairs = [{ between = [\"disc\", \"wall\"], restitution = 0.4 }]");
        assert_eq!(restitution_with_walls(&walls), Some(0.4));
        assert_eq!(restitution_of_discs(&walls), Some(0.9));
        let glass =
            config("materials = [{ name = \"glass\", restitution = 0.5, density_ratio = 2.0 }]");
        assert_eq!(restitution_with_walls(&glass), Some(((0.25 + 0.81) / 2.0_f64).sqrt()));
        assert_eq!(restitution_of_discs(&glass), Some(0.5));
        assert_eq!(disc_mass_kg(&glass), Some(2e-3));
        let two = config("materials = [{ name = \"a\", restitution = 0.5 }, { name = \"b\" }]");
        assert_eq!([restitution_with_walls(&two), restitution_of_discs(&two)], [None; 2]);
        assert_eq!(disc_mass_kg(&two), Some(1e-3));
        let stiff = config(
            "materials = [{ name = \"a\", restitution = 0.5, stiffness_ratio = 4.0, cohesion_n = 0.01 }]",
        );
        let restitution = ((0.25 + 4.0 * 0.81) / 5.0_f64).sqrt();
        assert!((restitution_with_walls(&stiff).unwrap() - restitution).abs() < 1e-15);
        assert_eq!(with_walls(&stiff, |pair| Some(pair.stiffness)), Some(1.6));
        assert_eq!(of_discs(&stiff, |pair| Some(pair.stiffness)), Some(4.0));
        assert_eq!(with_walls(&stiff, |pair| Some(pair.cohesion_n)), Some(0.0));
        let step = |config: &DemConfig| time_step_s(config).unwrap();
        assert!((step(&plain) / step(&stiff) - 2.0).abs() < 1e-15);
    }
}
