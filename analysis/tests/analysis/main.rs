//! The analysis as its user sees it: metrics of recordings with known numbers, checks, reports, exports, damaged inputs.
//!
//! A test belongs here if it starts `analyze-recordings` or reads a recording through the analysis library.

// Recordings with known numbers, written without physics.
mod synthetic;

// Metrics of gas and DEM equal the closed forms behind the frames.
mod known_numbers_of_gas_and_dem;
// Metrics of orbit and packing equal the closed forms behind the frames.
mod known_numbers_of_orbit_and_packing;
// The stress by height equals the weight above.
mod known_numbers_of_stress;
// Order, correlations, displacements and floor loads equal the values put in.
mod known_numbers_of_structure_and_beds;

// Failed and missing checks exit with code 3.
mod checks_decide_the_exit_code;
// Unreadable inputs are named; the rest is analyzed.
mod inputs_that_are_not_whole;
// JUnit, GitHub annotations, baselines and the analysis cache.
mod verdicts_for_machines;

// Exports contain the recorded bits in every format.
mod exports_read_back;
// `docs/metrics.md` and the schema of `metrics.json` are current.
mod metrics_reference_is_current;
// The report opens in a browser without errors and on a phone.
mod report_opens_in_a_browser;
// A thumbnail shows the recorded positions and colors.
mod thumbnail_shows_the_recording;
// A timing table is shown in the report and changes no metric.
mod timing_is_shown;
