//! Guarantee: `kinetoscope plot` draws the metrics of the recordings as SVG or PNG, the same bytes on every call, and rejects
//! what it cannot draw with the nearest name or the limit.

use crate::subcommand_bench::{Bench, Called, GAS, call};
use std::fs;

const SWEEP: &str = "seed = 1\nreplicates = 2\n[model.gas]\nparticles = 20\nduration_s = 0.001\n\
    [record]\nframes = 4\n[sweep]\nmodel.gas.temperature_k = [200, 300, 400]\n";

/// A sweep over two integrators, one of which has no error.
const ORBITS: &str = "[model.orbit]\nduration_days = 400\n[record]\nframes = 2\n[sweep]\nmodel.orbit.integrator = [\"rk4\", \"kepler\"]\n";

/// The recordings of a sweep over three temperatures.
fn sweep() -> Bench {
    let bench = Bench::new();
    bench.write("gas.toml", SWEEP);
    let ran = bench.call(&["run", "--quiet", "gas.toml"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    bench
}

/// Calls `plot` for the measured pressure over temperature with further arguments.
fn plot(bench: &Bench, further: &[&str]) -> Called {
    let command = ["plot", "recordings/gas", "--y", "pressure.measured"];
    bench.call(&[&command, further].concat())
}

/// Width and height in the header of a PNG.
fn size_of(png: &[u8]) -> [u32; 2] {
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()))
}

#[test]
fn plot_shows_the_metrics_of_the_analysis_with_errors_and_theory() {
    let bench = sweep();
    let analyzed = bench.call(&["analyze", "--json", "recordings/gas"]).json();
    let drawn = plot(&bench, &["--x", "temperature_k", "--json", "--output", "p.svg"]).json();
    let metrics = analyzed["experiments"][0]["analysis"]["metrics"].as_array().unwrap().clone();
    let means: Vec<_> = metrics
        .iter()
        .filter(|it| it["name"] == "pressure.measured" && it["run"].is_null())
        .collect();
    let curves = drawn["plot"]["curves"].as_array().unwrap();
    assert_eq!(
        (curves.len(), &curves[0]["style"], &curves[1]["style"]),
        (2, &"data".into(), &"theory".into())
    );
    let [data, theory] = [0, 1].map(|index| curves[index]["points"].as_array().unwrap());
    assert_eq!((data.len(), theory.len()), (3, 3));
    for (point, temperature) in data.iter().zip([200.0, 300.0, 400.0]) {
        assert_eq!(point["x"], temperature);
        let same = |mean: &&&serde_json::Value| mean["value"] == point["y"];
        let mean = means.iter().find(same).unwrap_or_else(|| panic!("{point} in {means:?}"));
        assert_eq!(mean["standard_error"], point["standard_error"]);
        assert!(theory.iter().any(|expected| expected["y"] == mean["theory"]["value"]));
    }
    let svg = fs::read_to_string(bench.path("p.svg")).unwrap();
    assert!(svg.contains("theory") && svg.contains("temperature (K)"), "{svg}");
    assert_eq!(svg.matches("<circle").count(), 4, "three points and the legend");
}

/// The plot in the report has the same bytes, whether or not the analysis has been cached.
#[test]
fn plots_do_not_depend_on_the_cache_and_are_the_same_on_every_call() {
    let bench = sweep();
    let first = plot(&bench, &[]);
    assert_eq!(first.code, Some(0), "{}", first.err);
    assert!(!bench.path("recordings/gas/.analysis-cache").exists());
    assert_eq!(bench.call(&["analyze", "--quiet", "recordings/gas"]).code, Some(0));
    assert_eq!(plot(&bench, &[]).out, first.out);
    assert_eq!(plot(&bench, &["--output", "one.png"]).code, Some(0));
    assert_eq!(plot(&bench, &["--output", "other.PNG"]).code, Some(0));
    assert_eq!(
        fs::read(bench.path("one.png")).unwrap(),
        fs::read(bench.path("other.PNG")).unwrap()
    );
}

