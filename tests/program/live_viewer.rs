//! A viewer of a run in progress, and the run: the program as a user starts it, and the protocol as a viewer implements it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::error::ProtocolError;
use tungstenite::http::HeaderValue;
use tungstenite::{Error, Message, WebSocket};

/// Time between two frames at 25 frames per second, ns.
pub(crate) const FRAME_NS: u64 = 40_000_000;

/// A program that has not ended by then does not end.
const HANG: Duration = Duration::from_secs(600);

/// A message as recorded: topic, log time in ns, payload.
pub(crate) type Recorded = (String, u64, Vec<u8>);

/// A folder with a manifest and its recordings.
pub(crate) struct Experiment {
    pub(crate) folder: tempfile::TempDir,
    manifest: PathBuf,
}

impl Experiment {
    pub(crate) fn new(manifest: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("watched.toml");
        fs::write(&path, manifest).unwrap();
        Self { folder, manifest: path }
    }

    fn output(&self, output: &str) -> PathBuf {
        self.folder.path().join(output)
    }

    pub(crate) fn command(&self, output: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_run-experiment"));
        command.arg("--output").arg(self.output(output)).args(arguments).arg(&self.manifest);
        command
    }

    /// Starts the program and returns it with the address of its live server.
    pub(crate) fn start(&self, output: &str, arguments: &[&str]) -> (Child, String) {
        let mut command = self.command(output, arguments);
        command.arg("--live=0").stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut program = command.spawn().unwrap();
        let mut lines = BufReader::new(program.stdout.take().unwrap()).lines();
        let invitation = lines.by_ref().map(Result::unwrap).find(|line| line.contains("ws://"));
        let invitation = invitation.expect("the program must print the address of its live server");
        let address = invitation.split("ws://").nth(1).unwrap();
        let address = address.split_whitespace().next().unwrap().to_owned();
        // The output must be read to its end, or the program would block.
        std::thread::spawn(move || lines.for_each(drop));
        (program, address)
    }

    /// Waits for the end of a program and returns its exit code. The limit is far above the time that a busy machine needs.
    pub(crate) fn end_of(program: &mut Child) -> Option<i32> {
        let started = Instant::now();
        loop {
            if let Some(status) = program.try_wait().unwrap() {
                return status.code();
            }
            if started.elapsed() > HANG {
                program.kill().unwrap();
            }
            sleep(Duration::from_millis(5));
        }
    }

    /// The recordings, sorted by name.
    pub(crate) fn recordings(&self, output: &str) -> Vec<PathBuf> {
        let files = fs::read_dir(self.output(output).join("watched")).unwrap();
        let files = files.map(|entry| entry.unwrap().path());
        let mut files: Vec<PathBuf> =
            files.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect();
        files.sort();
        files
    }

    /// The bytes of all recordings that the same manifest gives without a viewer.
    pub(crate) fn recorded_without_viewer(&self) -> Vec<Vec<u8>> {
        let output =
            self.command("recorded_without_viewer", &["--quiet", "--jobs", "1"]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        bytes(&self.recordings("recorded_without_viewer"))
    }
}

pub(crate) fn bytes(files: &[PathBuf]) -> Vec<Vec<u8>> {
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

/// The messages in the order of frames and channels; in the file, groups of channels have chunks of their own.
pub(crate) fn messages(recording: &Path) -> Vec<Recorded> {
    let bytes = fs::read(recording).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let mut messages: Vec<mcap::Message<'_>> = messages.collect();
    messages.sort_by_key(|message| (message.log_time, message.channel.id));
    let recorded = |message: mcap::Message<'_>| {
        (message.channel.topic.clone(), message.log_time, message.data.into_owned())
    };
    messages.into_iter().map(recorded).collect()
}

/// What a viewer receives.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Received {
    /// A text message, such as `serverInfo`.
    Text(Value),
    /// A message of a topic: log time in ns, payload.
    Data(Recorded),
    /// The viewer's clock, ns.
    Time(u64),
    /// Whether the run is paused, log time in ns, and the id of the answered request.
    Playback(bool, u64, String),
    /// The connection has ended: the server has closed it, or the program has ended before this viewer replied.
    Closed,
}

pub(crate) struct Viewer {
    socket: WebSocket<TcpStream>,
    /// Topics by channel id, as announced.
    pub(crate) topics: BTreeMap<u64, String>,
    /// Topics by subscription id, which equals the channel id.
    subscribed: BTreeMap<u32, String>,
}

/// A connection on which the protocol was agreed, or the reason why the server did not agree.
pub(crate) fn agree(address: &str) -> Result<WebSocket<TcpStream>, String> {
    let stream = TcpStream::connect(address).map_err(|error| error.to_string())?;
    let mut request = format!("ws://{address}").into_client_request().unwrap();
    // Lichtblick offers an older protocol as well.
    let offer = HeaderValue::from_static("foxglove.websocket.v1, foxglove.sdk.v1");
    request.headers_mut().insert("sec-websocket-protocol", offer);
    let (socket, response) =
        tungstenite::client(request, stream).map_err(|error| error.to_string())?;
    assert_eq!(response.headers()["sec-websocket-protocol"], "foxglove.sdk.v1");
    Ok(socket)
}

