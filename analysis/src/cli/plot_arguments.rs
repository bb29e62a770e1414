//! The command `kinetoscope plot`: one plot from the recordings of an experiment, as SVG or PNG.

use super::exit::CommandError;
use super::meant_paths::meant_paths;
use super::messages::{complain_unreadable, concluded};
use super::plotted_names::{check_names, check_places};
use crate::input::recording::{self, OpenRun};
use crate::input::{self, OpenedRuns, RecordingFolder, UnreadableRecording};
use crate::metric_files::rows_of_folder;
use crate::plot::png::png;
use crate::plot::{ChartSize, Plot, PlotContent, Point};
use crate::run::cache::AnalysisCache;
use crate::run::fields::names;
use crate::run::{self, RunAnalysis, RunOptions, RunStatus};
use crate::sweep::requested::{PlotData, fields_to_read};
use crate::sweep::samples::Abscissa;
use crate::sweep::{fits, points};
use crate::write_file;
use kinetoscope_console::Message;
use kinetoscope_console::text::{plural, shown_path};
use kinetoscope_console::{Exit, StandardOutput, complain};
use kinetoscope_files::folder::folder_of;
use kinetoscope_manifest::{Axis as SweptAxis, Coordinate, PlotAxis, PlotFit, PlotRequest};
use rayon::iter::{IndexedParallelIterator as _, IntoParallelIterator as _, ParallelIterator as _};
use serde_json::{Value, json};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Draw one plot from the recordings of an experiment: metrics over a swept key or over another metric, fields of channels over time,
/// or a chart of the model.
#[derive(Debug, clap::Args)]
pub struct PlotArguments {
    /// Recordings of one experiment, or their folder
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Metric, such as bed.height (with its standard error and, if there is one, its theoretical value), or field of a recorded
    /// channel, such as /energy.kinetic_j; can be repeated for the same axes
    #[arg(long, value_name = "NAME", required_unless_present = "figure", help_heading = "Plot")]
    y: Vec<String>,
    /// Chart that the analysis of the model draws, such as energy_balance, in place of --y
    #[arg(long, value_name = "NAME", conflicts_with_all = ["y", "x", "fit", "log_x", "log_y", "linear"], help_heading = "Plot")]
    figure: Option<String>,
    /// Function that is fitted to each curve by least squares; its exponent or slope is stated
    #[arg(long, value_name = "FUNCTION", value_parser = fit, help_heading = "Plot")]
    fit: Option<PlotFit>,
    /// Swept key, number that the variants of a sweep set, metric, or `time` for a field of a channel [default: the only swept number,
    /// else the only swept key, or time]
    #[arg(long, value_name = "KEY", help_heading = "Plot")]
    x: Option<String>,
    /// Show only the points of the sweep with this value of a key; can be repeated
    #[arg(long = "where", value_name = "KEY=VALUE", value_parser = place, help_heading = "Plot")]
    at: Vec<(String, String)>,
    /// Title [default: the names of both quantities]
    #[arg(long, value_name = "TEXT", help_heading = "Plot")]
    title: Option<String>,
    /// Draw a logarithmic horizontal axis [default: by the range of the values]
    #[arg(long, help_heading = "Plot")]
    log_x: bool,
    /// Draw a logarithmic vertical axis [default: by the range of the values]
    #[arg(long, help_heading = "Plot")]
    log_y: bool,
    /// Draw linear axes whatever the range of the values
    #[arg(long, conflicts_with_all = ["log_x", "log_y"], help_heading = "Plot")]
    linear: bool,
    /// File for the plot, a .svg or .png [default: SVG to standard output]
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Width, from 100 to 10000 [default: 640]
    #[arg(long, value_name = "PX", value_parser = side, help_heading = "Output")]
    width: Option<u32>,
    /// Height, from 100 to 10000 [default: 49/64 of the width, or what title and legend need]
    #[arg(long, value_name = "PX", value_parser = side, help_heading = "Output")]
    height: Option<u32>,
    /// Size of the letters, from 6 to 400 [default: 16]
    #[arg(long, value_name = "PX", value_parser = font_size, help_heading = "Output")]
    font_size: Option<f64>,
    /// Pixels of a .png per px of width and height, from 0.5 to 8 [default: 1]
    #[arg(long, value_name = "NUMBER", value_parser = scale, help_heading = "Output")]
    scale: Option<f64>,
    /// Print errors only
    #[arg(long, short, help_heading = "Messages")]
    quiet: bool,
    /// Print the written file and the drawn points as JSON
    #[arg(long, requires = "output", help_heading = "Messages")]
    json: bool,
    #[arg(skip)]
    standard_output: StandardOutput,
}

