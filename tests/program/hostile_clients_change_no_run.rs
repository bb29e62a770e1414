//! Guarantee: whatever the clients of a live server do, the run records the same bytes, the program ends on its own, and the first
//! signal ends it. Web pages that are not known viewers, and names of this machine that were not given, are rejected.
//!
//! Setup: clients that drip the handshake, are silent, do not read, or send too much, together with a viewer that watches the run.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::hostile_client::{HOSTILITIES, Hostility, start};
use crate::live_viewer::{Experiment, FRAME_NS, Received, Viewer, agree, bytes, data};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::process::{Child, Command};
use std::thread::JoinHandle;

/// A run with 8 frames after the start.
const RUN: &str =
    "seed = 6\n[model.gas]\nparticles = 500\nduration_s = 0.01\n[record]\nframes = 8\n";
const FRAMES: u64 = 8;
/// Options of a run that waits for its first viewer, and then takes half a minute unless a viewer changes the speed.
const SLOW: [&str; 3] = ["--force", "--live-speed", "0.01"];
/// The number of connections that the server allows.
const SLOTS: usize = 64;

fn interrupt(program: &Child) {
    let sent = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Watches a run that waits for its first viewer to its end.
fn watch(address: &str) {
    let mut viewer = Viewer::connect(address);
    viewer.receive_the_announcement();
    viewer.ask(false, 100.0, 0, "play");
    viewer.subscribe_to_all();
    let seen = data(&viewer.receive_until(|event| *event == Received::Closed));
    assert!(seen.iter().any(|(topic, time, _)| topic == "/frame" && *time == FRAMES * FRAME_NS));
}

/// As many clients of each kind as are given.
fn attack(address: &str, clients: &[(Hostility, usize)]) -> Vec<JoinHandle<()>> {
    let all = clients.iter().flat_map(|&(hostility, count)| std::iter::repeat_n(hostility, count));
    all.map(|hostility| start(hostility, address)).collect()
}

#[test]
fn run_with_hostile_clients_records_the_same_bytes_and_ends() {
    record_with(vec![HOSTILITIES.map(|kind| (kind, 4)).to_vec()]);
}

#[test]
#[ignore = "a run with each kind of client"]
fn run_with_each_kind_of_hostile_client_records_the_same_bytes_and_ends() {
    record_with(HOSTILITIES.map(|kind| vec![(kind, 4)]).to_vec());
}

/// Records a run for each of these groups of clients, and compares it with the run without viewers.
fn record_with(groups: Vec<Vec<(Hostility, usize)>>) {
    let experiment = Experiment::new(RUN);
    let expected = experiment.recorded_without_viewer();
    for clients in groups {
        let (mut program, address) = experiment.start("watched", &SLOW);
        let attackers = attack(&address, &clients);
        watch(&address);
        assert_eq!(Experiment::end_of(&mut program), Some(0), "{clients:?}");
        assert!(bytes(&experiment.recordings("watched")) == expected, "{clients:?}");
        attackers.into_iter().for_each(|client| client.join().unwrap());
    }
}

#[test]
fn first_interrupt_ends_a_run_with_hostile_clients() {
    let experiment = Experiment::new(RUN);
    for hostility in HOSTILITIES {
        let (mut program, address) = experiment.start("watched", &SLOW);
        let attackers = attack(&address, &[(hostility, 4)]);
        interrupt(&program);
        assert_eq!(Experiment::end_of(&mut program), Some(130), "{hostility:?}");
        attackers.into_iter().for_each(|client| client.join().unwrap());
    }
    // The interrupted run is completed to the same bytes.
    let done = experiment.command("watched", &["--quiet"]).output().unwrap();
    assert!(done.status.success());
    assert!(bytes(&experiment.recordings("watched")) == experiment.recorded_without_viewer());
}

#[test]
fn slow_clients_leave_room_for_a_viewer() {
    let experiment = Experiment::new(RUN);
    let expected = experiment.recorded_without_viewer();
    for hostility in [Hostility::Drips, Hostility::Connects, Hostility::DoesNotRead] {
        let (mut program, address) = experiment.start("watched", &SLOW);
        let attackers = attack(&address, &[(hostility, SLOTS)]);
        watch(&address);
        assert_eq!(Experiment::end_of(&mut program), Some(0), "{hostility:?}");
        assert!(bytes(&experiment.recordings("watched")) == expected, "{hostility:?}");
        attackers.into_iter().for_each(|client| client.join().unwrap());
    }
}

/// The status of the server's answer to a handshake with the given lines in its request.
fn status(address: &str, lines: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!(
        "GET / HTTP/1.1\r\n{lines}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).unwrap();
    // `HTTP/1.1 101`
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).unwrap();
    String::from_utf8_lossy(&answer[9..]).into_owned()
}

#[test]
fn foreign_pages_and_names_are_rejected() {
    let experiment = Experiment::new(RUN);
    let options =
        ["--live-speed", "1", "--live-origin", "https://viewer.example", "--live-host", "node7"];
    let (mut program, address) = experiment.start("watched", &options);
    for lines in [
        format!("Host: {address}"),
        "Host: localhost".to_owned(),
        "Host: node7:8765".to_owned(),
        format!("Host: {address}\r\nOrigin: https://app.foxglove.dev"),
        format!("Host: {address}\r\nOrigin: http://localhost:8080"),
        format!("Host: {address}\r\nOrigin: https://viewer.example"),
    ] {
        assert_eq!(status(&address, &lines), "101", "{lines}");
    }
    for lines in [
        "X-No: host".to_owned(),
        "Host: evil.example".to_owned(),
        format!("Host: {address}\r\nHost: evil.example"),
        format!("Host: {address}\r\nOrigin: https://evil.example"),
        format!("Host: {address}\r\nOrigin: null"),
        format!(
            "Host: {address}\r\nOrigin: https://app.foxglove.dev\r\nOrigin: https://evil.example"
        ),
        "Host: evil.example\r\nOrigin: http://evil.example".to_owned(),
    ] {
        assert_eq!(status(&address, &lines), "403", "{lines}");
    }
    interrupt(&program);
    assert_eq!(Experiment::end_of(&mut program), Some(130));
}

/// The largest resident memory of a process so far, in KiB.
#[cfg(target_os = "linux")]
fn peak_kib(program: &Child) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches("kB").trim().parse().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn large_requests_are_rejected_at_their_header() {
    const CLAIMED: u64 = 16 << 20;
    let experiment = Experiment::new(RUN);
    let (mut program, address) = experiment.start("watched", &["--live-speed", "1"]);
    Viewer::connect(&address).receive_the_announcement();
    let before = peak_kib(&program);
    let floods: Vec<JoinHandle<u64>> = (0..16)
        .map(|_| {
            let mut stream = agree(&address).unwrap().into_inner();
            std::thread::spawn(move || {
                // A masked binary frame (RFC 6455, 5.2) with a length of 64 bits.
                let mut header = vec![0x82, 0xff];
                header.extend(CLAIMED.to_be_bytes());
                header.extend([0; 4]);
                let mut sent = 0;
                if stream.write_all(&header).is_ok() {
                    while sent < CLAIMED && stream.write_all(&[b'x'; 1 << 16]).is_ok() {
                        sent += 1 << 16;
                    }
                }
                // The server ends the connection, although the frame is incomplete.
                let _ = stream.read_to_end(&mut Vec::new());
                sent
            })
        })
        .collect();
    let sent: u64 = floods.into_iter().map(|flood| flood.join().unwrap()).sum();
    let grown_mib = (peak_kib(&program) - before) >> 10;
    println!("{sent} bytes sent by 16 clients; the program has grown by {grown_mib} MiB");
    assert!(grown_mib < 16, "the program has grown by {grown_mib} MiB");
    interrupt(&program);
    assert_eq!(Experiment::end_of(&mut program), Some(130));
}
