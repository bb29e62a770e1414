//! Guarantee: every rule of `[model.dem]` is enforced, and the message states the allowed values and the position.
//!
//! Setup: each rule is violated once.

use crate::verdicts::{accepted, rejected};

#[test]
fn inconsistent_dem_scenes_are_rejected() {
    rejected("[model.dem]\nradius_m = { min = 1e-4, max = 1.1e-3 } # <-", "at most 10 times");
    rejected("[model.dem]\nradius_m = { mean = 1e-4, std = 4e-5 } # <-", "below a third");
    rejected(
        "[model.dem]\nradius_m = { small = 2e-4, large = 1e-4, small_fraction = 0.5 } # <-",
        "<= large",
    );
    rejected("[model.dem]\nstiffness_n_per_m = 0 # <-", "must be a number > 0");
    rejected("[model.dem]\nrestitution = 1.1 # <-", "must be a number in (0, 1]");
    accepted("[model.dem]\nyoungs_modulus_pa = 1e9\npoisson_ratio = 0.5");
    rejected("[model.dem]\npoisson_ratio = 0.3 # <-", "in place of `stiffness_n_per_m`");
    accepted("[model.dem]\nyoungs_modulus_pa = 1e9\ntangential_law = \"mindlin\"");
    rejected(
        "[model.dem]\ntangential_law = \"mindlin\" # <-",
        "give `youngs_modulus_pa` in place of `stiffness_n_per_m`",
    );
    rejected(
        "[model.dem]\nyoungs_modulus_pa = 1e9\ntangential_law = \"mindlin\"\ntangential_to_normal_stiffness = 0.5 # <-",
        "cannot be used together",
    );
    rejected("[model.dem]\nyoungs_modulus_pa = 1e9\ntangential_law = \"linear\" # <-", "mindlin");
    rejected(
        "[model.dem]\nyoungs_modulus_pa = 1e9\npoisson_ratio = 0.6 # <-",
        "must be a number in [0, 0.5]",
    );
    rejected(
        "[model.dem]\nyoungs_modulus_pa = 1e9\nstiffness_n_per_m = 5e4 # <-",
        "cannot be used together",
    );
    rejected(
        "[model.dem]\nyoungs_modulus_pa = 1e9\ndamping_n_s_per_m = 1 # <-",
        "replace `damping_n_s_per_m` with `restitution`",
    );
    rejected(
        "[model.dem]\nwalls = [{ from_m = [0.0, 0.01], to_m = [0.05, 0.01] }] # <-",
        "an outlet cannot be wider than its hopper",
    );
    rejected(
        "[model.dem]\nperiodic = \"x\"\nwidth_m = 0.005 # <-",
        "at least 12 of the largest radii",
    );
    rejected(
        "[model.dem]\nfriction = 0.1\ndashpot = \"implicit\" # <-",
        "neither friction nor moving walls",
    );
    rejected("[model.dem]\nplacement_region_m = [[0, 0], [1, 1]] # <-", "must lie within the box");
    accepted("[model.dem]\ntime_step_s = \"automatic\"");
    rejected("[model.dem]\ntime_step_s = \"auto\" # <-", "a number > 0 or \"automatic\"");
}

