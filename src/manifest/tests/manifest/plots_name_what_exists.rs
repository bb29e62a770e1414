//! Guarantee: `[[plots]]` names metrics, channels and swept keys that exist, and a wrong name is reported at its place with the
//! nearest right one. Plots do not affect the run key.

// A test may panic.
#![allow(clippy::unwrap_used)]

use crate::verdicts::{experiment, rejected};
use kinetoscope_manifest::{
    ExperimentRecord, Lookup, Override, PlotAxis, PlotFit, PlotRequest, channel_field, parse,
    parse_run, parse_with, run_key,
};

const SWEEP: &str = "[model.gas]\n[record]\nchannels = [\"state\", \"pressure\"]\n[sweep]\n\
    model.gas.temperature_k = [200, 300]\nmodel.gas.speed_distribution = [\"maxwell\", \"uniform\"]\n";

/// The plots of a manifest with a sweep over a number and a word.
fn accepted(plots: &str) -> Vec<PlotRequest> {
    experiment(&format!("{SWEEP}{plots}")).plots
}

#[test]
fn plot_of_a_metric_is_over_the_full_name_of_the_swept_number() {
    let plots = accepted(
        "[[plots]]\ny = \"mean_speed\"\n[[plots]]\ny = \"pressure.measured\"\nx = \"temperature_k\"\n\
         title = \"p\"\nlog = [\"y\"]\nwhere = { speed_distribution = \"uniform\" }\n\
         [[plots]]\ny = \"/pressure.measured_n_per_m\"\nx = \"time\"\nlog = []\n",
    );
    let key = Some("model.gas.temperature_k".to_owned());
    assert_eq!(plots.iter().map(|plot| plot.line).collect::<Vec<_>>(), [7, 9, 15]);
    assert_eq!((&plots[0].x, &plots[1].x), (&key, &key));
    assert_eq!(plots[1].log, Some(vec![PlotAxis::Y]));
    assert_eq!(plots[1].title.as_deref(), Some("p"));
    assert_eq!(plots[1].at[0].0, "model.gas.speed_distribution");
    assert_eq!(channel_field(&plots[2].y), Some(("/pressure", "measured_n_per_m")));
    assert_eq!((plots[0].log.as_ref(), plots[2].log.as_ref()), (None, Some(&vec![])));
    assert_eq!(channel_field(&plots[0].y), None);
}

/// Control: a word and a key that only one variant sets to a word are rejected.
#[test]
fn plot_is_over_a_number_that_the_variants_set() {
    let variant = |name: &str, distribution: &str, radius: f64| {
        format!(
            "[[sweep.variants]]\nname = \"{name}\"\nmodel.gas.radius_m = {radius:?}\n\
             model.gas.speed_distribution = \"{distribution}\"\n"
        )
    };
    let variants = variant("narrow", "maxwell", 1.0) + &variant("wide", "uniform", 2.0);
    let text = |x: &str| {
        format!("[model.gas]\n{variants}[[plots]]\ny = \"mean_speed\"\nx = \"{x}\" # <-\n")
    };
    for x in ["radius_m", "model.gas.radius_m"] {
        let plots = experiment(&text(x)).plots;
        assert_eq!(plots[0].x.as_deref(), Some("model.gas.radius_m"));
    }
    assert_eq!(experiment(&text("variant")).plots[0].x.as_deref(), Some("variant"));
    rejected(&text("speed_distribution"), "is neither swept nor a metric");
}

