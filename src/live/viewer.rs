//! One viewer's connection, served by its own thread.

use super::admission::Admission;
use super::connection::{Connection, Exchange, Progress, Slot};
use super::frame_buffer::{BroadcastFrame, BroadcastMessage, FrameBuffer, RunInfo};
use super::protocol::{self, Request, Subscription};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};
use tungstenite::handshake::server::{Request as HandshakeRequest, Response};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

/// Time for requests, after which queued frames are sent.
const TURN: Duration = Duration::from_millis(4);
/// The same for a viewer without subscriptions, to which no frames are sent.
const IDLE_TURN: Duration = Duration::from_millis(50);
/// Maximum number of messages that are received in one turn, so that no client occupies a processor.
const MAX_MESSAGES_PER_TURN: usize = 32;
/// Maximum size of a request.
const MAX_REQUEST_BYTES: usize = 1 << 16;
/// Size of the buffer for requests, which each connection allocates.
const READ_BUFFER_BYTES: usize = 1 << 12;
/// The first time that a viewer receives in a session, ns, from which its plots count. Viewers take 0 for a missing time.
const FIRST_TIME_NS: u64 = 1;

/// What all viewers of a server share.
pub(super) struct Service {
    pub(super) buffer: FrameBuffer,
    pub(super) admission: Admission,
    /// Distinguishes this server from an earlier one at the same address.
    pub(super) session_prefix: String,
}

/// Serves one viewer until it disconnects, or until the broadcast has ended and its last frame is sent.
pub(super) fn serve(stream: TcpStream, service: &Service, slot: Arc<Slot>) {
    let buffer = &service.buffer;
    // An error of the connection affects only its viewer, which reports it.
    let Ok(socket) = accept_handshake(stream, service, slot) else { return };
    let id = buffer.add_viewer();
    let changes = buffer.playback().1;
    let mut viewer = Viewer {
        socket,
        buffer,
        id,
        session_prefix: &service.session_prefix,
        run_info: buffer.run_info().0,
        subscriptions: BTreeMap::new(),
        changes,
        time_ns: 0,
    };
    let _ = viewer.announce().and_then(|()| viewer.watch());
    buffer.remove_viewer(id);
}

fn accept_handshake<'a>(
    stream: TcpStream,
    service: &'a Service,
    slot: Arc<Slot>,
) -> Result<WebSocket<Connection<'a>>, Error> {
    let connection = Connection::new(stream, &service.buffer, slot)?;
    let config = WebSocketConfig::default()
        .read_buffer_size(READ_BUFFER_BYTES)
        .max_message_size(Some(MAX_REQUEST_BYTES))
        .max_frame_size(Some(MAX_REQUEST_BYTES));
    #[expect(clippy::result_large_err, reason = "the signature that tungstenite requires")]
    let answer = |request: &HandshakeRequest, response: Response| {
        service.admission.answer(request, response)
    };
    let socket = tungstenite::accept_hdr_with_config(connection, answer, Some(config))
        .map_err(|error| Error::Io(io::Error::other(error.to_string())))?;
    socket.get_ref().report(Progress::Agreed);
    Ok(socket)
}

/// A channel that a viewer receives.
struct Receiving {
    subscription: u32,
    /// Number of the last frame that is not sent again.
    seen: u64,
}

struct Viewer<'a> {
    socket: WebSocket<Connection<'a>>,
    buffer: &'a FrameBuffer,
    id: u64,
    session_prefix: &'a str,
    run_info: Arc<RunInfo>,
    /// By the channel's index in the list.
    subscriptions: BTreeMap<usize, Receiving>,
    /// Number of playback changes already sent.
    changes: u64,
    /// The latest time sent in this session, ns; 0 if none was sent.
    time_ns: u64,
}

