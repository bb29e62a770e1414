//! Collects evenly spaced frames of a run in bounded memory, and makes the replay of them.

use super::encoding::{
    ABSENT, LARGEST, append_series, append_speeds, base64_bytes, best_order, deflated, quantized,
};
use super::film::{Film, Replay};
use super::flights::Flights;
use super::forces::{self, append_forces, forces};
use super::lines::{LineStyle, Lines, styles, texts};
use super::picture::{PictureStyle, picture};
use super::poster::{nearest, poster, usual_color};
use super::speeds::{Speeds, Velocities, append_spins, legend_top};
use super::still::{Columns, Point, Still, halve, padded, thinned};
use super::view::{Range, View};
use crate::input::recording::OpenRun;
use crate::models;
use crate::models::contract::Extent;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::record::RecordInterval;
use kinetoscope_manifest::{ViewColor, ViewFrame, ViewRequest};
use kinetoscope_recording::channels::{DISCS, LEGEND, WALLS};
use kinetoscope_recording::drawing::read_shapes;
use kinetoscope_recording::reader::RecordedFrame;
use std::sync::Arc;

/// Maximum number of particles in a replay; a browser draws this many in a few milliseconds.
const MAX_PARTICLES: usize = 10_000;
/// Number of frames below which particles are left out rather than more frames.
const MIN_FRAMES: usize = 60;
/// Blocks of neighboring frames whose encoding predicts that of all frames.
const SAMPLED_BLOCKS: usize = 3;
/// Bytes per particle and frame that the collector counts on; the encoding of most runs takes one to three.
const MIN_BYTES_PER_POINT: usize = 1;

/// Collects the frames of a replay while a run is read.
#[derive(Debug)]
pub(crate) struct ReplayCollector {
    /// Maximum size of the replay in the page.
    max_bytes: usize,
    /// Maximum number of points in memory.
    max_points: usize,
    max_particles: usize,
    /// A frame is kept if its number is a multiple of this; the last one is kept in any case.
    every_frame: u64,
    every_particle: u64,
    extent: Extent,
    fps: f64,
    units: [String; 3],
    columns: Option<Columns>,
    /// How the manifest requests that the run is shown first, and the number of its species.
    request: ViewRequest,
    species: usize,
    /// The speed at the upper end of the recorded color bar, and the recorded names of the first particles.
    legend_top: Option<f64>,
    names: Vec<String>,
    lines: Arc<Lines>,
    flights: Flights,
    stills: Vec<Still>,
    last: Option<Still>,
    frames: u64,
    /// Number of particles of the largest frame, and of contact forces of the frame with the most.
    particles: usize,
    most_forces: usize,
}

impl ReplayCollector {
    /// A collector for a replay of at most `max_bytes` in the page, which begins as requested.
    pub(crate) fn new(max_bytes: usize, run: &OpenRun, request: ViewRequest) -> Self {
        let (extent, provenance) =
            (models::extent(&run.manifest.model), run.recording().provenance());
        let max_points = (max_bytes / 4 * 3 / MIN_BYTES_PER_POINT).max(1);
        let frames = match run.manifest.record.interval {
            RecordInterval::Frames(intervals) => intervals.get().saturating_add(1),
            _ => u64::MAX,
        };
        let min_frames = usize::try_from(frames).unwrap_or(MIN_FRAMES).min(MIN_FRAMES);
        let max_particles = (max_points / min_frames).clamp(1, MAX_PARTICLES);
        let unit = |name: &str| {
            let index = provenance.state_columns.iter().position(|column| column == name);
            index.and_then(|index| provenance.state_units.get(index)).cloned().unwrap_or_default()
        };
        let lines = Arc::new(Lines::of(&extent.walls));
        let time_unit = match provenance.time_unit.as_str() {
            "" => "units of time",
            unit => unit,
        };
        Self {
            max_bytes,
            max_points,
            max_particles,
            every_frame: 1,
            every_particle: 1,
            flights: Flights::new(&extent, max_bytes),
            extent,
            fps: provenance.playback_fps,
            units: [unit("x"), unit("vx"), time_unit.to_owned()],
            columns: None,
            request,
            species: species(&run.manifest.model),
            legend_top: None,
            names: Vec::new(),
            lines,
            stills: Vec::new(),
            last: None,
            frames: 0,
            particles: 0,
            most_forces: 0,
        }
    }

