//! List of all propagators. Adding one takes a file that implements [`Propagator`], a line in the list, and its condition in
//! [`Scheme::prepare`].

use super::as_printed::AsPrinted;
use super::clock::{Clock, StepClock};
use super::closed_form::ClosedForm;
use super::collisions::CollidingDiscs;
use super::event_driven::EventDriven;
use super::propagator::Propagator;
use super::state::GasState;
use super::time_stepped::TimeStepped;
use crate::model::SetupError;
use crate::random::Seed;
use kinetoscope_manifest::model::{GasConfig, Propagation};
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

macro_rules! schemes {
    ($($scheme:ident),+ $(,)?) => {
        /// The propagator of a run.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub(super) enum Scheme {
            $($scheme($scheme)),+
        }

        impl Deref for Scheme {
            type Target = dyn Propagator;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$scheme(scheme) => scheme),+
                }
            }
        }

        impl DerefMut for Scheme {
            fn deref_mut(&mut self) -> &mut Self::Target {
                match self {
                    $(Self::$scheme(scheme) => scheme),+
                }
            }
        }
    };
}

schemes! {
    CollidingDiscs,
    EventDriven,
    ClosedForm,
    TimeStepped,
    AsPrinted,
}

impl Scheme {
    /// Whether this is the scheme of a manifest, with its duration or its steps.
    pub(super) fn is_of(&self, config: &GasConfig) -> bool {
        let is_its_scheme = match (config.propagation, config.disc_radius_m) {
            (Propagation::Exact, Some(_)) => matches!(self, Self::CollidingDiscs(_)),
            (Propagation::Exact, None) if has_encounters(config) => {
                matches!(self, Self::EventDriven(scheme) if scheme.is_of(config))
            }
            (Propagation::Exact, None) => matches!(self, Self::ClosedForm(_)),
            (Propagation::TimeStepped { .. }, _) => matches!(self, Self::TimeStepped(_)),
            (Propagation::AsPrinted { .. }, _) => matches!(self, Self::AsPrinted(_)),
        };
        let has_its_clock = match (config.propagation, self.clock()) {
            (Propagation::Exact, Clock::Continuous { time_s, duration_s }) => {
                duration_s == config.duration_s.get() && time_s >= 0.0
            }
            (
                Propagation::TimeStepped { time_step_s } | Propagation::AsPrinted { time_step_s },
                Clock::Steps(clock),
            ) => {
                let done = clock.done;
                clock == StepClock { done, ..StepClock::new(config.duration_s, time_step_s) }
                    && done <= clock.total
            }
            _ => false,
        };
        is_its_scheme && has_its_clock
    }

    /// The propagator that the manifest requests, at time 0.
    ///
    /// # Errors
    /// A start that it cannot run.
    pub(super) fn prepare(
        config: &GasConfig,
        seed: Seed,
        state: &GasState,
        records_events: bool,
    ) -> Result<Self, SetupError> {
        let duration_s = config.duration_s.get();
        Ok(match (config.propagation, config.disc_radius_m) {
            (Propagation::Exact, Some(radius)) => Self::CollidingDiscs(CollidingDiscs::new(
                duration_s,
                radius.get(),
                state,
                records_events,
            )?),
            (Propagation::Exact, None) if has_encounters(config) => {
                Self::EventDriven(EventDriven::new(config, seed, state))
            }
            (Propagation::Exact, None) => Self::ClosedForm(ClosedForm::new(duration_s, state)),
            (Propagation::TimeStepped { time_step_s }, _) => {
                let clock = StepClock::new(config.duration_s, time_step_s);
                Self::TimeStepped(TimeStepped::new(clock, state))
            }
            (Propagation::AsPrinted { time_step_s }, _) => {
                let clock = StepClock::new(config.duration_s, time_step_s);
                Self::AsPrinted(AsPrinted::new(clock, state))
            }
        })
    }
}

/// Whether points can meet anything but a wall that reflects them specularly, or fall.
fn has_encounters(config: &GasConfig) -> bool {
    config.thermal_wall.is_some()
        || config.orifice_width_m.is_some()
        || config.has_gravity_or_partition()
}