impl Viewer {
    /// Connects without reading the announcement.
    pub(crate) fn connect(address: &str) -> Self {
        Self::try_connect(address).unwrap()
    }

    /// Connects to a program that may have ended.
    pub(crate) fn try_connect(address: &str) -> Result<Self, String> {
        let socket = agree(address)?;
        Ok(Self { socket, topics: BTreeMap::new(), subscribed: BTreeMap::new() })
    }

    /// Receives the next message.
    pub(crate) fn receive(&mut self) -> Received {
        match self.socket.read() {
            Ok(Message::Text(text)) => {
                let said: Value = serde_json::from_str(&text).unwrap();
                if said["op"] == "advertise" {
                    for channel in said["channels"].as_array().unwrap() {
                        let topic = channel["topic"].as_str().unwrap().to_owned();
                        self.topics.insert(channel["id"].as_u64().unwrap(), topic);
                    }
                } else if said["op"] == "unadvertise" {
                    for id in said["channelIds"].as_array().unwrap() {
                        self.topics.remove(&id.as_u64().unwrap());
                    }
                }
                Received::Text(said)
            }
            Ok(Message::Binary(bytes)) => self.receive_binary(&bytes),
            Ok(Message::Close(_))
            | Err(
                Error::ConnectionClosed
                | Error::Io(_)
                | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake),
            ) => Received::Closed,
            other => panic!("{other:?}"),
        }
    }

    fn receive_binary(&self, bytes: &[u8]) -> Received {
        let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        match bytes[0] {
            1 => {
                let topic = self.subscribed[&u32_at(1)].clone();
                Received::Data((topic, u64_at(5), bytes[13..].to_vec()))
            }
            2 => Received::Time(u64_at(1)),
            5 => {
                let id = str::from_utf8(&bytes[19..]).unwrap().to_owned();
                assert_eq!(u32_at(15) as usize, id.len());
                Received::Playback(bytes[1] == 1, u64_at(2), id)
            }
            other => panic!("operation {other}"),
        }
    }

    /// Receives messages until one satisfies a condition, and returns all of them.
    pub(crate) fn receive_until(&mut self, wanted: impl Fn(&Received) -> bool) -> Vec<Received> {
        let mut events = Vec::new();
        loop {
            events.push(self.receive());
            let last = &events[events.len() - 1];
            if wanted(last) {
                return events;
            }
            assert!(*last != Received::Closed, "closed after {events:?}");
        }
    }

    pub(crate) fn receive_the_announcement(&mut self) -> Vec<Received> {
        self.receive_until(
            |event| matches!(event, Received::Text(said) if said["op"] == "advertise"),
        )
    }

    pub(crate) fn subscribe_to_all(&mut self) {
        let topics: Vec<String> = self.topics.values().cloned().collect();
        let topics: Vec<&str> = topics.iter().map(String::as_str).collect();
        self.subscribe(&topics);
    }

    /// Subscribes to topics with one request.
    pub(crate) fn subscribe(&mut self, wanted: &[&str]) {
        let channels = self.topics.iter().filter(|(_, topic)| wanted.contains(&topic.as_str()));
        let channels: Vec<(u32, String)> =
            channels.map(|(id, topic)| (*id as u32, topic.clone())).collect();
        assert_eq!(channels.len(), wanted.len(), "{wanted:?} of {:?}", self.topics);
        let wanted: Vec<Value> =
            channels.iter().map(|(id, _)| json!({ "id": id, "channelId": id })).collect();
        self.subscribed.extend(channels);
        let request = json!({ "op": "subscribe", "subscriptions": wanted });
        self.send(Message::text(request.to_string()));
    }

    /// Requests to play or pause at a speed, and to advance to a log time unless it is 0.
    pub(crate) fn ask(&mut self, pause: bool, speed: f32, to_ns: u64, id: &str) {
        let mut request = vec![3, u8::from(pause)];
        request.extend(speed.to_le_bytes());
        request.push(u8::from(to_ns > 0));
        request.extend(to_ns.to_le_bytes());
        request.extend((id.len() as u32).to_le_bytes());
        request.extend(id.as_bytes());
        self.send(Message::binary(request));
    }

    /// Sends a request. If the connection has ended, [`Viewer::receive`] reports it.
    fn send(&mut self, request: Message) {
        let _ = self.socket.send(request);
    }
}

/// The data messages among the received ones.
pub(crate) fn data(events: &[Received]) -> Vec<Recorded> {
    events
        .iter()
        .filter_map(|event| match event {
            Received::Data(message) => Some(message.clone()),
            _ => None,
        })
        .collect()
}
