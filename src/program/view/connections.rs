//! Connections of the server: a limited number, each of which ends if its client does not go on.
//!
//! A client that sends or reads slowly occupies one of them. If all are occupied, a new connection displaces the one that has achieved
//! least, so that clients that only connect cannot lock out a viewer.

use kinetoscope_files::connection_slots::{CHECK_INTERVAL, Slot, Slots};
use socket2::SockRef;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, Sleep, sleep};

/// Time until the first byte of an answer.
const FIRST_ANSWER: Duration = Duration::from_secs(5);
/// Time without an answered byte, after the first one.
const SILENCE: Duration = Duration::from_secs(60);

/// Bytes that the system takes before the client reads them. They count as sent, so many of them would hide that a slow client reads.
const SEND_BUFFER: usize = 1 << 16;

/// What a connection has achieved, from the one that is displaced first to the one that is displaced last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Progress {
    is_answered: bool,
    /// Whether the client is to read the rest of an answer.
    is_reading: bool,
}

/// Whether a connection has been displaced, or its client has not gone on in time.
fn must_end(slot: &Slot<Progress>) -> bool {
    let (Progress { is_answered, .. }, since) = slot.progress();
    let limit = if is_answered { SILENCE } else { FIRST_ANSWER };
    slot.is_displaced() || since.elapsed() >= limit
}

/// A listener that accepts a limited number of connections.
#[derive(Debug)]
pub(super) struct Listener {
    listener: TcpListener,
    slots: Slots<Progress>,
}

impl Listener {
    pub(super) fn new(listener: TcpListener) -> Self {
        Self { listener, slots: Slots::default() }
    }
}

impl axum::serve::Listener for Listener {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Self::Io, Self::Addr) {
        loop {
            if self.slots.has_room()
                && let Ok((stream, address)) = self.listener.accept().await
            {
                // Without it, only the rank of a slow client is lower.
                let _ = SockRef::from(&stream).set_send_buffer_size(SEND_BUFFER);
                // Without it, small answers on one connection wait for each other.
                let _ = stream.set_nodelay(true);
                let progress = Progress { is_answered: false, is_reading: false };
                let (slot, check) = (self.slots.occupy(progress), Box::pin(sleep(CHECK_INTERVAL)));
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
    slot: Arc<Slot<Progress>>,
    check: Pin<Box<Sleep>>,
}

impl Connection {
    /// Wakes the task at the next check as well, because the client may never do so.
    fn check(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        if must_end(&self.slot) {
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
        match &sent {
            Poll::Pending => self.slot.change(|progress| progress.is_reading = true),
            Poll::Ready(_) => self.slot.report(Progress { is_answered: true, is_reading: false }),
        }
        sent
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_shutdown(context)
    }
}
