//! Rules for connections: which names of this machine a client may have used, and which web pages may connect.
//!
//! A browser lets every web page open a WebSocket to any address. The header `Origin`, which a page cannot change, names the page. A
//! page whose own name was redirected to this machine (DNS rebinding) is recognized by the header `Host`, which contains that name.

use std::net::{IpAddr, Ipv6Addr};
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::header::{HOST, HeaderName, ORIGIN, SEC_WEBSOCKET_PROTOCOL};
use tungstenite::http::{HeaderMap, HeaderValue, StatusCode};

use super::protocol::SUBPROTOCOL;

/// Origins of the viewers: Foxglove and Lichtblick on the web, and their desktop programs, whose pages are files (Lichtblick's
/// `suite-desktop/src/webpackMainConfig.ts`).
const VIEWERS: [&str; 4] = [
    "https://app.foxglove.dev",
    "https://studio.foxglove.dev",
    "https://lichtblick-suite.github.io",
    "file://",
];

/// The origins and host names that are admitted in addition to those of the viewers and of this machine.
#[derive(Clone, Debug, Default)]
pub struct Admission {
    /// Origins such as `https://viewer.example:8080`, in lower case.
    pub origins: Vec<String>,
    /// Names of this machine, in lower case.
    pub hosts: Vec<String>,
}

impl Admission {
    /// Answers the request of a handshake: selects the protocol, or rejects the client.
    #[expect(clippy::result_large_err, reason = "the signature that tungstenite requires")]
    pub(super) fn answer(
        &self,
        request: &Request,
        mut response: Response,
    ) -> Result<Response, ErrorResponse> {
        let headers = request.headers();
        if !only_value(headers, HOST).is_some_and(|host| self.admits_host(host)) {
            return Err(rejection(
                StatusCode::FORBIDDEN,
                "connect by IP address or localhost, or name this host with --live-host",
            ));
        }
        let is_web_page = headers.contains_key(ORIGIN);
        if is_web_page
            && !only_value(headers, ORIGIN).is_some_and(|origin| self.admits_origin(origin))
        {
            return Err(rejection(
                StatusCode::FORBIDDEN,
                "this web page is not a known viewer: --live-origin admits it",
            ));
        }
        let offers = headers.get_all(SEC_WEBSOCKET_PROTOCOL).iter();
        let is_offered = offers
            .flat_map(|offer| offer.to_str().unwrap_or_default().split(','))
            .any(|offer| offer.trim() == SUBPROTOCOL);
        if !is_offered {
            let reason = format!("this server requires {SUBPROTOCOL}");
            return Err(rejection(StatusCode::BAD_REQUEST, &reason));
        }
        let agreed = HeaderValue::from_static(SUBPROTOCOL);
        response.headers_mut().insert(SEC_WEBSOCKET_PROTOCOL, agreed);
        Ok(response)
    }

    /// Whether the value of `Host` is an IP address, `localhost` or an admitted name.
    #[must_use]
    pub fn admits_host(&self, host: &str) -> bool {
        let name = without_port(host).to_ascii_lowercase();
        is_address(&name) || name == "localhost" || self.hosts.contains(&name)
    }

    /// Whether the value of `Origin` is a viewer's, a page of this machine, or an admitted one.
    #[must_use]
    pub fn admits_origin(&self, origin: &str) -> bool {
        let origin = origin.to_ascii_lowercase();
        if VIEWERS.contains(&origin.as_str()) || self.origins.contains(&origin) {
            return true;
        }
        let server = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        server.map(without_port).is_some_and(|name| name == "localhost" || is_loopback(name))
    }
}

fn rejection(status: StatusCode, reason: &str) -> ErrorResponse {
    let mut rejection = ErrorResponse::new(Some(format!("{reason}\n")));
    *rejection.status_mut() = status;
    rejection
}