#[test]
fn png_has_the_requested_pixels_and_its_text() {
    let bench = sweep();
    let pixels = |further: &[&str]| {
        let called = plot(&bench, &[further, &["--output", "p.png"]].concat());
        assert_eq!(called.code, Some(0), "{}", called.err);
        assert!(called.out.starts_with("written: p.png ("), "{}", called.out);
        fs::read(bench.path("p.png")).unwrap()
    };
    let plain = pixels(&[]);
    assert_eq!(size_of(&plain), [640, 490]);
    assert_eq!(size_of(&pixels(&["--scale", "2"])), [1280, 980]);
    let size = ["--width", "1000", "--height", "500", "--font-size", "20", "--scale", "1.5"];
    assert_eq!(size_of(&pixels(&size)), [1500, 750]);
    // Letters that no font has would all look alike: a box.
    let titled = |title: &str| pixels(&["--title", title]);
    let titles = ["p", "λ", "⟨v²⟩", "σ ≤ 10⁻³", "\u{e000}"].map(titled);
    for (index, one) in titles.iter().enumerate() {
        assert!(titles[..index].iter().all(|other| other != one), "title {index}");
    }
    assert_eq!(titled("\u{e000}"), titled("\u{e001}"), "control: unknown letters are a box");
}

/// A plot has several metrics of one unit on its axes, over a key, another metric, or a number that the variants set, and states the
/// number of a fit: the mean speed is proportional to the root of the temperature, and to the rms speed. Tolerance: rounding, because
/// all points share their random numbers.
#[test]
fn metrics_are_plotted_over_each_other_with_fits() {
    let bench = sweep();
    let drawn = |arguments: &[&str]| {
        let command = ["plot", "recordings/gas", "--json", "--output", "p.svg"];
        let called = bench.call(&[&command, arguments].concat());
        assert_eq!(called.code, Some(0), "{}", called.err);
        called.json()["plot"].clone()
    };
    let fitted = |plot: &serde_json::Value| {
        let curve = plot["curves"].as_array().unwrap().iter().find(|curve| {
            curve["style"] == "fit" && curve["name"].as_str().unwrap().contains("fit, exponent")
        });
        let name = curve.unwrap_or_else(|| panic!("{plot}"))["name"].as_str().unwrap();
        let number = name.split("exponent ").nth(1).unwrap().split('(').next().unwrap();
        number.parse::<f64>().unwrap()
    };
    let over_key = drawn(&["--y", "mean_speed", "--fit", "power"]);
    assert!((fitted(&over_key) - 0.5).abs() < 1e-6, "{over_key}");
    let over_metric = drawn(&["--y", "mean_speed", "--x", "rms_speed", "--fit", "power"]);
    assert!((fitted(&over_metric) - 1.0).abs() < 1e-6, "{over_metric}");
    assert_eq!(over_metric["x"]["name"], "root of the mean square speed");
    let two = drawn(&["--y", "mean_speed", "--y", "rms_speed"]);
    let is_data = |curve: &&serde_json::Value| curve["style"] == "data";
    assert_eq!(two["curves"].as_array().unwrap().iter().filter(is_data).count(), 2);
    let refused =
        bench.call(&["plot", "recordings/gas", "--y", "mean_speed", "--y", "pressure.measured"]);
    assert!(refused.err.contains("different units"), "{}", refused.err);
    let histogram = drawn(&["--figure", "speed_histogram", "--where", "temperature_k=300"]);
    assert_eq!(histogram["x"]["name"], "speed");
    let refused = bench.call(&["plot", "recordings/gas", "--figure", "speed_histgram"]);
    assert!(refused.err.contains("did you mean `speed_histogram`?"), "{}", refused.err);
}

#[test]
fn number_that_the_variants_set_is_an_axis() {
    let bench = Bench::new();
    let variant = |name: &str, radius: f64| {
        format!("[[sweep.variants]]\nname = \"{name}\"\nmodel.gas.radius_m = {radius}\n")
    };
    let base = "seed = 1\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n";
    bench.write("gas.toml", &format!("{base}{}{}", variant("small", 1.0), variant("large", 2.0)));
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    let command = ["--x", "radius_m", "--json", "--output", "p.svg"];
    let drawn = plot(&bench, &command).json();
    let points = drawn["plot"]["curves"][0]["points"].as_array().unwrap().clone();
    assert_eq!((&points[0]["x"], &points[1]["x"]), (&1.0.into(), &2.0.into()), "{drawn}");
    let refused = plot(&bench, &["--x", "radus_m"]);
    assert_eq!(refused.code, Some(2), "control: {}", refused.err);
}

