#!/bin/sh
# Writes a summary as a comment of the open pull request with the commit HEAD_SHA, or replaces the comment that an earlier call wrote.
#
#     GH_TOKEN=… GITHUB_REPOSITORY=owner/name HEAD_SHA=commit RUN_URL=address action/comment.sh SUMMARY.md
#
# The text comes from the pull request and is only data: it must be a file, is cut to the size of a comment, and the number of the pull
# request follows from the commit. Needs `gh` and `python3`.
set -eu
mark='<!-- kinetoscope -->'
case $HEAD_SHA in
    *[!0-9a-f]* | '') echo "HEAD_SHA is not a commit" >&2; exit 2 ;;
esac
# A link could name a file of this machine, such as the environment with the token.
if [ -L "$1" ] || [ ! -f "$1" ]; then
    echo "$1 is not a file" >&2
    exit 2
fi
# Not from the list of pull requests of the commit: it is empty for a commit of a fork.
number=$(gh api --paginate "repos/$GITHUB_REPOSITORY/pulls?state=open&per_page=100" --jq ".[] | select(.head.sha == \"$HEAD_SHA\") | .number" | head -n 1)
if [ -z "$number" ]; then
    echo "no open pull request has the commit $HEAD_SHA"
    exit 0
fi
body=$(mktemp)
MARK=$mark python3 -I - "$1" > "$body" <<'PYTHON'
import json, os, sys
text = open(sys.argv[1], encoding="utf-8", errors="replace").read()
link = os.environ.get("RUN_URL", "")
limit = 60_000
if len(text) > limit:
    text = text[:limit].rsplit("\n", 1)[0] + "\n\nThe rest is in the summary of the job.\n"
print(json.dumps({"body": f"{os.environ['MARK']}\n{text}\n[Reports and test results]({link})\n"}))
PYTHON
# Only its own comment: that of a user with the same mark could be edited later.
own="select(.user.login == \"github-actions[bot]\") | select(.body | startswith(\"$mark\")) | .id"
comment=$(gh api --paginate "repos/$GITHUB_REPOSITORY/issues/$number/comments" --jq ".[] | $own" | head -n 1)
if [ -n "$comment" ]; then
    gh api --method PATCH "repos/$GITHUB_REPOSITORY/issues/comments/$comment" --input "$body" --silent
else
    gh api --method POST "repos/$GITHUB_REPOSITORY/issues/$number/comments" --input "$body" --silent
fi
rm -f "$body"