    /// Takes in the next frame. A scene that cannot be decoded leaves the walls as they are.
    pub(crate) fn observe(&mut self, frame: &RecordedFrame) {
        let number = self.frames;
        self.frames += 1;
        let shapes = |topic: &str| {
            let message = frame.messages().iter().find(|message| message.topic() == topic);
            message.and_then(|message| read_shapes(message.payload()))
        };
        if let Some(shapes) = shapes(WALLS) {
            self.lines = Arc::new(Lines::of(&shapes));
        }
        if number == 0 {
            self.legend_top = shapes(LEGEND).and_then(|legend| legend_top(&legend));
            self.names = shapes(DISCS).map(|discs| texts(&discs)).unwrap_or_default();
        }
        let Some(state) = frame.state() else { return };
        self.columns = self.columns.take().or_else(|| Columns::of(state));
        let Some(columns) = &self.columns else { return };
        if self.particles == 0 {
            self.every_particle = state.rows().div_ceil(self.max_particles).max(1) as u64;
        }
        self.flights.observe(number, frame, columns, self.every_particle);
        self.particles = self.particles.max(state.rows());
        let mut points = Vec::new();
        for row in 0..state.rows() {
            let values = state.row(row);
            let particle = columns.number(row, values);
            if particle.is_multiple_of(self.every_particle) {
                // Each doubling of the interval halves the places.
                let mut place = (particle / self.every_particle) as usize;
                while place >= self.max_particles.max(1) {
                    self.every_particle *= 2;
                    halve(&mut points);
                    self.stills.iter_mut().for_each(|still| halve(&mut still.points));
                    place = (particle / self.every_particle) as usize;
                }
                if particle.is_multiple_of(self.every_particle) {
                    if points.len() <= place {
                        points.resize(place + 1, Point::ABSENT);
                    }
                    points[place] = columns.point(values, self.extent.radius);
                }
            }
        }
        let time = frame.clock.time;
        let (forces, all) = if self.request.forces { forces(frame) } else { Default::default() };
        self.most_forces = self.most_forces.max(all);
        let still = Still { number, time, points, lines: Arc::clone(&self.lines), forces };
        if number.is_multiple_of(self.every_frame) {
            self.stills.push(still);
            self.last = None;
            self.drop_frames();
        } else {
            self.last = Some(still);
        }
    }

    /// Keeps every second frame if there are too many in memory.
    fn drop_frames(&mut self) {
        let points = |stills: &[Still]| -> usize {
            let size =
                |it: &Still| it.points.len() + it.lines.ends.len() + 5 * it.forces.len() + 16;
            stills.iter().map(size).sum()
        };
        while self.stills.len() > 2 && points(&self.stills) > self.max_points {
            self.every_frame *= 2;
            if let Some(newest) = self.stills.last()
                && !newest.number.is_multiple_of(self.every_frame)
            {
                self.last = self.stills.pop();
            }
            self.stills.retain(|still| still.number.is_multiple_of(self.every_frame));
        }
    }

    /// The replay of the frames so far.
    pub(crate) fn finish(mut self) -> Replay {
        let missing = |why: &str| Replay { note: format!("No replay: {why}."), film: None };
        if self.columns.is_none() {
            return missing("positions were not recorded (channel `state`)");
        }
        self.stills.extend(self.last.take());
        let Some(view) = self.view() else {
            return missing("no recorded position is a finite number");
        };
        let fewest = self.stills.len().div_ceil(MIN_FRAMES);
        let mut every = self.first_interval(view).min(fewest);
        loop {
            let stills = thinned(&self.stills, every);
            let film = self.film(&stills, view, true);
            let bytes = base64_bytes(film.data.len());
            if bytes <= self.max_bytes {
                let mut note = self.note(&stills, view, every as u64 * self.every_frame);
                note.push_str(&self.flights.note(&stills, film.flights));
                return Replay { note, film: Some(film) };
            }
            let (frames, particles) = (stills.len(), film.particles);
            // The size is nearly proportional to the number of frames.
            let wanted = (every + 1).max(every * bytes / self.max_bytes);
            if every < fewest {
                every = wanted.min(fewest);
            } else if particles > 1 {
                self.every_particle *= 2;
                self.stills.iter_mut().for_each(|still| halve(&mut still.points));
            } else if frames > 2 {
                every = wanted;
            } else {
                return missing("one frame is larger than the budget (--replay-budget)");
            }
        }
    }

