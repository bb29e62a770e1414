//! An S3 server on loopback, behind a connection that can be cut or held.
#![allow(clippy::unwrap_used, reason = "a test's helper may panic")]

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::thread::{sleep, spawn};
use std::time::Duration;

/// What the connection does when the allowed number of bytes has passed toward the server.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wire {
    /// The connection is cut permanently.
    Cut,
    /// Further bytes are held back.
    Held,
}

/// moto's server with a bucket named `bucket`, and the connection to it. Both end when this value is dropped.
pub(crate) struct S3Server {
    child: Child,
    port: u16,
    wire: u16,
    /// Bytes that may still pass toward the server.
    allowed: Arc<AtomicI64>,
}

impl S3Server {
    pub(crate) fn start(wire: Wire) -> Self {
        let (child, port) = Self::start_server();
        let allowed = Arc::new(AtomicI64::new(i64::MAX));
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let server = Self {
            child,
            port,
            wire: listener.local_addr().unwrap().port(),
            allowed: allowed.clone(),
        };
        spawn(move || {
            for client in listener.incoming() {
                let (client, allowed) = (client.unwrap(), allowed.clone());
                spawn(move || pass(&client, port, &allowed, wire));
            }
        });
        server.put("/bucket", b"");
        server
    }

    /// Starts the server at a free port; again at another one if a program took the port in the meantime.
    fn start_server() -> (Child, u16) {
        for _ in 0..10 {
            let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
            let mut child = Command::new("moto_server")
                .args(["-H", "127.0.0.1", "-p", &port.to_string()])
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("moto_server of the Python package moto must be on the PATH");
            while child.try_wait().unwrap().is_none() {
                if TcpStream::connect(("127.0.0.1", port)).is_ok() {
                    return (child, port);
                }
                sleep(Duration::from_millis(50));
            }
        }
        panic!("moto_server ended ten times before it answered");
    }

    /// Allows more bytes to pass toward the server.
    pub(crate) fn allow(&self, bytes: i64) {
        self.allowed.store(bytes, Ordering::SeqCst);
    }

    /// Whether the connection is held or cut.
    pub(crate) fn is_stopped(&self) -> bool {
        self.allowed.load(Ordering::SeqCst) < 0
    }

    /// A command whose environment names the server behind the connection.
    pub(crate) fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command
            .env("AWS_ENDPOINT_URL", format!("http://127.0.0.1:{}", self.wire))
            .env("AWS_ALLOW_HTTP", "true")
            .env("AWS_ACCESS_KEY_ID", "nobody")
            .env("AWS_SECRET_ACCESS_KEY", "nothing")
            .env("AWS_REGION", "us-east-1");
        command
    }

    /// The body of an object or a listing, requested without the connection; `None` if it does not exist.
    pub(crate) fn get(&self, path: &str) -> Option<Vec<u8>> {
        let (status, body) = self.request("GET", path, b"");
        (status == "200").then_some(body)
    }

    /// The names of all objects of the bucket with the given end.
    pub(crate) fn names(&self, end: &str) -> Vec<String> {
        let listing = String::from_utf8(self.get("/bucket").unwrap()).unwrap();
        let names = listing.split("<Key>").skip(1).filter_map(|rest| rest.split('<').next());
        names.filter(|name| name.ends_with(end)).map(str::to_owned).collect()
    }

    pub(crate) fn put(&self, path: &str, body: &[u8]) {
        assert_eq!(self.request("PUT", path, body).0, "200");
    }

    /// Sends one request. The server requires credentials and accepts any.
    fn request(&self, method: &str, path: &str, body: &[u8]) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let head = format!(
            "{method} {path} HTTP/1.0\r\nHost: 127.0.0.1:{}\r\nAuthorization: AWS nobody:nothing\r\nContent-Length: {}\r\n\r\n",
            self.port,
            body.len()
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|window| window == b"\r\n\r\n").unwrap();
        let status = String::from_utf8(answer[9..12].to_vec()).unwrap();
        (status, answer.split_off(end + 4))
    }
}

impl Drop for S3Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Passes bytes between a client and the server in both directions, up to the allowed number.
fn pass(client: &TcpStream, port: u16, allowed: &AtomicI64, wire: Wire) {
    let end = |stream: &TcpStream| drop(stream.shutdown(Shutdown::Both));
    if wire == Wire::Cut && allowed.load(Ordering::SeqCst) < 0 {
        return end(client);
    }
    let server = TcpStream::connect(("127.0.0.1", port)).unwrap();
    let (mut answers, mut back) = (server.try_clone().unwrap(), client.try_clone().unwrap());
    spawn(move || {
        let _ = std::io::copy(&mut answers, &mut back);
        let _ = back.shutdown(Shutdown::Both);
    });
    let (mut from, mut to) = (client, &server);
    let mut part = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut part) {
        let left = allowed.fetch_sub(count as i64, Ordering::SeqCst) - count as i64;
        if left < 0 && wire == Wire::Cut {
            break;
        }
        while allowed.load(Ordering::SeqCst) < 0 {
            sleep(Duration::from_millis(20));
        }
        if to.write_all(&part[..count]).is_err() {
            break;
        }
    }
    end(client);
    end(&server);
}
