//! `[model.oscillator]`: a body on a spring.

use crate::model::contract::{Model, check_steps};
use crate::keys::Reader;
use crate::quantity::Positive;
use crate::table::table;

table! {
    /// All physics of an oscillator run.
    pub struct OscillatorConfig {
        /// Angular frequency, sqrt(k/m).
        angular_frequency_rad_per_s: Positive ["rad/s"] = Positive::literal(1.0),
        /// Position at the start, where the body is at rest.
        amplitude_m: Positive ["m"] = Positive::literal(1.0),
        /// Time step.
        time_step_s: Positive ["s"] = Positive::literal(0.1),
        /// Simulated time.
        duration_s: Positive ["s"] = Positive::literal(100.0),
    }
}

impl Model for OscillatorConfig {
    fn intervals(&self, _sound: bool) -> &'static [&'static str] {
        &["every_s", "every_steps"]
    }

    fn duration(&self) -> Option<f64> {
        Some(self.duration_s.get())
    }

    fn particles(&self) -> u64 {
        1
    }

    fn check(&mut self, table: &mut Reader<'_>) {
        let keys = ["duration_s", "time_step_s"];
        check_steps(self.duration_s, Some(self.time_step_s), table, &keys);
    }
}
