//! Messages of the WebSocket subprotocol `foxglove.sdk.v1` that a live view needs. Source:
//! `<https://github.com/foxglove/ws-protocol>`, and the Foxglove SDK 0.30 for the playback control.

use data_encoding::BASE64;
use kinetoscope_recording::observer::ChannelInfo;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// The name of the subprotocol in the handshake.
pub(super) const SUBPROTOCOL: &str = "foxglove.sdk.v1";

/// Operation codes of binary messages, of the server and of the client.
const MESSAGE_DATA: u8 = 1;
const TIME: u8 = 2;
const PLAYBACK_STATE: u8 = 5;
const PLAYBACK_CONTROL_REQUEST: u8 = 3;

/// The server's name and capabilities. With `range_ns`, the playback from log time 0 to `range_ns` can be controlled.
pub(super) fn server_info(name: &str, session: &str, range_ns: Option<u64>) -> String {
    let mut info = json!({
        "op": "serverInfo",
        "name": name,
        // The viewer's clock shows log time, not wall-clock time.
        "capabilities": ["time"],
        "sessionId": session,
    });
    if let Some(end) = range_ns {
        info["capabilities"] = json!(["time", "playbackControl"]);
        info["dataStartTime"] = json!({ "sec": 0, "nsec": 0 });
        info["dataEndTime"] = json!({ "sec": end / 1_000_000_000, "nsec": end % 1_000_000_000 });
    }
    info.to_string()
}

/// Announces channels with consecutive ids from `first_id`.
pub(super) fn advertise(channels: &[ChannelInfo], first_id: u64) -> String {
    let channels: Vec<serde_json::Value> = (first_id..)
        .zip(channels)
        .map(|(id, channel)| {
            json!({
                "id": id,
                "topic": channel.topic,
                "encoding": "protobuf",
                "schemaName": channel.schema_name,
                "schemaEncoding": "protobuf",
                "schema": BASE64.encode(&channel.schema),
            })
        })
        .collect();
    json!({ "op": "advertise", "channels": channels }).to_string()
}

/// Withdraws `count` channels with consecutive ids from `first_id`.
pub(super) fn unadvertise(first_id: u64, count: u64) -> String {
    let ids: Vec<u64> = (first_id..).take(count as usize).collect();
    json!({ "op": "unadvertise", "channelIds": ids }).to_string()
}

/// A warning for the viewer to show.
pub(super) fn warning(text: &str) -> String {
    json!({ "op": "status", "level": 1, "message": text }).to_string()
}

/// What precedes the payload of one message of a channel, for a subscription: the header of a WebSocket frame with binary data that
/// is not masked (RFC 6455, section 5.2), and that of the message. The payload is not copied, since it has megabytes and is sent to
/// each viewer.
pub(super) fn message_header(subscription: u32, log_time_ns: u64, payload: &[u8]) -> Vec<u8> {
    const FINAL_BINARY: u8 = 0x82;
    let length = 13 + payload.len() as u64;
    let mut bytes = vec![FINAL_BINARY];
    match (u8::try_from(length), u16::try_from(length)) {
        (Ok(length @ ..=125), _) => bytes.push(length),
        (_, Ok(length)) => {
            bytes.push(126);
            bytes.extend(length.to_be_bytes());
        }
        _ => {
            bytes.push(127);
            bytes.extend(length.to_be_bytes());
        }
    }
    bytes.push(MESSAGE_DATA);
    bytes.extend(subscription.to_le_bytes());
    bytes.extend(log_time_ns.to_le_bytes());
    bytes
}

/// Sets the viewer's clock.
pub(super) fn time(log_time_ns: u64) -> Vec<u8> {
    let mut bytes = vec![TIME];
    bytes.extend(log_time_ns.to_le_bytes());
    bytes
}

/// State of the playback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaybackState {
    /// Whether the run is held.
    pub(super) paused: bool,
    /// Log time of the last broadcast frame, ns.
    pub(super) time_ns: u64,
    /// Seconds of playback per second.
    pub(super) speed: f64,
    /// Whether a viewer's jump led to this state.
    pub(super) jumped: bool,
}

impl PlaybackState {
    /// Encodes the state as the reply to a request, or as a notification if `request_id` is empty.
    pub(super) fn encode(self, request_id: &str) -> Vec<u8> {
        let mut bytes = vec![PLAYBACK_STATE, u8::from(self.paused)];
        bytes.extend(self.time_ns.to_le_bytes());
        bytes.extend((self.speed as f32).to_le_bytes());
        bytes.push(u8::from(self.jumped));
        bytes.extend((request_id.len() as u32).to_le_bytes());
        bytes.extend(request_id.as_bytes());
        bytes
    }
}

