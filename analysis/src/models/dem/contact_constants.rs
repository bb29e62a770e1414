//! Constants of the contacts that a manifest describes: pairs of materials, effective masses and the time step.

use super::elasticity::Elastic;
use kinetoscope_manifest::model::{
    DISC, DemConfig, DemContactPair, DemMaterial, Dissipation, StepLength, TimeStep, WALL,
};
use kinetoscope_manifest::quantity::Fraction;
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
pub(super) fn given_pair<'a>(
    config: &'a DemConfig,
    names: [&str; 2],
) -> Option<&'a DemContactPair> {
    config.contact_pairs.iter().find(|pair| {
        let [one, other] = [&*pair.between[0], &*pair.between[1]];
        [one, other] == names || [other, one] == names
    })
}

/// The given restitution of a pair of materials: its own, or by the mixing rule e^2 = (e_1^2 + e_2^2)/2. `None` if the manifest gives
/// a damping.
fn restitution_between(config: &DemConfig, one: Material<'_>, other: Material<'_>) -> Option<f64> {
    let Dissipation::Restitution(common) = config.dissipation else { return None };
    let of = |(_, material): Material<'_>| {
        material.and_then(|material| material.constants.restitution).unwrap_or(common).get()
    };
    let (e, e_other) = (of(one), of(other));
    let mixed = if e == e_other { e } else { ((e * e + e_other * e_other) / 2.0).sqrt() };
    let pair = given_pair(config, [one.0, other.0]);
    Some(pair.and_then(|pair| pair.constants.restitution).map_or(mixed, Fraction::get))
}

/// The only value of several; `None` if there are two different ones, or none.
fn only(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|value| value == first).then_some(first)
}

/// The given restitution of contacts with the walls; `None` for a damping, and if it depends on the material.
pub(super) fn restitution_with_walls(config: &DemConfig) -> Option<f64> {
    let discs = disc_materials(config).into_iter();
    let values: Option<Vec<f64>> =
        discs.map(|disc| restitution_between(config, disc, (WALL, None))).collect();
    only(values?.into_iter())
}

/// The given restitution of contacts between discs; `None` for a damping, and if it depends on the materials.
pub(super) fn restitution_of_discs(config: &DemConfig) -> Option<f64> {
    let discs = disc_materials(config);
    let pairs = discs.iter().flat_map(|&one| discs.iter().map(move |&other| (one, other)));
    let values: Option<Vec<f64>> =
        pairs.map(|(one, other)| restitution_between(config, one, other)).collect();
    only(values?.into_iter())
}

/// Mass of equal discs, kg; `None` if radii or densities differ.
pub(super) fn disc_mass_kg(config: &DemConfig) -> Option<f64> {
    let (smallest, largest) = config.radius_m.range();
    let ratio = only(density_ratios(config))?;
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
            let stiffness = Elastic::of(config).spring_n_per_m()?;
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
    }
}
