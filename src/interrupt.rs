//! Ctrl-C, SIGTERM and SIGHUP. The first signal ends the runs in order; a second Ctrl-C or SIGTERM ends the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A request to stop: by a signal or by the program itself.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    signal: Arc<AtomicUsize>,
    stopped: Arc<AtomicBool>,
}

impl Interrupt {
    /// Installs the handlers of the signals.
    ///
    /// # Errors
    /// A handler that the operating system rejects.
    #[cfg(unix)]
    pub fn listen() -> std::io::Result<Self> {
        use signal_hook::consts::{SIGINT, SIGTERM};
        let interrupt = Self::default();
        for signal in [SIGINT, SIGTERM] {
            let again = Arc::new(AtomicBool::new(false));
            let number = signal as usize;
            // The order matters: at the first signal, `again` is not set yet, and the second handler sets it.
            signal_hook::flag::register_conditional_shutdown(
                signal,
                128 + signal,
                Arc::clone(&again),
            )?;
            signal_hook::flag::register(signal, again)?;
            signal_hook::flag::register_usize(signal, Arc::clone(&interrupt.signal), number)?;
        }
        interrupt.listen_to_hangup()?;
        // A file-size limit then causes an error of the write, which is reported, and does not kill the program.
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
        Ok(interrupt)
    }

    /// Installs the handler of the console, which is one for the whole program: Ctrl-C, Ctrl-Break, a closed window and the end of the
    /// session. The second event ends the program at once.
    ///
    /// # Errors
    /// A handler that the operating system rejects.
    #[cfg(windows)]
    pub fn listen() -> std::io::Result<Self> {
        use std::sync::OnceLock;
        const CTRL_C: usize = 2;
        static SIGNAL: OnceLock<Arc<AtomicUsize>> = OnceLock::new();
        let is_first = SIGNAL.get().is_none();
        let signal = Arc::clone(SIGNAL.get_or_init(Arc::default));
        if is_first {
            let raised = Arc::clone(&signal);
            let handle = move || {
                if raised.swap(CTRL_C, Ordering::Relaxed) != 0 {
                    std::process::exit(128 + CTRL_C as i32);
                }
            };
            ctrlc::set_handler(handle).map_err(std::io::Error::other)?;
        }
        Ok(Self { signal, stopped: Arc::default() })
    }

    /// Installs the handler of SIGHUP, which the system sends when the terminal is closed, often from several processes at once:
    /// a second one changes nothing. Under `nohup`, the runs continue.
    #[cfg(unix)]
    fn listen_to_hangup(&self) -> std::io::Result<()> {
        use signal_hook::consts::SIGHUP;
        if !is_ignored(SIGHUP) {
            let number = SIGHUP as usize;
            signal_hook::flag::register_usize(SIGHUP, Arc::clone(&self.signal), number)?;
        }
        Ok(())
    }

    /// Whether the runs are to stop.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0 || self.stopped.load(Ordering::Relaxed)
    }

    /// An interrupt with the same signals and its own [`Interrupt::stop`].
    #[must_use]
    pub fn with_own_stop(&self) -> Self {
        Self { signal: Arc::clone(&self.signal), stopped: Arc::default() }
    }

    /// Requests a stop without a signal.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Requests a stop as a signal does: for all interrupts with the same signals.
    pub fn raise(&self, signal: usize) {
        self.signal.store(signal, Ordering::Relaxed);
    }

    /// The conventional exit code after a signal: 128 plus its number.
    #[must_use]
    pub fn exit_code(&self) -> Option<u8> {
        let signal = self.signal.load(Ordering::Relaxed);
        (signal != 0).then_some(128 + signal as u8)
    }
}

/// Whether the caller of the program has set a signal to be ignored. Only Linux reports it without a call into the C library.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // Bit 0 is signal 1.
    ignored.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
