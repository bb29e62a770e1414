//! Connections of the server: a limited number, each of which ends if its client does not go on.
//!
//! A client that sends or reads slowly occupies one of them. If all are occupied, a new connection displaces the one that has achieved
//! least, so that clients that only connect cannot lock out a viewer.

use socket2::SockRef;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, Sleep, sleep};

/// Maximum number of connections.
const MAX_CONNECTIONS: usize = 64;
/// Maximum number together with displaced connections that have not ended yet.
const MAX_OPEN: usize = 2 * MAX_CONNECTIONS;
/// Time until the first byte of an answer.
const FIRST_ANSWER: Duration = Duration::from_secs(5);
/// Time without an answered byte, after the first one.
const SILENCE: Duration = Duration::from_secs(60);
/// Interval at which a connection checks whether it must end.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Bytes that the system takes before the client reads them. They count as sent, so many of them would hide that a slow client reads.
const SEND_BUFFER: usize = 1 << 16;

/// What a connection has achieved, from the one that is displaced first to the one that is displaced last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Progress {
    is_answered: bool,
    /// Whether the client is to read the rest of an answer.
    is_reading: bool,
    /// When the connection was accepted, or the last byte was sent.
    since: Instant,
}

/// The place of one connection among all.
#[derive(Debug)]
struct Slot {
    progress: Mutex<Progress>,
    is_displaced: AtomicBool,
}

impl Slot {
    fn progress(&self) -> Progress {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn update(&self, change: impl FnOnce(&mut Progress)) {
        change(&mut self.progress.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn must_end(&self) -> bool {
        let Progress { is_answered, since, .. } = self.progress();
        let limit = if is_answered { SILENCE } else { FIRST_ANSWER };
        self.is_displaced.load(Ordering::Relaxed) || since.elapsed() >= limit
    }
}

/// A listener that accepts a limited number of connections.
#[derive(Debug)]
pub(super) struct Listener {
    listener: TcpListener,
    slots: Vec<Weak<Slot>>,
}

impl Listener {
    pub(super) fn new(listener: TcpListener) -> Self {
        Self { listener, slots: Vec::new() }
    }

    /// Occupies a slot until the value is dropped.
    fn occupy(&mut self) -> Arc<Slot> {
        let occupied = self.slots.iter().filter_map(Weak::upgrade);
        let occupied: Vec<Arc<Slot>> =
            occupied.filter(|slot| !slot.is_displaced.load(Ordering::Relaxed)).collect();
        if occupied.len() >= MAX_CONNECTIONS
            && let Some(least) = occupied.iter().min_by_key(|slot| slot.progress())
        {
            least.is_displaced.store(true, Ordering::Relaxed);
        }
        let progress = Progress { is_answered: false, is_reading: false, since: Instant::now() };
        let slot =
            Arc::new(Slot { progress: Mutex::new(progress), is_displaced: AtomicBool::new(false) });
        self.slots.push(Arc::downgrade(&slot));
        slot
    }
}

impl axum::serve::Listener for Listener {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        loop {
            self.slots.retain(|slot| slot.strong_count() > 0);
            if self.slots.len() < MAX_OPEN
                && let Ok((stream, address)) = self.listener.accept().await
            {
                // Without it, only the rank of a slow client is lower.
                let _ = SockRef::from(&stream).set_send_buffer_size(SEND_BUFFER);
                // Without it, small answers on one connection wait for each other.
                let _ = stream.set_nodelay(true);
                let (slot, check) = (self.occupy(), Box::pin(sleep(CHECK_INTERVAL)));
                return (Connection { stream, slot, check }, address);
            }
            sleep(CHECK_INTERVAL).await;
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection whose reads and writes end at its deadline, or when another one takes its slot.
#[derive(Debug)]
pub(super) struct Connection {
    stream: TcpStream,
    slot: Arc<Slot>,
    check: Pin<Box<Sleep>>,
}

impl Connection {
    /// Wakes the task at the next check as well, because the client may never do so.
    fn check(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        if self.slot.must_end() {
            return Err(ErrorKind::ConnectionAborted.into());
        }
        while self.check.as_mut().poll(context).is_ready() {
            self.check.as_mut().reset(Instant::now() + CHECK_INTERVAL);
        }
        Ok(())
    }

    fn stream(&mut self) -> Pin<&mut TcpStream> {
        Pin::new(&mut self.stream)
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.check(context)?;
        self.stream().poll_read(context, buffer)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.check(context)?;
        let sent = self.stream().poll_write(context, bytes);
        self.slot.update(|progress| match &sent {
            Poll::Pending => progress.is_reading = true,
            Poll::Ready(_) => {
                *progress =
                    Progress { is_answered: true, is_reading: false, since: Instant::now() };
            }
        });
        sent
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_shutdown(context)
    }
}
