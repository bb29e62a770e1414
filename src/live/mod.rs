//! Live view of a run in progress: a server for Foxglove and its open fork Lichtblick with the protocol `foxglove.sdk.v1`.
//!
//! Viewers receive the recorded messages byte for byte. Invariant: they never change a recording. A slow viewer misses whole
//! frames and delays neither the run nor other viewers. Without a speed, the run advances at full speed, and viewers receive as
//! many frames as the playback shows in the same time. With a speed, the run is held to it and waits for the first viewer;
//! viewers can pause, step and change the speed.
//!
//! If several runs execute in parallel, the first one is shown. When it ends, the next run that starts is shown.

mod broadcaster;
mod frame_buffer;
mod pace;
mod protocol;
mod viewer;

use crate::interrupt::Interrupt;
use frame_buffer::FrameBuffer;
use kinetoscope_recording::observer::FrameObserver;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The default port of viewers, open to this machine only.
pub const DEFAULT_PORT: u16 = 8765;
/// Interval at which new connections are accepted.
const ACCEPT_INTERVAL: Duration = Duration::from_millis(20);

/// The server. When dropped, it sends the last frame to the viewers and closes.
pub struct LiveServer {
    buffer: Arc<FrameBuffer>,
    taken: Arc<AtomicBool>,
    address: SocketAddr,
    acceptor: Option<JoinHandle<()>>,
}

impl LiveServer {
    /// Listens at an address; port 0 selects a free port. Runs are held to `speed`, in seconds of playback per second, until they
    /// are interrupted.
    ///
    /// # Errors
    /// An address that is in use or does not belong to this machine.
    pub fn open(
        address: SocketAddr,
        speed: Option<f64>,
        interrupt: &Interrupt,
    ) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let buffer = Arc::new(FrameBuffer::new(speed, interrupt));
        let inside = Arc::clone(&buffer);
        let acceptor = thread::spawn(move || accept_viewers(&listener, &inside));
        Ok(Self { buffer, taken: Arc::default(), address, acceptor: Some(acceptor) })
    }

    /// The address of the server.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The observer that broadcasts a run; `None` while another run is broadcast.
    #[must_use]
    pub fn observer(&self, name: &str) -> Option<Box<dyn FrameObserver>> {
        if self.taken.swap(true, Ordering::AcqRel) {
            return None;
        }
        let (buffer, taken) = (Arc::clone(&self.buffer), Arc::clone(&self.taken));
        Some(Box::new(broadcaster::Broadcaster::new(buffer, taken, name)))
    }
}

impl Drop for LiveServer {
    fn drop(&mut self) {
        self.buffer.close();
        if let Some(acceptor) = self.acceptor.take() {
            // A panic of the thread has been reported, and no run depends on it.
            let _ = acceptor.join();
        }
    }
}

/// Accepts viewers until the broadcast ends, then waits until they have disconnected.
fn accept_viewers(listener: &TcpListener, buffer: &Arc<FrameBuffer>) {
    // Distinguishes this server from an earlier one at the same address.
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let session_prefix = since_1970.as_millis().to_string();
    let mut viewers: Vec<JoinHandle<()>> = Vec::new();
    while buffer.closed_for().is_none() {
        match listener.accept() {
            Ok((stream, _)) => {
                let (buffer, prefix) = (Arc::clone(buffer), session_prefix.clone());
                viewers.push(thread::spawn(move || viewer::serve(stream, &buffer, &prefix)));
            }
            // No connection, or one that is already closed.
            Err(_) => thread::sleep(ACCEPT_INTERVAL),
        }
        viewers.retain(|viewer| !viewer.is_finished());
    }
    for viewer in viewers {
        let _ = viewer.join();
    }
}

/// Parses `ADDRESS:PORT`, or a port of this machine.
///
/// # Errors
/// Any other text.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().map(|port: u16| SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    port.ok()
        .or_else(|| text.parse().ok())
        .ok_or_else(|| "write a port, or an address such as 127.0.0.1:8765".to_owned())
}

/// Parses a speed, in seconds of playback per second.
///
/// # Errors
/// A text that is not a number, or a speed out of range.
pub fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse().ok().filter(|speed| (pace::SLOWEST..=pace::FASTEST).contains(speed));
    speed.ok_or_else(|| {
        format!("write a number from {} to {}, such as 1", pace::SLOWEST, pace::FASTEST)
    })
}
