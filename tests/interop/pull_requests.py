#!/usr/bin/env python3
"""Do the scripts of `action/` work where others use them? Pull requests in a scratch repository that has manifests and a lock file only.

    tests/interop/pull_requests.py WHEEL                  # built by release/build.sh
    tests/interop/pull_requests.py WHEEL OTHER_WHEEL      # also: the pull request takes a program with another force in DEM

Each step of the composite action, of the job for GitLab and of the plain script runs in a shell with the variables of that system, as the
files in `action/` have them; a token that can only read; and a `gh` that fails. A cache is restored before a job and kept only if it
succeeds, as actions/cache does. Prints each summary, and the time from the checkout to the summary with a warm wheel and cached recordings;
then the time of the hook for commits of one, four and all shipped manifests.

Package: pyyaml. Exit code 1 if a summary, an exit code or an artifact is not as expected.
"""

import functools
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXPERIMENTS = ("first_run", "gas_300_kelvin", "packing_fifty_discs", "orbit_exercise")
EXPRESSION = re.compile(r"\$\{\{\s*(.+?)\s*\}\}")
# What GitHub's runner takes for a command: `::name …::` at the start of a line, `##[name]` anywhere.
COMMAND = re.compile(r"^\s*::([a-z-]+)|##\[([a-z-]+)")
HOSTILE = (
    'question = "::add-mask::x ##[set-output name=a]b <img src=x onerror=alert(1)>"\n'
    'answer = "# All equal | ::stop-commands::y <script>z</script> [link](https://evil.example) @everyone #1 ##[error]w"\n'
)


class Repository:
    """A scratch repository with four manifests, its lock file, and what its CI system keeps."""

    def __init__(self, folder, wheel, program):
        self.folder, self.wheel = folder, wheel
        self.origin, self.cache = folder / "origin", folder / "cache"
        (self.origin / "experiments").mkdir(parents=True)
        for name in EXPERIMENTS:
            shutil.copy(ROOT / f"experiments/{name}.toml", self.origin / "experiments")
        subprocess.run([program, "lock", "--quiet", "experiments"], cwd=self.origin, check=True)
        self.git("init", "--quiet", "--initial-branch=main")
        self.commit("main")
        self.baselines = folder / "baselines"
        # The version of the action that the workflow names, outside of the repository.
        self.action = folder / "actions" / "kinetoscope" / "action"
        shutil.copytree(ROOT / "action", self.action)
        programs = folder / "programs-without-a-token"
        programs.mkdir()
        for name in ("gh", "cargo", "rustc"):
            (programs / name).write_text(f"#!/bin/sh\necho {name} was called >&2\nexit 1\n")
            (programs / name).chmod(0o755)
        self.path = f"{programs}:/usr/local/bin:/usr/bin:/bin"

    def git(self, *arguments):
        identity = ("-c", "user.name=a", "-c", "user.email=a@example.org")
        subprocess.run(["git", *identity, *arguments], cwd=self.origin, check=True)

    def commit(self, branch, change=None):
        """A branch of main with a change."""
        if change:
            self.git("checkout", "--quiet", "-B", branch, "main")
            change(self.origin)
        self.git("add", "--all")
        self.git("commit", "--quiet", "--allow-empty", "-m", branch)

    def checkout(self, branch):
        workspace = pathlib.Path(tempfile.mkdtemp(dir=self.folder)) / "work"
        subprocess.run(["git", "clone", "--quiet", "--branch", branch, self.origin, workspace], check=True)
        assert not (workspace / "Cargo.toml").exists()
        return workspace


