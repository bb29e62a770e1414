//! Ctrl-C and SIGTERM: the first ends the runs in order, a second ends the program at once.

use signal_hook::consts::{SIGINT, SIGTERM};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Whether somebody asked the program to stop, and how.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    signal: Arc<AtomicUsize>,
    enough: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens to both signals from now on.
    ///
    /// # Errors
    /// Where the operating system refuses a handler.
    pub fn listen() -> io::Result<Self> {
        let interrupt = Self::default();
        for signal in [SIGINT, SIGTERM] {
            let again = Arc::new(AtomicBool::new(false));
            let number = signal as usize;
            // In this order: a first signal finds `again` unset and only sets it.
            signal_hook::flag::register_conditional_shutdown(
                signal,
                128 + signal,
                Arc::clone(&again),
            )?;
            signal_hook::flag::register(signal, again)?;
            signal_hook::flag::register_usize(signal, Arc::clone(&interrupt.signal), number)?;
        }
        // A file-size limit then shows as an error of the write, which is reported, and not as a silent death.
        #[cfg(unix)]
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
        Ok(interrupt)
    }

    /// Whether to stop at the next opportunity.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0 || self.enough.load(Ordering::Relaxed)
    }

    /// The same signals, and a wish of the program's own to stop: that of [`Interrupt::stop`].
    #[must_use]
    pub fn with_own_stop(&self) -> Self {
        Self { signal: Arc::clone(&self.signal), enough: Arc::default() }
    }

    /// Asks to stop without a signal: enough was done.
    pub fn stop(&self) {
        self.enough.store(true, Ordering::Relaxed);
    }

    /// The exit code by convention, 128 and the signal's number, if one came.
    #[must_use]
    pub fn exit_code(&self) -> Option<u8> {
        let signal = self.signal.load(Ordering::Relaxed);
        (signal != 0).then_some(128 + signal as u8)
    }
}