/// A metric over words has a place for each, in the order of the sweep; with a number as well, each number has a curve.
#[test]
fn metric_is_plotted_over_words() {
    let bench = Bench::new();
    let words = SWEEP.replace("replicates = 2\n", "")
        + "model.gas.speed_distribution = [\"maxwell\", \"equal\", \"uniform\"]\n";
    bench.write("gas.toml", &words);
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    let drawn = plot(&bench, &["--x", "speed_distribution", "--json", "--output", "p.svg"]).json();
    let curves = drawn["plot"]["curves"].as_array().unwrap();
    let data: Vec<_> = curves.iter().filter(|curve| curve["style"] == "data").collect();
    assert_eq!(data.len(), 3, "one curve per temperature");
    for curve in data {
        let places = curve["points"].as_array().unwrap().iter().map(|point| &point["x"]);
        assert_eq!(places.collect::<Vec<_>>(), ["maxwell", "equal", "uniform"]);
    }
    let svg = fs::read_to_string(bench.path("p.svg")).unwrap();
    let at = |word: &str| svg.rfind(&format!(">{word}</text>")).unwrap_or_else(|| panic!("{svg}"));
    assert!(at("maxwell") < at("equal") && at("equal") < at("uniform"));
    let called = plot(&bench, &["--x", "speed_distribution", "--log-x"]);
    assert!(called.err.contains("are words, which have no logarithms"), "{}", called.err);
}

/// No point of a sweep is left out silently: numbers next to a table are words, an axis that contains 0 is linear
/// unless a logarithmic one is requested, and a value of 0 on a logarithmic axis is stated.
#[test]
fn every_point_is_drawn_or_stated() {
    let bench = Bench::new();
    bench.write(
        "mixed.toml",
        "[model.dem]\ndiscs = 4\nduration_s = 0.001\n[record]\nframes = 2\n\
         [sweep]\nmodel.dem.radius_m = [4e-4, { min = 4e-4, max = 6e-4 }, 5e-4]\n",
    );
    bench.write("orbit.toml", ORBITS);
    assert_eq!(bench.call(&["run", "--quiet", "mixed.toml", "orbit.toml"]).code, Some(0));
    let plot_with = |name: &str, y: &str, options: &[&str]| {
        let folder = format!("recordings/{name}");
        let command = ["plot", &folder, "--y", y, "--json", "--output", "p.svg"];
        let called = bench.call(&[&command, options].concat());
        assert_eq!(called.code, Some(0), "{}", called.err);
        (called.json(), fs::read_to_string(bench.path("p.svg")).unwrap())
    };
    let plot = |name: &str, y: &str| plot_with(name, y, &[]);
    let (mixed, _) = plot("mixed", "packing_fraction");
    let points = mixed["plot"]["curves"][0]["points"].as_array().unwrap();
    assert_eq!((points.len(), &points[0]["x"]), (3, &"0.0004".into()));
    // A run without the key of the horizontal axis.
    for (name, step) in [("a", "time_step_s = 1e-6"), ("b", "time_step_s = 2e-6"), ("c", "")] {
        let manifest =
            format!("[model.dem]\ndiscs = 4\nduration_s = 1e-4\n{step}\n[record]\nframes = 2\n");
        bench.write(&format!("{name}.toml"), &manifest);
        assert_eq!(bench.call(&["run", "--quiet", &format!("{name}.toml")]).code, Some(0));
        fs::create_dir_all(bench.path("recordings/all")).unwrap();
        let recording =
            crate::subcommand_bench::recordings(&bench.path(&format!("recordings/{name}")))
                .remove(0);
        fs::copy(&recording, bench.path(&format!("recordings/all/{name}.mcap"))).unwrap();
    }
    let called = bench.call(&[
        "plot",
        "recordings/all",
        "--y",
        "packing_fraction",
        "--x",
        "time_step_s",
        "--json",
        "--output",
        "p.svg",
    ]);
    assert_eq!(called.code, Some(0), "{}", called.err);
    assert_eq!(called.json()["plot"]["remark"], "1 of 3 points have no `time_step_s`");
    let (zero, svg) = plot("orbit", "position_error.final");
    assert_eq!(zero["plot"]["remark"], "", "an axis that contains 0 is linear");
    assert!(svg.contains("kepler</text>") && svg.contains(">0</text>"), "{svg}");
    let (zero, svg) = plot_with("orbit", "position_error.final", &["--log-y"]);
    let stated = "1 point at 0 or below: not on a logarithmic axis";
    assert_eq!(zero["plot"]["remark"], stated);
    assert!(svg.contains(stated) && svg.contains("kepler</text>"), "{svg}");
    let of_zero = ["plot", "recordings/orbit", "--y", "position_error.final", "--output", "p.svg"];
    assert_eq!(bench.call(&of_zero).err, "", "every point is drawn");
    assert_eq!(bench.call(&[&of_zero[..], &["--log-y"]].concat()).err, format!("note: {stated}\n"));
    let noted = format!("note: plot of `position_error.final`: {stated}");
    for (log, is_noted) in [("[\"y\"]", true), ("[]", false)] {
        let requested = format!("{ORBITS}[[plots]]\ny = \"position_error.final\"\nlog = {log}\n");
        bench.write("orbit.toml", &requested);
        assert_eq!(bench.call(&["run", "--quiet", "orbit.toml"]).code, Some(0));
        let analyzed = bench.call(&["analyze", "recordings/orbit"]);
        assert_eq!(analyzed.out.contains(&noted), is_noted, "{}", analyzed.out);
    }
}

