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
    ACCEPT_RANGES, CONNECTION, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_SECURITY_POLICY, ETAG, HOST,
    HeaderName, LAST_MODIFIED, ORIGIN, RANGE, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse as _, Response};
use axum::routing::get;
use kinetoscope::live::Admission;
use maud::{DOCTYPE, Markup, html};
use percent_encoding::percent_decode_str;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use tower_http::cors::{AllowOrigin, CorsLayer};
use tower_http::services::ServeDir;

/// Extensions of the files that belong to recordings.
const SERVED: [&str; 10] =
    ["mcap", "json", "html", "svg", "png", "apng", "csv", "toml", "parquet", "xyz"];
/// A page of the folder runs its own script and style, and sends nothing anywhere.
const PAGE_POLICY: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:; form-action 'none'; base-uri 'none'",
);
const NO_SNIFFING: HeaderValue = HeaderValue::from_static("nosniff");

/// What is served, where, and for which viewer.
#[derive(Debug)]
pub(super) struct Server {
    /// The folder, without symbolic links in its path.
    pub(super) folder: PathBuf,
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
        let files = ServeDir::new(&self.folder).append_index_html_on_directories(true);
        let served = Arc::new(Served { server: self, admission: admission.clone() });
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
            .route("/", get(list))
            .fallback_service(files)
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
    let mut response = match served.rejection(request.headers(), request.uri()) {
        Some((status, reason)) => {
            (status, [(CONNECTION, "close")], format!("{reason}\n")).into_response()
        }
        None => next.run(request).await,
    };
    response.headers_mut().insert(CONTENT_SECURITY_POLICY, PAGE_POLICY);
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
        let is_served = address.path() == "/" || self.is_served(address.path());
        (!is_served).then_some((StatusCode::NOT_FOUND, "there is no such file"))
    }

    /// Whether a path of an address is a file that belongs to recordings, reached without symbolic links.
    fn is_served(&self, path: &str) -> bool {
        let Ok(path) = percent_decode_str(path.trim_start_matches('/')).decode_utf8() else {
            return false;
        };
        let path = Path::new(path.as_ref());
        let is_plain = |part: Component<'_>| {
            matches!(part, Component::Normal(_)) && !is_hidden(Path::new(part.as_os_str()))
        };
        if !path.components().all(is_plain) {
            return false;
        }
        let extension = path.extension().and_then(|extension| extension.to_str());
        if !extension.is_some_and(|extension| SERVED.contains(&extension)) {
            return false;
        }
        let is_wanted = match &self.server.file {
            Some(only) => {
                path.components().count() == 1
                    && (extension != Some("mcap") || path == Path::new(only))
            }
            None => true,
        };
        let whole = self.server.folder.join(path);
        is_wanted && whole.is_file() && whole.canonicalize().is_ok_and(|real| real == whole)
    }
}

/// The page that lists the recordings.
async fn list(State(served): State<Arc<Served>>) -> Html<String> {
    // On a thread of its own, because a folder of many files takes long, and downloads go on.
    let listed = tokio::task::spawn_blocking(move || {
        let Server { folder, file, viewer, address } = &served.server;
        let contents = Contents::of(folder, file.as_deref());
        let has_index = file.is_none() && folder.join("index.html").is_file();
        page(&contents, has_index, |found| viewer_address(viewer, *address, found))
    });
    // Only a panic ends the thread early.
    Html(listed.await.unwrap_or_default())
}

fn page(contents: &Contents, has_index: bool, viewer: impl Fn(&Found) -> String) -> String {
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
                    @if has_index { p { a href="/index.html" { "All experiments with their results" } } }
                    ul {
                        @for found in &contents.recordings {
                            li {
                                a href=(viewer(found)) { (found.path) }
                                (link(&found.report, "report"))
                                (link(&Some(found.path.clone()), "file"))
                                (link(&found.layout, "layout"))
                            }
                        }
                    }
                    @if contents.is_cut { p { "More recordings are not listed: name a folder below." } }
                    p { "A name opens the recording in the viewer, which must be running." }
                }
            }
        }
    };
    kinetoscope_usage::text::visible(&page.into_string()).into_owned()
}
