//! Clients of the live server that are slow, silent or excessive, each on its own thread until the server ends the connection.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use crate::live_viewer::agree;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::thread::{self, JoinHandle, sleep};
use std::time::Duration;
use tungstenite::{Bytes, Message};

/// What a client does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hostility {
    /// Sends the request of the handshake byte by byte.
    Drips,
    /// Connects and sends nothing.
    Connects,
    /// Agrees on the protocol, subscribes to all channels, and does not read.
    DoesNotRead,
    /// Sends a ping every millisecond.
    Pings,
    /// Sends a text every half second.
    Texts,
    /// Sends requests as fast as the server accepts them, and does not read the replies.
    Floods,
}

pub(crate) const HOSTILITIES: [Hostility; 6] = [
    Hostility::Drips,
    Hostility::Connects,
    Hostility::DoesNotRead,
    Hostility::Pings,
    Hostility::Texts,
    Hostility::Floods,
];

/// Starts a client after it has connected.
pub(crate) fn start(hostility: Hostility, address: &str) -> JoinHandle<()> {
    match hostility {
        Hostility::Drips => {
            let mut stream = TcpStream::connect(address).unwrap();
            let request = format!("GET / HTTP/1.1\r\nHost: {address}\r\nX-Drip: ");
            thread::spawn(move || {
                for byte in request.bytes().chain(std::iter::repeat(b'x')) {
                    if stream.write_all(&[byte]).is_err() {
                        return;
                    }
                    sleep(Duration::from_millis(100));
                }
            })
        }
        Hostility::Connects => {
            let mut stream = TcpStream::connect(address).unwrap();
            thread::spawn(move || {
                let _ = stream.read_to_end(&mut Vec::new());
            })
        }
        Hostility::DoesNotRead => {
            // The ids of the channels of the first run begin with 1; ids without a channel are ignored.
            let wanted: Vec<String> =
                (1..=40).map(|id| format!("{{\"id\":{id},\"channelId\":{id}}}")).collect();
            let request =
                format!("{{\"op\":\"subscribe\",\"subscriptions\":[{}]}}", wanted.join(","));
            send_every(address, Message::text(request), Duration::from_secs(1))
        }
        Hostility::Pings => {
            let ping = Message::Ping(Bytes::from_static(&[7; 125]));
            send_every(address, ping, Duration::from_millis(1))
        }
        Hostility::Texts => send_every(address, Message::text("{}"), Duration::from_millis(500)),
        Hostility::Floods => send_every(address, Message::text("{}"), Duration::ZERO),
    }
}

/// Agrees on the protocol, and sends a message again and again without reading.
fn send_every(address: &str, message: Message, interval: Duration) -> JoinHandle<()> {
    let mut socket = agree(address).unwrap();
    thread::spawn(move || {
        while socket.send(message.clone()).is_ok() {
            sleep(interval);
        }
    })
}