/// Maximum number of pixels of a PNG; each takes four bytes of memory, and three more while it is encoded.
const MAX_PIXELS: f64 = 4e7;

/// The kind of file that is written.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    Svg,
    Png,
}

impl PlotArguments {
    /// Draws the plot and writes it.
    #[must_use]
    pub fn execute(&self) -> Exit {
        concluded(self.draw(), &self.standard_output, self.json)
    }

    fn draw(&self) -> Result<Exit, CommandError> {
        let format = self.format()?;
        let size = ChartSize::new(self.width, self.height, self.font_size);
        let size = size.map_err(CommandError::usage)?;
        let scale = self.scale.unwrap_or(1.0);
        if format == Format::Png && size.pixels(scale) > MAX_PIXELS {
            return Err(CommandError::usage(Message::new(
                format!(
                    "the image has {:.0} million pixels; must be at most {:.0} million",
                    size.pixels(scale) / 1e6,
                    MAX_PIXELS / 1e6
                ),
                "reduce --width, --height or --scale",
            )));
        }
        let mut source = self.source()?;
        let is_table = source.is_table && source.files.is_empty();
        let drawn = if is_table { self.plot_of_table(&mut source) } else { self.plot(&source) };
        let (plot, mut unreadable) = drawn?;
        let svg = plot.svg_of(Some(size)).map_err(|error| CommandError::usage(error.0))?;
        let svg = svg.ok_or_else(|| CommandError::usage("there is no point to draw"))?;
        match (&self.output, format) {
            (None, _) => self.standard_output.print_exactly(&svg),
            (Some(file), Format::Svg) => self.write(file, svg.as_bytes())?,
            (Some(file), Format::Png) => {
                self.write(file, &png(&svg, scale).map_err(|error| CommandError::usage(error.0))?)?;
            }
        }
        if let Some(hidden) = plot.hidden_data().filter(|_| !self.quiet) {
            complain(&format!("note: {hidden}"), false);
        }
        unreadable.dedup();
        unreadable.iter().for_each(complain_unreadable);
        let exit = UnreadableRecording::exit(&unreadable).unwrap_or(Exit::Done);
        if self.json {
            let document = json!({ "exit_code": exit.code(), "plot": self.described(&plot) });
            self.standard_output.print_json(&format!("{document:#}\n"));
        }
        Ok(exit)
    }

    fn format(&self) -> Result<Format, CommandError> {
        let Some(file) = &self.output else { return self.svg() };
        match file.extension().and_then(|end| end.to_str()).map(str::to_lowercase).as_deref() {
            _ if !is_in_a_folder(file) => Err(CommandError::usage(Message::new(
                format!("{} is in a folder that does not exist", shown_path(file)),
                "create the folder, or name another file with --output",
            ))),
            Some("png") => Ok(Format::Png),
            Some("svg") => self.svg(),
            _ => Err(CommandError::usage(Message::new(
                format!("{} is neither a .svg nor a .png", shown_path(file)),
                "name a file with one of these endings",
            ))),
        }
    }

    /// The format SVG, which has no pixels.
    fn svg(&self) -> Result<Format, CommandError> {
        if self.scale.is_some() {
            return Err(CommandError::usage(Message::new(
                "`--scale` applies to a .png",
                "name one with --output, or use --width and --font-size",
            )));
        }
        Ok(Format::Svg)
    }

    fn write(&self, file: &Path, content: &[u8]) -> Result<(), CommandError> {
        write_file::write(file, content)?;
        if !self.quiet && !self.json {
            let size = content.len().div_ceil(1000);
            self.standard_output.print(&format!("written: {} ({size} kB)\n", shown_path(file)));
        }
        Ok(())
    }

    /// The one experiment among the paths.
    fn source(&self) -> Result<RecordingFolder, CommandError> {
        let (mut sources, unlisted): (Vec<_>, Vec<_>) =
            input::sources_and_tables(&meant_paths(&self.paths)?)?
                .into_iter()
                .partition(|source| !source.files.is_empty() || source.is_table);
        let unlisted: Vec<UnreadableRecording> =
            unlisted.into_iter().flat_map(|folder| folder.unreadable).collect();
        match (sources.pop(), sources.as_slice()) {
            (Some(mut only), []) => {
                only.unreadable.extend(unlisted);
                Ok(only)
            }
            (None, _) => Err(CommandError::all_unreadable(&unlisted)),
            (last, others) => {
                let folders = others.iter().chain(&last).map(|it| shown_path(&it.folder));
                let folders: Vec<String> = folders.take(5).collect();
                Err(CommandError::usage(Message::new(
                    format!(
                        "a plot shows the recordings of one folder; found {}",
                        others.len() + usize::from(last.is_some())
                    ),
                    format!("name one of: {}", folders.join(", ")),
                )))
            }
        }
    }