/// Of one point, place, value and theory are stated, because theory is a line between points; of several replicates, which one is drawn.
#[test]
fn remark_states_what_a_plot_of_one_point_cannot_show() {
    let bench = sweep();
    let remark = |arguments: &[&str]| {
        let command = ["plot", "recordings/gas", "--json", "--output", "p.svg"];
        let drawn = bench.call(&[&command, arguments].concat()).json();
        drawn["plot"]["remark"].as_str().unwrap().to_owned()
    };
    let one_point = remark(&["--y", "mean_speed", "--where", "temperature_k=300"]);
    assert!(one_point.starts_with("temperature = 300 K: measured "), "{one_point}");
    assert!(one_point.contains(", theory "), "{one_point}");
    assert!(!remark(&["--y", "mean_speed"]).contains("measured"), "control");
    let field = ["--y", "/energy.kinetic_j"];
    assert_eq!(remark(&field), "one replicate of each point");
    // Of one point, the title states it.
    let one =
        ["plot", "recordings/gas", "--json", "--output", "p.svg", "--where", "temperature_k=300"];
    let drawn = bench.call(&[&one[..], &field].concat()).json();
    let title = drawn["plot"]["title"].as_str().unwrap();
    assert!(title.ends_with("(one of 2 replicates)"), "{title}");
}

#[test]
fn unknown_names_name_the_nearest() {
    let bench = sweep();
    let ask = |arguments: &[&str]| {
        let called = bench.call(&[&["plot", "recordings/gas"], arguments].concat());
        assert_eq!((called.code, called.out.as_str()), (Some(2), ""), "{}", called.err);
        called.err
    };
    for (arguments, help) in [
        (&["--y", "pressure.mesured"] as &[&str], "did you mean `pressure.measured`?"),
        (&["--y", "bed.height"], "`kinetoscope analyze --list-metrics` lists all metrics"),
        (&["--y", "energy.kinetic_j"], "a field of a channel is written `/energy.kinetic_j`"),
        (&["--y", "/energy.kinetik_j"], "did you mean `/energy.kinetic_j`?"),
        (&["--y", "/energy.x"], "fields: /energy.kinetic_j, "),
        (&["--y", "/speeds.density"], "fields: "),
        (&["--y", "mean_speed", "--x", "temprature_k"], "did you mean `temperature_k`?"),
        (&["--y", "mean_speed", "--x", "time"], "name one of: temperature_k"),
        (&["--y", "/energy.kinetic_j", "--x", "temperature_k"], "or name `time`"),
        (&["--y", "mean_speed", "--where", "temperature_k=250"], "values: 200, 300, 400"),
        (
            &["--y", "mean_speed", "--where", "radius_m=1"],
            "name a key in which the recordings differ",
        ),
        (&["--y", "energy.drift_relative", "--log-y", "--where", "temperature_k=200"], "linear"),
    ] {
        let said = ask(arguments);
        let (error, rest) = said.split_once("\nhelp: ").unwrap_or_else(|| panic!("{said}"));
        assert!(error.starts_with("error: ") && rest.contains(help), "{arguments:?}: {said}");
    }
}

