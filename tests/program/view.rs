//! Guarantee: `view` serves recordings in parts to the viewer and to this machine only. Other web pages, other names of this machine, hidden
//! files, other types of files and links get nothing.

#![cfg(unix)]

use crate::subcommand_bench::{Bench, command};
use serde_json::Value;
use std::fs;
use std::io::{BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// A running server, which ends with the test.
struct View {
    child: Child,
    document: Value,
}

impl View {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        Self::start_by(command(), folder, arguments)
    }

    fn start_by(mut command: Command, folder: &Path, arguments: &[&str]) -> Self {
        let mut child = command
            .args(["view", "--port", "0", "--json"])
            .args(arguments)
            .current_dir(folder)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        let document =
            serde_json::Deserializer::from_reader(&mut output).into_iter().next().unwrap().unwrap();
        Self { child, document }
    }

    fn address(&self) -> SocketAddr {
        let page = self.document["page"].as_str().unwrap();
        page.trim_start_matches("http://").trim_end_matches('/').parse().unwrap()
    }

    /// A connection on which a server that does not answer is an error.
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        stream
    }

    /// Sends a request with headers; returns the head of the answer in lower case, and its body.
    fn request(&self, method: &str, path: &str, headers: &[(&str, &str)]) -> (String, Vec<u8>) {
        let mut stream = self.connect();
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        if !headers.iter().any(|(name, _)| *name == "Host") {
            text += &format!("Host: {}\r\n", self.address());
        }
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        stream.write_all(format!("{text}\r\n").as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(answer[..end].to_vec()).unwrap().to_lowercase();
        (head, answer[end + 4..].to_vec())
    }

    fn status(&self, path: &str, headers: &[(&str, &str)]) -> u16 {
        let (head, _) = self.request("GET", path, headers);
        head.split(' ').nth(1).unwrap().parse().unwrap()
    }
}