    /// The plot, and what could not be read.
    fn plot(
        &self,
        source: &RecordingFolder,
    ) -> Result<(Plot, Vec<UnreadableRecording>), CommandError> {
        let OpenedRuns { runs: opened, unreadable: unopened, .. } =
            source.opened(recording::opened);
        let mut unreadable = [source.unreadable.as_slice(), &unopened].concat();
        let request = self.request();
        let Some((first, _)) = opened.first() else {
            return Err(CommandError::all_unreadable(&unreadable));
        };
        let model = first.manifest.model.name();
        if let Some((other, _)) = opened.iter().find(|(run, _)| run.manifest.model.name() != model)
        {
            return Err(CommandError::usage(Message::new(
                format!(
                    "the recordings are of two models, {model} and {}",
                    other.manifest.model.name()
                ),
                "name the recordings of one",
            )));
        }
        // Without a readable frame, no field has a name; the error is that of the recording.
        let fields = names(first.recording()).unwrap_or_default();
        check_names(&request, model, &fields).map_err(CommandError::usage)?;
        let places: Vec<Vec<Coordinate>> = opened.iter().map(|(_, place)| place.clone()).collect();
        check_places(&request, &places).map_err(CommandError::usage)?;
        let axes = source.record.as_ref().map_or(&[][..], |record| &record.axes);
        if !request.is_of_channel() && request.figure.is_none() {
            let manifests = opened.iter().map(|(run, _)| &run.manifest);
            let found = Abscissa::find(request.x.as_deref(), &places, axes, manifests);
            found.map_err(CommandError::usage)?;
        }
        let fields = fields_to_read(std::slice::from_ref(&request), &places);
        let tasks = opened.into_iter().zip(fields).filter(|((_, coordinates), fields)| {
            request.selects(coordinates) && (!request.is_of_channel() || !fields.is_empty())
        });
        let mut runs = Vec::new();
        let has_figures = request.figure.is_some();
        for read in read_all(tasks.collect(), &source.folder, has_figures) {
            match read {
                Ok(run) => runs.push(run),
                Err(why) => unreadable.push(why),
            }
        }
        self.say_about(&runs, &mut unreadable);
        drawn(&request, &runs, &places, axes, unreadable)
    }

    /// The plot of metrics of runs that have no recordings, but rows in a table.
    fn plot_of_table(
        &self,
        source: &mut RecordingFolder,
    ) -> Result<(Plot, Vec<UnreadableRecording>), CommandError> {
        let request = self.request();
        if request.is_of_channel() || request.figure.is_some() {
            let folder = shown_path(&source.folder);
            return Err(CommandError::usage(Message::new(
                format!("{folder} has no recordings, whose frames this plot needs"),
                format!(
                    "write those of some runs: kinetoscope restore {folder} --where 'replicate = 0'; or plot a metric over a swept key"
                ),
            )));
        }
        let (mut runs, _) = rows_of_folder(source, &[]);
        let Some(first) = runs.first() else {
            return Err(CommandError::all_unreadable(&source.unreadable));
        };
        check_names(&request, first.manifest.model.name(), &[]).map_err(CommandError::usage)?;
        let places: Vec<Vec<Coordinate>> = runs.iter().map(|run| run.coordinates.clone()).collect();
        check_places(&request, &places).map_err(CommandError::usage)?;
        let axes = source.record.as_ref().map_or(&[][..], |record| &record.axes);
        let manifests = runs.iter().map(|run| &run.manifest);
        let found = Abscissa::find(request.x.as_deref(), &places, axes, manifests);
        found.map_err(CommandError::usage)?;
        runs.retain(|run| request.selects(&run.coordinates));
        let mut unreadable = source.unreadable.clone();
        self.say_about(&runs, &mut unreadable);
        drawn(&request, &runs, &places, axes, unreadable)
    }

    /// Prints which runs a plot of a metric omits.
    fn say_about(&self, runs: &[RunAnalysis], unreadable: &mut Vec<UnreadableRecording>) {
        for run in runs {
            match &run.ending {
                RunStatus::Complete => {}
                RunStatus::Damaged(why) => unreadable.push(why.clone().into()),
                other if !self.quiet => {
                    let (word, frames) = (other.word(), plural(run.frames, "frame"));
                    complain(&format!("note: {}: {word} after {frames}", run.file), false);
                }
                _ => {}
            }
        }
    }

