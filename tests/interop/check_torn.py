"""Reads the partial recording of a killed run with the reader of another project.

Usage: python check_torn.py TORN.mcap WHOLE.mcap       (packages: requirements.txt)

Every message of the torn file up to its tear must be, byte for byte and in order, a message of the whole recording, with all
checksums validated. Prints the number of messages; exit code 1 if a message differs or none is found.
"""

import sys

from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader


def messages(path):
    """Messages with their topics, and whether the file ended as a file should."""
    topics, found = {}, []
    with open(path, "rb") as stream:
        try:
            for record in StreamReader(stream, validate_crcs=True).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message):
                    found.append((topics[record.channel_id], record.sequence, record.log_time, record.data))
        except Exception as error:  # where and how a file is torn is up to the kill
            return found, f"{type(error).__name__}: {error}"
    return found, None


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    torn, tear = messages(sys.argv[1])
    whole, fault = messages(sys.argv[2])
    if fault is not None:
        sys.exit(f"{sys.argv[2]}: {fault}")
    if not torn:
        sys.exit(f"{sys.argv[1]}: no message is left ({tear})")
    if torn != whole[: len(torn)]:
        sys.exit(f"{sys.argv[1]}: other messages than in the whole recording")
    print(f"{len(torn)} of {len(whole)} messages, then {tear}")


if __name__ == "__main__":
    main()
