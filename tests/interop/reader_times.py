"""Times of Python readers on recordings: the `mcap` package, which any user has, and the package `kinetoscope`.

Usage: python reader_times.py RECORDING.mcap ...    (packages: requirements.txt, and `kinetoscope` on PYTHONPATH)

Prints one line per recording, in milliseconds of processor time, the least of five: opening, the first second of playback after the middle (what a
viewer reads when the user jumps there), all messages, and by `kinetoscope` opening, the state in the middle, and the clocks.

Why chunks of states have 4 MiB (`STATE_BYTES` in `src/recording/block_writer.rs`): the dense runs of `benches/recording_overhead.rs`, recorded with
chunks of 1, 2 and 4 MiB, under a load of 20 on two cores; MB, and ms of processor time.

|                   |        MB         |        jump       |        all        |      state     |       clocks      |
| dem               |   52,   43,   38  |   39,   19,   19  |  244,  239,  233  |   5,   5,   8  |  118,   49,   26  |
| dem with friction |  162,  160,  159  |   66,   32,   34  |  495,  317,  321  |   7,   8,  14  |   72,   32,   18  |
| gas               |   75,   68,   64  |   27,   24,   26  |  273,  226,  227  |   2,   3,   6  |   32,   20,   13  |
| packing           |   79,   73,   70  |   27,   23,   25  |  291,  219,  223  |   5,   6,  11  |   29,   18,   11  |

Half of the size would save 3 to 6 ms of a jump to a single state, and nothing of a second of playback or of all messages; the files are up to 12 %
larger, and the clocks take 1.5 to 1.9 times as long, because each block has a chunk of them. Since these measurements, a jump reads the particles of the start
once per run, which saves a chunk: 4 instead of 8 ms for dem.

Schema version 3, which had one chunk for all channels, in turn with version 5 (each recording of ten shipped experiments by its own program, seven times, ms of
processor time): all messages by `mcap` in order of time take 1.09 of the time (0.98 to 1.16), because it merges the three groups, 0.5 to 1 microsecond per message.
In the order of the file (`log_time_order=False`) four of them take 0.92 to 1.03. Large ones gain (gas_300_kelvin and gas_mixing 0.98), and so do the clocks
(gas_mixing 103 and 5 ms, gas_300_kelvin 62 and 8). A jump takes 2 to 6 ms more where recordings are small (dem_rotating_drum 5 and 11 ms).
"""

import sys
import time
from pathlib import Path

import kinetoscope
from mcap.reader import make_reader

REPEATS = 5


def least_ms(measured):
    def once():
        started = time.process_time()
        measured()
        return 1e3 * (time.process_time() - started)

    return min(once() for _ in range(REPEATS))


def count(messages):
    return sum(1 for _ in messages)


def row(path):
    with open(path, "rb") as stream:
        statistics = make_reader(stream).get_summary().statistics
        middle = (statistics.message_start_time + statistics.message_end_time) // 2

        def opened():
            stream.seek(0)
            return make_reader(stream)

        mcap_times = [
            least_ms(lambda: opened().get_summary()),
            least_ms(lambda: count(opened().iter_messages(starting_at=middle, ending_at=middle + 10**9))),
            least_ms(lambda: count(opened().iter_messages())),
        ]
    run = kinetoscope.Run(path)
    clocks = run["/frame"]
    own_times = [
        least_ms(lambda: kinetoscope.Run(path)),
        least_ms(lambda: run["/state"][len(clocks) // 2]),
        least_ms(lambda: count(run["/frame"])),
    ]
    return mcap_times + own_times


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    names = ["open", "jump", "all", "Run()", "state", "clocks"]
    print("".join(f"{name:>10}" for name in ["MB", *names]), " recording")
    for name in sys.argv[1:]:
        path = Path(name)
        megabytes = path.stat().st_size / 1e6
        print(f"{megabytes:10.2f}" + "".join(f"{value:10.2f}" for value in row(path)), f" {path.stem}", flush=True)


if __name__ == "__main__":
    main()