impl Drop for View {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// A bench with a recording; its path from the bench.
fn recorded() -> (Bench, String) {
    let bench = Bench::new();
    let recording = bench.recording();
    let name = recording.file_name().unwrap().to_str().unwrap().to_owned();
    (bench, format!("gas/{name}"))
}

#[test]
fn the_viewer_reads_the_recording_in_parts() {
    let (bench, path) = recorded();
    let view = View::start(
        &bench.path("."),
        &["recordings", "--viewer", "https://viewer.example:8443/x/"],
    );
    let origin = ("Origin", "https://viewer.example:8443");
    let (head, whole) = view.request("GET", &format!("/{path}"), &[origin]);
    assert!(head.starts_with("http/1.1 200"), "{head}");
    assert_eq!(whole, fs::read(bench.path("recordings").join(&path)).unwrap());
    let (head, part) = view.request("GET", &format!("/{path}"), &[origin, ("Range", "bytes=8-99")]);
    for line in [
        "http/1.1 206".to_owned(),
        format!("content-range: bytes 8-99/{}", whole.len()),
        "content-length: 92".to_owned(),
        "accept-ranges: bytes".to_owned(),
        "access-control-allow-origin: https://viewer.example:8443".to_owned(),
    ] {
        assert!(head.contains(&line), "{line} is missing in {head}");
    }
    let exposed =
        head.lines().find(|line| line.starts_with("access-control-expose-headers")).unwrap();
    for header in ["accept-ranges", "content-length", "content-range"] {
        assert!(exposed.contains(header), "{exposed}");
    }
    assert_eq!(part, whole[8..100]);
    let several = [origin, ("Range", "bytes=0-0,2-2")];
    let (head, reason) = view.request("GET", &format!("/{path}"), &several);
    assert!(head.starts_with("http/1.1 416"), "{head}");
    // Before the parts are compared with each other.
    assert_eq!(reason, b"ask for one part of the file\n");
    // The question of a browser before a request with a range.
    let asked = [
        origin,
        ("Access-Control-Request-Method", "GET"),
        ("Access-Control-Request-Headers", "range"),
    ];
    let (head, _) = view.request("OPTIONS", &format!("/{path}"), &asked);
    assert!(head.starts_with("http/1.1 200"), "{head}");
    assert!(head.contains("access-control-allow-headers: range"), "{head}");
}

#[test]
fn the_printed_address_names_recording_and_layout() {
    let (bench, path) = recorded();
    let view = View::start(&bench.path("."), &["recordings"]);
    let url = view.document["viewer"][0]["url"].as_str().unwrap();
    let server = format!("http%3A%2F%2F127.0.0.1%3A{}%2F", view.address().port());
    let (folder, file) = path.split_once('/').unwrap();
    assert_eq!(
        url,
        format!(
            "http://localhost:8080/?ds=remote-file&ds.url={server}{folder}%2F{file}&layoutUrl={server}gas%2Fgas.layout.json"
        )
    );
    let (_, page) = view.request("GET", "/", &[]);
    let page = String::from_utf8(page).unwrap();
    assert!(page.contains(&url.replace('&', "&amp;")), "{page}");
    assert_eq!(view.status("/gas/gas.layout.json", &[]), 200);
}

/// Guarantee: the gallery that an analysis has written is the first page, and leads to the list of the recordings. Control: a user's own page is not it.
#[test]
fn gallery_of_the_experiments_is_the_first_page() {
    let (bench, path) = recorded();
    let gallery = "<main class=\"kinetoscope-index\"><header><h1>Experiments</h1></header></main>";
    for (page, is_first) in [(gallery, true), ("<main><h1>Experiments</h1></main>", false)] {
        bench.write("recordings/index.html", page);
        let view = View::start(&bench.path("."), &["recordings"]);
        let [first, list] = ["/", "/recordings"]
            .map(|address| String::from_utf8(view.request("GET", address, &[]).1).unwrap());
        assert_eq!(first.contains("kinetoscope-index"), is_first, "{first}");
        assert_eq!(first.contains("href=\"/recordings\""), is_first, "{first}");
        assert!(list.contains(&path) && (is_first || first == list), "{list}");
    }
}

#[test]
fn other_web_pages_and_other_names_of_this_machine_are_rejected() {
    let (bench, path) = recorded();
    let view = View::start(&bench.path("."), &["recordings"]);
    for path in ["/".to_owned(), format!("/{path}")] {
        assert_eq!(view.status(&path, &[]), 200);
        assert_eq!(view.status(&path, &[("Origin", "http://localhost:8080")]), 200);
        for headers in [
            vec![("Origin", "https://evil.example")],
            vec![("Origin", "null")],
            vec![("Origin", "http://localhost:8080"), ("Origin", "https://evil.example")],
            vec![("Host", "evil.example")],
            vec![("Host", "localhost.evil.example:80")],
        ] {
            let (head, _) = view.request("GET", &path, &headers);
            assert!(head.starts_with("http/1.1 403"), "{headers:?}: {head}");
            assert!(!head.contains("access-control-allow-origin: https://evil"), "{head}");
        }
    }
}

/// Guarantee: a page of the folder has an origin of its own, so that it reads no other file, and other pages show no file as a picture.
/// Every answer has both headers, also where a file is missing or a request is rejected.
#[test]
fn pages_of_the_folder_read_no_other_file_and_no_page_embeds_one() {
    let (bench, path) = recorded();
    bench.write("recordings/gas/report.html", "<p>report</p>");
    let view = View::start(&bench.path("."), &["recordings"]);
    let recording = format!("/{path}");
    for (path, headers) in [
        ("/", vec![]),
        ("/gas/report.html", vec![]),
        (&recording, vec![]),
        ("/gas/missing.svg", vec![]),
        ("/", vec![("Origin", "https://evil.example")]),
    ] {
        let (head, _) = view.request("GET", path, &headers);
        let policy = head.lines().find(|line| line.starts_with("content-security-policy: "));
        let policy = policy.unwrap_or_else(|| panic!("{path}: {head}"));
        let sandbox = policy.split([':', ';']).find(|part| part.trim().starts_with("sandbox"));
        assert_eq!(sandbox.map(str::trim), Some("sandbox allow-scripts allow-downloads"), "{path}");
        assert!(head.contains("cross-origin-resource-policy: same-origin"), "{path}: {head}");
    }
    // The engine of the reports is the same in every folder.
    let (head, _) = view.request("GET", "/gas/kinetoscope-engine.js", &[]);
    assert!(head.contains("cross-origin-resource-policy: cross-origin"), "{head}");
}

#[test]
fn only_files_of_recordings_are_served() {
    let (bench, path) = recorded();
    bench.write("secret.json", "secret");
    bench.write("recordings/gas/notes.txt", "private");
    bench.write("recordings/gas/.hidden.json", "private");
    symlink(bench.path("secret.json"), bench.path("recordings/gas/link.json")).unwrap();
    symlink(bench.path("."), bench.path("recordings/out")).unwrap();
    let view = View::start(&bench.path("."), &["recordings"]);
    assert_eq!(view.status("/gas/experiment.toml", &[]), 200);
    for path in [
        "/gas/notes.txt",
        "/gas/.hidden.json",
        "/gas/link.json",
        "/out/secret.json",
        "/../secret.json",
        "/%2e%2e/secret.json",
        "/gas/..%2f..%2fsecret.json",
        "//etc/passwd",
        "/gas",
        "/gas/",
        "/nothing.mcap",
        "/gas/%ff.json",
    ] {
        assert_eq!(view.status(path, &[]), 404, "{path}");
    }
    let (head, _) = view.request("POST", &format!("/{path}"), &[("Content-Length", "0")]);
    assert!(head.starts_with("http/1.1 405"), "{head}");
}

/// Guarantee: a file that another process exchanges for a link, back and forth, is served or missing, never the file behind the link.
/// Control: without the exchange, the file is served.
#[test]
fn link_that_replaces_a_file_during_a_request_is_not_followed() {
    const REQUESTS: usize = 1000;
    let (bench, _) = recorded();
    bench.write("secret.json", "secret");
    bench.write("recordings/gas/exchanged.json", "public");
    let served = bench.path("recordings/gas/exchanged.json");
    let view = View::start(&bench.path("."), &["recordings"]);
    assert_eq!(view.request("GET", "/gas/exchanged.json", &[]).1, b"public");
    let is_over = Arc::new(AtomicBool::new(false));
    let exchange = {
        let (served, secret) = (served.clone(), bench.path("secret.json"));
        let (new, is_over) = (served.with_extension("new"), Arc::clone(&is_over));
        thread::spawn(move || {
            while !is_over.load(Ordering::Relaxed) {
                fs::write(&new, "public").unwrap();
                fs::rename(&new, &served).unwrap();
                symlink(&secret, &new).unwrap();
                fs::rename(&new, &served).unwrap();
            }
        })
    };
    let bodies: Vec<Vec<u8>> =
        (0..REQUESTS).map(|_| view.request("GET", "/gas/exchanged.json", &[]).1).collect();
    is_over.store(true, Ordering::Relaxed);
    exchange.join().unwrap();
    assert!(!bodies.iter().any(|body| body == b"secret"));
}

/// Guarantee: the served folder stays the same if a link takes its place. Control: the file in it is served as before.
#[test]
fn link_that_replaces_the_folder_is_not_followed() {
    let (bench, _) = recorded();
    bench.write("recordings/gas/note.json", "public");
    fs::create_dir_all(bench.path("secret/gas")).unwrap();
    bench.write("secret/gas/note.json", "secret");
    let view = View::start(&bench.path("."), &["recordings"]);
    fs::rename(bench.path("recordings"), bench.path("moved")).unwrap();
    symlink(bench.path("secret"), bench.path("recordings")).unwrap();
    assert_eq!(view.request("GET", "/gas/note.json", &[]).1, b"public");
}

/// Guarantee: one list is made at a time, however many clients ask for it and leave. Control: the folder takes long to list, so that
/// lists of their own would take threads of their own.
#[test]
fn lists_that_nobody_waits_for_take_one_thread() {
    const FILES: usize = 5000;
    const CLIENTS: usize = 60;
    let (bench, path) = recorded();
    for file in 0..FILES {
        bench.write(&format!("recordings/gas/{file}.json"), "");
    }
    let view = View::start(&bench.path("."), &["recordings"]);
    for _ in 0..CLIENTS {
        let request = format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", view.address());
        view.connect().write_all(request.as_bytes()).unwrap();
    }
    assert_eq!(view.status(&format!("/{path}"), &[]), 200);
    let status = fs::read_to_string(format!("/proc/{}/status", view.child.id()));
    // Only Linux counts the threads of a process.
    let Ok(status) = status else { return };
    let threads = status.lines().find_map(|line| line.strip_prefix("Threads:")).unwrap();
    let threads: usize = threads.trim().parse().unwrap();
    assert!(threads < 10, "{threads} threads");
}

#[test]
fn a_named_recording_is_served_alone() {
    let (bench, path) = recorded();
    let name = path.trim_start_matches("gas/");
    fs::copy(bench.path("recordings").join(&path), bench.path("recordings/gas/other.mcap"))
        .unwrap();
    let view = View::start(&bench.path("."), &[&format!("recordings/{path}")]);
    assert_eq!(view.document["viewer"].as_array().unwrap().len(), 1);
    assert_eq!(view.status(&format!("/{name}"), &[]), 200);
    assert_eq!(view.status("/gas.layout.json", &[]), 200);
    assert_eq!(view.status("/other.mcap", &[]), 404);
    // One that its user names may be hidden.
    fs::copy(bench.path("recordings").join(&path), bench.path("recordings/.hidden.mcap")).unwrap();
    let view = View::start(&bench.path("."), &["recordings/.hidden.mcap"]);
    assert_eq!(view.status("/.hidden.mcap", &[]), 200);
}

#[test]
fn what_cannot_be_served_is_an_error_with_help() {
    let bench = Bench::new();
    fs::create_dir(bench.path("empty")).unwrap();
    bench.write("a.txt", "");
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    bench.recording();
    for (arguments, code) in [
        (vec!["view", "nothing"], 5),
        (vec!["view", "empty"], 5),
        (vec!["view", "a.txt"], 5),
        (vec!["view", "recordings", "--port", &port], 75),
        (vec!["view", "recordings", "--viewer", "ftp://x/"], 2),
        (vec!["view", "recordings", "--viewer", "viewer"], 2),
    ] {
        let called = bench.call(&arguments);
        assert_eq!(called.code, Some(code), "{arguments:?}: {}", called.err);
        assert!(called.err.contains("error: ") && called.err.contains("help: "), "{}", called.err);
    }
}

/// Clients that send nothing, a part of a request, or a request whose answer they do not read.
fn slow_clients(view: &View, path: &str, count: usize) -> Vec<TcpStream> {
    let request = format!("GET /{path} HTTP/1.1\r\nHost: {}\r\n", view.address());
    let parts = ["", "GET ", &request, &format!("{request}\r\n")];
    let connect = |at: usize| {
        let mut stream = view.connect();
        stream.write_all(parts[at % parts.len()].as_bytes()).unwrap();
        stream
    };
    (0..count).map(connect).collect()
}

#[test]
fn slow_clients_leave_room_for_an_honest_one() {
    let (bench, path) = recorded();
    // With 200 files, a server without a limit of its connections accepts no more.
    let mut limited = Command::new("sh");
    limited.args(["-c", r#"ulimit -n 200; exec "$0" "$@""#, env!("CARGO_BIN_EXE_kinetoscope")]);
    let view = View::start_by(limited, &bench.path("."), &["recordings"]);
    let slow = slow_clients(&view, &path, 300);
    assert_eq!(view.status(&format!("/{path}"), &[]), 200);
    drop(slow);
}

#[test]
fn connection_without_a_complete_request_is_ended() {
    let (bench, path) = recorded();
    let view = View::start(&bench.path("."), &["recordings"]);
    for mut client in slow_clients(&view, &path, 3) {
        // The end of the connection, not the time limit of this client.
        let end = client.read(&mut [0]);
        assert!(matches!(end, Ok(0)), "{end:?}");
    }
}

/// Setup: more clients than connections ask for the head of a file again and again, while an honest one reads a large file slowly.
#[test]
fn honest_download_goes_on_beside_many_clients() {
    const BYTES: usize = 24 << 20;
    let (bench, path) = recorded();
    fs::write(bench.path("recordings/gas/large.json"), vec![b' '; BYTES]).unwrap();
    let view = View::start(&bench.path("."), &["recordings"]);
    let request = |method: &str, path: &str| {
        format!("{method} /{path} HTTP/1.1\r\nHost: {}\r\n\r\n", view.address())
    };
    let mut honest = view.connect();
    honest.write_all(request("GET", "gas/large.json").as_bytes()).unwrap();
    let mut part = vec![0; 1 << 18];
    let mut received = honest.read(&mut part).unwrap();
    let mut others: Vec<TcpStream> = (0..70).map(|_| view.connect()).collect();
    let head = request("HEAD", &path);
    while received < BYTES {
        for other in &mut others {
            if other.write_all(head.as_bytes()).is_err() {
                *other = view.connect();
            }
        }
        std::thread::sleep(Duration::from_millis(40));
        let count = honest.read(&mut part).unwrap();
        assert!(count > 0, "the connection ended after {received} bytes");
        received += count;
    }
}
