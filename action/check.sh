#!/bin/sh
# Runs manifests, analyzes them and compares them with a lock file or a baseline, in any CI system. Writes a summary in Markdown.
#
#     action/check.sh MANIFEST…
#
# Settings, all optional, from the environment:
#     KINETOSCOPE   the program                                                    [kinetoscope]
#     RESULTS_CACHE folder that the CI system keeps between jobs                   [.kinetoscope]
#     SUMMARY       file to which the summary is appended                          [$GITHUB_STEP_SUMMARY, or summary.md]
#     LOCK_FILE     lock file; compared if it exists                               [kinetoscope.lock]
#     BASELINE      metrics.json of an earlier version, compared in the analysis
#     ALLOW_CHANGED keys that may differ from the baseline, separated by spaces
#
# The recordings are in $RESULTS_CACHE/PROGRAM, where PROGRAM is the hash of the program's file: what this program recorded already is not
# run again, and what another one recorded is never taken for a result of this one. It serves to explain differences.
# The exit code is the first one of these commands that is not 0: 1, a run failed; 3, a check failed; 4, a difference from the lock file.
set -u
program=${KINETOSCOPE:-kinetoscope}
cache=${RESULTS_CACHE:-.kinetoscope}
summary=${SUMMARY:-${GITHUB_STEP_SUMMARY:-summary.md}}
lock=${LOCK_FILE:-kinetoscope.lock}
if [ $# -eq 0 ]; then
    echo "usage: $0 MANIFEST…" >&2
    exit 2
fi

file=$(command -v "$program") || { echo "$program is not installed: set KINETOSCOPE" >&2; exit 2; }
version=$( { sha256sum "$file" 2>/dev/null || shasum -a 256 "$file"; } | cut -c 1-16)
results=$cache/$version
# Folders of programs, the newest first: other folders of the cache belong to others.
programs() {
    ls -td "$cache"/*/ 2>/dev/null | grep -E '/[0-9a-f]{16}/$'
}
earlier=$(programs | grep -v "/$version/\$" | head -n 1)
mkdir -p -- "$results"
touch -- "$results"
: >> "$summary"

first=0
keep() {
    code=$?
    [ "$first" -ne 0 ] || first=$code
}

"$program" run --quiet --output "$results" "$@"; keep
if [ "$first" -eq 2 ]; then
    # Nothing was run: what is in the cache belongs to earlier manifests.
    echo "**The manifests were refused**; the messages of the step say why." >> "$summary"
    exit 2
fi

if [ -f "$lock" ]; then
    "$program" check --locked --recorded --lock-file "$lock" --output "$results" --earlier "${earlier:-$results}" \
        --summary "$summary" "$@"; keep
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
[ $# -gt 0 ] || exit "$first"
for key in ${ALLOW_CHANGED:-}; do
    set -- --allow-changed "$key" "$@"
done
tables=$(mktemp)
GITHUB_STEP_SUMMARY=$tables "$program" analyze --quiet --github-annotations --junit "$results/results.xml" \
    ${BASELINE:+--baseline "$BASELINE"} "$@"
analyzed=$?
(exit "$analyzed"); keep
# The table of all checks, if there is no lock file or a check failed.
if [ ! -f "$lock" ] || [ "$analyzed" -ne 0 ]; then
    cat "$tables" >> "$summary"
fi
rm -f "$tables"

# One earlier version is enough to explain a difference.
programs | tail -n +3 | while read -r old; do rm -rf -- "$old"; done
exit "$first"
