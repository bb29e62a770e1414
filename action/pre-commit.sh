#!/bin/sh
# A hook for git: compares the manifests of the commit, as they are staged, with the staged lock file. Those that together take some 5 s are run.
#
#     ln -s ../../action/pre-commit.sh .git/hooks/pre-commit
#
# Another program than `kinetoscope`, or another lock file in the repository: KINETOSCOPE, LOCK_FILE.
set -u
lock=${LOCK_FILE:-kinetoscope.lock}
program=$(command -v "${KINETOSCOPE:-kinetoscope}") || { echo "kinetoscope is not installed: set KINETOSCOPE" >&2; exit 2; }
case $program in /*) ;; *) program=$PWD/$program ;; esac
staged=$(mktemp -d)
trap 'rm -rf "$staged"' EXIT
# What is committed can differ from the files in the work tree. Manifests may begin with the state of others.
git ls-files -z -- "$lock" '*.toml' | git checkout-index -z --stdin --prefix="$staged/tree/" || exit
[ -f "$staged/tree/$lock" ] || exit 0
git diff --cached --name-only --diff-filter=d -z -- '*.toml' > "$staged/changed"
[ -s "$staged/changed" ] || exit 0
(cd "$staged/tree" && xargs -0 "$program" check --locked --quick --quiet --lock-file "$lock" -- < "$staged/changed")
code=$?
# xargs replaces exit codes.
[ "$code" -eq 0 ] || echo "help: \`kinetoscope lock\` accepts the change; add the lock file to the commit" >&2
exit "$code"
