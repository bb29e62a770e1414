"""Receives the messages of a run in progress and compares them with the recording.

Usage: python live_viewer.py ADDRESS FOLDER    (packages: requirements.txt)

ADDRESS is the address of `run-experiment --live`; FOLDER is the folder of the only recording. Every message is decoded by the schema
that the server announces. Exit code 1 if a message differs from the recording, a frame is incomplete, the last frame is missing, or the
viewer's clock does not advance.
"""

import base64
import json
import struct
import sys
from pathlib import Path

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

SUBPROTOCOL = "foxglove.sdk.v1"
MESSAGE_DATA = 1
TIME = 2


def require(holds, what):
    if not holds:
        sys.exit(what)


def decoder(channel):
    """The message class of a channel, from the schema in its announcement."""
    files = descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"], validate=True))
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))


def watch(address):
    """All messages until the server closes: topic, log time, bytes."""
    topics, decoders, seen, clock = {}, {}, [], 0
    with connect(f"ws://{address}", subprotocols=[SUBPROTOCOL], max_size=None) as socket:
        require(socket.subprotocol == SUBPROTOCOL, f"agreed on {socket.subprotocol}")
        while True:
            try:
                said = socket.recv()
            except ConnectionClosed:
                return seen
            if isinstance(said, str):
                said = json.loads(said)
                require(said["op"] in {"serverInfo", "advertise"}, f"unexpected message of the server: {said}")
                for channel in said.get("channels", []):
                    topics[channel["id"]], decoders[channel["id"]] = channel["topic"], decoder(channel)
                subscriptions = [{"id": channel, "channelId": channel} for channel in topics]
                if said["op"] == "advertise":
                    socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
            elif said[0] == MESSAGE_DATA:
                channel, log_time = struct.unpack_from("<IQ", said, 1)
                decoders[channel].FromString(said[13:])
                seen.append((topics[channel], log_time, said[13:]))
            elif said[0] == TIME:
                (time,) = struct.unpack_from("<Q", said, 1)
                require(time > clock, f"the clock goes from {clock} to {time} ns")
                clock = time


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    seen = watch(sys.argv[1])
    (recording,) = Path(sys.argv[2]).glob("*.mcap")
    with open(recording, "rb") as stream:
        messages = make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        recorded = [(channel.topic, message.log_time, message.data) for _, channel, message in messages]
    require(set(seen) <= set(recorded), "a message differs from the recording")
    times = {time for _, time, _ in seen}
    for time in times:
        of_frame = [sorted(message for message in all_ if message[1] == time) for all_ in (seen, recorded)]
        require(of_frame[0] == of_frame[1], f"the frame at {time} ns is incomplete")
    last = max(time for _, time, _ in recorded)
    require(last in times, "the last frame is missing")
    frames = len({time for _, time, _ in recorded})
    print(f"{len(seen)} messages of {len(times)} frames, of {frames} recorded: equal in every byte")


if __name__ == "__main__":
    main()
