# Runs the steps of `.ci/run` and `.ci/full`, which source this file: each step is a function, is timed, and has a row in the table at
# the end. What a step cannot do here is stated there with the reason.
# shellcheck shell=bash
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# Everything is in `target` of this clone, where the scripts of other folders expect it.
unset CARGO_TARGET_DIR
export CARGO_TERM_COLOR=never CARGO_INCREMENTAL=0 DEBIAN_FRONTEND=noninteractive
ci=$PWD/target/ci
recordings=$ci/recordings
programs=$PWD/target/release
mkdir -p "$ci"
rows=() failed=0 beside='' beside_job=''

# States that a part of this step is not done, and why.
skip() {
    echo "skipped: $1"
    echo "$1" >> "$ci/skipped"
}

# The same of the whole step, which it ends.
skip_step() {
    skip "$1"
    exit 77
}

# Executes the function `step_NAME` in a shell of its own, in which the first error ends the step. Bash ignores `set -e` in whatever is
# called in a condition; therefore, this function succeeds and sets `failed`.
run_step() {
    local name=$1 started=$SECONDS code result=ok reason
    printf '\n== %s\n' "$name"
    rm -f "$ci/skipped"
    set +e
    (
        set -e
        "step_${name//-/_}"
    )
    code=$?
    set -e
    case $code in
        0) ;;
        77) result=skipped ;;
        *) result=FAILED failed=1 ;;
    esac
    printf '== %s: %s after %d s\n' "$name" "$result" $((SECONDS - started))
    rows+=("$(printf '%6d s  %-8s %s' $((SECONDS - started)) "$result" "$name")")
    [ "$name" != "$beside" ] || echo "${rows[-1]}" > "$ci/beside.row"
    [ ! -e "$ci/skipped" ] || while read -r reason; do rows+=("          skipped: $reason"); done < "$ci/skipped"
}

# Starts a step that is executed in parallel with the next ones, in a group of processes of its own.
start_beside() {
    printf '\n== %s: in parallel with the next steps\n' "$1"
    set -m
    run_step "$1" > "$ci/beside.txt" 2>&1 &
    beside_job=$!
    set +m
}

# Its output and its row, or its end if another step has failed.
finish_beside() {
    [ -n "$beside_job" ] || return 0
    if [ "$failed" = 1 ] && [ "$keep_going" = 0 ]; then
        kill -- "-$beside_job" 2> /dev/null || true
        wait "$beside_job" 2> /dev/null || true
        rows+=("$(printf '%8s  %-8s %s' '' 'stopped' "$beside")")
    else
        wait "$beside_job"
        cat "$ci/beside.txt"
        rows+=("$(cat "$ci/beside.row")")
        ! grep -q FAILED "$ci/beside.row" || failed=1
    fi
}

# `steps` has one line per step: its name and what it checks. Arguments: names of steps (all if there are none), or --list.
# With `keep_going=1`, the steps after a failed one are executed as well. If there are no arguments, the step `beside` does not hold up
# the next ones.
run_steps() {
    local name wanted=("$@")
    local names=() known=()
    while read -r name _; do known+=("$name"); done <<< "$steps"
    if [ "${1:-}" = --list ]; then
        echo "$steps"
        return
    fi
    [ $# -gt 0 ] || wanted=("${known[@]}")
    for name in "${wanted[@]}"; do
        grep -q "^$name " <<< "$steps" || {
            echo "error: no step is named $name; the steps are: ${known[*]}" >&2
            exit 2
        }
        names+=("$name")
    done
    for name in "${names[@]}"; do
        if [ "$failed" = 1 ] && [ "$keep_going" = 0 ]; then
            rows+=("$(printf '%8s  %-8s %s' '' 'not run' "$name")")
        elif [ "$name" = "$beside" ] && [ $# = 0 ]; then
            start_beside "$name"
        else
            run_step "$name"
        fi
    done
    finish_beside
    printf '\n== %s of %s: %d s\n' "${0##*/}" "$(git rev-parse --short HEAD)$(git diff --quiet HEAD || echo ', changed')" "$SECONDS"
    printf '%s\n' "${rows[@]}"
    exit "$failed"
}

# Installs packages of the operating system if one of the programs is missing: PROGRAM[=PACKAGE] ...
install_programs() {
    local pair missing=() as_root=()
    for pair in "$@"; do
        command -v "${pair%=*}" > /dev/null || missing+=("${pair#*=}")
    done
    [ "${#missing[@]}" -gt 0 ] || return 0
    [ "$(id -u)" = 0 ] || as_root=(sudo --non-interactive --preserve-env=DEBIAN_FRONTEND)
    "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=300 update -qq
    "${as_root[@]}" apt-get -o DPkg::Lock::Timeout=300 install -y -qq "${missing[@]}"
}

# Installs packages of Python, as the requirements that pip takes, into an environment: FOLDER REQUIREMENT ...
install_packages() {
    local folder=$1
    shift
    [ -x "$folder/bin/python" ] || python3 -m venv "$folder"
    "$folder/bin/pip" install --quiet --disable-pip-version-check "$@"
}

# The browser, the spelling checker, what typesets formulas, and the script of axe-core alone; what drives a browser with it is not needed.
install_gate_tools() {
    install_programs chromium
    install_packages "$ci/tools" "$(grep '^typos==' tests/interop/requirements.txt)" --requirement book/generator/requirements.txt
    install_packages "$ci/tools" --no-deps axe-playwright-python==0.1.8
}

build_programs() {
    cargo build --release --quiet
}

# Records and analyzes every shipped experiment, unless this build has done so.
record_experiments() {
    local build manifest name
    build=$(cat "$programs"/{kinetoscope,run-experiment,analyze-recordings} experiments/*.toml | sha256sum)
    [ "$(cat "$ci/recorded" 2> /dev/null)" != "$build" ] || return 0
    rm -rf "$ci/recorded" "$recordings"
    for manifest in experiments/*.toml; do
        name=$(basename "$manifest" .toml)
        "$programs/run-experiment" --quiet --output "$recordings" "$manifest"
        "$programs/analyze-recordings" "$recordings/$name" > "$recordings/$name.txt" || {
            cat "$recordings/$name.txt"
            return 1
        }
        echo "$name: recorded, $(grep -c '^  ok ' "$recordings/$name.txt") checks pass ($SECONDS s)"
    done
    echo "$build" > "$ci/recorded"
}

# Opens the page of the experiments in a folder and their reports in Chromium, with the tests that take reports: FOLDER
open_reports() {
    "$programs/analyze-recordings" --quiet "$1"
    INDEX=$1/index.html
    [ "$(grep -o '<h3><a h' "$INDEX" | wc -l)" = "$(find "$1" -mindepth 1 -maxdepth 1 -type d | wc -l)" ]
    REPORTS=$(printf ':%s' "$1"/*/report.html)
    REPORTS=${REPORTS:1}
    AXE=$(find "$ci/tools" -name axe.min.js)
    export INDEX REPORTS AXE
    cargo test --workspace --quiet --test analysis -- --ignored given_ pages_have pale_text
}