    fn request(&self) -> PlotRequest {
        let logarithmic = [(self.log_x, PlotAxis::X), (self.log_y, PlotAxis::Y)];
        let log: Vec<PlotAxis> =
            logarithmic.iter().filter(|(is_log, _)| *is_log).map(|(_, axis)| *axis).collect();
        PlotRequest {
            y: self.y.first().cloned().unwrap_or_default(),
            also: self.y.iter().skip(1).cloned().collect(),
            figure: self.figure.clone(),
            x: self.x.clone(),
            fit: self.fit,
            exponents: Vec::new(),
            title: self.title.clone(),
            log: (self.linear || !log.is_empty()).then_some(log),
            at: self.at.clone(),
            line: 0,
        }
    }

    /// The drawn points and the written file.
    fn described(&self, plot: &Plot) -> Value {
        let PlotContent::Chart(chart) = &plot.content else { return Value::Null };
        let x_of = |point: &Point| {
            let word = chart.x.words.get(point.x as usize);
            word.map_or_else(|| json!(point.x), |word| json!(word))
        };
        let curves = chart.curves.iter().map(|curve| {
            let points = curve.points.iter().map(
                |point| json!({ "x": x_of(point), "y": point.y, "standard_error": point.error }),
            );
            json!({ "name": curve.name, "style": curve.style.word(), "points": points.collect::<Vec<_>>() })
        });
        let bytes = self.output.as_ref().and_then(|file| std::fs::metadata(file).ok());
        json!({
            "path": self.output,
            "bytes": bytes.map(|file| file.len()),
            "title": plot.title,
            "x": { "name": chart.x.label, "unit": chart.x.unit },
            "y": { "name": self.request().subject(), "unit": chart.y.unit },
            "curves": curves.collect::<Vec<_>>(),
            "remark": chart.full_remark(),
        })
    }
}

/// Draws the plot of these runs, which are those of some of the places.
fn drawn(
    request: &PlotRequest,
    runs: &[RunAnalysis],
    places: &[Vec<Coordinate>],
    axes: &[SweptAxis],
    unreadable: Vec<UnreadableRecording>,
) -> Result<(Plot, Vec<UnreadableRecording>), CommandError> {
    let points = points(runs);
    let (metrics, _) = fits::fits(&points);
    let data = PlotData { runs, points: &points, metrics: &metrics, places, axes };
    match data.draw(request) {
        Ok(plot) => Ok((plot, unreadable)),
        // What could not be read may be the cause.
        Err(_) if !unreadable.is_empty() => Err(CommandError::all_unreadable(&unreadable)),
        Err(why) => Err(CommandError::usage(why)),
    }
}

/// A run with its coordinates, and the fields of channels to read.
type Task = ((OpenRun, Vec<Coordinate>), Vec<String>);

/// Reads recordings in parallel, or loads their analyses from the cache next to them, which is not changed.
fn read_all(
    tasks: Vec<Task>,
    folder: &Path,
    has_figures: bool,
) -> Vec<Result<RunAnalysis, UnreadableRecording>> {
    let cache = AnalysisCache::in_folder(folder);
    let read = |((run, coordinates), fields): Task| {
        let options =
            RunOptions { fields: &fields, with_figures: has_figures, ..RunOptions::default() };
        if let Some(found) = cache.as_ref().and_then(|it| it.load(&run, &coordinates, options)) {
            return Ok(found);
        }
        run::catch_defect(run.recording().path(), || {
            run::analyze(&run, coordinates.clone(), options, NonZeroUsize::MIN)
        })
    };
    tasks.into_par_iter().with_max_len(1).map(read).collect()
}

/// Whether the folder of a file exists.
fn is_in_a_folder(file: &Path) -> bool {
    folder_of(file).is_dir()
}

fn place(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').map(|(key, value)| (key.trim(), value.trim()));
    let pair = pair.filter(|(key, value)| !key.is_empty() && !value.is_empty());
    pair.map(|(key, value)| (key.to_owned(), value.to_owned()))
        .ok_or_else(|| "must be KEY=VALUE".to_owned())
}

fn fit(text: &str) -> Result<PlotFit, String> {
    match text {
        "power" => Ok(PlotFit::Power),
        "linear" => Ok(PlotFit::Linear),
        _ => Err("must be power or linear".to_owned()),
    }
}

fn side(text: &str) -> Result<u32, String> {
    let side = text.parse().ok().filter(|side| (100..=10_000).contains(side));
    side.ok_or_else(|| "must be a whole number from 100 to 10000".to_owned())
}

fn font_size(text: &str) -> Result<f64, String> {
    let size = text.parse().ok().filter(|size| (6.0..=400.0).contains(size));
    size.ok_or_else(|| "must be a number from 6 to 400".to_owned())
}

fn scale(text: &str) -> Result<f64, String> {
    let scale = text.parse().ok().filter(|scale| (0.5..=8.0).contains(scale));
    scale.ok_or_else(|| "must be a number from 0.5 to 8".to_owned())
}
