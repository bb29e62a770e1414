//! Keys and values that 0.1 renamed, so that the error for an old name gives the new one. Kept for 0.1 only.

use crate::diagnostics::Diagnostic;
use crate::tree::Span;

/// Old names: the path of the table that had the key (or of the key that had the value), the old name, and what to write
/// instead, as in a manifest: `insertion`, `"dop853"`, or `dashpot = "implicit"`.
type Renames = &'static [(&'static str, &'static str, &'static str)];

/// Old keys, by the path of their table: `model.dem`, `model.dem.materials`, `record`, `checks`, or "" for the first keys.
#[cfg(not(test))]
const KEYS: Renames = &[
    ("model.dem", "steps_per_contact", "steps_per_wall_contact"),
    ("model.dem", "rain", "insertion"),
    ("model.dem", "tangential_stiffness_share", "tangential_to_normal_stiffness"),
    ("model.dem", "tangential_damping_share", "tangential_to_normal_damping"),
    (
        "model.dem",
        "force_tail",
        "limit_damping = true` in place of \"clamped\", and in place of \"attractive\" `limit_damping = false",
    ),
    ("model.dem", "velocity_deviation_m_per_s", "velocity_std_m_per_s"),
    ("model.dem", "outlet_below_m", "remove_below_m"),
    ("model.dem", "region_m", "placement_region_m"),
    ("model.dem", "stability", "on_unstable_time_step"),
    ("model.dem.materials", "share", "fraction"),
    ("model.dem.radius_m", "deviation", "std"),
    ("model.dem.radius_m", "small_share", "small_fraction"),
    ("model.gas", "opening_width_m", "orifice_width_m"),
    ("model.gas", "wall_accommodation", "accommodation_coefficient"),
    ("model.gas", "place_distribution", "position_distribution"),
    ("model.gas", "further_masses_kg", "additional_masses_kg"),
    ("model.gas", "centre_m", "center_m"),
    ("model.packing", "polydispersity", "radius_half_width"),
    ("model.packing", "compression_pressure", "target_reduced_pressure"),
    ("runs", "content_key", "run_key"),
    ("record", "drawn_particles", "max_drawn_particles"),
    ("record", "playback_rate", "playback_fps"),
];

/// Old words, by the path of their key, such as `model.orbit.integrator`.
#[cfg(not(test))]
const VALUES: Renames = &[
    ("model.dem.on_unstable_time_step", "refuse", "\"error\""),
    ("model.dem.integrator", "implicit-dashpot", "dashpot = \"implicit\""),
    ("model.gas.position_distribution", "area", "\"uniform-in-area\""),
    ("model.gas.position_distribution", "radius", "\"uniform-in-radius\""),
    ("model.gas.propagation", "literal", "\"as-printed\""),
    ("model.gas.propagation", "stepped", "\"time-stepped\""),
    ("model.packing.initial_velocities", "unmodified", "\"unit-variance\""),
    ("model.packing.initial_velocities", "modified", "\"variance-1-over-n\""),
    ("model.orbit.start", "document", "\"barycentric\""),
    ("model.orbit.integrator", "dormand-prince8", "\"dop853\""),
];

#[cfg(test)]
const KEYS: Renames = &[
    ("", "random_seed", "seed"),
    ("model.dem", "tail", "limit_damping = true"),
    ("model.dem.materials", "label", "name"),
    ("model.gas", "container_m", "radius_m"),
    ("model.gas", "motion", "propagation"),
    ("record", "images", "frames"),
];

#[cfg(test)]
const VALUES: Renames = &[
    ("model.gas.propagation", "closed-form", "\"exact\""),
    ("model.gas.placement", "anywhere", "\"random\""),
];

/// Old channels of `record.channels` and old metrics of `[[checks]]`.
const NAMES: Renames = &[
    ("channels", "contacts", "force_chains"),
    ("channels", "ledger", "energy_balance"),
    ("channels", "contact_count", "contact_statistics"),
    ("channels", "energy_share", "energy_percent"),
    ("metric", "hit_rate", "wall_collision_rate"),
    ("metric", "wall_rate", "wall_collision_rate_per_disc"),
    ("metric", "pair_collision_rate", "pair_collision_rate_per_disc"),
    ("metric", "collision_rate", "pair_collision_rate_per_disc"),
    ("metric", "contact_value.by_rate", "contact_value.from_collision_rate"),
    ("metric", "compressibility_factor.by_rate", "compressibility_factor.from_collision_rate"),
    ("metric", "share_inside_half_radius", "fraction_within_half_radius"),
    ("metric", "share_inside_half_radius.start", "fraction_within_half_radius.start"),
    ("metric", "speed_histogram.distance_from_maxwell", "speed_histogram.total_variation_distance"),
    ("metric", "eccentricity_vector.turn", "apsidal_rotation"),
    ("metric", "outlet.rate", "outlet.discharge_rate"),
    ("metric", "outlet.free_width", "outlet.effective_width"),
    (
        "metric",
        "outlet.rate_vs_free_width.exponent",
        "outlet.discharge_rate_vs_effective_width.exponent",
    ),
    ("metric", "silo.screening_weight", "silo.saturation_weight"),
    ("metric", "silo.janssen_misfit", "silo.janssen_rms_deviation"),
    ("metric", "stress.horizontal_over_vertical", "stress.lateral_ratio"),
    ("metric", "stress.distance_from_weight", "stress.overburden_deviation"),
    ("metric", "row.transmitted_velocity", "row.velocity_transmission"),
    ("metric", "bed.slope", "bed.surface_angle"),
    ("metric", "bed.reach", "bed.deposit_length"),
    ("metric", "bed.run_out", "bed.normalized_runout"),
    ("metric", "run_out_vs_discs.exponent", "normalized_runout_vs_discs.exponent"),
    ("metric", "speed_kurtosis", "a2"),
    ("metric", "excess_h", "relative_entropy"),
    ("metric", "excess_h.start", "relative_entropy.start"),
    ("metric", "temperature.kinetic_final", "temperature.final"),
    ("metric", "temperature.thermalised", "temperature.thermalized"),
    ("metric", "largest_overlap_over_radius", "max_overlap_over_radius"),
    ("metric", "largest_speed_change_relative", "max_speed_change_relative"),
    ("metric", "largest_angular_momentum_change_relative", "max_angular_momentum_change_relative"),
    ("metric", "energy.largest_residual_relative", "energy.max_residual_relative"),
    ("metric", "energy.largest_error_relative", "energy.max_error_relative"),
    ("metric", "angular_momentum.largest_change_relative", "angular_momentum.max_change_relative"),
];

