//! A short experiment of each model and variant, and its trajectory as bits.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use kinetoscope::run::schedule::Schedule;
use kinetoscope_manifest::RunManifest;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::record::RecordInterval;
use kinetoscope_physics::model::{Model, Progress};
use kinetoscope_physics::random::Seed;
use kinetoscope_physics::{prepare, restore};
use kinetoscope_recording::checkpoint;
use kinetoscope_recording::frame::Frame;
use std::num::NonZeroU64;

/// Manifests that cover every method of moving particles; each takes a fraction of a second.
pub(crate) const MANIFESTS: &[(&str, &str)] = &[
    (
        "dem",
        "seed = 3\n[model.dem]\nintegrator = \"semi-implicit-euler\"\ndiscs = 30\nwidth_m = 0.01\nheight_m = 0.01\nduration_s = 0.04\n[record]\nframes = 20\n",
    ),
    (
        "dem_verlet_clamped_mixed_radii",
        "seed = 4\n[model.dem]\ndiscs = 30\nradius_m = { min = 4e-4, max = 6e-4 }\nwidth_m = 0.01\nheight_m = 0.01\n\
         duration_s = 0.03\nintegrator = \"velocity-verlet\"\nlimit_damping = true\n[record]\nframes = 20\n",
    ),
    (
        "dem_implicit_dashpot",
        "seed = 5\n[model.dem]\ndiscs = 20\nwidth_m = 0.01\nheight_m = 0.01\nduration_s = 0.03\n\
         damping_n_s_per_m = 1.5e3\ndashpot = \"implicit\"\n[record]\nframes = 20\n",
    ),
    (
        "dem_verlet_implicit_mixed_radii",
        "seed = 27\n[model.dem]\ndiscs = 60\nradius_m = { min = 3e-4, max = 7e-4 }\nwidth_m = 0.012\nheight_m = 0.012\n\
         duration_s = 0.03\nintegrator = \"velocity-verlet\"\ndashpot = \"implicit\"\n[record]\nframes = 20\n",
    ),
    (
        "gas_exact",
        "seed = 6\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_stepped",
        "seed = 7\n[model.gas]\nparticles = 50\nduration_s = 0.02\npropagation = \"time-stepped\"\ntime_step_s = 3e-5\n\
         [record]\nframes = 20\n",
    ),
    (
        "packing",
        "seed = 8\n[model.packing]\ndiscs = 40\nwall_noise_variance_rad2 = 0.003\n[record]\nframes = 20\n",
    ),
    (
        "packing_inelastic_by_time",
        "seed = 9\n[model.packing]\ndiscs = 40\nwall_noise_variance_rad2 = 0.003\nremove_mean_velocity = true\nrestitution = 0.9\nduration = 40.0\n[record]\nframes = 20\n",
    ),
    (
        "orbit_euler",
        "[model.orbit]\nstart = \"barycentric\"\nintegrator = \"explicit-euler\"\nduration_days = 100.0\n[record]\nframes = 20\n",
    ),
    (
        "orbit_rk4",
        "[model.orbit]\nduration_days = 100.0\nintegrator = \"rk4\"\nstart = \"heliocentric\"\n[record]\nframes = 20\n",
    ),
    (
        "orbit_semi_implicit_euler",
        "[model.orbit]\nduration_days = 100.0\nintegrator = \"semi-implicit-euler\"\n[record]\nframes = 20\n",
    ),
    (
        "orbit_velocity_verlet",
        "[model.orbit]\nduration_days = 100.0\nintegrator = \"velocity-verlet\"\n[record]\nframes = 20\n",
    ),
    (
        "orbit_kepler",
        "[model.orbit]\nduration_days = 900.0\nintegrator = \"kepler\"\n[record]\nframes = 20\n",
    ),
    (
        "dem_rubbing_in_a_drum",
        "seed = 10\n[model.dem]\ndiscs = 60\nradius_m = { mean = 5e-4, std = 5e-5 }\nwidth_m = 0.016\nheight_m = 0.016\n\
         friction = 0.5\nrolling_friction = 0.05\nduration_s = 0.03\nplacement_region_m = [[0.0, 0.0], [0.016, 0.01]]\n\
         walls = [{ center_m = [0.008, 0.008], radius_m = 0.008, spin_rad_per_s = -12.0 }]\n[record]\nframes = 20\n",
    ),
    (
        "dem_periodic_with_an_outlet",
        "seed = 11\n[model.dem]\ndiscs = 60\nwidth_m = 0.016\nheight_m = 0.016\nperiodic = \"x\"\nfriction = 0.3\n\
         remove_below_m = 0.004\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_thermal_wall_and_masses",
        "seed = 12\n[model.gas]\nparticles = 50\nadditional_masses_kg = [3e-26]\nwall_temperature_k = 200.0\n\
         accommodation_coefficient = 0.7\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_gravity",
        "seed = 24\n[model.gas]\nparticles = 50\ngravity_m_per_s2 = 1e6\nposition_distribution = \"barometric\"\n\
         duration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_partition_and_given_start",
        "seed = 25\n[model.gas]\nparticles = 2\npartition_x_m = 0.0\npartition_opens_s = 0.01\nduration_s = 0.02\n\
         placement = { positions_m = [[-0.5, 0.1], [0.5, 0.0]], velocities_m_per_s = [[300.0, 10.0], [-200.0, 50.0]] }\n\
         [record]\nframes = 20\n",
    ),
    (
        "gas_piston",
        "seed = 13\n[model.gas]\nparticles = 50\nwall_speed_m_per_s = -5.0\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_schedule_and_opening",
        "seed = 14\n[model.gas]\nparticles = 50\ntemperature_schedule = [[0.0103, 500.0]]\norifice_width_m = 0.5\n\
         duration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "packing_periodic_mixed_radii",
        "seed = 15\n[model.packing]\ndiscs = 100\nboundary = \"periodic\"\nradius_half_width = 0.2\nrestitution = 0.9\n\
         contact_time = 1e-4\n[record]\nframes = 20\n",
    ),
    (
        "packing_gravity",
        "seed = 28\n[model.packing]\ndiscs = 80\ngravity = 0.2\nradius_half_width = 0.1\nrestitution = 0.95\n\
         wall_noise_variance_rad2 = 0.003\nevents_per_disc = 20\n[record]\nframes = 20\n",
    ),
    (
        "packing_floor_with_a_temperature",
        "seed = 29\n[model.packing]\ndiscs = 80\ngravity = 0.2\nfloor_temperature = 2.0\nrestitution = 0.9\n\
         cutoff_velocity = 1e-3\nduration = 30.0\n[record]\nframes = 20\n",
    ),
    (
        "packing_shaken_floor",
        "seed = 30\n[model.packing]\ndiscs = 80\ngravity = 0.2\nfloor_stroke = 1.5\nfloor_period = 3.0\nrestitution = 0.9\n\
         placement = \"compressed\"\nduration = 30.0\n[record]\nframes = 20\n",
    ),
    (
        "packing_obstacles",
        "seed = 31\n[model.packing]\ndiscs = 60\nboundary = \"periodic\"\nradius_half_width = 0.1\n\
         obstacles = { positions = [[-12.0, 3.0], [0.0, -9.0], [19.5, 14.0]], radius = 4.0 }\nevents_per_disc = 20\n[record]\nframes = 20\n",
    ),
    (
        "packing_obstacles_in_gravity",
        "seed = 32\n[model.packing]\ndiscs = 60\ngravity = 0.2\nrestitution = 0.9\ncutoff_velocity = 1e-2\nduration = 30.0\n\
         obstacles = { positions = [[-12.0, -6.0], [0.0, -10.0], [12.0, -3.0]], radius = 2.5 }\n[record]\nframes = 20\n",
    ),
    (
        "packing_compressed",
        "seed = 16\n[model.packing]\ndiscs = 60\nwidth = 18.0\nheight = 18.0\nplacement = \"compressed\"\n[record]\nframes = 20\n",
    ),
    (
        "orbit_adaptive",
        "[model.orbit]\nduration_days = 500.0\nintegrator = \"dop853\"\n[record]\nframes = 20\n",
    ),
    (
        "orbit_three_bodies",
        "[model.orbit]\nduration_days = 50.0\nintegrator = \"yoshida4\"\nsummation = \"compensated\"\n\
         bodies = [{ gm_au3_per_day2 = 3e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, \
         { gm_au3_per_day2 = 1e-6, position_au = [1, 0, 0], velocity_au_per_day = [0, 0.017, 0] }, \
         { gm_au3_per_day2 = 1e-7, position_au = [0, 2, 0], velocity_au_per_day = [-0.012, 0, 0] }]\n[record]\nframes = 20\n",
    ),
    (
        "dem_rain_on_two_materials_behind_a_gate",
        "seed = 17\n[model.dem]\ndiscs = 30\nwidth_m = 0.016\nheight_m = 0.016\nfriction = 0.3\nduration_s = 0.03\n\
         velocity_std_m_per_s = 0.2\nplacement_region_m = [[0.0, 0.0], [0.008, 0.012]]\n\
         materials = [{ name = \"heavy\", density_ratio = 2.0, restitution = 0.9 }, { name = \"light\", fraction = 2.0 }]\n\
         contact_pairs = [{ between = [\"light\", \"wall\"], friction = 0.0 }]\n\
         walls = [{ from_m = [0.008, 0.0], to_m = [0.008, 0.014], velocity_m_per_s = [1.0, 0.0], moves_s = [0.01, 0.016] }]\n\
         insertion = { discs = 20, discs_per_s = 1000.0, from_m = [0.002, 0.015], to_m = [0.014, 0.015], \
         velocity_m_per_s = [0.0, -0.5], starts_s = 2e-3 }\n[record]\nframes = 20\n",
    ),
    (
        "dem_cohesive_bed_of_two_stiffnesses",
        "seed = 23\n[model.dem]\ndiscs = 50\nwidth_m = 0.012\nheight_m = 0.016\nfriction = 0.3\nrolling_friction = 0.05\nduration_s = 0.03\n\
         cohesion_n = 0.01\nmaterials = [{ name = \"hard\", stiffness_ratio = 2.0, restitution = 0.9 }, \
         { name = \"soft\", stiffness_ratio = 0.3, cohesion_n = 0.02 }]\n[record]\nframes = 20\n",
    ),
    (
        "gas_discs_that_collide",
        "seed = 17\n[model.gas]\nparticles = 60\nadditional_masses_kg = [2e-26]\ndisc_radius_m = 0.04\n\
         speeds_m_per_s = [300.0, 900.0, 600.0]\ntemperature_schedule = [[0.0103, 500.0]]\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_in_gravity",
        "seed = 21\n[model.gas]\nparticles = 50\nadditional_masses_kg = [3e-26]\ngravity_m_per_s2 = 5e5\n\
         position_distribution = \"barometric\"\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_with_a_partition",
        "seed = 22\n[model.gas]\nparticles = 50\nadditional_masses_kg = [3e-26]\npartition_x_m = 0.1\n\
         partition_opens_s = 0.0103\npartition_side = \"by-mass\"\nduration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_in_gravity_within_combined_walls",
        "seed = 26\n[model.gas]\nparticles = 50\ngravity_m_per_s2 = 5e5\nwall_temperature_k = 500.0\n\
         accommodation_coefficient = 0.6\norifice_width_m = 0.4\npartition_x_m = 0.1\npartition_opens_s = 0.0103\n\
         duration_s = 0.02\n[record]\nframes = 20\n",
    ),
    (
        "gas_logarithmic",
        "seed = 18\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes_per_decade = 7\n",
    ),
    (
        "packing_logarithmic",
        "seed = 19\n[model.packing]\ndiscs = 40\n[record]\nframes_per_decade = 6\ndecades = 4\n",
    ),
    (
        "dem_logarithmic_with_contact_forces",
        "seed = 20\n[model.dem]\ndiscs = 30\nwidth_m = 0.01\nheight_m = 0.01\nfriction = 0.3\nduration_s = 0.04\n\
         [record]\nframes_per_decade = 8\nchannels = [\"state\", \"energy\", \"contact_forces\"]\n",
    ),
    (
        "orbit_logarithmic",
        "[model.orbit]\nduration_days = 100.0\n[record]\nframes_per_decade = 9\ndecades = 2\n",
    ),
];

