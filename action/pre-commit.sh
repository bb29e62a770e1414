#!/bin/sh
# A hook for git: compares the manifests of the commit with kinetoscope.lock, those of the quick tier only.
#
#     ln -s ../../action/pre-commit.sh .git/hooks/pre-commit
#
# Another program than `kinetoscope`, or another lock file: KINETOSCOPE, LOCK_FILE.
set -u
lock=${LOCK_FILE:-kinetoscope.lock}
[ -f "$lock" ] || exit 0
changed=$(mktemp)
git diff --cached --name-only --diff-filter=d -z -- '*.toml' > "$changed"
[ ! -s "$changed" ] || xargs -0 "${KINETOSCOPE:-kinetoscope}" check --locked --quick --quiet --lock-file "$lock" < "$changed"
code=$?
rm -f "$changed"
# xargs replaces exit codes.
[ "$code" -eq 0 ] || echo "help: \`kinetoscope lock\` accepts the change; add the lock file to the commit" >&2
exit "$code"
