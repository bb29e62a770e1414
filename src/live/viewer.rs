//! One viewer's connection, served by its own thread.

use super::frame_buffer::{FrameBuffer, RunInfo};
use super::protocol::{self, Request, SUBPROTOCOL, Subscription};
use std::collections::BTreeMap;
use std::io;
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;
use tungstenite::handshake::server::{ErrorResponse, Request as HandshakeRequest, Response};
use tungstenite::http::{HeaderValue, StatusCode, header::SEC_WEBSOCKET_PROTOCOL};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

/// Time limit of the handshake, of one write, and of the closing handshake.
const CONNECTION_TIMEOUT: Duration = Duration::from_secs(1);
/// Time limit of one read, after which queued frames are sent.
const READ_TIMEOUT: Duration = Duration::from_millis(4);
/// Maximum size of a request.
const MAX_REQUEST_BYTES: usize = 1 << 16;

/// Serves one viewer until it disconnects, or until the broadcast has ended and its last frame is sent.
pub(super) fn serve(stream: TcpStream, buffer: &FrameBuffer, session_prefix: &str) {
    let Some(id) = buffer.add_viewer() else { return };
    // An error of the connection affects only its viewer, which reports it.
    let _ = accept_handshake(stream).and_then(|socket| {
        let (subscriptions, run_info) = (BTreeMap::new(), buffer.run_info());
        let changes = buffer.playback().1;
        let mut viewer =
            Viewer { socket, buffer, id, session_prefix, run_info, subscriptions, changes };
        viewer.announce()?;
        viewer.watch()
    });
    buffer.remove_viewer(id);
}

fn accept_handshake(stream: TcpStream) -> Result<WebSocket<TcpStream>, Error> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(CONNECTION_TIMEOUT))?;
    stream.set_write_timeout(Some(CONNECTION_TIMEOUT))?;
    let config = WebSocketConfig::default().max_message_size(Some(MAX_REQUEST_BYTES));
    let socket = tungstenite::accept_hdr_with_config(stream, select_protocol, Some(config));
    let socket = socket.map_err(|error| Error::Io(io::Error::other(error.to_string())))?;
    socket.get_ref().set_read_timeout(Some(READ_TIMEOUT))?;
    Ok(socket)
}

/// Selects the protocol, which the viewer must have offered.
#[expect(clippy::result_large_err, reason = "the signature that tungstenite requires")]
fn select_protocol(
    request: &HandshakeRequest,
    mut response: Response,
) -> Result<Response, ErrorResponse> {
    let offers = request.headers().get_all(SEC_WEBSOCKET_PROTOCOL).iter();
    let offered = offers
        .flat_map(|offer| offer.to_str().unwrap_or_default().split(','))
        .any(|offer| offer.trim() == SUBPROTOCOL);
    if !offered {
        let mut rejection = ErrorResponse::new(Some(format!("this server requires {SUBPROTOCOL}")));
        *rejection.status_mut() = StatusCode::BAD_REQUEST;
        return Err(rejection);
    }
    let agreed = HeaderValue::from_static(SUBPROTOCOL);
    response.headers_mut().insert(SEC_WEBSOCKET_PROTOCOL, agreed);
    Ok(response)
}

/// A channel that a viewer receives.
struct Receiving {
    subscription: u32,
    /// Number of the last frame that is not sent again.
    seen: u64,
}

struct Viewer<'a> {
    socket: WebSocket<TcpStream>,
    buffer: &'a FrameBuffer,
    id: u64,
    session_prefix: &'a str,
    run_info: Arc<RunInfo>,
    /// By the channel's index in the list.
    subscriptions: BTreeMap<usize, Receiving>,
    /// Number of playback changes already sent.
    changes: u64,
}