fn find(names: Renames, path: &str, old: &str) -> Option<&'static str> {
    // An element of a list has its index in brackets.
    let is_at = |at: &str| match path.strip_prefix(at) {
        Some(index) => index.is_empty() || index.starts_with('[') && index.ends_with(']'),
        None => false,
    };
    let entry = names.iter().find(|(at, name, _)| is_at(at) && *name == old);
    entry.map(|(_, _, new)| *new)
}

/// The new name of an old key of a table.
pub(crate) fn key(table: &str, old: &str) -> Option<&'static str> {
    find(KEYS, table, old)
}

/// The new name of an old channel.
pub(crate) fn channel(old: &str) -> Option<&'static str> {
    find(NAMES, "channels", old)
}

/// The new name of an old metric.
pub(crate) fn metric(old: &str) -> Option<&'static str> {
    find(NAMES, "metric", old)
}

/// The new name of an old value of a key.
pub(crate) fn value(key: &str, old: &str) -> Option<&'static str> {
    find(VALUES, key, old)
}

/// The new name of an old key that is written with its table, such as `model.gas.radius`, or by its last part only.
pub(crate) fn dotted_key(old: &str) -> Option<&'static str> {
    match old.rsplit_once('.') {
        Some((table, old)) => key(table, old),
        None => KEYS.iter().find(|(_, name, _)| *name == old).map(|(_, _, new)| *new),
    }
}

/// The error for an old name.
pub(crate) fn error(old: &str, new: &str, at: Span) -> Diagnostic {
    Diagnostic::new(format!("`{old}` was renamed; use `{new}`")).at(at, "old name")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::parse;

    /// Every line of a manifest that ends in `# <- NEW` has an old name; nothing else is wrong.
    fn names_every_new_name(manifest: &str) {
        let errors = parse(manifest, "m.toml", &[]).unwrap_err();
        let text = errors.to_string();
        let mut expected = 0;
        for (index, line) in manifest.lines().enumerate() {
            let Some((_, new)) = line.split_once("# <- ") else { continue };
            expected += 1;
            assert!(text.contains(&format!("was renamed; use `{new}`")), "{line}\n{text}");
            assert!(text.contains(&format!("--> m.toml:{}:", index + 1)), "{line}\n{text}");
        }
        assert_eq!(errors.len(), expected, "{text}");
    }

    #[test]
    fn all_old_names_are_reported_at_once_with_the_new_ones() {
        names_every_new_name(
            "random_seed = 3 # <- seed\n[model.gas]\ncontainer_m = 2 # <- radius_m\n\
             propagation = \"closed-form\" # <- \"exact\"\nplacement = \"anywhere\" # <- \"random\"\n\
             [record]\nimages = 3 # <- frames\n",
        );
        names_every_new_name("[model.dem]\ntail = \"clamped\" # <- limit_damping = true\n");
    }

    #[test]
    fn values_of_old_keys_are_reported_at_once() {
        let manifest = "[model.gas]\nmotion = \"closed-form\"\ncontainer_m = -1\n";
        let errors = parse(manifest, "m.toml", &[]).unwrap_err();
        let text = errors.to_string();
        for part in [
            "`motion` was renamed; use `propagation`",
            "`\"closed-form\"` was renamed; use `\"exact\"`",
            "`container_m` was renamed; use `radius_m`",
            "`model.gas.radius_m` is -1; must be",
        ] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert_eq!(errors.len(), 4, "{text}");
    }

    #[test]
    fn old_channels_and_metrics_are_reported_with_the_new_ones() {
        names_every_new_name(
            "[model.gas]\n[record]\nchannels = [\"ledger\"] # <- energy_balance\n\
             [[checks]]\nmetric = \"hit_rate\" # <- wall_collision_rate\nminimum = 1\n",
        );
    }

    #[test]
    fn old_required_key_is_one_error() {
        names_every_new_name("[model.dem]\nmaterials = [{ label = \"a\" }] # <- name\n");
    }

    #[test]
    fn old_names_of_swept_keys_are_reported() {
        names_every_new_name(
            "[model.gas]\n[sweep]\nmodel.gas.container_m = [1, 2] # <- radius_m\n\
             [[checks]]\nmetric = \"a2\"\nminimum = 1\nwhere = { container_m = 1 } # <- radius_m\n",
        );
    }
}
