"""Commands of the book's pages, which are executed when the book is built, and numbers taken from their results.

In a page,

    ```console
    $ kinetoscope run experiments/first_run.toml
    ```

runs the command in a folder of that page, which contains copies of `experiments/`, `book/exercises/` and `book/solutions/`, and inserts what it prints. The info string
may limit this: `console lines=8` shows the last 8 lines, `console head=8` the first ones, and `console exit=2` expects that code of
the last command.
`{{scene EXPERIMENT NUMBER}}` is the last frame of a recording that the page has made, counted from 0 in the order of their names, and from -1 at the end.
`{{value EXPERIMENT METRIC KEY=VALUE …}}` is the value of a metric; `variant=velocity_Verlet` is the variant "velocity Verlet". `![…](x.png)` shows a picture that a command has written.
"""

import json
import os
import re
import shutil
import subprocess

from pages import number

BLOCK = re.compile(r"^```console([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
VALUE = re.compile(r"\{\{value ([^}]+)\}\}")
SCENE = re.compile(r"\{\{scene (\w+) (-?\d+)\}\}")


class ExecutionError(Exception):
    """A command or a number of a page that is wrong, with the page."""


class Pages:
    """Executes the commands of pages, each page in its own folder."""

    def __init__(self, repository, bin_folder, folder):
        self.repository, self.bin_folder, self.folder = repository, bin_folder, folder

    def execute(self, text, page, place):
        """The text with the output of its commands and the values of its metrics."""
        if "\n$ " not in text:
            return text
        folder = self.folder / page.with_suffix("")
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.repository / "experiments", folder / "experiments")
        for name in ("exercises", "solutions"):
            shutil.copytree(self.repository / "book" / name, folder / name)
        text = BLOCK.sub(lambda block: self.block(page, folder, block[1].split(), block[2]), text)
        text = VALUE.sub(lambda found: self.value(page, folder, found[1].split()), text)
        text = SCENE.sub(lambda found: self.scene(folder, page.stem, found[1], int(found[2])), text)
        for picture in re.findall(r"!\[[^\]]*\]\(([^):]+)\)", text):
            if (folder / picture).is_file():
                shutil.copyfile(folder / picture, place / picture)
        return text

    def block(self, page, folder, options, body):
        """A block with the output of each command."""
        settings = dict(option.split("=") for option in options)
        lines = []
        commands = [line for line in body.splitlines() if line.startswith("$ ")]
        for command in commands:
            expected = int(settings.get("exit", 0)) if command is commands[-1] else 0
            lines += [command, *self.output(page, folder, command[2:], settings, expected)]
        return "```console\n" + "\n".join(lines) + "\n```"

    def output(self, page, folder, command, settings, expected):
        """What a command prints, with paths of this machine removed."""
        environment = os.environ | {"PATH": f"{self.bin_folder}{os.pathsep}{os.environ['PATH']}", "NO_COLOR": "1", "COLUMNS": "100"}
        done = subprocess.run(command, shell=True, cwd=folder, env=environment, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        if done.returncode != expected:
            raise ExecutionError(f"{page}: `{command}` ended with exit code {done.returncode}, not {expected}:\n{done.stdout}")
        text = done.stdout.replace(f"{folder}/", "").replace(str(folder), ".")
        lines = [line.rstrip() for line in text.splitlines()]
        if "head" in settings and len(lines) > int(settings["head"]):
            return lines[: int(settings["head"])] + ["…"]
        if "lines" in settings and len(lines) > int(settings["lines"]):
            return ["…"] + lines[-int(settings["lines"]):]
        return lines

    def value(self, page, folder, words):
        """The value of a metric of an experiment that the page has run."""
        experiment, metric, *wanted = words
        wanted = dict(word.replace("_", " ").split("=", 1) if word.startswith("variant=") else word.split("=", 1) for word in wanted)
        with (folder / "recordings" / experiment / "metrics.json").open() as text:
            entries = json.load(text)["metrics"]
        for entry in sorted(entries, key=lambda entry: "sweep" not in entry):
            place = (entry.get("sweep") or entry["run"])["coordinates"]
            same = all(name in place and str(place[name]["value"]) == value for name, value in wanted.items())
            if entry["name"] == metric and same and entry["value"] is not None:
                return number(entry["value"], 4)
        raise ExecutionError(f"{page}: {experiment} has no {metric} {wanted or ''}")

    def scene(self, folder, page, experiment, number):
        """The picture of a recording."""
        recording = sorted((folder / "recordings" / experiment).glob("*.mcap"))[number]
        name = f"{page}_scene.png"
        subprocess.run([self.bin_folder / "kinetoscope", "export", "--quiet", "--thumbnail", folder / name, recording], check=True)
        return f"![One of the runs of this page]({name})"
