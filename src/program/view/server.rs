//! The HTTP server of `view`: files of one folder, for this machine and the viewer's page only.
//!
//! Clients may be hostile: a web page in the user's browser can send requests to this machine. As for the live view, a request must
//! name this machine by address or as `localhost` (DNS rebinding), and a web page must be the viewer's or of this machine. Only
//! recordings and what belongs to them are served; symbolic links and hidden files are not. Slow clients are ended (`connections.rs`).

use super::connections::Listener;
use super::contents::{Contents, Found, is_hidden, path_of_address, viewer_address};
use axum::Router;
use axum::extract::{Request, State};
use axum::http::header::{
    ACCEPT_RANGES, CONNECTION, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_SECURITY_POLICY,
    CONTENT_TYPE, ETAG, HOST, HeaderName, LAST_MODIFIED, ORIGIN, RANGE, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse as _, Response};
use axum::routing::get;
use kinetoscope::live::Admission;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, OpenFolder, path_of_open};
use maud::{DOCTYPE, Markup, html};
use percent_encoding::percent_decode_str;
use std::io::{self, Read as _};
use std::net::{SocketAddr, TcpListener};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;
use tower_http::cors::{AllowOrigin, CorsLayer};
use tower_http::services::ServeFile;

/// Extensions of the files that belong to recordings, with their media types.
const SERVED: [(&str, &str); 11] = [
    ("mcap", "application/octet-stream"),
    ("json", "application/json"),
    ("html", "text/html"),
    ("js", "text/javascript"),
    ("svg", "image/svg+xml"),
    ("png", "image/png"),
    ("apng", "image/apng"),
    ("csv", "text/csv"),
    ("toml", "text/x-toml"),
    ("parquet", "application/octet-stream"),
    ("xyz", "chemical/x-xyz"),
];
/// The page of the experiments, and the address of the list of the recordings.
const INDEX: &str = "index.html";
const LIST: &str = "/recordings";
/// Time for which a list of the recordings is kept, so that no number of requests makes more lists.
const LIST_AGE: Duration = Duration::from_secs(1);
/// A page of the folder runs its own script and style, and sends nothing anywhere. The sandbox gives each page an origin of its own, so that
/// it reads no other file, neither in a window nor from a picture. The engine of a report is a script of the folder, a module and a worker.
const PAGE_POLICY: HeaderValue = HeaderValue::from_static(
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline' 'self' 'wasm-unsafe-eval'; worker-src blob:; style-src 'unsafe-inline'; img-src data:; form-action 'none'; base-uri 'none'",
);
/// No other page shows a file as a picture, or learns from it whether a file exists. A viewer's page asks by CORS.
const NO_EMBEDDING: HeaderValue = HeaderValue::from_static("same-origin");
/// A report, whose origin is of its own, loads the engine, which is the same in every folder.
const ENGINE_FILE: &str = "/kinetoscope-engine.js";
const EMBEDDING_OF_ENGINE: HeaderValue = HeaderValue::from_static("cross-origin");
const CROSS_ORIGIN_RESOURCE_POLICY: HeaderName =
    HeaderName::from_static("cross-origin-resource-policy");
const NO_SUCH_FILE: &str = "there is no such file";
const NO_SNIFFING: HeaderValue = HeaderValue::from_static("nosniff");

/// What is served, where, and for which viewer.
#[derive(Debug)]
pub(super) struct Server {
    /// The folder, without symbolic links in its path.
    pub(super) folder: PathBuf,
    /// The same folder, from whose descriptor files are opened.
    pub(super) opened: OpenFolder,
    /// The name of the only recording, if one is named.
    pub(super) file: Option<String>,
    /// The address of the viewer.
    pub(super) viewer: String,
    /// The address of the server.
    pub(super) address: SocketAddr,
}

/// The server and who may connect.
#[derive(Debug)]
struct Served {
    server: Server,
    admission: Admission,
    /// The last pages of the recordings, and when they were made. They are made once at a time.
    listed: Mutex<Option<(Instant, Pages)>>,
}

/// The pages that are made for each folder.
#[derive(Clone, Debug, Default)]
struct Pages {
    /// The list of the recordings.
    list: String,
    /// The gallery of the experiments, if an analysis has written one.
    gallery: Option<String>,
}

impl Server {
    /// Serves until the program ends.
    ///
    /// # Errors
    /// No runtime, or a listener that the system has closed.
    pub(super) fn run(self, listener: TcpListener) -> io::Result<()> {
        listener.set_nonblocking(true)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(async {
            let listener = Listener::new(tokio::net::TcpListener::from_std(listener)?);
            axum::serve(listener, self.router()).await
        })
    }

