//! Scenes of all models, and changes of their physics that a comparison with a baseline must find.

/// A scene with its changes.
#[derive(Clone, Copy)]
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    /// The manifest without name, seed and replicates.
    manifest: &'static str,
    /// The channels that its metrics need.
    channels: &'static str,
    pub(crate) changes: [Change; 5],
}

/// What changes, and the values `--set` with it.
#[derive(Clone, Copy)]
pub(crate) struct Change {
    pub(crate) what: &'static str,
    pub(crate) key: &'static str,
    pub(crate) value: &'static str,
}

impl Scene {
    /// The whole manifest.
    pub(crate) fn manifest(&self) -> String {
        let Self { name, manifest, channels, .. } = self;
        let channels = match channels.is_empty() {
            true => String::new(),
            false => format!("channels = {channels}\n"),
        };
        format!("name = \"{name}\"\n{manifest}{channels}")
    }
}

const fn change(what: &'static str, key: &'static str, value: &'static str) -> Change {
    Change { what, key, value }
}

const GAS: &str =
    r#"["state", "pressure", "temperature", "energy", "energy_balance", "collisions", "speeds"]"#;
const PACKING: &str = r#"["state", "temperature", "collisions", "pressure"]"#;
const DEM: &str = r#"["state", "energy", "contact_statistics", "wall_forces", "temperature"]"#;

/// A gas has gravity in the second scene only; elsewhere, its particles are twice as heavy. Its collisions are elastic: walls that are
/// colder by 0.9^2 take the energy instead. Its trajectories have no time step: its speeds are equal instead of Maxwell's, at the same
/// temperature; with gravity, its particles are twice as heavy.
const COLDER_WALLS: Change = change("walls at 0.81 T", "model.gas.wall_temperature_k", "243.0");
const HEAVIER: Change = change("mass x 2", "model.gas.mass_kg", "2e-26");
const EQUAL_SPEEDS: Change = change("equal speeds", "model.gas.speed_distribution", "\"equal\"");
const HOTTER: Change = change("T + 25 %", "model.gas.temperature_k", "375.0");
const WIDER: Change = change("container radius + 10 %", "model.gas.radius_m", "1.1");

/// Hard discs in a box have no gravity, which would make them denser: there are twice as many. The manifest offers two temperatures, 1 and
/// 1/N. Events have no time step: the box is wider.
const PACKING_CHANGES: [Change; 5] = [
    change("discs x 2", "model.packing.discs", "600"),
    change("e 1 → 0.9", "model.packing.restitution", "0.9"),
    change("T → T/N", "model.packing.initial_velocities", "\"variance-1-over-n\""),
    change("radius + 10 %", "model.packing.radius", "1.1"),
    change("box width + 25 %", "model.packing.width", "122.5"),
];

const DEM_RESTITUTION: Change = change("e 1 → 0.9", "model.dem.restitution", "0.9");
const DEM_RADIUS: Change = change("radius + 10 %", "model.dem.radius_m", "5.5e-4");
const DEM_TIME_STEP: Change = change("time step x 2", "model.dem.steps_per_wall_contact", "10.0");
/// 0.5 sqrt(1.25) m/s.
const DEM_TEMPERATURE: Change =
    change("T + 25 %", "model.dem.velocity_std_m_per_s", "0.5590169943749475");
const DEM_GRAVITY: Change = change("gravity x 2", "model.dem.gravity_m_per_s2", "[0.0, -19.62]");
const FALLING: Change =
    change("gravity x 2 (0 → 9.81 m/s²)", "model.dem.gravity_m_per_s2", "[0.0, -9.81]");

/// Orbits do not collide: explicit Euler changes the energy instead. The Sun's attraction is no key: 0.5^(1/3) of the axis has the period of
/// twice the attraction, and 0.8 of it has 25 % more kinetic energy.
const DISSIPATION: Change =
    change("explicit Euler", "model.orbit.integrator", "\"explicit-euler\"");

const fn orbit(
    gravity: &'static str,
    temperature: &'static str,
    radius: &'static str,
) -> [Change; 5] {
    [
        change("axis x 0.79 (period of gravity x 2)", "model.orbit.start", gravity),
        DISSIPATION,
        change("axis x 0.8 (kinetic energy + 25 %)", "model.orbit.start", temperature),
        change("axis + 10 %", "model.orbit.start", radius),
        change("time step x 2", "model.orbit.time_step_days", "2.0"),
    ]
}