#[test]
fn contact_pairs_must_name_known_materials() {
    const TWO: &str = "materials = [{ name = \"glass\" }, { name = \"cork\", friction = 0.5 }]";
    let dem = |rest: &str| format!("[model.dem]\n{TWO}\n{rest}");
    accepted(&dem("contact_pairs = [{ between = [\"glass\", \"wall\"], restitution = 0.9 }]"));
    accepted("[model.dem]\ncontact_pairs = [{ between = [\"disc\", \"wall\"], friction = 0.1 }]");
    rejected(
        &dem("contact_pairs = [{ between = [\"glass\", \"steel\"] }] # <-"),
        "known: glass, cork, wall",
    );
    rejected(
        &dem("contact_pairs = [{ between = [\"wall\", \"wall\"] }] # <-"),
        "walls do not touch each other",
    );
    rejected(
        &dem(
            "contact_pairs = [{ between = [\"glass\", \"cork\"] }, { between = [\"cork\", \"glass\"] }] # <-",
        ),
        "is listed twice",
    );
    rejected(
        "[model.dem]\nmaterials = [{ name = \"wall\" }] # <-",
        "must not be empty or \"wall\"",
    );
    rejected(
        "[model.dem]\nmaterials = [{ name = \"a\" }, { name = \"a\" }] # <-",
        "material \"a\" is listed twice",
    );
    rejected("[model.dem]\nmaterials = [{ fraction = 0.5 }] # <-", "needs `name`");
    rejected(
        "[model.dem]\nmaterials = [{ name = \"a\", restitution = 0 }] # <-",
        "must be a number in (0, 1]",
    );
    rejected(
        "[model.dem]\nmaterials = [{ name = \"a\", stiffness_ratio = 0 }] # <-",
        "must be a number > 0",
    );
    rejected("[model.dem]\ncohesion_n = -1 # <-", "must be a number >= 0");
    rejected("[model.dem]\ncohesion_n = 0.1\ndashpot = \"implicit\" # <-", "cohesion");
    rejected(
        "[model.dem]\nmaterials = [{ name = \"a\", density_ratio = 0 }] # <-",
        "must be a number > 0",
    );
    rejected(
        "[model.dem]\ndamping_n_s_per_m = 0.1\nmaterials = [{ name = \"a\", restitution = 0.5 }] # <-",
        "replace damping_n_s_per_m with restitution",
    );
    rejected(&dem("dashpot = \"implicit\" # <-"), "neither friction nor moving walls");
}

#[test]
fn inserted_discs_must_start_inside_the_box() {
    let insertion = |rest: &str| {
        format!(
            "[model.dem]\ninsertion = {{ discs = 5, discs_per_s = 10, from_m = [0.01, 0.03], to_m = [0.03, 0.03], {rest} }} # <-"
        )
    };
    accepted(&insertion("velocity_m_per_s = [0, -1]"));
    rejected(&insertion("velocity_m_per_s = [0, 0]"), "must not be [0, 0]");
    rejected(&insertion("velocity_m_per_s = [0, -1], starts_s = -1"), "must be a number >= 0");
    rejected(&insertion("starts_s = 1"), "needs `velocity_m_per_s`");
    rejected(
        "[model.dem]\ninsertion = { discs = 5, discs_per_s = 10, from_m = [0, 0.03], to_m = [0.03, 0.03], velocity_m_per_s = [0, -1] } # <-",
        "keep the largest radius off",
    );
    rejected("[model.dem]\ninsertion = 5 # <-", "a table { discs, discs_per_s");
    rejected(
        "[model.dem]\nvelocity_std_m_per_s = 1\nplacement = { positions_m = [[0.01, 0.01]], velocities_m_per_s = [[0, 0]] } # <-",
        "`velocity_std_m_per_s` cannot be used with a given or recorded start",
    );
    rejected(
        "[model.dem]\nwalls = [{ from_m = [0, 0], to_m = [0.01, 0], moves_s = [2, 1] }] # <-",
        "must be [begin, end]",
    );
}

#[test]
fn dem_discs_must_fit_their_box() {
    rejected("[model.dem]\nradius_m = 0.02 # <-", "does not fit into a box of 0.04 m x 0.04 m");
    rejected("[model.dem]\nradius_m = 0.02\nheight_m = 0.03 # <-", "does not fit");
    accepted("[model.dem]\nradius_m = 0.0199");
    rejected("[model.dem]\nradius_m = { min = 2e-4, max = 1e-4 } # <-", "min must be <= max");
    rejected("[model.dem]\nradius_m = { min = 2e-4 } # <-", "needs `max`");
    rejected(
        "[model.dem]\nradius_m = { min = 1e-4, max = 2e-4, mean = 1.5e-4 } # <-",
        "`mean` cannot be used together",
    );
    rejected(
        "[model.dem]\nradius_m = \"big\" # <-",
        "must be a number > 0 or { min = ..., max = ... }",
    );
    rejected("[model.dem]\ntime_step_s = 2.0 # <-", "the time step must be <= the duration");
}
