//! A viewer's connection, on which each exchange has a deadline, and the slots of all connections.
//!
//! Every read and write of the server goes through [`Connection`]. It ends at the deadline of the exchange, when another connection
//! takes its slot, and when the server closes. Therefore, a viewer that sends, reads or closes slowly occupies its own thread only.

use super::frame_buffer::FrameBuffer;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Maximum number of connections.
const MAX_CONNECTIONS: usize = 64;
/// Interval at which a blocked read or write checks whether the connection must end.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// An exchange with a viewer, which ends at a deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exchange {
    /// The complete handshake.
    Handshake,
    /// Reading requests for this time. At the deadline, the connection continues with another exchange.
    Listening(Duration),
    /// Sending one message.
    Sending,
    /// Closing after the end of the broadcast; [`FrameBuffer::is_over`] ends it.
    Closing,
}

impl Exchange {
    fn limit(self) -> Duration {
        match self {
            Self::Handshake => Duration::from_secs(5),
            Self::Listening(turn) => turn,
            // A message of 80 MB (1e6 discs) at 11 Mbit/s.
            Self::Sending | Self::Closing => Duration::from_secs(60),
        }
    }
}

/// What a connection has achieved, from the one that is displaced first to the one that is displaced last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Progress {
    Connected,
    Agreed,
    Subscribed,
}

/// The place of one connection among at most [`MAX_CONNECTIONS`].
#[derive(Debug)]
pub(super) struct Slot {
    /// What was achieved, and when a message was last sent completely.
    progress: Mutex<(Progress, Instant)>,
    is_displaced: AtomicBool,
}

impl Slot {
    fn progress(&self) -> (Progress, Instant) {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reports what the connection has achieved.
    pub(super) fn report(&self, progress: Progress) {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner) = (progress, Instant::now());
    }

    pub(super) fn is_displaced(&self) -> bool {
        self.is_displaced.load(Ordering::Relaxed)
    }
}

/// The slots of all connections. If all are occupied, a new connection displaces the one that has achieved least, and among
/// these the one that has been idle longest: clients that only connect cannot lock out a viewer.
#[derive(Debug, Default)]
pub(super) struct Slots {
    occupied: Vec<Weak<Slot>>,
}

impl Slots {
    /// Occupies a slot until the value is dropped.
    pub(super) fn occupy(&mut self) -> Arc<Slot> {
        self.occupied.retain(|slot| slot.strong_count() > 0);
        if self.occupied.len() >= MAX_CONNECTIONS {
            let progress = |slot: &Weak<Slot>| slot.upgrade().map(|slot| slot.progress());
            let least = (0..self.occupied.len()).min_by_key(|&at| progress(&self.occupied[at]));
            if let Some(displaced) = least.and_then(|at| self.occupied.remove(at).upgrade()) {
                displaced.is_displaced.store(true, Ordering::Relaxed);
            }
        }
        let slot = Arc::new(Slot {
            progress: Mutex::new((Progress::Connected, Instant::now())),
            is_displaced: AtomicBool::new(false),
        });
        self.occupied.push(Arc::downgrade(&slot));
        slot
    }

    /// Maximum number of threads: those of the connections, and of displaced ones that have not ended yet.
    pub(super) const MAX_THREADS: usize = 2 * MAX_CONNECTIONS;
}

/// A connection whose reads and writes end at the deadline of the current exchange.
pub(super) struct Connection<'a> {
    stream: TcpStream,
    buffer: &'a FrameBuffer,
    slot: Arc<Slot>,
    exchange: Exchange,
    deadline: Instant,
}

impl<'a> Connection<'a> {
    /// Wraps an accepted stream and begins the handshake.
    pub(super) fn new(
        stream: TcpStream,
        buffer: &'a FrameBuffer,
        slot: Arc<Slot>,
    ) -> io::Result<Self> {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        let exchange = Exchange::Handshake;
        Ok(Self { stream, buffer, slot, exchange, deadline: Instant::now() + exchange.limit() })
    }

    /// Begins an exchange, whose deadline replaces that of the previous one.
    pub(super) fn begin(&mut self, exchange: Exchange) {
        self.exchange = exchange;
        self.deadline = Instant::now() + exchange.limit();
    }

    /// Reports what the connection has achieved.
    pub(super) fn report(&self, progress: Progress) {
        self.slot.report(progress);
    }

    /// Time for which a read or write may block.
    ///
    /// # Errors
    /// `WouldBlock` at the end of a turn of listening; another kind if the connection must end.
    fn time_to_block(&self) -> io::Result<Duration> {
        if self.slot.is_displaced() || self.buffer.is_over() {
            return Err(ErrorKind::ConnectionAborted.into());
        }
        let left = self.deadline.saturating_duration_since(Instant::now());
        if !left.is_zero() {
            return Ok(left.min(CHECK_INTERVAL));
        }
        Err(match self.exchange {
            Exchange::Listening(_) => ErrorKind::WouldBlock.into(),
            Exchange::Handshake | Exchange::Sending | Exchange::Closing => {
                ErrorKind::TimedOut.into()
            }
        })
    }
}

/// Whether a call on the stream ended without a result: at its time limit, whose error depends on the system, or because of a
/// signal, which interrupts a read with a time limit.
fn is_retried(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

impl Read for Connection<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            self.stream.set_read_timeout(Some(self.time_to_block()?))?;
            match self.stream.read(bytes) {
                Err(error) if is_retried(&error) => {}
                result => return result,
            }
        }
    }
}

impl Write for Connection<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        loop {
            self.stream.set_write_timeout(Some(self.time_to_block()?))?;
            match self.stream.write(bytes) {
                Err(error) if is_retried(&error) => {}
                result => return result,
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_connection_displaces_the_one_that_has_achieved_least() {
        let mut slots = Slots::default();
        let mut occupied: Vec<Arc<Slot>> = (0..MAX_CONNECTIONS).map(|_| slots.occupy()).collect();
        // The first one is a viewer, and the second one has agreed on the protocol.
        occupied[0].report(Progress::Subscribed);
        occupied[1].report(Progress::Agreed);
        let displaced = |occupied: &[Arc<Slot>]| -> Vec<usize> {
            (0..occupied.len()).filter(|&at| occupied[at].is_displaced()).collect()
        };
        assert!(displaced(&occupied).is_empty());
        for count in 1..=3 * MAX_CONNECTIONS {
            occupied.push(slots.occupy());
            // The oldest of those that have only connected, in the order in which they came.
            assert_eq!(displaced(&occupied), (2..2 + count).collect::<Vec<_>>());
        }
        let newest = occupied.last().unwrap();
        assert!(!newest.is_displaced());
    }

    #[test]
    fn ended_connections_leave_their_slots() {
        let mut slots = Slots::default();
        let mut occupied: Vec<Arc<Slot>> = (0..MAX_CONNECTIONS).map(|_| slots.occupy()).collect();
        occupied.remove(7);
        occupied.push(slots.occupy());
        assert!(!occupied.iter().any(|slot| slot.is_displaced()));
    }
}