/// Runs that are too short for some of their standard errors, or for those of some seeds.
pub(crate) const SHORT_SCENES: [Scene; 2] = [
    Scene {
        name: "gas_of_few_frames",
        manifest: "[model.gas]\nparticles = 200\ndisc_radius_m = 0.02\nduration_s = 0.02\n[record]\nframes = 80\n",
        channels: GAS,
        changes: SCENES[0].changes,
    },
    Scene {
        name: "packing_of_few_discs",
        manifest: "[model.packing]\ndiscs = 60\nwidth = 30.0\nheight = 30.0\nboundary = \"periodic\"\nduration = 60.0\n[record]\nframes = 100\n",
        channels: PACKING,
        changes: PACKING_CHANGES,
    },
];

/// Runs of few particles, or in which a value, its error or the validity of its law depends on the seed: few particles that leave through an
/// orifice or get lost, energies lost in few collisions, discs that may go a quarter of the box between two frames, and discs that
/// hardly collide.
pub(crate) const CHANCE_SCENES: [Scene; 5] = [
    Scene {
        name: "gas_few_leave",
        manifest: "[model.gas]\nparticles = 20\nduration_s = 0.002\norifice_width_m = 0.5\n[record]\nframes = 20\n",
        channels: GAS,
        changes: SCENES[2].changes,
    },
    Scene {
        name: "gas_few_as_printed",
        manifest: "[model.gas]\nparticles = 10\nduration_s = 0.002\npropagation = \"as-printed\"\ntime_step_s = 1e-5\n[[checks]]\nmetric = \"particles_outside\"\nmaximum = 10.0\n[record]\nframes = 20\n",
        channels: GAS,
        changes: SCENES[0].changes,
    },
    Scene {
        name: "packing_few_losses",
        manifest: "[model.packing]\ndiscs = 150\nwidth = 100.0\nheight = 100.0\nduration = 6.0\nrestitution = 0.9\nboundary = \"periodic\"\n[record]\nframes = 80\n",
        channels: PACKING,
        changes: PACKING_CHANGES,
    },
    Scene {
        name: "packing_far_between_frames",
        manifest: "[model.packing]\ndiscs = 40\nwidth = 40.0\nheight = 40.0\nduration = 250.0\nboundary = \"periodic\"\n[record]\nframes = 90\n",
        channels: PACKING,
        changes: PACKING_CHANGES,
    },
    Scene {
        name: "gas_few_discs",
        manifest: "[model.gas]\nparticles = 6\nduration_s = 0.05\ndisc_radius_m = 0.02\n[record]\nframes = 100\n",
        channels: GAS,
        changes: SCENES[0].changes,
    },
];

/// Changes that no metric of a single run shows: time steps that are exact whatever their length, and walls that hardly turn directions.
pub(crate) const HIDDEN: [(Scene, Change); 2] = [
    (
        Scene {
            name: "gas_time_stepped",
            manifest: "[model.gas]\nparticles = 2000\nduration_s = 0.002\npropagation = \"time-stepped\"\ntime_step_s = 1e-5\n[record]\nframes = 70\n",
            channels: GAS,
            changes: SCENES[0].changes,
        },
        change("time step x 2", "model.gas.time_step_s", "2e-5"),
    ),
    (
        Scene {
            name: "packing_long",
            manifest: "[model.packing]\ndiscs = 300\nwidth = 98.0\nheight = 98.0\nduration = 1000.0\n[record]\nframes = 200\n",
            channels: PACKING,
            changes: PACKING_CHANGES,
        },
        change("wall noise", "model.packing.wall_noise_variance_rad2", "0.003"),
    ),
];

/// Falling discs, some of which touch nothing until the end of some runs.
pub(crate) const FEW_CONTACTS: Scene = Scene {
    name: "dem_few_contacts",
    manifest: "[model.dem]\ndiscs = 5\nwidth_m = 0.04\nheight_m = 0.04\nduration_s = 0.05\n[record]\nframes = 50\n",
    channels: "",
    changes: [FALLING, DEM_RESTITUTION, DEM_TEMPERATURE, DEM_RADIUS, DEM_TIME_STEP],
};

