//! The experiments that the program carries: each manifest of `experiments`.

use kinetoscope_manifest::Experiment;

/// An experiment that the program carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shipped {
    /// The name of the experiment and the stem of its file.
    pub(crate) name: &'static str,
    /// The manifest.
    pub(crate) manifest: &'static str,
}

macro_rules! shipped {
    ($($name:literal),+ $(,)?) => {
        /// All of them, by name.
        pub(crate) const SHIPPED: &[Shipped] = &[
            $(Shipped {
                name: $name,
                manifest: include_str!(concat!("../../experiments/", $name, ".toml")),
            },)+
        ];
    };
}

shipped![
    "dem_column_collapse",
    "dem_energy_and_time_step",
    "dem_exercise_damping",
    "dem_fed_hopper",
    "dem_granular_gas",
    "dem_heap",
    "dem_hertz_impacts",
    "dem_hopper",
    "dem_hopper_discharge",
    "dem_incline",
    "dem_newtons_cradle",
    "dem_restitution",
    "dem_rotating_drum",
    "dem_silo",
    "dem_thousand_discs",
    "dem_twenty_discs",
    "first_run",
    "gas_300_kelvin",
    "gas_373_kelvin",
    "gas_adiabatic_compression",
    "gas_as_printed_scheme",
    "gas_barometric",
    "gas_effusion",
    "gas_exercise_temperature",
    "gas_free_expansion",
    "gas_mean_speed_vs_temperature",
    "gas_mixing",
    "gas_pressure_vs_radius",
    "gas_pressure_vs_temperature",
    "gas_relaxation",
    "gas_stationarity",
    "gas_temperature_schedule",
    "gas_thermal_wall",
    "gas_wall_collisions",
    "orbit_cost_and_error",
    "orbit_drift_in_a_century",
    "orbit_drift_in_a_year",
    "orbit_drift_in_ten_years",
    "orbit_euler_spiral",
    "orbit_euler_time_steps",
    "orbit_exercise",
    "orbit_figure_eight",
    "orbit_heliocentric",
    "orbit_integrators",
    "orbit_keplers_laws",
    "orbit_outer_planets",
    "orbit_trojans",
    "packing_divergence",
    "packing_fifty_discs",
    "packing_freezing",
    "packing_gravity",
    "packing_inelastic_cooling",
    "packing_pegs",
    "packing_self_diffusion",
    "packing_timing_table",
    "packing_velocity_laws",
];

impl Shipped {
    /// The experiment of a name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        SHIPPED.iter().find(|shipped| shipped.name == name)
    }

    /// What the experiment asks; empty if its manifest does not say.
    pub(crate) fn question(&self) -> String {
        let parsed = kinetoscope_manifest::parse(self.manifest, self.name, &[]);
        parsed.map_or_else(|_| String::new(), |experiment: Experiment| experiment.question)
    }
}
