#!/bin/sh
# Runs manifests, analyzes them and compares them with a lock file or a baseline, in any CI system. Writes a summary in Markdown.
#
#     action/check.sh MANIFEST…
#
# Settings, all optional, from the environment:
#     KINETOSCOPE   the program                                                    [kinetoscope]
#     RESULTS_CACHE folder that the CI system keeps between jobs                   [.kinetoscope]
#     REPORTS       folder for the reports, metrics and test results of this job   [kinetoscope-reports]
#     REPORTS_URL   address of that folder, for the summary                        [that of the job in GitHub or GitLab]
#     SUMMARY       file to which the summary is appended                          [$GITHUB_STEP_SUMMARY, or summary.md]
#     LOCK_FILE     lock file; compared if it exists                               [kinetoscope.lock]
#     BASELINE      metrics.json of earlier analyses, one per experiment, separated by spaces or as a pattern
#     ALLOW_CHANGED keys that may differ from the baseline, separated by spaces
#
# The recordings are in $RESULTS_CACHE/PROGRAM, where PROGRAM is the hash of the program's file: what this program recorded already is not
# run again, and what another one recorded is never taken for a result of this one. It serves to explain differences.
# The exit code is the first one of these commands that is not 0: 1, a run failed; 3, a check failed; 4, a difference from the lock file.
set -u
program=${KINETOSCOPE:-kinetoscope}
cache=${RESULTS_CACHE:-.kinetoscope}
reports=${REPORTS:-kinetoscope-reports}
summary=${SUMMARY:-${GITHUB_STEP_SUMMARY:-summary.md}}
lock=${LOCK_FILE:-kinetoscope.lock}
# GitHub rejects a summary of more than 1 MiB; other steps of the job may write before.
most_bytes=900000
if [ $# -eq 0 ]; then
    echo "usage: $0 MANIFEST…" >&2
    exit 2
fi
# Recordings that belong to the repository would be taken for those of an earlier job.
git ls-files --error-unmatch -- "$cache" > /dev/null 2>&1
committed=$?
# Without git, or in a folder of another user, where it refuses to answer, the index itself contains the names of the files.
if [ "$committed" -gt 1 ] && [ -e .git ]; then
    ! grep -qaF "${cache%/}/" .git/index 2>/dev/null || committed=0
fi
if [ "$committed" -eq 0 ]; then
    echo "$cache is committed: remove it from the repository, or name another folder with RESULTS_CACHE" >&2
    exit 2
fi
if [ -n "${GITHUB_RUN_ID:-}" ]; then
    url=${REPORTS_URL:-${GITHUB_SERVER_URL:-https://github.com}/${GITHUB_REPOSITORY:-}/actions/runs/$GITHUB_RUN_ID#artifacts}
else
    url=${REPORTS_URL:-${CI_JOB_URL:+$CI_JOB_URL/artifacts/browse}}
fi

file=$(command -v "$program") || { echo "$program is not installed: set KINETOSCOPE" >&2; exit 2; }
version=$( { sha256sum "$file" 2>/dev/null || shasum -a 256 "$file"; } | cut -c 1-16)
results=$cache/$version
# Folders of programs, the newest first: other folders of the cache belong to others.
programs() {
    ls -td "$cache"/*/ 2>/dev/null | grep -E '/[0-9a-f]{16}/$'
}
earlier=$(programs | grep -v "/$version/\$" | head -n 1)
mkdir -p -- "$results" "$reports"
touch -- "$results"
text=$(mktemp)
tables=$(mktemp)

first=0
keep() {
    code=$?
    [ "$first" -ne 0 ] || first=$code
}

# Appends the text to the summary, cut after a line, with a link to the reports if there is more than one line.
finish() {
    if [ "$(wc -c < "$text")" -gt "$most_bytes" ]; then
        head -c "$most_bytes" "$text" | sed '$d' > "$tables"
        printf '\nThe rest would be too long for a summary%s.\n' "${url:+; the reports have all}" >> "$tables"
        cp "$tables" "$text"
    fi
    if [ -n "$url" ] && [ "$(wc -l < "$text")" -gt 1 ]; then
        printf '\n[Reports and test results](%s)\n' "$url" >> "$text"
    fi
    cat "$text" >> "$summary"
    rm -f "$text" "$tables"
    exit "$1"
}

"$program" run --quiet --output "$results" "$@"; keep
if [ "$first" -eq 2 ]; then
    # Nothing was run: what is in the cache belongs to earlier manifests.
    echo "**The manifests were refused**; the messages of the step say why." >> "$text"
    finish 2
fi

if [ -f "$lock" ]; then
    "$program" check --locked --recorded --lock-file "$lock" --output "$results" --earlier "${earlier:-$results}" \
        --summary "$text" "$@"; keep
    [ -s "$text" ] || echo "**Nothing was compared with the lock file**; the messages of the step say why." >> "$text"
fi

# Also after a run that failed: its recording contains the fault, which becomes an error in the test report.
names=$(for manifest in "$@"; do
    "$program" check --json --output "$results" "$manifest" 2>/dev/null | sed -n 's/^ *"experiment": "\(.*\)",*$/\1/p'
done)
set --
for name in $names; do
    [ ! -d "$results/$name" ] || set -- "$@" "$results/$name"
done
# Without a recording, there is nothing to analyze, and the exit code is that of the commands before.
[ $# -gt 0 ] || finish "$first"
for key in ${ALLOW_CHANGED:-}; do
    set -- --allow-changed "$key" "$@"
done
for baseline in ${BASELINE:-}; do
    set -- --baseline "$baseline" "$@"
done
GITHUB_STEP_SUMMARY=$tables "$program" analyze --quiet --github-annotations --junit "$reports/results.xml" "$@"
analyzed=$?
(exit "$analyzed"); keep
[ "$analyzed" -eq 0 ] || [ -s "$tables" ] || echo "**Nothing was analyzed**; the messages of the step say why." >> "$text"
# The table of all checks, if there is no lock file or a check failed.
if [ ! -f "$lock" ] || [ "$analyzed" -ne 0 ]; then
    cat "$tables" >> "$text"
fi
# Only those of this job: the cache has experiments and programs of earlier ones.
for name in $names; do
    [ -d "$results/$name" ] || continue
    mkdir -p -- "$reports/$name"
    for result in report.html kinetoscope-engine.js metrics.json; do
        [ ! -f "$results/$name/$result" ] || cp -- "$results/$name/$result" "$reports/$name"
    done
done

# One earlier version is enough to explain a difference.
programs | tail -n +3 | while read -r old; do rm -rf -- "$old"; done
finish "$first"
