//! List of all propagators. Adding one takes a file that implements [`Propagator`] and a line in the list.

use super::as_printed::AsPrinted;
use super::closed_form::ClosedForm;
use super::collisions::CollidingDiscs;
use super::event_driven::EventDriven;
use super::propagator::Propagator;
use super::state::GasState;
use super::time_stepped::TimeStepped;
use crate::model::SetupError;
use crate::random::Seed;
use kinetoscope_manifest::model::GasConfig;
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

macro_rules! schemes {
    ($($scheme:ident),+ $(,)?) => {
        /// The propagator of a run.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub(super) enum Scheme {
            $($scheme($scheme)),+
        }

        impl Scheme {
            /// Prepares the first scheme of the list that the manifest requests.
            pub(super) fn prepare(
                config: &GasConfig,
                seed: Seed,
                state: &GasState,
            ) -> Result<Self, SetupError> {
                $(if let Some(scheme) = $scheme::prepare(config, seed, state) {
                    return scheme.map(Self::$scheme);
                })+
                Err(SetupError("no propagator supports this combination of keys".to_owned()))
            }
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
