#!/usr/bin/env bash
# Checks wheel, Python package, Debian package, manual pages and completions. release/test_install.sh executes it in a root without Rust.
set -euo pipefail
cd /work
fail() { echo "error: $1" >&2; exit 1; }
! command -v cargo rustc || fail "this root contains Rust"

milliseconds() { echo $((($(date +%s%N) - start) / 1000000)); }
start=$(date +%s%N)
python3 -m venv /environment
created=$(milliseconds)
/environment/bin/pip install --quiet --disable-pip-version-check --no-index --find-links /index kinetoscope
installed=$(milliseconds)
/environment/bin/run-experiment --quiet first_run.toml
recorded=$(milliseconds)
/environment/bin/analyze-recordings recordings/first_run > analysis.txt
[ -s recordings/first_run/report.html ] || fail "there is no report"
# The answer is in the text and on the page.
answer='Into the dashpots of their contacts: they lose'
grep -q "$answer" analysis.txt && grep -q "$answer" recordings/first_run/report.html || fail "there is no answer"
analyzed=$(milliseconds)
echo "wheel: environment after $created ms, installed after $installed ms, recording after $recorded ms, report after $analyzed ms"
[ "$analyzed" -le "$((LIMIT * 1000))" ] || fail "more than $LIMIT s"
for program in kinetoscope run-experiment analyze-recordings; do
    "/environment/bin/$program" --version | grep -q "^$program [0-9]" || fail "$program --version"
done
grep -q '^mcap ' /environment/share/doc/kinetoscope-licenses.txt || fail "no licenses of the packages"
/environment/bin/kinetoscope doctor | grep -q 'parquet: yes' || fail "no Parquet"
man -P cat -M /environment/share/man kinetoscope-run | grep -q -- '--force' || fail "no manual page in the wheel"

# The Python package: a folder whose name has a space and umlauts, no HOME, and a package that cannot be written (root without its
# capabilities is the owner only).
chmod -R a-w /environment
mkdir -p "Zwölf Boxkämpfer"
cp first_run.toml "Zwölf Boxkämpfer"
(cd "Zwölf Boxkämpfer" && setpriv --bounding-set=-all env -u HOME /environment/bin/python -c '
import kinetoscope as k
experiment = k.run("first_run.toml", seed=3)
run = experiment.runs[0]
assert len(run["/state"].array()) == len(run) == 251 and run.verify() and all(check["passed"] for check in experiment.checks)
')
echo "Python: $(/environment/bin/python --version), recorded, read, verified and checked"

[ -z "${WHEEL_ONLY:-}" ] || exit 0
dpkg --install kinetoscope_*.deb > /dev/null
for program in kinetoscope run-experiment analyze-recordings; do
    "/usr/bin/$program" --version | grep -q "^$program [0-9]" || fail "/usr/bin/$program --version"
done
for page in kinetoscope kinetoscope-run run-experiment; do
    man -P cat "$page" | grep -q -- '--\|kinetoscope' || fail "man $page"
done
man -P cat kinetoscope-run | grep -q -- '--force' || fail "man kinetoscope-run does not describe --force"
echo "man: $(man -P cat kinetoscope-run | wc -l) lines of kinetoscope-run"

# As the shell does it at the first Tab: the file is loaded by the name of the command.
check_completion() {
    program=$1 word=$2 expected=$3
    replies=$(bash -c '
        . /usr/share/bash-completion/bash_completion
        _completion_loader "$1" || [ $? = 124 ]
        COMP_WORDS=("$1" "$2") COMP_CWORD=1 COMP_LINE="$1 $2" COMP_POINT=$((${#1} + ${#2} + 1))
        function=$(complete -p "$1" | sed "s/.*-F \([^ ]*\) .*/\1/")
        "$function" "$1" "$2" "$1"
        echo "${COMPREPLY[*]}"' bash "$program" "$word")
    [ "$replies" = "$expected" ] || fail "bash completes \`$program $word\` to \`$replies\`"
    replies=$(zsh -f completion.zsh "$program $word" "$program $expected")
    case $replies in *"$program $expected"*) ;; *) fail "zsh completes \`$program $word\` to \`$replies\`" ;; esac
    echo "completions: bash and zsh complete \`$program $word\` to \`$program $expected\`"
}
check_completion kinetoscope ver verify
check_completion run-experiment --forc --force
check_completion analyze-recordings --github --github-annotations
