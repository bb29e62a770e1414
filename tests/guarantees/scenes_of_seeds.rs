//! Scenes whose seeds are compared with their standard errors.

/// A scene: its name and its manifest.
pub(crate) type Scene = (&'static str, String);

/// The scenes, each with this number of seeds.
pub(crate) fn scenes(seeds: u32) -> Vec<Scene> {
    let starter = |text: &str| text.replace("replicates = 1 ", &format!("replicates = {seeds} "));
    let gas = include_str!("../../src/manifest/model/gas/starter.toml");
    let packing = include_str!("../../src/manifest/model/packing/starter.toml");
    let of_discs = format!(
        r#"
        replicates = {seeds}
        [model.gas]
        particles = 200
        disc_radius_m = 0.01
        duration_s = 0.06
        [record]
        frames = 400
        "#
    );
    let bed = format!(
        r#"
        replicates = {seeds}
        [model.dem]
        discs = 30
        width_m = 0.01
        height_m = 0.02
        stiffness_n_per_m = 1e4
        duration_s = 0.5
        [record]
        frames = 1000
        channels = ["state", "energy", "contact_statistics", "contact_forces", "wall_forces", "temperature"]
        "#
    );
    vec![
        ("gas starter", starter(gas)),
        ("packing starter", starter(packing)),
        ("colliding gas", of_discs),
        ("bed", bed),
    ]
}

/// Scenes in which something that the run conserves, or the start, adds to the scatter: the rotation of gases, radii, the
/// drift in a periodic box, and neighbors that move together.
fn conserving_scenes(seeds: u32) -> Vec<Scene> {
    let gas = |particles: u32, radius: f64, duration: f64| {
        format!(
            "replicates = {seeds}\n[model.gas]\nparticles = {particles}\ndisc_radius_m = {radius}\n\
             duration_s = {duration}\n[record]\nframes = 200\n"
        )
    };
    let packing = |keys: &str| format!("replicates = {seeds}\n[model.packing]\n{keys}\n");
    vec![
        ("gas of 100 discs", gas(100, 0.03, 0.1)),
        ("dense gas", gas(60, 0.07, 0.3)),
        ("several radii", packing("radius_half_width = 0.3\nwidth = 22.0\nheight = 22.0")),
        ("drift", packing("boundary = \"periodic\"\nevents_per_disc = 400")),
        ("gas as printed", AS_PRINTED.replace("replicates = 8", &format!("replicates = {seeds}"))),
        ("lattice", packing("placement = \"lattice\"\nwidth = 17.0\nheight = 17.0")),
    ]
}

/// The gas exercise's reflection as printed, which loses particles for good.
pub(crate) const AS_PRINTED: &str = r#"
    replicates = 8
    [model.gas]
    particles = 500
    propagation = "as-printed"
    time_step_s = 2e-5
    duration_s = 0.01
    [record]
    frames = 100
"#;

/// Scenes whose errors follow from counting or from a formula: drawn velocities, layers in gravity, particles that escape, mixing
/// species, a thermal wall; and discs that leave a silo.
fn counting_scenes(seeds: u32) -> Vec<Scene> {
    let gas =
        |keys: &str| format!("replicates = {seeds}\n[model.gas]\n{keys}\n[record]\nframes = 100\n");
    let silo = format!(
        r#"
        replicates = {seeds}
        [model.dem]
        discs = 150
        radius_m = {{ min = 4.5e-4, max = 5.5e-4 }}
        width_m = 0.012
        height_m = 0.03
        stiffness_n_per_m = 1e4
        friction = 0.5
        remove_below_m = 0.002
        placement_region_m = [[0.0, 0.004], [0.012, 0.03]]
        walls = [
          {{ from_m = [0.0, 0.004], to_m = [0.003, 0.004] }},
          {{ from_m = [0.009, 0.004], to_m = [0.012, 0.004] }},
        ]
        duration_s = 0.4
        [record]
        frames = 800
        channels = ["state", "energy", "contact_statistics", "wall_forces", "temperature"]
        "#
    );
    let few_discs = format!(
        r#"
        replicates = {seeds}
        [model.dem]
        discs = 60
        width_m = 0.0165
        height_m = 0.0165
        periodic = "both"
        gravity_m_per_s2 = [0.0, 0.0]
        stiffness_n_per_m = 2e5
        restitution = 1.0
        velocity_std_m_per_s = 0.5
        duration_s = 0.001
        [record]
        frames = 2
        channels = ["temperature"]
        "#
    );
    vec![
        ("few elastic discs", few_discs),
        (
            "gas in gravity",
            gas(
                "particles = 1000\ngravity_m_per_s2 = 828389.4\nposition_distribution = \"barometric\"\nduration_s = 0.03",
            ),
        ),
        ("orifice", gas("particles = 5000\norifice_width_m = 0.2\nduration_s = 0.001")),
        (
            "mixing gases",
            gas(
                "particles = 1000\nadditional_masses_kg = [4e-26]\npartition_x_m = 0.0\npartition_opens_s = 0.01\npartition_side = \"by-mass\"\nduration_s = 0.1",
            ),
        ),
        (
            "thermal wall",
            gas(
                "particles = 500\nspeed_distribution = \"equal\"\ntemperature_k = 100.0\nwall_temperature_k = 300.0\nduration_s = 0.05",
            ),
        ),
        ("silo", silo),
    ]
}

/// The mean a2 of cooling discs in boxes in which no flow grows; then one in which it does.
pub(crate) fn cooling_scenes(seeds: u32) -> [Scene; 3] {
    let scene = |keys: &str| {
        format!(
            "replicates = {seeds}\n[model.packing]\n{keys}\n[record]\nchannels = [\"state\", \"temperature\", \"collisions\"]\n"
        )
    };
    [
        (
            "cooling, periodic",
            scene(
                "discs = 100\nwidth = 60.0\nheight = 60.0\nboundary = \"periodic\"\nremove_mean_velocity = true\nrestitution = 0.9",
            ),
        ),
        ("cooling", scene("discs = 50\nrestitution = 0.9")),
        ("cooling, unstable", scene("discs = 100\nwidth = 60.0\nheight = 60.0\nrestitution = 0.7")),
    ]
}

/// All scenes: the first ones, those that conserve more, those that count, and two that cool.
pub(crate) fn all_scenes(seeds: u32) -> Vec<Scene> {
    let [periodic, walls, _] = cooling_scenes(seeds);
    let lists =
        [scenes(seeds), conserving_scenes(seeds), counting_scenes(seeds), vec![periodic, walls]];
    lists.into_iter().flatten().collect()
}
