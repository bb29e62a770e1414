//! Live view of a run in progress: a server for Foxglove and its open fork Lichtblick with the protocol `foxglove.sdk.v1`.
//!
//! Viewers receive the recorded messages byte for byte. Invariant: they never change a recording. A slow viewer misses whole
//! frames and delays neither the run nor other viewers. Without a speed, the run advances at full speed, and viewers receive as
//! many frames as the playback shows in the same time. With a speed, the run is held to it and waits for the first viewer;
//! viewers with the protocol's playback control can pause, step and change the speed. Lichtblick has no such control.
//!
//! Clients may be hostile, such as a web page in the user's browser. `admission.rs` rejects pages that are not known viewers.
//! `connection.rs` ends every exchange at a deadline and limits the number of connections, so that no client can delay the end of
//! the program or lock out a viewer.
//!
//! If several runs execute in parallel, the first one is shown. When it ends, the next run that starts is shown.
//!
//! `gnuplot_loop.rs` writes the newest frame of each run as text files for gnuplot instead.

mod admission;
mod broadcaster;
mod connection;
mod frame_buffer;
pub(crate) mod gnuplot_loop;
mod pace;
mod protocol;
mod viewer;

pub use admission::{Admission, host, origin};
pub use gnuplot_loop::GnuplotLoop;

use crate::interrupt::Interrupt;
use connection::Progress;
use frame_buffer::FrameBuffer;
use kinetoscope_files::connection_slots::{MAX_OPEN, Slots};
use kinetoscope_recording::observer::FrameObserver;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use viewer::Service;

/// The default port of viewers, open to this machine only.
pub const DEFAULT_PORT: u16 = 8765;
/// Interval at which new connections are accepted.
const ACCEPT_INTERVAL: Duration = Duration::from_millis(20);
/// Interval at which the end of the connections is checked.
const END_INTERVAL: Duration = Duration::from_millis(2);
/// Time for the threads of connections to end after the deadline of closing.
const LAST_WAIT: Duration = Duration::from_millis(300);

/// The server. When dropped, it sends the last frame to the viewers and closes within two seconds.
pub struct LiveServer {
    service: Arc<Service>,
    taken: Arc<AtomicBool>,
    address: SocketAddr,
    acceptor: Option<JoinHandle<()>>,
}

impl LiveServer {
    /// Listens at an address; port 0 selects a free port. Runs are held to `speed`, in seconds of playback per second, until they
    /// are interrupted.
    ///
    /// # Errors
    /// An address that is in use or does not belong to this machine, or a machine without threads left.
    pub fn open(
        address: SocketAddr,
        speed: Option<f64>,
        admission: Admission,
        interrupt: &Interrupt,
    ) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let service = Arc::new(Service {
            buffer: FrameBuffer::new(speed, interrupt),
            admission,
            session_prefix: since_1970.as_millis().to_string(),
        });
        let inside = Arc::clone(&service);
        let acceptor = thread::Builder::new().spawn(move || accept_viewers(&listener, &inside))?;
        Ok(Self { service, taken: Arc::default(), address, acceptor: Some(acceptor) })
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
        let (service, taken) = (Arc::clone(&self.service), Arc::clone(&self.taken));
        Some(Box::new(broadcaster::Broadcaster::new(service, taken, name)))
    }
}

impl Drop for LiveServer {
    fn drop(&mut self) {
        self.service.buffer.close();
        if let Some(acceptor) = self.acceptor.take() {
            // A panic of the thread has been reported, and no run depends on it.
            let _ = acceptor.join();
        }
    }
}

/// Accepts viewers until the broadcast ends, then waits until they have disconnected, which the deadline of closing limits.
fn accept_viewers(listener: &TcpListener, service: &Arc<Service>) {
    let mut slots = Slots::default();
    let mut viewers: Vec<JoinHandle<()>> = Vec::new();
    while !service.buffer.is_closed() {
        viewers.retain(|viewer| !viewer.is_finished());
        let accepted = if viewers.len() < MAX_OPEN { listener.accept().ok() } else { None };
        let Some((stream, _)) = accepted else {
            thread::sleep(ACCEPT_INTERVAL);
            continue;
        };
        let (inside, slot) = (Arc::clone(service), slots.occupy(Progress::Connected));
        let serve = move || viewer::serve(stream, &inside, slot);
        // Without a thread for it, the connection is closed.
        viewers.extend(thread::Builder::new().spawn(serve));
    }
    let mut over = None;
    while viewers.iter().any(|viewer| !viewer.is_finished()) {
        // A thread that outlives the deadline ends with the program.
        if service.buffer.is_over() && over.get_or_insert_with(Instant::now).elapsed() > LAST_WAIT {
            return;
        }
        thread::sleep(END_INTERVAL);
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