    /// The interval of frames that a sample of neighboring frames suggests: encoding all frames of a long run only to find that they
    /// do not fit would take most of the time.
    fn first_interval(&self, view: View) -> usize {
        let frames = self.stills.len();
        if frames < 2 * MIN_FRAMES {
            return 1;
        }
        let block = MIN_FRAMES / SAMPLED_BLOCKS;
        let blocks =
            (0..SAMPLED_BLOCKS).map(|index| (frames - block) * index / (SAMPLED_BLOCKS - 1));
        let sample: Vec<&Still> =
            blocks.flat_map(|start| &self.stills[start..start + block]).collect();
        let bytes = base64_bytes(self.film(&sample, view, false).data.len());
        (bytes * frames / sample.len() / self.max_bytes).max(1)
    }

    /// All positions, within and near the container if there is one, else with everything else that is drawn.
    fn view(&self) -> Option<View> {
        let points = || {
            let discs = self.stills.iter().flat_map(|still| &still.points).map(Point::disc);
            discs.chain(self.flights.places(self.extent.radius))
        };
        let container = self.stills.iter().flat_map(|still| still.lines.container());
        let shown = match View::containing(container) {
            Some(container) => View::of_contained(points(), container).or(Some(container)),
            None => {
                let lines = self.stills.first().into_iter().flat_map(|still| still.lines.extent());
                View::of_particles(&points().chain(lines).collect::<Vec<_>>())
            }
        };
        shown.map(View::with_margin)
    }

    /// What is shown and what was left out.
    fn note(&self, stills: &[&Still], view: View, every_frame: u64) -> String {
        let frames = match (stills.len() as u64, self.frames) {
            (1, 1) => "The recording has one frame.".to_owned(),
            (shown, all) if shown == all => format!("All {all} frames are shown."),
            (shown, all) => format!(
                "{shown} of {all} frames are shown (every {}, and the last), so that the page stays small.",
                ordinal(every_frame)
            ),
        };
        let particles = if self.every_particle > 1 {
            format!(
                " Of up to {} particles, every {} is drawn.",
                self.particles,
                ordinal(self.every_particle)
            )
        } else {
            String::new()
        };
        let range = Range::around(view);
        // The largest number of particles of a frame at such places.
        let most = |is_there: &dyn Fn([f64; 2]) -> bool| {
            let missing = |point: &&Point| {
                let [x, y, _] = point.disc();
                !point.radius.is_nan() && is_there([x, y])
            };
            let counts = stills.iter().map(|still| still.points.iter().filter(missing).count());
            counts.max().unwrap_or(0) as u64
        };
        let is_finite = |place: [f64; 2]| place.iter().all(|part| part.is_finite());
        let not_finite = most(&|place| !is_finite(place));
        let outside = most(&|place| is_finite(place) && range.stored(place).contains(&ABSENT));
        let are_points = |still: &&Still| {
            still.points.iter().all(|point| point.radius.is_nan() || point.radius == 0.0)
        };
        let points = match stills.iter().all(are_points) && !self.extent.has_trails {
            true => " Points are drawn as dots.",
            false => "",
        };
        let periodic = match self.extent.is_periodic {
            true => " A disc that leaves through a periodic side enters through the opposite one.",
            false => "",
        };
        let missing = |count: u64, place: &str| match count {
            0 => String::new(),
            1 => format!(" One particle {place} is not drawn."),
            count => format!(" Up to {count} particles {place} are not drawn."),
        };
        [
            frames,
            particles,
            forces::note(self.most_forces),
            points.to_owned(),
            periodic.to_owned(),
            if self.extent.has_trails { self.lines.key_of_trails() } else { String::new() },
            missing(not_finite, "at no finite place"),
            missing(outside, "far outside of the view"),
        ]
        .concat()
    }