/// Points that hardly feel gravity: m g R is an eighth of kT.
pub(crate) const WEAK_GRAVITY: Scene = Scene {
    name: "gas_in_weak_gravity",
    manifest: "[model.gas]\nparticles = 500\nmass_kg = 1e-26\ngravity_m_per_s2 = 5e4\nduration_s = 0.01\n[record]\nframes = 40\n",
    channels: "",
    changes: [
        change("gravity x 2", "model.gas.gravity_m_per_s2", "1e5"),
        COLDER_WALLS,
        HOTTER,
        WIDER,
        HEAVIER,
    ],
};

/// Three scenes of each model; then a gas that starts in equilibrium with gravity, and a gas of few elastic discs.
pub(crate) const SCENES: [Scene; 14] = [
    Scene {
        name: "gas_points",
        manifest: "[model.gas]\nparticles = 2000\nduration_s = 0.0003\nposition_distribution = \"uniform-in-radius\"\n[record]\nframes = 70\n",
        channels: GAS,
        changes: [HEAVIER, COLDER_WALLS, HOTTER, WIDER, EQUAL_SPEEDS],
    },
    Scene {
        name: "gas_falling",
        manifest: "[model.gas]\nparticles = 5000\nduration_s = 0.0006\ngravity_m_per_s2 = 828389.4\n[record]\nframes = 70\n",
        channels: GAS,
        changes: [
            change("gravity x 2", "model.gas.gravity_m_per_s2", "1656778.8"),
            COLDER_WALLS,
            HOTTER,
            WIDER,
            HEAVIER,
        ],
    },
    Scene {
        name: "gas_effusion",
        manifest: "[model.gas]\nparticles = 20000\nduration_s = 0.008\norifice_width_m = 1.0\n[record]\nframes = 10\n",
        channels: GAS,
        changes: [HEAVIER, COLDER_WALLS, HOTTER, WIDER, EQUAL_SPEEDS],
    },
    Scene {
        name: "packing_walls",
        manifest: "[model.packing]\ndiscs = 300\nwidth = 98.0\nheight = 98.0\nduration = 40.0\n[record]\nframes = 80\n",
        channels: PACKING,
        changes: PACKING_CHANGES,
    },
    Scene {
        name: "packing_periodic",
        manifest: "[model.packing]\ndiscs = 300\nwidth = 98.0\nheight = 98.0\nduration = 40.0\nboundary = \"periodic\"\nremove_mean_velocity = true\n[record]\nframes = 80\n",
        channels: PACKING,
        changes: PACKING_CHANGES,
    },
    Scene {
        name: "packing_sizes",
        manifest: "[model.packing]\ndiscs = 300\nwidth = 98.0\nheight = 98.0\nduration = 40.0\nradius_half_width = 0.3\n[record]\nframes = 80\n",
        channels: PACKING,
        changes: PACKING_CHANGES,
    },
    Scene {
        name: "dem_agitated",
        manifest: "[model.dem]\ndiscs = 300\nwidth_m = 0.037\nheight_m = 0.037\nstiffness_n_per_m = 2e5\nrestitution = 1.0\nvelocity_std_m_per_s = 0.5\nduration_s = 0.1\n[record]\nframes = 100\n",
        channels: DEM,
        changes: [DEM_GRAVITY, DEM_RESTITUTION, DEM_TEMPERATURE, DEM_RADIUS, DEM_TIME_STEP],
    },
    Scene {
        name: "dem_gas",
        manifest: "[model.dem]\ndiscs = 300\nwidth_m = 0.037\nheight_m = 0.037\nperiodic = \"both\"\ngravity_m_per_s2 = [0.0, 0.0]\nstiffness_n_per_m = 2e5\nrestitution = 1.0\nvelocity_std_m_per_s = 0.5\nduration_s = 0.1\n[record]\nframes = 100\n",
        channels: DEM,
        changes: [FALLING, DEM_RESTITUTION, DEM_TEMPERATURE, DEM_RADIUS, DEM_TIME_STEP],
    },
    Scene {
        name: "dem_drop",
        manifest: "[model.dem]\nstiffness_n_per_m = 2e5\nrestitution = 1.0\nplacement = { positions_m = [[0.02, 0.02]], velocities_m_per_s = [[0.1, 0.0]] }\nduration_s = 0.5\n[record]\nframes = 200\n",
        channels: DEM,
        changes: [
            DEM_GRAVITY,
            DEM_RESTITUTION,
            change(
                "horizontal kinetic energy + 25 %",
                "model.dem.placement",
                "{ positions_m = [[0.02, 0.02]], velocities_m_per_s = [[0.1118033988749895, 0.0]] }",
            ),
            DEM_RADIUS,
            DEM_TIME_STEP,
        ],
    },
    Scene {
        name: "orbit_circle",
        manifest: "[model.orbit]\nstart = { semi_major_axis_au = 1.0, eccentricity = 0.02 }\ntime_step_days = 1.0\nduration_days = 1000.0\n[record]\nframes = 100\n",
        channels: "",
        changes: orbit(
            "{ semi_major_axis_au = 0.7937005259840998, eccentricity = 0.02 }",
            "{ semi_major_axis_au = 0.8, eccentricity = 0.02 }",
            "{ semi_major_axis_au = 1.1, eccentricity = 0.02 }",
        ),
    },
    Scene {
        name: "orbit_eccentric",
        manifest: "[model.orbit]\nstart = { semi_major_axis_au = 1.0, eccentricity = 0.6 }\nintegrator = \"rk4\"\ntime_step_days = 1.0\nduration_days = 1000.0\n[record]\nframes = 100\n",
        channels: "",
        changes: orbit(
            "{ semi_major_axis_au = 0.7937005259840998, eccentricity = 0.6 }",
            "{ semi_major_axis_au = 0.8, eccentricity = 0.6 }",
            "{ semi_major_axis_au = 1.1, eccentricity = 0.6 }",
        ),
    },
    Scene {
        name: "orbit_bodies",
        manifest: "[model.orbit]\nbodies = [{ gm_au3_per_day2 = 2.959e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, { gm_au3_per_day2 = 2.825e-7, position_au = [5.2, 0, 0], velocity_au_per_day = [0, 0.00754, 0] }]\ntime_step_days = 5.0\nduration_days = 2000.0\n[record]\nframes = 100\n",
        channels: "",
        changes: [
            change(
                "attraction of the heavier body x 2",
                "model.orbit.bodies",
                "[{ gm_au3_per_day2 = 5.918e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, { gm_au3_per_day2 = 2.825e-7, position_au = [5.2, 0, 0], velocity_au_per_day = [0, 0.00754, 0] }]",
            ),
            DISSIPATION,
            change(
                "kinetic energy of the lighter body + 25 %",
                "model.orbit.bodies",
                "[{ gm_au3_per_day2 = 2.959e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, { gm_au3_per_day2 = 2.825e-7, position_au = [5.2, 0, 0], velocity_au_per_day = [0, 0.00843, 0] }]",
            ),
            change(
                "distance + 10 %",
                "model.orbit.bodies",
                "[{ gm_au3_per_day2 = 2.959e-4, position_au = [0, 0, 0], velocity_au_per_day = [0, 0, 0] }, { gm_au3_per_day2 = 2.825e-7, position_au = [5.72, 0, 0], velocity_au_per_day = [0, 0.00754, 0] }]",
            ),
            change("time step x 2", "model.orbit.time_step_days", "10.0"),
        ],
    },
    Scene {
        name: "gas_in_equilibrium",
        manifest: "[model.gas]\nparticles = 1000\nmass_kg = 1e-26\ntemperature_k = 300.0\ngravity_m_per_s2 = 1e6\nposition_distribution = \"barometric\"\nduration_s = 0.02\n[record]\nframes = 30\n",
        channels: "",
        changes: [
            change("gravity x 2", "model.gas.gravity_m_per_s2", "2e6"),
            COLDER_WALLS,
            HOTTER,
            WIDER,
            HEAVIER,
        ],
    },
    Scene {
        name: "dem_few_discs",
        manifest: "[model.dem]\ndiscs = 60\nwidth_m = 0.0165\nheight_m = 0.0165\nperiodic = \"both\"\ngravity_m_per_s2 = [0.0, 0.0]\nstiffness_n_per_m = 2e5\nrestitution = 1.0\nvelocity_std_m_per_s = 0.5\nduration_s = 0.1\n[record]\nframes = 100\n",
        channels: DEM,
        changes: [FALLING, DEM_RESTITUTION, DEM_TEMPERATURE, DEM_RADIUS, DEM_TIME_STEP],
    },
];