#[test]
fn wrong_names_of_a_plot_are_reported_with_the_nearest() {
    let plot = |text: &str| format!("{SWEEP}[[plots]]\n{text}");
    for (text, message) in [
        ("y = \"pressure.mesured\" # <-", "did you mean `pressure.measured`?"),
        ("y = \"zzz\" # <-", "`kinetoscope analyze --list-metrics` lists all metrics"),
        ("y = \"\" # <-", "must not be empty"),
        ("y = \"pressure.window_s\" # <-", "is written `/pressure.window_s`"),
        ("y = \"pressure.window_s\\u001b\" # <-", "is written `/pressure.window_s\\u{1b}`"),
        ("y = \"/presure.window_s\" # <-", "did you mean `/pressure`?"),
        ("y = \"/pressure\" # <-", "must be `/CHANNEL.FIELD`"),
        ("y = \"/energy.kinetic_j\" # <-", "add \"energy\" to `record.channels`"),
        ("y = \"/pressure.window_s\"\nx = \"temperature_k\" # <-", "must be `time`"),
        ("y = \"mean_speed\"\nx = \"temprature_k\" # <-", "did you mean `temperature_k`?"),
        (
            "y = \"mean_speed\"\nx = \"time\" # <-",
            "must be one of model.gas.temperature_k, model.gas.speed_distribution",
        ),
        ("y = \"mean_speed\"\nwhere = { radius_m = 1 } # <-", "`radius_m` is not swept"),
        ("y = \"mean_speed\"\nwhere = { temperature_k = 1 } # <-", "values: 200, 300"),
        ("y = \"mean_speed\"\nlog = [\"z\"] # <-", "unknown value \"z\""),
        ("y = \"mean_speed\"\nfit = \"cubic\" # <-", "unknown value \"cubic\""),
        ("y = \"mean_speed\"\nx = \"mean_sped\" # <-", "did you mean `mean_speed`?"),
        ("y = \"mean_speed\"\nalso = [\"mean_sped\"] # <-", "did you mean `mean_speed`?"),
        ("figure = \"a\"\ny = \"mean_speed\" # <-", "the model's chart has axes of its own"),
        ("y = \"mean_speed\"\ntitle = \" \" # <-", "leave it out"),
        ("y = \"mean_speed\"\ntitel = \"t\" # <-", "did you mean `title`?"),
    ] {
        rejected(&plot(text), message);
    }
    rejected(&format!("{SWEEP}[[plots]] # <-\nx = \"temperature_k\"\n"), "needs `y`");
    rejected("[model.gas]\n[[plots]] # <-\ny = \"mean_speed\"\n", "such as `/energy.kinetic_j`");
    rejected(
        "[model.gas]\n[sweep]\nmodel.gas.temperature_k = [1, 2]\nmodel.gas.radius_m = [1, 2]\n\
         [[plots]] # <-\ny = \"mean_speed\"\n",
        "must be one of model.gas.temperature_k, model.gas.radius_m",
    );
    rejected(
        "[model.gas]\n[sweep]\nmodel.gas.speed_distribution = [\"maxwell\", \"equal\"]\n\
         model.gas.temperature_definition = [\"mean-speed\", \"mean-square\"]\n\
         [[plots]] # <-\ny = \"mean_speed\"\n",
        "must be one of model.gas.speed_distribution, model.gas.temperature_definition",
    );
    // Control: the second key of a pair is not an axis of its own.
    let paired = "[model.gas]\n[sweep]\nzip = [[\"model.gas.temperature_k\", \"model.gas.radius_m\"]]\n\
        model.gas.temperature_k = [1, 2]\nmodel.gas.radius_m = [1, 2]\n[[plots]]\ny = \"mean_speed\"\n";
    let x = experiment(paired).plots[0].x.clone();
    assert_eq!(x.as_deref(), Some("model.gas.temperature_k"));
}

/// A plot may have another metric as its axis, several metrics, fits and power laws, or be a chart of the model; its record has all of
/// them.
#[test]
fn plot_of_a_metric_over_another_or_of_the_model_is_recorded() {
    let plots = "[[plots]]\ny = \"mean_speed\"\nalso = [\"a2\"]\nx = \"pressure.measured\"\nfit = \"power\"\n\
        exponents = [0.5, -2]\n[[plots]]\nfigure = \"speed_histogram\"\nwhere = { temperature_k = 200 }\n";
    let experiment = experiment(&format!("{SWEEP}{plots}"));
    let [metrics, chart] = experiment.plots.as_slice() else { panic!("{:?}", experiment.plots) };
    assert_eq!(metrics.ordinates().collect::<Vec<_>>(), ["mean_speed", "a2"]);
    assert_eq!(
        (metrics.x.as_deref(), metrics.fit),
        (Some("pressure.measured"), Some(PlotFit::Power))
    );
    assert_eq!(metrics.exponents.iter().map(|it| it.get()).collect::<Vec<_>>(), [0.5, -2.0]);
    assert_eq!((chart.subject(), chart.ordinates().count()), ("speed_histogram", 0));
    let text = ExperimentRecord::new(&experiment, []).to_toml();
    let back = ExperimentRecord::from_toml(&text, "experiment.toml").unwrap();
    let without_lines = |plot: &PlotRequest| PlotRequest { line: 0, ..plot.clone() };
    assert_eq!(
        back.plots,
        experiment.plots.iter().map(without_lines).collect::<Vec<_>>(),
        "{text}"
    );
}

