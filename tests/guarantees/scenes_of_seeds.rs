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

/// Scenes in which something that the run conserves, or the start, adds to the scatter: the rotation of gases, radii, and the
/// drift in a periodic box.
pub(crate) fn conserving_scenes(seeds: u32) -> Vec<Scene> {
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
    ]
}

/// A gas whose particles get lost, and a lattice whose discs move together.
pub(crate) fn further_scenes(seeds: u32) -> [Scene; 2] {
    let lattice = format!(
        "replicates = {seeds}\n[model.packing]\nplacement = \"lattice\"\nwidth = 17.0\nheight = 17.0\n"
    );
    [
        ("gas as printed", AS_PRINTED.replace("replicates = 8", &format!("replicates = {seeds}"))),
        ("lattice", lattice),
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