#[test]
fn sizes_beyond_the_limits_are_rejected() {
    let bench = sweep();
    for (arguments, limit) in [
        (&["--width", "100000"] as &[&str], "from 100 to 10000"),
        (&["--height=-1"], "from 100 to 10000"),
        (&["--scale", "1e9", "--output", "p.png"], "from 0.5 to 8"),
        (&["--font-size", "NaN"], "from 6 to 400"),
        (&["--width", "9000", "--height", "9000", "--output", "p.png"], "at most 40 million"),
        (&["--width", "300"], "must be at least 400 px"),
        (&["--height", "150"], "must be at least"),
        (&["--scale", "2"], "applies to a .png"),
        (&["--output", "p.jpg"], "neither a .svg nor a .png"),
        (&["--json"], "--output"),
    ] {
        let called = plot(&bench, arguments);
        assert_eq!(called.code, Some(2), "{arguments:?}: {}", called.err);
        assert!(called.err.contains(limit) && called.err.contains("\nhelp: "), "{}", called.err);
    }
    assert!(!bench.path("p.png").exists());
}

#[test]
fn recordings_that_make_no_plot_are_rejected() {
    let bench = sweep();
    let rejected = |arguments: &[&str], message: &str| {
        let called = bench.call(&[&["plot"], arguments].concat());
        assert_eq!(called.code, Some(2), "{arguments:?}: {}", called.err);
        assert!(called.err.contains(message), "{arguments:?}: {}", called.err);
    };
    fs::create_dir(bench.path("empty")).unwrap();
    rejected(&["empty", "--y", "mean_speed"], "empty");
    rejected(&["missing", "--y", "mean_speed"], "does not exist");
    bench.write("one.toml", GAS);
    bench.write("orbit.toml", "[model.orbit]\nduration_days = 10\n[record]\nframes = 2\n");
    assert_eq!(bench.call(&["run", "--quiet", "one.toml", "orbit.toml"]).code, Some(0));
    rejected(
        &["recordings/one", "--y", "mean_speed"],
        "a plot of a metric needs recordings of a sweep",
    );
    rejected(&["recordings", "--y", "mean_speed"], "recordings of one folder; found 3");
    // A folder with recordings of two models, without the record of an experiment.
    fs::create_dir(bench.path("mixed")).unwrap();
    for folder in ["recordings/one", "recordings/orbit"] {
        for recording in crate::subcommand_bench::recordings(&bench.path(folder)) {
            let name = recording.file_name().unwrap();
            fs::copy(&recording, bench.path("mixed").join(name)).unwrap();
        }
    }
    rejected(&["mixed", "--y", "mean_speed"], "two models, gas and orbit");
    // One run has a plot over time.
    let over_time = bench.call(&["plot", "recordings/one", "--y", "/energy.kinetic_j"]);
    assert_eq!(over_time.code, Some(0), "{}", over_time.err);
    assert!(over_time.out.contains("time (") && over_time.out.starts_with("<svg"));
}

/// A damaged recording is named and the others are drawn.
#[test]
fn damaged_recording_gives_exit_code_5_and_a_plot_of_the_others() {
    let bench = sweep();
    let all = crate::subcommand_bench::recordings(&bench.path("recordings/gas"));
    fs::write(&all[0], "no recording").unwrap();
    fs::write(&all[1], "no recording").unwrap();
    let called = plot(&bench, &["--output", "p.svg", "--json"]);
    assert_eq!(called.code, Some(5), "{}", called.err);
    assert!(called.err.contains(all[0].file_name().unwrap().to_str().unwrap()), "{}", called.err);
    let points = called.json()["plot"]["curves"][0]["points"].as_array().unwrap().len();
    assert_eq!(points, 2, "the point without recordings is a gap, not a zero");
}

