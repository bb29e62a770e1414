"""Guarantee: the public interface has types without `Any`, every field has its unit, and the log and contacts are readable."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Iterator, Optional, Tuple

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

import kinetoscope as k
from kinetoscope import _units

PACKAGE = Path(k.__file__).resolve().parent
CHANNELS = PACKAGE.parent.parent / "src/recording/channels.rs"
# Units as the comments of the channels write them.
WRITTEN = ("J s", "N s", "J", "N/m", "N", "K", "m/s", "m^2/s^2", "m", "s/m", "s", "AU^2/d^2", "AU^2/d", "AU/d", "AU", "rad", "d")
FIELD = re.compile(r"((?:^ +///.*\n)+) +(\w+): [\w<>]+ \[(\w+)", re.MULTILINE)
CHANNEL = re.compile(r'^    (\w+) on "(/\w+)" \{\n(.*?)^    \}', re.MULTILINE | re.DOTALL)


def annotations_of_public_names() -> Iterator[Tuple[str, ast.expr]]:
    """Annotations of functions and methods without a leading underscore, in modules of public names."""
    for module in ("_checks", "_experiment", "_frames", "_launch", "_log", "_run", "_simulation", "_errors"):
        for node in ast.walk(ast.parse((PACKAGE / f"{module}.py").read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                for entry in node.body:
                    if isinstance(entry, ast.AnnAssign) and not ast.unparse(entry.target).startswith("_"):
                        yield f"{node.name}.{ast.unparse(entry.target)}", entry.annotation
            if not isinstance(node, ast.FunctionDef) or (node.name.startswith("_") and not node.name.endswith("__")):
                continue
            if node.name in ("evaluate", "checks_of", "test", "read") and module in ("_checks", "_log"):
                continue
            arguments = [*node.args.args, *node.args.kwonlyargs]
            for annotation in [node.returns, *(argument.annotation for argument in arguments)]:
                if annotation is not None:
                    yield f"{module}.{node.name}", annotation


def test_public_annotations_have_no_any() -> None:
    found = list(annotations_of_public_names())
    assert len(found) > 80
    loose = [f"{name}: {ast.unparse(annotation)}" for name, annotation in found if re.search(r"\bAny\b", ast.unparse(annotation))]
    assert loose == []


def test_every_field_has_the_unit_that_its_declaration_states() -> None:
    compared = 0
    text = CHANNELS.read_text(encoding="utf-8")
    for message, topic, body in CHANNEL.findall(text):
        model = "packing" if message.startswith(("Packing", "PerCollision")) else "gas" if message.startswith("Gas") else "dem"
        for comment, name, kind in FIELD.findall(body):
            written = " ".join(line.strip().lstrip("/ ") for line in comment.splitlines())
            stated = next((unit for unit in WRITTEN if re.search(rf", {re.escape(unit)}(\.|:|;| \(|$)", written)), None)
            unit = _units.of_fields(model, [name], "s")[name]
            if kind == "uint64":
                assert unit == ("" if model == "packing" else "1"), (topic, name)
            elif stated is not None and model != "packing":
                assert unit.replace("*", " ") == stated, (topic, name, written)
                compared += 1
    assert compared >= 55


def test_units_of_all_topics_are_given(recording: k.Run) -> None:
    assert recording["/frame"].units == {"frame": "1", "step_or_event_count": "1", "time": "s", "time_unit": "1"}
    assert recording["/wall_forces"].units["mean_force_x_n"] == "N"
    assert recording["/temperature"].units["granular_temperature_m2_per_s2"] == "m^2/s^2"


def test_the_log_has_all_messages(recording: k.Run, tmp_path: Path, programs: Optional[str]) -> None:
    fault = 'name = "fault"\n[model.dem]\ndiscs = 5\nduration_s = 0.5\nsteps_per_wall_contact = 1.5\non_unstable_time_step = "warn"\n[record]\nframes = 5\n'
    with pytest.raises(k.RunFailedError, match="Blow-up"):
        k.run(fault, output=tmp_path, programs=programs)
    failed = k.open(tmp_path / "fault", programs=programs).runs[0]
    assert [entry.level for entry in failed.log] == ["warning", "error"] and failed.log[-1].message.startswith("Blow-up")
    for run in (recording, failed):
        with run.path.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            expected = [message.message for _, _, _, message in reader.iter_decoded_messages(["/log"])]
        assert [entry.message for entry in run.log] == expected and run.log[0].frame == 0


def test_contacts_name_their_discs(tmp_path: Path, programs: Optional[str]) -> None:
    text = 'name = "pile"\n[model.dem]\ndiscs = 20\nduration_s = 0.1\n[record]\nframes = 10\nchannels = ["state", "contact_forces"]\n'
    run = k.run(text, output=tmp_path, programs=programs).runs[0]
    contacts, pairs = run["/contact_forces"], 0
    assert contacts.units["first_id"] == "1" and contacts.units["force_x_n"] == "N"
    for state, contact in zip(run["/state"], contacts):
        ids = np.asarray(state["id"] if "id" in (state.dtype.names or ()) else np.arange(len(state)), np.uint64)
        order = {int(number): row for row, number in enumerate(ids)}
        for entry in contact[contact["first_id"] != contact["second_id"]]:
            first = state[order[int(entry["first_id"])]]
            assert abs(first["x"] - entry["from_x_m"]) < 1e-12 and abs(first["y"] - entry["from_y_m"]) < 1e-12
            pairs += 1
    assert pairs > 0
