//! A run watched while it is under way: a server for Foxglove and its open fork Lichtblick, by the protocol
//! `foxglove.sdk.v1`.
//!
//! Viewers receive the messages that are recorded, byte for byte. They never change a recording. A slow viewer misses whole
//! frames and delays nobody. Without a speed the run goes as fast as it can, and viewers see as many frames as playback has
//! in the same time. With a speed the run keeps that pace, waits for the first viewer, and viewers pause, step and change
//! the speed.
//!
//! Of runs side by side one is shown, the first under way; when it ends, the next one that starts.

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

/// Where viewers look first; from this machine alone.
pub const USUAL_PORT: u16 = 8765;
/// How soon a new viewer is let in.
const KNOCKING: Duration = Duration::from_millis(20);

/// The server. Dropped, it lets the viewers see the last frame and closes.
pub struct LiveServer {
    buffer: Arc<FrameBuffer>,
    taken: Arc<AtomicBool>,
    address: SocketAddr,
    door: Option<JoinHandle<()>>,
}

impl LiveServer {
    /// Listens at an address; port 0 is any free one. With a speed, in seconds of playback a second, runs are held to it
    /// until they are interrupted.
    ///
    /// # Errors
    /// An address that is in use or not this machine's.
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
        let door = thread::spawn(move || keep_the_door(&listener, &inside));
        Ok(Self { buffer, taken: Arc::default(), address, door: Some(door) })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Who watches a run for the viewers; `None` while another run is shown.
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
        if let Some(door) = self.door.take() {
            // A panic in there has been reported, and no run depends on it.
            let _ = door.join();
        }
    }
}

/// Lets viewers in until the show is over and they are gone.
fn keep_the_door(listener: &TcpListener, buffer: &Arc<FrameBuffer>) {
    // Tells this server from an earlier one at the same address.
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let session_prefix = since_1970.as_millis().to_string();
    let mut viewers: Vec<JoinHandle<()>> = Vec::new();
    while buffer.closed_for().is_none() {
        match listener.accept() {
            Ok((stream, _)) => {
                let (buffer, prefix) = (Arc::clone(buffer), session_prefix.clone());
                viewers.push(thread::spawn(move || viewer::serve(stream, &buffer, &prefix)));
            }
            // Nobody, or somebody who is gone already.
            Err(_) => thread::sleep(KNOCKING),
        }
        viewers.retain(|viewer| !viewer.is_finished());
    }
    for viewer in viewers {
        let _ = viewer.join();
    }
}

/// An address of the command line: `ADDRESS:PORT`, or a port of this machine alone.
///
/// # Errors
/// What is neither.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().map(|port: u16| SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    port.ok()
        .or_else(|| text.parse().ok())
        .ok_or_else(|| "write a port, or an address such as 127.0.0.1:8765".to_owned())
}

/// A speed of the command line, in seconds of playback a second.
///
/// # Errors
/// What is no number, or none that a run can be held to.
pub fn speed(text: &str) -> Result<f64, String> {
    let speed = text.parse().ok().filter(|speed| (pace::SLOWEST..=pace::FASTEST).contains(speed));
    speed.ok_or_else(|| {
        format!("write a number from {} to {}, such as 1", pace::SLOWEST, pace::FASTEST)
    })
}