    fn router(self) -> Router {
        let origins = origin_of(&self.viewer).into_iter().collect();
        let admission = Admission { origins, hosts: Vec::new() };
        let served = Arc::new(Served {
            server: self,
            admission: admission.clone(),
            listed: Mutex::default(),
        });
        let is_admitted = move |origin: &HeaderValue, _: &_| {
            origin.to_str().is_ok_and(|origin| admission.admits_origin(origin))
        };
        let readable: [HeaderName; 5] =
            [ACCEPT_RANGES, CONTENT_LENGTH, CONTENT_RANGE, ETAG, LAST_MODIFIED];
        let cors = CorsLayer::new()
            .allow_origin(AllowOrigin::predicate(is_admitted))
            .allow_methods([Method::GET, Method::HEAD])
            .allow_headers([RANGE])
            .expose_headers(readable)
            .allow_private_network(true);
        Router::new()
            .route("/", get(front))
            .route(LIST, get(list))
            .fallback(file)
            .layer(cors)
            .layer(middleware::from_fn_with_state(served.clone(), admit))
            .with_state(served)
    }
}

/// `scheme://host:port` of an address, in lower case.
fn origin_of(viewer: &str) -> Option<String> {
    let address: Uri = viewer.parse().ok()?;
    Some(format!("{}://{}", address.scheme_str()?, address.authority()?).to_ascii_lowercase())
}

/// Answers requests that are not admitted, and adds the headers that every answer has.
async fn admit(State(served): State<Arc<Served>>, request: Request, next: Next) -> Response {
    let is_engine = request.uri().path().ends_with(ENGINE_FILE);
    let mut response = match served.rejection(request.headers(), request.uri()) {
        Some((status, reason)) => {
            (status, [(CONNECTION, "close")], format!("{reason}\n")).into_response()
        }
        None => next.run(request).await,
    };
    response.headers_mut().insert(CONTENT_SECURITY_POLICY, PAGE_POLICY);
    let embedding = if is_engine { EMBEDDING_OF_ENGINE } else { NO_EMBEDDING };
    response.headers_mut().insert(CROSS_ORIGIN_RESOURCE_POLICY, embedding);
    response.headers_mut().insert(X_CONTENT_TYPE_OPTIONS, NO_SNIFFING);
    response
}

impl Served {
    /// Why a request is rejected.
    fn rejection(&self, headers: &HeaderMap, address: &Uri) -> Option<(StatusCode, &'static str)> {
        let single = |name| {
            let mut values = headers.get_all(name).iter();
            let value = values.next()?.to_str().ok()?;
            values.next().is_none().then_some(value)
        };
        if !single(HOST).is_some_and(|host| self.admission.admits_host(host)) {
            return Some((StatusCode::FORBIDDEN, "connect by IP address or localhost"));
        }
        let has_origin = headers.contains_key(ORIGIN);
        if has_origin && !single(ORIGIN).is_some_and(|origin| self.admission.admits_origin(origin))
        {
            return Some((StatusCode::FORBIDDEN, "this web page is not the viewer: see --viewer"));
        }
        // A viewer asks for one part at a time, and a list of parts is checked for overlaps in quadratic time.
        if headers.get(RANGE).is_some_and(|range| range.as_bytes().contains(&b',')) {
            return Some((StatusCode::RANGE_NOT_SATISFIABLE, "ask for one part of the file"));
        }
        let is_served = ["/", LIST].contains(&address.path()) || self.path_of(address).is_some();
        (!is_served).then_some((StatusCode::NOT_FOUND, NO_SUCH_FILE))
    }

    /// The path below the folder that an address names, and its media type, if such a file belongs to recordings.
    fn path_of(&self, address: &Uri) -> Option<(PathBuf, &'static str)> {
        let path = percent_decode_str(address.path().trim_start_matches('/'));
        let path = PathBuf::from(path.decode_utf8().ok()?.as_ref());
        let is_plain = |part: Component<'_>| {
            matches!(part, Component::Normal(_)) && !is_hidden(Path::new(part.as_os_str()))
        };
        let only = self.server.file.as_ref();
        let is_named = only.is_some_and(|only| path == Path::new(only));
        if !is_named && !path.components().all(is_plain) {
            return None;
        }
        let extension = path.extension()?.to_str()?;
        let (_, media_type) = SERVED.iter().find(|(served, _)| *served == extension)?;
        let is_beside = path.components().count() == 1 && extension != "mcap";
        let is_wanted = is_named || only.is_none() || is_beside;
        is_wanted.then_some((path, *media_type))
    }

    /// The pages of the recordings, not older than [`LIST_AGE`].
    async fn listed(self: Arc<Self>) -> Pages {
        let mut listed = self.listed.lock().await;
        if let Some((_, pages)) = listed.as_ref().filter(|(made, _)| made.elapsed() < LIST_AGE) {
            return pages.clone();
        }
        let served = Arc::clone(&self);
        let made = spawn_blocking(move || served.server.pages());
        // Only a panic ends the thread early.
        let pages = made.await.unwrap_or_default();
        *listed = Some((Instant::now(), pages.clone()));
        pages
    }
}