#[test]
fn unknown_chart_of_the_model_names_the_nearest() {
    let lookup =
        Lookup { figures: Some(|_| vec!["speed_histogram", "h_over_time"]), ..Lookup::default() };
    let errors = |figure: &str| {
        let text = format!("[model.gas]\n[[plots]]\nfigure = \"{figure}\"\n");
        parse_with(&text, "m.toml", &[], lookup).map(|_| ()).map_err(|errors| errors.to_string())
    };
    let near = errors("speed_histogramm").unwrap_err();
    assert!(near.contains("did you mean `speed_histogram`?"), "{near}");
    assert!(errors("zzz").unwrap_err().contains("must be one of speed_histogram, h_over_time"));
    assert_eq!(errors("speed_histogram"), Ok(()), "control");
}

/// Words are an axis on request, and where the sweep has no number.
#[test]
fn metric_is_plotted_over_words() {
    let plots = accepted("[[plots]]\ny = \"mean_speed\"\nx = \"speed_distribution\"\n");
    assert_eq!(plots[0].x.as_deref(), Some("model.gas.speed_distribution"));
    let words = "[model.gas]\n[sweep]\nmodel.gas.speed_distribution = [\"maxwell\", \"equal\"]\n\
        [[plots]]\ny = \"mean_speed\"\n";
    let plots = experiment(words).plots;
    assert_eq!(plots[0].x.as_deref(), Some("model.gas.speed_distribution"));
}

#[test]
fn plots_do_not_affect_the_run_key_and_cannot_be_set() {
    let with = "[model.gas]\n[[plots]]\ny = \"/energy.kinetic_j\"\ntitle = \"t\"\n";
    let key = |text: &str| run_key(&parse_run(text).unwrap().canonical(), 1, 1);
    assert_eq!(key(with), key("[model.gas]\n"));
    let set = [Override { key: "plots".to_owned(), value: "[]".to_owned() }];
    let errors = parse("[model.gas]\n", "m.toml", &set).unwrap_err().to_string();
    assert!(errors.contains("`plots` cannot be set"), "{errors}");
}

#[test]
fn record_of_an_experiment_contains_its_plots() {
    let plots = "[[plots]]\ny = \"/pressure.window_s\"\ntitle = \"a \\\"b\\\" <c>\"\nlog = []\n\
        [[plots]]\ny = \"mean_speed\"\nlog = [\"x\", \"y\"]\nwhere = { temperature_k = 200 }\n";
    let experiment = experiment(&format!("{SWEEP}{plots}"));
    let text = ExperimentRecord::new(&experiment, []).to_toml();
    let back = ExperimentRecord::from_toml(&text, "experiment.toml").unwrap();
    let without_lines = |plots: &[PlotRequest]| -> Vec<PlotRequest> {
        plots.iter().map(|plot| PlotRequest { line: 0, ..plot.clone() }).collect()
    };
    assert_eq!(without_lines(&back.plots), without_lines(&experiment.plots), "{text}");
    assert_eq!(back.plots.len(), 2);
}

#[test]
fn more_than_a_hundred_plots_are_rejected() {
    let plots = |count| "[[plots]]\ny = \"mean_speed\"\n".repeat(count);
    assert_eq!(accepted(&plots(100)).len(), 100);
    let marked = format!("{SWEEP}{}[[plots]] # <-\ny = \"mean_speed\"\n", plots(100));
    rejected(&marked, "101 plots are requested; must be at most 100");
}

#[test]
fn more_than_seven_reference_lines_are_rejected() {
    let plot = |count: usize, mark: &str| {
        let exponents = vec!["1"; count].join(", ");
        format!("{SWEEP}[[plots]]\ny = \"mean_speed\"\nexponents = [{exponents}]{mark}\n")
    };
    rejected(&plot(8, " # <-"), "must have at most 7");
    experiment(&plot(7, ""));
}