impl Viewer<'_> {
    fn watch(&mut self) -> Result<(), Error> {
        loop {
            self.receive()?;
            let over = self.buffer.closed_for().is_some();
            self.switch_run()?;
            for frame in self.buffer.take(self.id) {
                let mut has_time = false;
                for message in &frame.messages {
                    let Some(receiving) = self.subscriptions.get(&message.channel) else {
                        continue;
                    };
                    if receiving.seen >= frame.number {
                        continue;
                    }
                    let subscription = receiving.subscription;
                    if !has_time {
                        self.send(protocol::time(frame.log_time_ns))?;
                        has_time = true;
                    }
                    let log_time = message.log_time_ns;
                    self.send(protocol::message_data(subscription, log_time, &message.payload))?;
                }
            }
            self.send_changes()?;
            if over {
                return self.close();
            }
        }
    }

    /// Sends the server's information, the run and its channels.
    fn announce(&mut self) -> Result<(), Error> {
        let run_info = Arc::clone(&self.run_info);
        let session = format!("{}-{}", self.session_prefix, run_info.session);
        let range = run_info.channel_list.end_ns.filter(|_| self.buffer.is_paced);
        self.send(protocol::server_info(&run_info.name, &session, range))?;
        let channels = &run_info.channel_list.channels;
        if channels.is_empty() {
            return Ok(());
        }
        self.send(protocol::advertise(channels, run_info.first_channel_id))
    }

    /// Switches to the next run, if one was announced.
    fn switch_run(&mut self) -> Result<(), Error> {
        let now = self.buffer.run_info();
        if now.session == self.run_info.session {
            return Ok(());
        }
        let last = std::mem::replace(&mut self.run_info, now);
        self.subscriptions.clear();
        let channels = last.channel_list.channels.len() as u64;
        if channels > 0 {
            self.send(protocol::unadvertise(last.first_channel_id, channels))?;
        }
        self.announce()
    }

    /// Receives and answers requests for a few milliseconds.
    fn receive(&mut self) -> Result<(), Error> {
        loop {
            let request = match self.socket.read() {
                Ok(Message::Text(text)) => protocol::text_request(&text),
                Ok(Message::Binary(bytes)) => protocol::binary_request(&bytes),
                Ok(Message::Ping(_) | Message::Pong(_) | Message::Close(_) | Message::Frame(_)) => {
                    continue;
                }
                Err(error) if would_block(&error) => return Ok(()),
                Err(error) => return Err(error),
            };
            match request {
                Some(request) => self.answer(request)?,
                None => {
                    self.send(protocol::warning("the message does not belong to the protocol"))?
                }
            }
        }
    }

    fn answer(&mut self, request: Request) -> Result<(), Error> {
        match request {
            Request::Subscribe(wanted) => self.subscribe(&wanted),
            Request::Unsubscribe(ids) => {
                self.subscriptions.retain(|_, receiving| !ids.contains(&receiving.subscription));
                Ok(())
            }
            Request::Playback(request) if self.buffer.is_paced => {
                let state = self.buffer.control(&request);
                self.send(state.encode(&request.id))?;
                if request.jump_to_ns.is_some_and(|to| to < state.time_ns) {
                    let text =
                        "a run in progress cannot go back: open its recording when it is finished";
                    self.send(protocol::warning(text))?;
                }
                Ok(())
            }
            Request::Playback(_) => {
                let text = "the run has full speed: --live-speed 1 lets viewers control it";
                self.send(protocol::warning(text))
            }
            Request::Other => Ok(()),
        }
    }

    /// Subscribes to channels and sends the last message of each.
    fn subscribe(&mut self, wanted: &[Subscription]) -> Result<(), Error> {
        // Channels of a run that has ended are ignored.
        let first = self.run_info.first_channel_id;
        let channels = self.run_info.channel_list.channels.len();
        let known = wanted.iter().filter_map(|subscription| {
            let channel = subscription.channel_id.checked_sub(first)? as usize;
            (channel < channels).then_some((channel, subscription.id))
        });
        let known: BTreeMap<usize, u32> = known.collect();
        let asked: Vec<usize> = known.keys().copied().collect();
        let (latest, seen) = self.buffer.subscribe(&asked);
        for (&channel, &subscription) in &known {
            self.subscriptions.insert(channel, Receiving { subscription, seen });
        }
        let newest = latest.iter().map(|message| message.log_time_ns).max();
        if let Some(newest) = newest {
            self.send(protocol::time(newest))?;
        }
        for message in latest {
            let Some(&subscription) = known.get(&message.channel) else { continue };
            let data = protocol::message_data(subscription, message.log_time_ns, &message.payload);
            self.send(data)?;
        }
        Ok(())
    }

    /// Sends the playback state if another viewer or the end of a pause changed it.
    fn send_changes(&mut self) -> Result<(), Error> {
        let (state, changes) = self.buffer.playback();
        if self.buffer.is_paced && changes != self.changes {
            self.changes = changes;
            self.send(state.encode(""))?;
        }
        Ok(())
    }

    /// Sends a message. Only this thread waits for a viewer that does not read; after the end of the broadcast, it stops waiting.
    fn send(&mut self, message: impl Into<Message>) -> Result<(), Error> {
        let mut sent = self.socket.send(message.into());
        while let Err(error) = sent {
            let late = self.buffer.closed_for().is_some_and(|closed| closed > CONNECTION_TIMEOUT);
            if late || !would_block(&error) {
                return Err(error);
            }
            sent = self.socket.flush();
        }
        Ok(())
    }

    /// Closes the connection after the viewer has read the remaining messages.
    fn close(&mut self) -> Result<(), Error> {
        self.socket.close(None)?;
        self.socket.get_ref().set_read_timeout(Some(CONNECTION_TIMEOUT))?;
        while self.socket.read().is_ok() {}
        Ok(())
    }
}

/// Whether a read or a write reached its time limit; the error kind depends on the system.
fn would_block(error: &Error) -> bool {
    let Error::Io(error) = error else { return false };
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}