/// The manifest of a name in [`MANIFESTS`].
pub(crate) fn manifest(name: &str) -> &'static str {
    let named = MANIFESTS.iter().find(|(known, _)| *known == name);
    named.unwrap_or_else(|| panic!("no small experiment is named {name}")).1
}

/// The only run of a manifest.
pub(crate) fn run_of(name: &str, manifest: &str) -> RunManifest {
    let experiment = kinetoscope_manifest::parse(manifest, &format!("{name}.toml"), &[])
        .unwrap_or_else(|diagnostics| panic!("{diagnostics}"));
    assert_eq!(experiment.runs.len(), 1);
    experiment.runs[0].manifest.clone()
}

/// How a trajectory is computed.
#[derive(Clone, Copy)]
pub(crate) struct Taking {
    /// Steps or events per call.
    pub(crate) budget: u64,
    /// Number of frames; `None` for that of the manifest.
    pub(crate) frames: Option<u64>,
    /// Whether every frame is observed, or only the last one.
    pub(crate) look_at_all: bool,
    /// Whether the per-collision series is collected.
    pub(crate) per_collision: bool,
    /// Whether the model is saved, dropped and restored whenever its budget is used up and after each frame.
    pub(crate) restore: bool,
}

impl Taking {
    /// The settings of a normal run.
    pub(crate) const PLAIN: Self = Self {
        budget: u64::MAX,
        frames: None,
        look_at_all: true,
        per_collision: false,
        restore: false,
    };
}