def shell(command, workspace, environment, program="bash"):
    options = {"bash": ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", command], "sh": ["sh", "-ec", command]}
    done = subprocess.run(options[program], cwd=workspace, env=environment, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def inject(workspace, cache):
    if cache.exists():
        shutil.copytree(cache, workspace / ".kinetoscope", dirs_exist_ok=True)


def github(repository, workspace, wheel, branch, further=()):
    """Runs the steps of action.yml, also with further inputs: exit code, output, summary, files of the artifact."""
    action = yaml.safe_load((repository.action / "action.yml").read_text())
    workflow = yaml.safe_load((repository.action / "workflow.yml").read_text())
    assert workflow["permissions"] == {"contents": "read"}
    given = {"manifests": "experiments", "wheel": str(wheel), "sha256": sha256(wheel), **dict(further)}
    inputs = {name: given.get(name, str(about.get("default", ""))) for name, about in action["inputs"].items()}
    temporary = workspace.parent / "runner"
    temporary.mkdir()
    summary, paths = temporary / "summary.md", temporary / "path"
    paths.touch()
    environment = {
        "PATH": repository.path, "HOME": str(temporary), "CI": "true", "GITHUB_ACTIONS": "true", "GITHUB_WORKSPACE": str(workspace),
        "GITHUB_ACTION_PATH": str(repository.action), "GITHUB_PATH": str(paths), "GITHUB_STEP_SUMMARY": str(summary),
        "GITHUB_SERVER_URL": "https://github.com", "GITHUB_REPOSITORY": "owner/name", "GITHUB_RUN_ID": "7", "GITHUB_TOKEN": "read-only",
        "RUNNER_OS": "Linux", "RUNNER_TEMP": str(temporary), "GITHUB_REF_NAME": branch, "LANG": "C.UTF-8",
    }  # fmt: skip
    code, output, artifact = 0, "", []
    for step in action["runs"]["steps"]:
        if step.get("uses", "").startswith("actions/cache@"):
            inject(workspace, repository.cache)
        elif step.get("uses", "").startswith("actions/upload-artifact@"):
            for pattern in step["with"]["path"].split():
                found = workspace / pattern
                artifact += [found] if found.is_file() else [path for path in found.rglob("*") if path.is_file()]
        elif code == 0:
            variables = {name: EXPRESSION.sub(lambda match: inputs[match[1].removeprefix("inputs.")], value) for name, value in step["env"].items()}
            added = ":".join(reversed(paths.read_text().split()))
            code, text = shell(step["run"], workspace, {**environment, **variables, "PATH": f"{added}:{repository.path}"})
            output += text
    if code == 0:
        shutil.rmtree(repository.cache, ignore_errors=True)
        shutil.copytree(workspace / ".kinetoscope", repository.cache)
    text = summary.read_text() if summary.exists() else ""
    return code, output, text, [str(path.relative_to(workspace)) for path in artifact]


def gitlab(repository, workspace, wheel, branch):
    job = yaml.safe_load((repository.action / "gitlab-ci.yml").read_text())["experiments"]
    # As its first line says: a copy of two scripts.
    shutil.copytree(repository.action, workspace / "action")
    inject(workspace, repository.cache)
    environment = {
        "PATH": repository.path, "HOME": str(workspace.parent), "CI": "true", "GITLAB_CI": "true", "CI_COMMIT_REF_NAME": branch, "LANG": "C.UTF-8",
        "CI_JOB_URL": "https://gitlab.com/owner/name/-/jobs/7", "WHEEL": str(wheel), "SHA256": sha256(wheel), **job["variables"],
    }  # fmt: skip
    code, output = shell("\n".join(job["script"]), workspace, environment)
    after, printed = shell("\n".join(job["after_script"]), workspace, environment)
    artifact = [path for pattern in job["artifacts"]["paths"] for path in [workspace / pattern, *(workspace / pattern).rglob("*")] if path.is_file()]
    assert after == 0 and (workspace / job["artifacts"]["reports"]["junit"]).exists()
    return code, output, printed, [str(path.relative_to(workspace)) for path in artifact]


def plain(repository, workspace, wheel, _branch):
    inject(workspace, repository.cache)
    environment = {"PATH": repository.path, "HOME": str(workspace.parent), "WHEEL": str(wheel), "SHA256": sha256(wheel), "LANG": "C.UTF-8"}
    command = f'PATH="$({repository.action}/install.sh):$PATH"; {repository.action}/check.sh experiments/*.toml'
    code, output = shell(command, workspace, environment, "sh")
    reports = [path for path in (workspace / "kinetoscope-reports").rglob("*") if path.is_file()]
    return code, output, (workspace / "summary.md").read_text(), [str(path.relative_to(workspace)) for path in reports]


# Without a lock file: a baseline of each experiment instead.
BASELINE = {"baseline": "baselines/*.json", "lock-file": "none.lock"}
SYSTEMS = {"GitHub": github, "GitLab": gitlab, "shell": plain, "GitHub with baselines": functools.partial(github, further=BASELINE)}


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def edit(name, old, new):
    def change(repository):
        path = repository / f"experiments/{name}.toml"
        text = path.read_text()
        assert old in text, (name, old)
        path.write_text(text.replace(old, new, 1))

    return change


def hostile(repository):
    path = repository / "experiments/gas_300_kelvin.toml"
    text = re.sub(r'^(question|answer) = ".*"\n', "", path.read_text(), flags=re.MULTILINE)
    path.write_text(text.replace("\nseed = ", f"\n{HOSTILE}seed = 1", 1))


def with_baselines(repository, change=lambda origin: None):
    def both(origin):
        shutil.copytree(repository.baselines, origin / "baselines")
        change(origin)

    return both


def hook(program, folder):
    """Seconds of the hook for commits of one, four and all shipped manifests, with a comment added to each."""
    folder.mkdir()
    for path in ("experiments", "kinetoscope.lock"):
        subprocess.run(["cp", "-r", ROOT / path, folder], check=True)
    subprocess.run("git init --quiet && git add --all && git -c user.name=a -c user.email=a@example.org commit --quiet -m all", shell=True, cwd=folder, check=True)
    manifests = sorted(folder.glob("experiments/*.toml"))
    failed = False
    for staged in ([folder / "experiments/first_run.toml"], [folder / f"experiments/{name}.toml" for name in EXPERIMENTS], manifests):
        for manifest in staged:
            manifest.write_text(manifest.read_text() + "# A comment.\n")
        subprocess.run(["git", "add", "--all"], cwd=folder, check=True)
        start, before = time.monotonic(), os.times()
        code = subprocess.run(["sh", ROOT / "action/pre-commit.sh"], cwd=folder, env={**os.environ, "KINETOSCOPE": program}).returncode
        used = os.times().children_user + os.times().children_system - before.children_user - before.children_system
        print(f"hook, {len(staged)} of {len(manifests)} manifests staged: exit code {code}, {time.monotonic() - start:.1f} s, {used:.2f} s of processor time")
        failed |= code != 0
        subprocess.run(["git", "reset", "--quiet", "--hard"], cwd=folder, check=True)
    return failed


def cases(other_wheel, repository):
    """Branch, change, other wheel, exit code, parts of the summary, systems."""
    everywhere, one, baselines = ["GitHub", "GitLab", "shell"], ["GitHub"], ["GitHub with baselines"]
    yield "nothing", lambda origin: (origin / "README.md").write_text("text\n"), False, 0, ["**4 experiments are equal to the lock file**"], everywhere
    yield (
        "restitution", edit("first_run", "restitution = 0.5", "restitution = 0.4"), False, 4,
        ["**1 of 4 experiments differs", "model.dem.restitution: 0.5 → 0.4", "| checked metric | locked | now | difference | check |"], everywhere,
    )  # fmt: skip
    if other_wheel:
        yield "code", lambda origin: None, True, 4, ["experiments/first\\_run.toml", "frame ", "particle ", "cause: "], everywhere
    yield (
        "deleted", lambda origin: (origin / "experiments/gas_300_kelvin.toml").unlink(), False, 4,
        ["the manifest no longer exists"], ["GitHub", "GitLab"],
    )  # fmt: skip
    yield "hostile", hostile, False, 4, ["gas\\_300\\_kelvin"], one
    yield "baselines-equal", with_baselines(repository), False, 0, ["| equal to the baseline |"], baselines
    restitution = with_baselines(repository, edit("first_run", "restitution = 0.5", "restitution = 0.4"))
    yield "baselines-edited", restitution, False, 3, ["| equal to the baseline | model.dem.restitution: 0.5 → 0.4"], baselines


def check(repository, case, system, wheel):
    branch, _, _, expected, parts, _ = case
    start = time.monotonic()
    workspace = repository.checkout(branch)
    code, output, summary, artifact = SYSTEMS[system](repository, workspace, wheel, branch)
    seconds = time.monotonic() - start
    faults = [f"exit code {code}, expected {expected}"] if code != expected else []
    faults += [f"the summary has no {part!r}" for part in parts if part not in summary]
    if branch == "nothing":
        faults += ["more than one line"] if summary.count("\n") > 1 else []
    if system != "shell" and not any(name.endswith("first_run/report.html") for name in artifact):
        faults.append(f"no report in {artifact}")
    commands = {match[1] or match[2] for match in map(COMMAND.search, (output + summary).splitlines()) if match}
    faults += [f"the command {command} is executed" for command in commands - {"error"}]
    faults += [f"{markup} in the summary" for markup in ("<img", "<script", "https://evil", "\n# All", " ::stop", "@everyone") if f" {markup}" in summary or summary.startswith(markup)]
    print(f"### {system}, {branch}: exit code {code}, {seconds:.1f} s from the checkout to the summary\n\n{summary}")
    if faults:
        print(f"FAULTS: {faults}\n{output}")
    return bool(faults)


def main():
    wheel, *other = [pathlib.Path(argument).resolve() for argument in sys.argv[1:]]
    failed = False
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        install = subprocess.run(["sh", ROOT / "action/install.sh"], env={**os.environ, "WHEEL": str(wheel)}, capture_output=True, text=True, check=True)
        repository = Repository(folder, wheel, f"{install.stdout.strip()}/kinetoscope")
        # A push to main fills the cache.
        workspace = repository.checkout("main")
        code, output, summary, _ = github(repository, workspace, wheel, "main")
        print(f"### GitHub, push to main, empty cache: exit code {code}\n\n{summary}")
        if code:
            sys.exit(output)
        repository.baselines.mkdir()
        for name in EXPERIMENTS:
            shutil.copy(workspace / f"kinetoscope-reports/{name}/metrics.json", repository.baselines / f"{name}.json")
        for case in cases(other, repository):
            repository.commit(case[0], case[1])
            for system in case[5]:
                failed |= check(repository, case, system, other[0] if case[2] else wheel)
        failed |= hook(f"{install.stdout.strip()}/kinetoscope", folder / "hook")
    sys.exit(failed)


if __name__ == "__main__":
    main()