impl Server {
    fn pages(&self) -> Pages {
        let Self { folder, file, viewer, address, .. } = self;
        let contents = Contents::of(folder, file.as_deref());
        let list = page(&contents, |found| viewer_address(viewer, *address, found));
        Pages { list, gallery: self.gallery() }
    }

    /// The page of the experiments that an analysis of the folder has written, with a link to the list of the recordings.
    fn gallery(&self) -> Option<String> {
        let (file, _) = self.opened.file(Path::new(INDEX)).ok().filter(|_| self.file.is_none())?;
        let mut text = String::new();
        file.take(MAX_SIDE_FILE_BYTES).read_to_string(&mut text).ok()?;
        // A page of the user's own is not the gallery.
        let (start, rest) = text.split_once("<h1>Experiments</h1>")?;
        let link = html! { p { a href=(LIST) { "Recordings in the viewer" } } }.into_string();
        start
            .contains("<main class=\"kinetoscope-index\">")
            .then(|| format!("{start}<h1>Experiments</h1>{link}{rest}"))
    }
}

/// The gallery of the experiments, or the list of the recordings where there is none. The pages are made on a thread of their own, because a folder of
/// many files takes long and downloads go on, and by a task of its own, because a client that leaves does not end it.
async fn front(State(served): State<Arc<Served>>) -> Html<String> {
    let pages = tokio::spawn(served.listed()).await.unwrap_or_default();
    Html(pages.gallery.unwrap_or(pages.list))
}

/// The list of the recordings.
async fn list(State(served): State<Arc<Served>>) -> Html<String> {
    Html(tokio::spawn(served.listed()).await.unwrap_or_default().list)
}

/// A file, or the part of it that the request asks for.
async fn file(State(served): State<Arc<Served>>, request: Request) -> Response {
    let missing = || (StatusCode::NOT_FOUND, format!("{NO_SUCH_FILE}\n")).into_response();
    let Some((path, media_type)) = served.path_of(request.uri()) else { return missing() };
    let whole = served.server.folder.join(&path);
    let opened = spawn_blocking(move || served.server.opened.file(&path));
    let Ok(Ok((opened, _))) = opened.await else { return missing() };
    let Ok(mut answer) = ServeFile::new(path_of_open(&opened, &whole)).try_call(request).await
    else {
        return missing();
    };
    answer.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(media_type));
    answer.into_response()
}

/// Number of recordings of a folder that are listed openly; more are collapsed.
const LISTED_OPENLY: usize = 8;

/// The folder of a recording; "." for the served one.
fn parent(found: &Found) -> &str {
    found.path.rsplit_once('/').map_or(".", |(folder, _)| folder)
}

fn page(contents: &Contents, viewer: impl Fn(&Found) -> String) -> String {
    let link = |path: &Option<String>, text: &str| -> Markup {
        html! { @if let Some(path) = path { " · " a href=(path_of_address(path)) { (text) } } }
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "Recordings" }
                style { "body { font: 16px/1.6 system-ui, sans-serif; max-width: 960px; margin: 0 auto; padding: 16px; overflow-wrap: anywhere; }" }
            }
            body {
                main {
                    h1 { "Recordings" }
                    @for folder in contents.recordings.chunk_by(|one, next| parent(one) == parent(next)) {
                        // A sweep of many runs does not hide the other folders.
                        details open[folder.len() <= LISTED_OPENLY] {
                            summary { (parent(&folder[0])) " (" (folder.len()) ")" }
                            ul {
                                @for found in folder {
                                    li {
                                        a href=(viewer(found)) { (found.path) }
                                        (link(&found.report, "report"))
                                        (link(&Some(found.path.clone()), "file"))
                                        (link(&found.layout, "layout"))
                                    }
                                }
                            }
                        }
                    }
                    @if contents.is_cut { p { "More recordings are not listed: name a folder below." } }
                    p { "A name opens the recording in the viewer, which must be running." }
                }
            }
        }
    };
    kinetoscope_console::text::visible(&page.into_string()).into_owned()
}