/// The observed frames, in order.
pub(crate) fn trajectory(manifest: &RunManifest, taking: Taking) -> Vec<Frame> {
    let seed = Seed { seed: manifest.seed, replicate: manifest.replicate };
    let mut model = prepare(&manifest.model, seed, taking.per_collision).unwrap();
    let interval = taking.frames.map_or(manifest.record.interval, |frames| {
        RecordInterval::Frames(NonZeroU64::new(frames).unwrap())
    });
    let schedule = Schedule::new(interval, model.extent()).unwrap();
    let mut frames = Vec::new();
    for index in 1..=schedule.frames() {
        let target = schedule.target(index);
        while model.advance(target, taking.budget).unwrap() == Progress::Working {
            model = if taking.restore { restored(&*model, &manifest.model) } else { model };
        }
        if taking.look_at_all || index == schedule.frames() {
            let mut frame = Frame::new();
            model.observe(&mut frame);
            frames.push(frame);
        }
        model = if taking.restore { restored(&*model, &manifest.model) } else { model };
    }
    frames
}

/// The model after it was saved to a checkpoint and restored.
fn restored(model: &dyn Model, config: &ModelConfig) -> Box<dyn Model> {
    let bytes = checkpoint::encode("a model", &[model]).unwrap();
    restore(config, checkpoint::content(&bytes, "a model").unwrap()).unwrap()
}

/// The bits of a frame's state.
pub(crate) fn bits(frame: &Frame) -> Vec<u64> {
    frame.state().iter().map(|value| value.to_bits()).collect()
}