    /// The names of the first drawn particles: those of the manifest, unless it names more than the run has, so that it is open which is which; else
    /// those of the recording.
    fn drawn_names(&self) -> Vec<String> {
        let requested = Some(&self.request.names);
        let given = requested.filter(|given| (1..=self.particles).contains(&given.len()));
        let names = given.unwrap_or(&self.names);
        names.iter().step_by(self.every_particle as usize).cloned().collect()
    }

    /// The frame that is shown first, its picture with the ends of the color scales of speed and spin, its color, and the names of the particles.
    fn first_picture(
        &self,
        stills: &[&Still],
        view: View,
        [top, spin_top]: [f64; 2],
    ) -> (usize, String, ViewColor, Vec<String>) {
        let requested = self.request.poster.map(|time| nearest(stills, time));
        let first = requested.unwrap_or_else(|| poster(stills, view));
        let names = self.drawn_names();
        let requested = self.request.color.filter(|it| *it != ViewColor::Spin || spin_top > 0.0);
        let color = requested.unwrap_or_else(|| usual_color(stills[first], top, &self.extent));
        let style = PictureStyle {
            top,
            spin_top,
            has_trails: self.extent.has_trails,
            names: &names,
            color,
            species: self.species,
            every_particle: self.every_particle as usize,
            is_rotating: self.request.frame == Some(ViewFrame::Rotating),
        };
        (first, picture(stills, first, view, &style), color, names)
    }

    fn film(&self, stills: &[&Still], view: View, with_flights: bool) -> Film {
        let particles = stills.iter().map(|still| still.points.len()).max().unwrap_or(0);
        let ends = stills.iter().map(|still| still.lines.ends.len()).max().unwrap_or(0);
        let has_moving_walls = stills.windows(2).any(|pair| pair[0].lines != pair[1].lines);
        let range = Range::around(view);
        let mut data: Vec<u8> = stills.iter().flat_map(|still| still.time.to_le_bytes()).collect();
        data.extend(stills.iter().flat_map(|still| (still.number as u32).to_le_bytes()));
        let points = || stills.iter().flat_map(move |still| padded(&still.points, particles));
        let (radii, radius_step) = radii(points());
        let (radii, has_growing_particles) = fixed_radii(radii, particles);
        append_series(&mut data, &radii, particles, 1);
        let [xs, ys] = [0, 1].map(|axis| -> Vec<u16> {
            points().map(|point| range.stored([point.x, point.y])[axis]).collect()
        });
        let orders = [&xs, &ys].map(|values| best_order(values, particles));
        append_series(&mut data, &xs, particles, orders[0]);
        append_series(&mut data, &ys, particles, orders[1]);
        let speed = |still: &&Still| still.points.iter().map(|at| f64::from(at.speed)).collect();
        let speeds = Speeds::of(stills.iter().map(speed), self.legend_top);
        let stored: Vec<u8> = points().map(|point| speeds.stored(point.speed)).collect();
        append_speeds(&mut data, &stored, particles);
        let styles = styles(stills.iter().map(|still| &*still.lines));
        let drawn = if has_moving_walls { stills } else { &stills[..1] };
        append_walls(&mut data, drawn, &range, view.cut(), &styles);
        let velocities = append_velocities(&mut data, stills, particles);
        let shown = stills.len() as f64 / self.frames as f64;
        let spin_top = append_spins(&mut data, stills, particles);
        let forces: Vec<&[_]> = stills.iter().map(|still| &*still.forces).collect();
        let (force_lines, force_top) = append_forces(&mut data, &forces, &range);
        let flown = [particles, self.every_particle as usize];
        let flights = with_flights.then(|| self.flights.append(&mut data, stills, &range, flown));
        let (first, picture, color, names) =
            self.first_picture(stills, view, [speeds.top, spin_top]);
        Film {
            frames: stills.len(),
            particles,
            every_particle: self.every_particle,
            view,
            cut: view.cut(),
            poster: first,
            picture,
            color: color.word().to_owned(),
            names,
            origin: range.origin,
            step: range.step,
            orders,
            radius_step,
            has_growing_particles,
            speed_max: speeds.max,
            speed_top: speeds.top,
            velocity_top: velocities.top,
            velocity_step: velocities.step,
            spin_top,
            wall_points: ends,
            force_lines,
            force_top,
            line_styles: styles,
            has_moving_walls,
            bodies: stills.first().map_or_else(Vec::new, |still| still.lines.bodies.clone()),
            labels: stills.first().map_or_else(Vec::new, |still| still.lines.labels.clone()),
            has_trails: self.extent.has_trails,
            fps: self.fps * shown,
            units: self.units.clone(),
            flights: flights.flatten(),
            data: deflated(&data),
        }
    }
}

