//! The analysis as its user sees it: metrics of recordings with known numbers, checks, reports, exports, damaged inputs.
//!
//! A test belongs here if it starts `analyze-recordings` or reads a recording through the analysis library.

// Recordings with known numbers, written without physics.
mod synthetic;
// Pages in a browser.
mod browser;
// The orbit exercise, integrated without the physics package.
mod orbit_exercise;

// Metrics of gas and DEM equal the closed forms behind the frames.
mod gas_and_dem_metrics_equal_closed_forms;
// Metrics of orbit and packing equal the closed forms behind the frames.
mod orbit_and_packing_metrics_equal_closed_forms;
// The closest approach of two bodies is found between frames.
// The stress by height equals the weight above.
mod stress_equals_weight_above;
// Every shipped experiment has a question and an answer.
mod shipped_experiments_answer_their_question;
// Orders of convergence come from runs in the asymptotic range only.
mod convergence_order_uses_the_asymptotic_range;
// Order, correlations, displacements and floor loads equal the values put in.
mod structure_and_bed_metrics_equal_closed_forms;
// The entropy by boxes equals its definition.
mod entropy_follows_its_definition;
// Theory is compared only within its range, and for the run's own materials, noise and density.
mod theory_is_given_within_its_range;

// Failed and missing checks exit with code 3.
mod checks_determine_the_exit_code;
// Unreadable inputs are named; the rest is analyzed.
mod unreadable_inputs_are_reported;
// JUnit, GitHub annotations and the analysis cache.
mod check_results_are_machine_readable;
// A baseline is compared run by run, by what differs.
mod baselines_are_compared_run_by_run;
mod baselines_need_power;

// Files of many runs hold means and checks only, and each definition once.
mod files_of_many_runs_are_small;
// The table of runs has their metrics, and answers questions.
mod table_of_runs_answers_questions;
// Exports contain the recorded bits in every format.
mod exports_contain_the_recorded_bits;
// `docs/metrics.md` and the schema of `metrics.json` are current.
mod metrics_reference_is_current;
// The report opens in a browser without errors and on a phone.
mod report_opens_in_a_browser;
// The pages have no violation of accessibility.
mod report_is_accessible;
// The head of the report answers the question.
mod head_of_the_report_answers_the_question;
// Recordings with nothing, too much or nonsense have a report.
mod report_of_unusual_recordings;
// A folder of experiments has a page that lists them.
mod index_lists_every_experiment;
// The plots of the report show values, zoom, and move the replay.
mod plots_respond_to_the_pointer;
// The density by height is that of the frame that is shown.
mod live_distribution_is_that_of_the_frame;
// Labels at the ends of curves are next to them.
mod end_labels_are_next_to_their_curves;
// The replay of a report shows the recorded positions.
mod replay_shows_the_recording;
// Two runs play in parallel with one clock.
mod two_runs_share_a_clock;
// Particles and their paths are between the frames where they were.
mod motion_between_frames_is_on_the_path;
// A speed has one color in the recording, the page and the list of experiments.
mod speeds_have_one_color;
// The first screen shows question, answer and action.
mod first_screen_shows_the_answer;
// A bed at rest is enlarged in the first picture, and a planet can rest.
mod first_picture_and_frame_of_reference;
mod flights_between_frames_are_exact;
// Requested plots come first and show gaps where there is no value.
mod requested_plots_show_the_metrics;
// A thumbnail shows the recorded positions and colors.
mod thumbnail_shows_the_recording;
// A timing table is shown in the report and changes no metric.
mod report_shows_the_timing_table;
