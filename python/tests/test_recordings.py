"""Guarantee: recordings are read as the official reader reads them, in any order, and damage is an error."""

from __future__ import annotations

import importlib.util
import shutil
import struct
import sys
import zlib
from pathlib import Path
from typing import BinaryIO, Iterator, List, Optional

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from mutated_recording import CHUNK, MutatedRecording, encoded

import kinetoscope as k
from kinetoscope import _chunks, _frames, _programs

MODELS = ["first_run", "gas_300_kelvin", "packing_fifty_discs", "orbit_exercise"]


@pytest.fixture(scope="session", params=MODELS)
def run_of_model(
    request: pytest.FixtureRequest, experiments: Path, tmp_path_factory: pytest.TempPathFactory, programs: Optional[str]
) -> k.Run:
    output = tmp_path_factory.mktemp("models")
    return k.run(experiments / f"{request.param}.toml", output=output, programs=programs).runs[0]


def official(path: Path, topic: str) -> Iterator[object]:
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=[topic]):
            yield message


def official_states(path: Path) -> List[np.ndarray]:
    """The states with the constants of the particles, in the order of the columns that the provenance names."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        provenance = next(record.metadata for record in reader.iter_metadata() if record.name == "kinetoscope")
        order = provenance["state_columns"].split(",")
        states, particles = [], {}
        for _, channel, _, cloud in reader.iter_decoded_messages(["/particles", "/state"]):
            rows = np.frombuffer(cloud.data, [(field.name, "<f8") for field in cloud.fields])
            columns = {name: rows[name] for name in rows.dtype.names or ()}
            if channel.topic == "/particles":
                particles = columns
                continue
            state = np.empty(len(rows), [(name, "<f8") for name in order])
            for name, column in {**columns, **particles}.items():
                state[name] = column
            states.append(state)
    return states


def test_state_equals_that_of_the_official_reader(run_of_model: k.Run) -> None:
    expected = official_states(run_of_model.path)
    frames = list(run_of_model["/state"])
    assert len(frames) == len(expected) == len(run_of_model)
    for ours, theirs in zip(frames, expected):
        assert ours.dtype.names == theirs.dtype.names and ours.tobytes() == theirs.tobytes()
    # Control: one bit.
    frames[-1]["x"][0] = np.nextafter(frames[-1]["x"][0], 1e9)
    assert frames[-1].tobytes() != expected[-1].tobytes()


def test_numeric_topics_equal_those_of_the_official_reader(run_of_model: k.Run) -> None:
    numeric = [topic for topic in run_of_model.topics if topic not in ("/state", "/particles", "/log")]
    compared = 0
    for topic in numeric:
        try:
            frames = run_of_model[topic]
        except k.KinetoscopeError as error:
            assert "foxglove.SceneUpdate, not numbers\nhelp: `run.show()`" in str(error)
            continue
        for ours, theirs in zip(frames, official(run_of_model.path, topic)):
            for name in frames.columns:
                np.testing.assert_array_equal(ours[name], getattr(theirs, name))
        compared += 1
    assert compared >= 3
    with pytest.raises(k.KinetoscopeError, match="foxglove.Log, not numbers\nhelp: `run.log` has"):
        run_of_model["/log"]


def test_single_frames_and_slices_equal_those_of_the_iteration(recording: k.Run) -> None:
    state = recording["/state"]
    frames = list(state)
    for index in (0, 1, 77, 180, 181, 182, 250, -1, -251):
        assert state[index].tobytes() == frames[index].tobytes()
    for part in (slice(5, 9), slice(None, None, 50), slice(None, None, -60), slice(3, 3)):
        assert [frame.tobytes() for frame in state[part]] == [frame.tobytes() for frame in frames[part]]
        assert list(state[part].times) == list(state.times[part])
    with pytest.raises(IndexError, match="frame 251 of 251 frames"):
        state[251]
    assert frames[3].flags.aligned and frames[3].flags.owndata


@pytest.mark.parametrize("rate", [0.1, 7.3, 29.97, 50.0])
def test_frames_are_found_at_every_playback_rate(
    rate: float, experiments: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    change = {"record.playback_fps": rate}
    run = k.run(experiments / "orbit_exercise.toml", set=change, output=tmp_path, programs=programs).runs[0]
    assert [frame.tobytes() for frame in run["/state"]] == [frame.tobytes() for frame in official_states(run.path)]


def test_frames_may_differ_in_size(experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    change = {"model.dem.duration_s": 0.3}
    run = k.run(experiments / "dem_fed_hopper.toml", set=change, output=tmp_path, programs=programs).runs[0]
    state = run["/state"]
    expected = official_states(run.path)
    assert len({len(frame) for frame in expected}) > 1
    assert [frame.tobytes() for frame in state] == [frame.tobytes() for frame in expected]
    with pytest.raises(k.KinetoscopeError, match="help: iterate"):
        state.array()


@pytest.mark.parametrize("compression", ["zstd-3", "lz4", "none"])
def test_every_compression_is_read(compression: str, experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    change = {"record.compression": compression}
    run = k.run(experiments / "first_run.toml", set=change, output=tmp_path, programs=programs).runs[0]
    assert [frame.tobytes() for frame in run["/state"]] == [frame.tobytes() for frame in official_states(run.path)]


def test_series_have_the_library_of_choice(recording: k.Run) -> None:
    pytest.importorskip("polars")
    polars, pandas = recording.series("/energy"), recording.series("/energy", "pandas")
    assert type(polars).__module__.startswith("polars") and type(pandas).__module__.startswith("pandas")
    assert polars["kinetic_j"].to_list() == pandas["kinetic_j"].to_list()
    walls = recording.series("/wall_forces")
    assert len(walls) == 4 * len(recording) and walls["frame"].to_list()[:5] == [0, 0, 0, 0, 1]
    assert recording.series("/frame")["time_unit"][0] == "s"


def test_series_of_keyframes_have_all_frames(experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    change = {"record.keep": "keyframes", "record.keyframe_distance": 30}
    keys, full = (
        k.run(experiments / "first_run.toml", set=change, output=tmp_path / name, programs=programs).runs[0]
        for name, change in (("keys", change), ("full", {}))
    )
    assert keys.path.stat().st_size < full.path.stat().st_size / 2
    assert keys.series("/energy").equals(full.series("/energy"))


def test_a_series_reads_the_chunks_of_its_topic_once(
    experiments: Path, tmp_path: Path, programs: Optional[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    change = {"record.keep": "keyframes", "record.keyframe_distance": 30}
    run = k.run(experiments / "first_run.toml", set=change, output=tmp_path, programs=programs).runs[0]
    channel = run._container.channel("/energy")
    assert channel is not None
    own = [chunk.offset for chunk in run._container.chunks if channel.id in chunk.channels]
    read: List[int] = []

    def counted(path: Path, stream: BinaryIO, offset: int, end: int) -> _chunks.Content:
        read.append(offset)
        return _chunks.read_chunk(path, stream, offset, end)

    monkeypatch.setattr(_frames, "read_chunk", counted)
    series = run.series("/energy", "pandas")
    assert read == own and len(own) > 5 and len(run._container.chunks) > 2 * len(own)
    # Control: the times and the numbers are those of the frames.
    assert list(series["time"]) == list(run.times)
    assert list(series["kinetic_j"]) == [frame["kinetic_j"][0] for frame in run["/energy"]]
    assert len(read) > 2 * len(own)


def test_frames_of_a_part_of_a_run_have_their_numbers(
    experiments: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    change = {"record.keep": "keyframes", "record.keyframe_distance": 30}
    keys, full = (
        k.run(experiments / "first_run.toml", set=change, output=tmp_path / name, programs=programs).runs[0]
        for name, change in (("keys", change), ("full", {}))
    )
    state, whole = keys["/state"], full["/state"]
    # 251 frames: every 30th, and the last one.
    assert list(state.indices) == [*range(0, 250, 30), 250] and len(keys.times) == 251
    assert [index for index, frame in zip(state.indices, state) if not np.array_equal(frame, whole[index])] == []
    assert np.array_equal(state[-1], whole[250]) and np.array_equal(state[1:3].times, full.times[[30, 60]])
    assert keys.series("/state", "pandas")["frame"].unique().tolist() == list(state.indices)
    with pytest.raises(IndexError, match="frame 250 of 10 frames: .* every 30th frame.*\nhelp: `kinetoscope fill /.*mcap`"):
        state[250]
    arguments = ["--from", "0.1", "--to", "0.11", "--every", "0.001", str(keys.path), "--output", str(tmp_path / "zoom.mcap")]
    assert _programs.call(["zoom", *arguments], programs).code == 0
    zoomed = k.Run(tmp_path / "zoom.mcap")
    assert len(zoomed["/state"]) == len(zoomed) == len(list(zoomed["/state"])) and zoomed.times[0] >= 0.0999
    assert _programs.call(["fill", str(keys.path)], programs).code == 0
    restored = k.open(keys.path.parent, programs=programs).runs[0]
    assert len(restored["/state"]) == 251 and restored.coordinates == keys.coordinates
    assert restored.run_key == full.run_key


def test_metrics_belong_to_the_restored_recording(experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    change = {"record.keep": "keyframes", "record.keyframe_distance": 30}
    experiment = k.run(experiments / "first_run.toml", set=change, output=tmp_path, programs=programs)
    keys = experiment.runs[0]
    name = "energy.kinetic_disagreement_relative"
    with pytest.raises(k.KinetoscopeError, match="has no value: it needs the states of all frames"):
        experiment.metric(name)
    assert _programs.call(["fill", str(keys.path)], programs).code == 0
    # The same object, one that is opened, and one that reads the results on disk.
    for again in (experiment, k.open(experiment.path, programs=programs), k.open(experiment.path, programs=tmp_path)):
        (run,) = again.runs
        assert run.path != keys.path and len(run["/state"]) == 251
        assert again.metric(name) == run.metric(name) < 1e-15
        assert set(again.table("pandas")["file"]) == {run.path.name}


def test_merged_runs_have_the_frames_of_their_recordings(experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    manifest = {"model": {"dem": {"discs": 12, "duration_s": 0.2}}, "record": {"frames": 20}}
    change = {"record.keep": "keyframes", "record.keyframe_distance": 7}
    first = k.run(manifest, output=tmp_path / "1", programs=programs).runs[0]
    second = k.run(manifest, seed=2, set=change, output=tmp_path / "2", programs=programs).runs[0]
    path = tmp_path / "merged.mcap"
    call = _programs.call(["compare", "--mcap", str(path), str(first.path), str(second.path)], programs)
    assert path.is_file(), call.messages
    merged = k.open(path, programs=programs)
    assert len(merged.runs) == 2 and "<run " in repr(merged.runs[1])
    for own, run in zip((first, second), merged.runs):
        assert (run.run_key, run.outcome, run.manifest, run.seed) == (own.run_key, own.outcome, own.manifest, own.seed)
        for topic in ("/frame", "/state", "/energy", "/contact_statistics"):
            assert list(run[topic].indices) == list(own[topic].indices), topic
            assert run[topic].units == own[topic].units
            assert all((a == b).all() for a, b in zip(run[topic], own[topic])), topic
        assert (run.times == own.times).all()
        assert run.series("/energy", "pandas").equals(own.series("/energy", "pandas"))
        for refused in (lambda: run.metric("energy.kinetic"), run.verify, run.show):
            with pytest.raises(k.KinetoscopeError, match="cannot be analyzed or verified"):
                refused()
    separation = merged.runs[1]["/separation"]
    assert separation.units["max_distance"] == "m" and list(separation.indices) == [0, 7, 14, 20]
    for frame, row in zip(separation.indices, separation):
        at = list(second["/state"].indices).index(frame)
        one, other = first["/state"][frame], second["/state"][at]
        distance = np.hypot(one["x"] - other["x"], one["y"] - other["y"])
        assert row["max_distance"][0] == pytest.approx(distance.max(), rel=1e-14)
    for of_all in (lambda: merged.metrics, lambda: merged.answer, merged.show, lambda: merged.plot("/energy.kinetic_j")):
        with pytest.raises(k.KinetoscopeError, match="cannot be analyzed or verified"):
            of_all()
    with pytest.raises(k.RecordingError, match="several runs, merged for a viewer"):
        k.Run(path)


def test_damaged_merged_recordings_are_errors(recording: k.Run, tmp_path: Path, programs: Optional[str]) -> None:
    path = tmp_path / "merged.mcap"
    call = _programs.call(["compare", "--mcap", str(path), str(recording.path), str(recording.path)], programs)
    assert path.is_file(), call.messages
    content, random = path.read_bytes(), np.random.default_rng(1)
    for _ in range(200):
        changed = bytearray(content)
        if random.integers(3) == 0:
            del changed[int(random.integers(len(content))) :]
        else:
            changed[int(random.integers(len(content)))] ^= 1 << int(random.integers(8))
        path.write_bytes(changed)
        try:
            assert all(len(run["/state"].array()) == len(recording) for run in k.open(path).runs)
        except k.KinetoscopeError as error:
            assert "verify" not in str(error) or "/state" in str(error)
    for cut in (1, 200, 3000):
        path.write_bytes(content[:-cut])
        with pytest.raises(k.RecordingError, match="merge the recordings again"):
            k.open(path)
    # Without its last chunk, whose place the index states, and with a repaired checksum.
    from mcap.reader import make_reader

    path.write_bytes(content)
    with open(path, "rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    last = summary.chunk_indexes[-1]
    end = last.chunk_start_offset + last.chunk_length + last.message_index_length
    data_end = content.index(struct.pack("<BQ", 15, 4), end)
    changed = bytearray(content[: last.chunk_start_offset] + content[end:])
    at = data_end - (end - last.chunk_start_offset)
    changed[at + 9 : at + 13] = struct.pack("<I", zlib.crc32(bytes(changed[:at])))
    path.write_bytes(changed)
    with pytest.raises(k.RecordingError, match="other numbers of messages"):
        k.open(path)


def test_other_files_are_named_as_before(recording: k.Run, tmp_path: Path) -> None:
    path, content = tmp_path / "other.mcap", recording.path.read_bytes()
    for cut in (8, 30, 100, 400):
        path.write_bytes(content[:cut])
        with pytest.raises(k.RecordingError, match="is not an MCAP file|has no end"):
            k.open(path)


def test_missing_optional_packages_are_named(recording: k.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "polars" else found(name))
    assert type(recording.series("/energy")).__module__.startswith("pandas")
    with pytest.raises(k.KinetoscopeError, match="polars is not installed\nhelp: `pip install 'kinetoscope.polars.'`"):
        recording.series("/energy", "polars")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(k.KinetoscopeError, match="neither polars nor pandas is installed"):
        recording.series("/energy")
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(k.KinetoscopeError, match="`xarray` is not installed"):
        recording["/state"].to_xarray()


def test_xarray_has_times_and_units(recording: k.Run) -> None:
    whole = recording["/state"][:10].to_xarray()
    energy = recording["/energy"][:2].to_xarray()
    assert energy["kinetic_j"].attrs["units"] == "J"
    assert whole["x"].shape == (10, 20) and whole["vx"].attrs["units"] == "m/s"
    one = recording["/state"].to_xarray(-1)
    assert int(one["frame"]) == 250 and float(one["time"]) == recording["/state"].times[-1]


def test_torn_files_are_rejected_and_their_intact_frames_can_be_read(recording: k.Run, tmp_path: Path) -> None:
    whole = recording.path.read_bytes()
    frames = list(recording["/state"])
    counts = {0}
    for part in range(1, 20):
        torn = tmp_path / f"torn {part}.mcap"
        torn.write_bytes(whole[: len(whole) * part // 20])
        with pytest.raises(k.RecordingError, match="has no end.*\nhelp: run the same experiment again"):
            k.Run(torn)
        run = k.Run(torn, allow_torn=True)
        assert run.outcome == "unfinished"
        if "/state" in run:
            intact = list(run["/state"])
            assert [frame.tobytes() for frame in intact] == [frame.tobytes() for frame in frames[: len(intact)]]
            counts.add(len(intact))
    # Nothing, and everything but the index: the recording has one block.
    assert counts == {0, len(frames)}
    (tmp_path / "start.mcap").write_bytes(whole[:5])
    with pytest.raises(k.RecordingError, match="is not an MCAP file"):
        k.Run(tmp_path / "start.mcap")


def test_a_changed_byte_is_an_error(recording: k.Run, tmp_path: Path) -> None:
    whole = bytearray(recording.path.read_bytes())
    changed = tmp_path / "changed.mcap"
    found = 0
    for at in range(200, len(whole) - 200, len(whole) // 60):
        whole[at] ^= 0xFF
        changed.write_bytes(whole)
        whole[at] ^= 0xFF
        try:
            run = k.Run(changed)
            frames = [frame.tobytes() for frame in run["/state"]]
        except k.KinetoscopeError:
            found += 1
        else:
            # The byte is not that of a chunk: nothing that was read has changed.
            assert frames == [frame.tobytes() for frame in recording["/state"]]
    assert found > 40


def with_schema_version(source: Path, target: Path, version: bytes) -> None:
    """A copy whose provenance states another schema version of the same length."""
    data = source.read_bytes()
    key = b"schema_version" + struct.pack("<I", 1)
    at = data.index(key) + len(key)
    target.write_bytes(data[:at] + version + data[at + 1 :])


def test_newer_schema_is_rejected_with_both_versions(recording: k.Run, tmp_path: Path) -> None:
    other = tmp_path / "other.mcap"
    with_schema_version(recording.path, other, b"6")
    with pytest.raises(k.RecordingError, match="schema version 6 .*this package reads version 5\nhelp: upgrade"):
        k.Run(other)
    with_schema_version(recording.path, other, b"4")
    with pytest.raises(k.RecordingError, match="schema version 4 .*this package reads version 5\nhelp: record it again"):
        k.open(other)
    # Control: the same version.
    with_schema_version(recording.path, other, b"5")
    assert len(k.Run(other)) == 251


def test_a_chunk_that_claims_too_much_is_rejected(recording: k.Run, tmp_path: Path) -> None:
    records = MutatedRecording(recording.path.read_bytes()).records
    for record in records:
        if record.kind == CHUNK:
            # The size of the content, after two log times.
            record.fields[2] = 1 << 40
    bomb = tmp_path / "bomb.mcap"
    bomb.write_bytes(encoded(records, True, True))
    with pytest.raises(k.RecordingError, match=f"claims {1 << 40} bytes"):
        list(k.Run(bomb)["/state"])


def test_unknown_names_have_the_nearest_ones(recording: k.Run, experiment: k.Experiment) -> None:
    with pytest.raises(k.UnknownNameError, match="unknown topic `/stat`\nhelp: did you mean `/state`"):
        recording["/stat"]
    with pytest.raises(k.KinetoscopeError, match="has frames, and each frame has the column `x`\nhelp: .*array"):
        recording["/state"]["x"]  # type: ignore[call-overload]
    with pytest.raises(k.UnknownNameError, match="unknown column `vz`\nhelp: expected one of"):
        recording["/state"]["vz"]  # type: ignore[call-overload]
    with pytest.raises(KeyError, match="did you mean `/energy`"):
        recording.series("/energy_")
    with pytest.raises(k.UnknownNameError, match="did you mean `energy.kinetic`"):
        experiment.metric("energy.kinetik")
    with pytest.raises(k.UnknownNameError, match="unknown coordinate `temperature_k`"):
        experiment.metric("energy.kinetic", temperature_k=300)


def test_files_that_are_not_recordings_are_errors(tmp_path: Path) -> None:
    with pytest.raises(k.RecordingError, match="No such file or directory\nhelp: check the path"):
        k.open(tmp_path / "none.mcap")
    with pytest.raises(k.RecordingError, match="contains no finished recording"):
        k.open(tmp_path)
    text = tmp_path / "text.mcap"
    text.write_text("text")
    with pytest.raises(k.RecordingError, match="is not an MCAP file"):
        k.open(text)
    with pytest.raises(k.RecordingError, match="is not a file"):
        k.Run("/dev/zero")


def test_a_folder_of_experiments_names_them(experiment: k.Experiment, tmp_path: Path) -> None:
    shutil.copytree(experiment.path, tmp_path / "a")
    with pytest.raises(k.RecordingError, match="contains 1 experiment\nhelp: open one of them, such as"):
        k.open(tmp_path)
    assert zlib.crc32(k.open(tmp_path / "a").runs[0].path.read_bytes()) == zlib.crc32(
        experiment.runs[0].path.read_bytes()
    )