/// A viewer's request.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Request {
    Subscribe(Vec<Subscription>),
    /// Subscriptions by their ids.
    Unsubscribe(Vec<u32>),
    Playback(PlaybackRequest),
    /// A request that is not supported, such as parameters.
    Other,
}

/// A subscription to a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Subscription {
    /// The viewer's id of the subscription.
    pub(super) id: u32,
    pub(super) channel_id: u64,
}

/// A request to play, pause, or jump.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlaybackRequest {
    pub(super) pause: bool,
    pub(super) speed: f32,
    /// Log time to jump to, ns.
    pub(super) jump_to_ns: Option<u64>,
    pub(super) id: String,
}

#[derive(Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum TextRequest {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    #[serde(rename_all = "camelCase")]
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    #[serde(other)]
    Other,
}

/// Decodes a viewer's text message; `None` if it does not belong to the protocol.
pub(super) fn text_request(text: &str) -> Option<Request> {
    Some(match serde_json::from_str(text).ok()? {
        TextRequest::Subscribe { subscriptions } => Request::Subscribe(subscriptions),
        TextRequest::Unsubscribe { subscription_ids } => Request::Unsubscribe(subscription_ids),
        TextRequest::Other => Request::Other,
    })
}

/// Decodes a viewer's binary message; `None` if it does not belong to the protocol.
pub(super) fn binary_request(bytes: &[u8]) -> Option<Request> {
    let (&operation, mut rest) = bytes.split_first()?;
    if operation != PLAYBACK_CONTROL_REQUEST {
        return Some(Request::Other);
    }
    let [command] = take(&mut rest)?;
    let speed = f32::from_le_bytes(take(&mut rest)?);
    let [jumps] = take(&mut rest)?;
    let jump_to = u64::from_le_bytes(take(&mut rest)?);
    let length = u32::from_le_bytes(take(&mut rest)?);
    let id = rest.get(..length as usize)?;
    Some(Request::Playback(PlaybackRequest {
        pause: command == 1,
        speed,
        jump_to_ns: (jumps != 0).then_some(jump_to),
        id: str::from_utf8(id).ok()?.to_owned(),
    }))
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (first, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_as_the_viewers_write_them() {
        // Bytes and texts as the Foxglove SDK 0.30.3 encodes them.
        let subscribe = r#"{"op":"subscribe","subscriptions":[{"id":1,"channelId":10},{"id":2,"channelId":20}]}"#;
        let wanted = [(1, 10), (2, 20)].map(|(id, channel_id)| Subscription { id, channel_id });
        assert_eq!(text_request(subscribe), Some(Request::Subscribe(wanted.to_vec())));
        let unsubscribe = r#"{"op":"unsubscribe","subscriptionIds":[1,2]}"#;
        assert_eq!(text_request(unsubscribe), Some(Request::Unsubscribe(vec![1, 2])));
        assert_eq!(text_request(r#"{"op":"getParameters"}"#), Some(Request::Other));
        assert_eq!(text_request("{"), None);
        let mut play = vec![3, 0];
        play.extend(1.5_f32.to_le_bytes());
        play.push(1);
        play.extend(7_u64.to_le_bytes());
        play.extend(2_u32.to_le_bytes());
        play.extend(b"id");
        let request =
            PlaybackRequest { pause: false, speed: 1.5, jump_to_ns: Some(7), id: "id".to_owned() };
        assert_eq!(binary_request(&play), Some(Request::Playback(request)));
        for end in 1..play.len() {
            assert_eq!(binary_request(&play[..end]), None, "cut after {end} bytes");
        }
    }

    #[test]
    fn message_headers_are_those_of_the_websocket_library() {
        use tungstenite::protocol::frame::Frame;
        use tungstenite::protocol::frame::coding::{Data, OpCode};
        // Around the lengths at which a frame's header grows.
        for length in [0, 112, 113, 65_522, 65_523] {
            let payload = vec![7; length];
            let mut message = vec![MESSAGE_DATA];
            message.extend([3, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0]);
            message.extend(&payload);
            let mut expected = Vec::new();
            let frame = Frame::message(message, OpCode::Data(Data::Binary), true);
            frame.format(&mut expected).unwrap();
            let header = message_header(3, 5, &payload);
            assert_eq!([header, payload].concat(), expected, "{length} bytes");
        }
    }
}