#[test]
fn output_is_replaced_as_a_whole_or_not_at_all() {
    let bench = sweep();
    let missing = plot(&bench, &["--output", "no/folder/p.svg"]);
    assert_eq!(missing.code, Some(2), "{}", missing.err);
    assert!(missing.err.contains("a folder that does not exist\nhelp: create"), "{}", missing.err);
    fs::create_dir(bench.path("folder.svg")).unwrap();
    let folder = plot(&bench, &["--output", "folder.svg"]);
    assert_eq!(folder.code, Some(2), "{}", folder.err);
    assert!(folder.err.contains("or name another file\n"), "{}", folder.err);
    bench.write("p.svg", "old");
    assert_eq!(plot(&bench, &["--quiet", "--output", "p.svg"]).out, "");
    let svg = fs::read_to_string(bench.path("p.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"), "{svg}");
    #[cfg(target_os = "linux")]
    {
        std::os::unix::fs::symlink("/dev/full", bench.path("full.svg")).unwrap();
        assert_eq!(plot(&bench, &["--output", "full.svg"]).code, Some(75));
    }
}

/// Markup in names of the command line and of manifests is shown as text.
#[test]
fn markup_in_names_is_escaped() {
    let bench = Bench::new();
    let variants =
        "[[sweep.variants]]\nname = \"<script>&\\u0007\"\n[[sweep.variants]]\nname = \"b\"\n";
    bench.write("gas.toml", &format!("{SWEEP}{variants}"));
    assert_eq!(bench.call(&["run", "--quiet", "gas.toml"]).code, Some(0));
    let title = "</text><image href=\"/etc/passwd\"/>\n\u{1b}[31m";
    for output in ["p.svg", "p.png"] {
        let called = plot(&bench, &["--title", title, "--output", output]);
        assert_eq!(called.code, Some(0), "{}", called.err);
    }
    let svg = fs::read_to_string(bench.path("p.svg")).unwrap();
    assert!(svg.contains("&lt;script&gt;&amp;") && svg.contains("&lt;image"), "{svg}");
    assert!(!svg.contains("<image") && !svg.contains('\u{1b}') && !svg.contains('\u{7}'));
}

/// The three commands of the README draw the shipped sweep.
#[test]
fn shipped_experiment_is_plotted_in_three_commands() {
    let bench = Bench::new();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let manifest = format!("{root}/experiments/gas_pressure_vs_temperature.toml");
    let text = fs::read_to_string(manifest).unwrap();
    bench.write("gas_pressure_vs_temperature.toml", &text);
    let readme = fs::read_to_string(format!("{root}/README.md")).unwrap();
    let (_, after) = readme.split_once("## A first plot\n").unwrap();
    let commands: Vec<&str> =
        after.lines().filter_map(|line| line.strip_prefix("    ")).take(3).collect();
    let called = |line: &str| {
        let line = line.split('#').next().unwrap().replace("experiments/", "");
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[0], "kinetoscope", "{line}");
        let short = ["--set", "model.gas.particles=20", "--set", "replicates=2", "--quiet"];
        let further = if words[1] == "run" { &short[..] } else { &[] };
        let called = bench.call(&[&words[1..], further].concat());
        assert_eq!(called.code, Some(0), "{line}: {}", called.err);
    };
    assert_eq!(commands.len(), 3);
    commands.iter().for_each(|line| called(line));
    assert_eq!(size_of(&fs::read(bench.path("p_vs_t.png")).unwrap()), [1280, 980]);
    assert_eq!(call(["plot", "--help"]).code, Some(0));
}

#[test]
fn files_that_are_not_recordings_are_errors_with_help() {
    let bench = Bench::new();
    for name in ["a.txt", "b.mcap"] {
        bench.write(name, "no recording");
        let called = bench.call(&["plot", name, "--y", "pressure.measured"]);
        assert_eq!(called.code, Some(5), "{}", called.err);
        assert!(called.err.starts_with("error: "), "{}", called.err);
        assert!(called.err.contains("\nhelp: name a recording"), "{}", called.err);
    }
}
