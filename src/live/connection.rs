//! A viewer's connection, on which each exchange has a deadline.
//!
//! Every read and write of the server goes through [`Connection`]. It ends at the deadline of the exchange, when another connection
//! takes its slot, and when the server closes. Therefore, a viewer that sends, reads or closes slowly occupies its own thread only.

use super::frame_buffer::FrameBuffer;
use kinetoscope_files::connection_slots::{self, CHECK_INTERVAL};
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

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

/// The place of one connection.
pub(super) type Slot = connection_slots::Slot<Progress>;

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