/// The value of a header that occurs once.
fn only_value(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// The name or address of `NAME`, `NAME:PORT` or `[ADDRESS]:PORT`; text of another form is returned unchanged.
fn without_port(server: &str) -> &str {
    let is_port = |port: &str| port.bytes().all(|byte| byte.is_ascii_digit());
    match server.rsplit_once(':') {
        // An IPv6 address ends with its bracket.
        Some((name, port)) if is_port(port) && (!name.contains(':') || name.ends_with(']')) => name,
        _ => server,
    }
}

/// An IPv4 address, or an IPv6 address in brackets.
fn parse_address(name: &str) -> Option<IpAddr> {
    let inside = name.strip_prefix('[').and_then(|name| name.strip_suffix(']'));
    match inside {
        Some(inside) => inside.parse().ok().map(|address: Ipv6Addr| IpAddr::V6(address)),
        None => name.parse().ok().filter(IpAddr::is_ipv4),
    }
}

fn is_address(name: &str) -> bool {
    parse_address(name).is_some()
}

fn is_loopback(name: &str) -> bool {
    parse_address(name).is_some_and(|address| address.is_loopback())
}

/// Parses an origin to admit, such as `https://viewer.example:8080`.
///
/// # Errors
/// A text that a browser does not send as an origin.
pub fn origin(text: &str) -> Result<String, String> {
    let origin = text.strip_suffix('/').unwrap_or(text).to_ascii_lowercase();
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._:[]".contains(&byte);
    match origin.split_once("://") {
        Some((scheme, server))
            if !scheme.is_empty()
                && scheme.bytes().all(is_plain)
                && !server.is_empty()
                && server.bytes().all(is_plain) =>
        {
            Ok(origin)
        }
        _ => Err("write scheme, name and port, such as https://viewer.example:8080".to_owned()),
    }
}

/// Parses a name of this machine, without a port.
///
/// # Errors
/// A text that is not a host name.
pub fn host(text: &str) -> Result<String, String> {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._".contains(&byte);
    if !text.is_empty() && text.bytes().all(is_plain) {
        Ok(text.to_ascii_lowercase())
    } else {
        Err("write a host name without a port, such as node7.example".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn host_is_an_address_or_localhost_or_named() {
        let admission =
            Admission { hosts: vec!["node7.example".to_owned()], ..Admission::default() };
        for host in [
            "127.0.0.1:8765",
            "127.0.0.1",
            "localhost:8765",
            "LOCALHOST",
            "[::1]:8765",
            "[::1]",
            "192.168.1.5:80",
            "Node7.Example:8765",
        ] {
            assert!(admission.admits_host(host), "{host}");
        }
        for host in [
            "",
            "evil.example",
            "evil.example:8765",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "127.0.0.1@evil.example",
            "::1",
            "[::1",
            "[127.0.0.1]",
            "localhost:8765:1",
            "node7.example.evil",
            "0x7f.1",
        ] {
            assert!(!admission.admits_host(host), "{host}");
        }
    }

    #[test]
    fn origin_is_a_viewer_or_this_machine_or_named() {
        let origins = vec!["https://viewer.example:8080".to_owned()];
        let admission = Admission { origins, ..Admission::default() };
        for origin in [
            "https://app.foxglove.dev",
            "https://lichtblick-suite.github.io",
            "file://",
            "http://localhost:8080",
            "https://localhost",
            "http://127.0.0.1:8080",
            "http://[::1]:8080",
            "https://viewer.example:8080",
        ] {
            assert!(admission.admits_origin(origin), "{origin}");
        }
        for origin in [
            // Every page can send `null`, from a sandboxed frame.
            "null",
            "",
            "https://evil.example",
            "http://app.foxglove.dev",
            "https://app.foxglove.dev.evil.example",
            "https://evil.example/https://app.foxglove.dev",
            "https://app.foxglove.dev:8080",
            "http://localhost.evil.example",
            "http://localhost:8080.evil.example",
            "http://192.168.1.5:8080",
            "ftp://localhost",
            "https://viewer.example",
        ] {
            assert!(!admission.admits_origin(origin), "{origin}");
        }
    }

    #[test]
    fn options_name_an_origin_and_a_host() {
        assert_eq!(origin("https://Viewer.Example/").as_deref(), Ok("https://viewer.example"));
        assert_eq!(host("Node7").as_deref(), Ok("node7"));
        for text in ["", "viewer.example", "https://", "https://a/b", "https://a b", "*", "null"] {
            assert!(origin(text).is_err(), "{text}");
        }
        for text in ["", "node7:8765", "https://node7", "*", "a b"] {
            assert!(host(text).is_err(), "{text}");
        }
    }
}