impl Viewer<'_> {
    fn watch(&mut self) -> Result<(), Error> {
        loop {
            self.receive()?;
            let over = self.buffer.is_closed();
            self.switch_run()?;
            for frame in self.buffer.take(self.id) {
                self.send_frame(&frame)?;
            }
            self.send_changes()?;
            if over {
                return self.close();
            }
        }
    }

    /// Sends the messages of a frame that the viewer has subscribed to and not received yet.
    fn send_frame(&mut self, frame: &BroadcastFrame) -> Result<(), Error> {
        // The channels of a run that was announced meanwhile are unknown to the viewer.
        if frame.session != self.run_info.session {
            return Ok(());
        }
        for message in &frame.messages {
            let Some(receiving) = self.subscriptions.get(&message.channel) else { continue };
            if receiving.seen >= frame.number {
                continue;
            }
            let subscription = receiving.subscription;
            self.send_time(frame.log_time_ns)?;
            self.send_message(subscription, message)?;
        }
        Ok(())
    }

    /// Sets the viewer's clock, unless it would not advance: a viewer drops everything drawn when its clock goes back.
    fn send_time(&mut self, time_ns: u64) -> Result<(), Error> {
        if time_ns <= self.time_ns {
            return Ok(());
        }
        self.time_ns = time_ns;
        self.send(protocol::time(time_ns))
    }

    /// Sends the server's information, the run and its channels, the start of the run, and the time at which the viewer joins.
    fn announce(&mut self) -> Result<(), Error> {
        let (run_info, joined_ns) = self.buffer.run_info();
        self.run_info = Arc::clone(&run_info);
        // A new session resets the viewer's clock.
        self.time_ns = 0;
        let session = format!("{}-{}", self.session_prefix, run_info.session);
        let range = run_info.channel_list.end_ns.filter(|_| self.buffer.is_paced);
        self.send(protocol::server_info(&run_info.name, &session, range))?;
        let channels = &run_info.channel_list.channels;
        if channels.is_empty() {
            return Ok(());
        }
        self.send(protocol::advertise(channels, run_info.first_channel_id))?;
        // Viewers subtract the first time that they receive from all times of their plots: it must be the start of the run.
        self.send_time(FIRST_TIME_NS)?;
        self.send_time(joined_ns)
    }

    /// Switches to the next run, if one was announced.
    fn switch_run(&mut self) -> Result<(), Error> {
        let last = Arc::clone(&self.run_info);
        if self.buffer.run_info().0.session == last.session {
            return Ok(());
        }
        self.subscriptions.clear();
        let channels = last.channel_list.channels.len() as u64;
        if channels > 0 {
            self.send(protocol::unadvertise(last.first_channel_id, channels))?;
        }
        self.announce()
    }

    /// Receives and answers requests for one turn.
    fn receive(&mut self) -> Result<(), Error> {
        let turn = if self.subscriptions.is_empty() { IDLE_TURN } else { TURN };
        let end = Instant::now() + turn;
        for _ in 0..MAX_MESSAGES_PER_TURN {
            self.socket
                .get_mut()
                .begin(Exchange::Listening(end.saturating_duration_since(Instant::now())));
            let request = match self.socket.read() {
                Ok(Message::Text(text)) => protocol::text_request(&text),
                Ok(Message::Binary(bytes)) => protocol::binary_request(&bytes),
                Ok(Message::Ping(_)) => {
                    // Otherwise, the replies to a client that does not read them would accumulate.
                    self.flush()?;
                    continue;
                }
                Ok(Message::Pong(_) | Message::Close(_) | Message::Frame(_)) => continue,
                Err(Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
                Err(error) => return Err(error),
            };
            match request {
                Some(request) => self.answer(request)?,
                None => {
                    self.send(protocol::warning("the message does not belong to the protocol"))?
                }
            }
        }
        // The client sends faster than any viewer.
        thread::sleep(end.saturating_duration_since(Instant::now()));
        Ok(())
    }

    fn answer(&mut self, request: Request) -> Result<(), Error> {
        match request {
            Request::Subscribe(wanted) => self.subscribe(&wanted),
            Request::Unsubscribe(ids) => {
                self.subscriptions.retain(|_, receiving| !ids.contains(&receiving.subscription));
                Ok(())
            }
            Request::Playback(request) if self.buffer.is_paced => {
                let state = self.buffer.control(self.id, &request);
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
        let (latest, seen) = self.buffer.subscribe(self.run_info.session, &asked);
        for (&channel, &subscription) in &known {
            self.subscriptions.insert(channel, Receiving { subscription, seen });
        }
        let newest = latest.iter().map(|message| message.log_time_ns).max();
        if let Some(newest) = newest {
            self.send_time(newest)?;
        }
        for message in latest {
            let Some(&subscription) = known.get(&message.channel) else { continue };
            self.send_message(subscription, &message)?;
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

    /// Sends a message. Only this thread waits for a viewer that does not read.
    fn send(&mut self, message: impl Into<Message>) -> Result<(), Error> {
        self.socket.get_mut().begin(Exchange::Sending);
        self.socket.send(message.into())?;
        self.report_sent();
        Ok(())
    }

    /// Sends a message of a channel from the memory that all viewers share.
    fn send_message(&mut self, subscription: u32, message: &BroadcastMessage) -> Result<(), Error> {
        let header = protocol::message_header(subscription, message.log_time_ns, &message.payload);
        if !self.socket.can_write() {
            return Err(Error::ConnectionClosed);
        }
        // What a frame of the protocol left in the buffer goes first.
        self.flush()?;
        let connection = self.socket.get_mut();
        connection.write_all(&header)?;
        connection.write_all(&message.payload)?;
        self.report_sent();
        Ok(())
    }

    fn report_sent(&self) {
        if !self.subscriptions.is_empty() {
            self.socket.get_ref().report(Progress::Subscribed);
        }
    }

    /// Sends what is in the buffer, such as the reply to a ping.
    fn flush(&mut self) -> Result<(), Error> {
        self.socket.get_mut().begin(Exchange::Sending);
        self.socket.flush()
    }

    /// Closes the connection after the viewer has read the remaining messages.
    fn close(&mut self) -> Result<(), Error> {
        self.socket.get_mut().begin(Exchange::Closing);
        self.socket.close(None)?;
        while self.socket.read().is_ok() {}
        Ok(())
    }
}
