#!/usr/bin/env bash
# What release/test_install.sh executes in a root without Rust: wheel, Debian package, manual page, completions.
set -euo pipefail
cd /work
fail() { echo "error: $1" >&2; exit 1; }
! command -v cargo rustc || fail "this root contains Rust"

start=$(date +%s%N)
python3 -m venv /environment
/environment/bin/pip install --quiet --disable-pip-version-check --no-index --find-links /index kinetoscope
installed=$(date +%s%N)
/environment/bin/run-experiment --quiet first_run.toml
/environment/bin/analyze-recordings recordings/first_run > analysis.txt
[ -s recordings/first_run/report.html ] || fail "there is no report"
end=$(date +%s%N)
seconds=$(((end - start) / 1000000))
echo "wheel: installed after $(((installed - start) / 1000000)) ms, report after $seconds ms"
[ "$seconds" -le "$((LIMIT * 1000))" ] || fail "more than $LIMIT s"
/environment/bin/kinetoscope doctor | grep -q parquet || fail "no Parquet"

dpkg --install kinetoscope_*.deb > /dev/null
/usr/bin/kinetoscope --version
for page in kinetoscope kinetoscope-run run-experiment; do
    man -P cat "$page" | grep -q -- '--\|kinetoscope' || fail "man $page"
done
man -P cat kinetoscope-run | grep -q -- '--force' || fail "man kinetoscope-run does not describe --force"
echo "man: $(man -P cat kinetoscope-run | wc -l) lines of kinetoscope-run"

# As the shell does it at the first Tab: the file is loaded by the name of the command.
replies=$(bash -c '
    . /usr/share/bash-completion/bash_completion
    _completion_loader kinetoscope || [ $? = 124 ]
    COMP_WORDS=(kinetoscope ver) COMP_CWORD=1 COMP_LINE="kinetoscope ver" COMP_POINT=15
    _kinetoscope kinetoscope ver kinetoscope
    echo "${COMPREPLY[*]}"')
[ "$replies" = verify ] || fail "bash completes \`kinetoscope ver\` to \`$replies\`"
replies=$(zsh -f completion.zsh 'kinetoscope ver')
case $replies in *"kinetoscope verify"*) ;; *) fail "zsh completes \`kinetoscope ver\` to \`$replies\`" ;; esac
echo "completions: bash and zsh complete \`kinetoscope ver\` to \`kinetoscope verify\`"