/// Number of the species of a gas, which its particles have in turn; 1 for other models.
pub(crate) fn species(model: &ModelConfig) -> usize {
    match model {
        ModelConfig::Gas(gas) => 1 + gas.additional_masses_kg.len(),
        _ => 1,
    }
}

/// Appends the ends of the walls where they are cut off, and their styles; each frame has as many as the one with the most.
fn append_walls(
    data: &mut Vec<u8>,
    drawn: &[&Still],
    range: &Range,
    cut: View,
    styles: &[LineStyle],
) {
    let ends = drawn.iter().map(|still| still.lines.ends.len()).max().unwrap_or(0);
    let walls: Vec<_> = drawn.iter().map(|still| still.lines.clipped(cut)).collect();
    for axis in 0..2 {
        let values = walls.iter().flat_map(|clipped| {
            let stored = clipped.iter().map(|end| range.stored(*end)[axis]);
            stored.chain(std::iter::repeat(ABSENT)).take(ends)
        });
        append_series(data, &values.collect::<Vec<_>>(), ends, 2);
    }
    let style = |style| styles.iter().position(|other| other == style).map_or(0, |at| at as u16);
    let values = drawn.iter().flat_map(|still| {
        still.lines.styles.iter().map(style).chain(std::iter::repeat(0)).take(ends / 2)
    });
    append_series(data, &values.collect::<Vec<_>>(), ends / 2, 1);
}

/// The radii of all points in steps, and the length of a step.
fn radii(points: impl Iterator<Item = Point> + Clone) -> (Vec<u16>, f64) {
    let largest = points.clone().map(|point| f64::from(point.radius));
    let largest = largest.filter(|radius| radius.is_finite()).fold(0.0, f64::max);
    let step = if largest > 0.0 { largest / f64::from(LARGEST) } else { 1.0 };
    (points.map(|point| quantized(f64::from(point.radius), step)).collect(), step)
}

/// One radius per particle if none changes while the particle is present, and whether one does.
fn fixed_radii(radii: Vec<u16>, particles: usize) -> (Vec<u16>, bool) {
    let mut fixed = vec![ABSENT; particles];
    for frame in radii.chunks(particles.max(1)) {
        for (fixed, radius) in fixed.iter_mut().zip(frame) {
            if *fixed == ABSENT {
                *fixed = *radius;
            } else if *radius != ABSENT && radius != fixed {
                return (radii, true);
            }
        }
    }
    (fixed, false)
}

/// "2nd", "3rd", "10th".
fn ordinal(number: u64) -> String {
    let ending = match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

/// Appends both components of the velocities, if any is stored; returns their scale.
fn append_velocities(data: &mut Vec<u8>, stills: &[&Still], particles: usize) -> Velocities {
    let parts = || stills.iter().flat_map(move |still| padded(&still.points, particles));
    let of_all = parts().flat_map(|point| point.velocity);
    let velocities = Velocities::of(of_all, particles * stills.len());
    for axis in 0..if velocities.step > 0.0 { 2 } else { 0 } {
        let stored: Vec<u16> =
            parts().map(|point| velocities.stored(point.velocity[axis])).collect();
        append_series(data, &stored, particles, 1);
    }
    velocities
}
