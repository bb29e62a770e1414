#!/bin/sh
# Writes a summary as a comment of the open pull request with the commit HEAD_SHA, or replaces the comment that an earlier call wrote.
#
#     GH_TOKEN=… GITHUB_REPOSITORY=owner/name HEAD_SHA=commit RUN_URL=address action/comment.sh SUMMARY.md
#
# The text comes from the pull request and is only data: it is cut to the size of a comment, and the number of the pull request follows
# from the commit. Needs `gh` and `python3`.
set -eu
mark='<!-- kinetoscope -->'
case $HEAD_SHA in
    *[!0-9a-f]* | '') echo "HEAD_SHA is not a commit" >&2; exit 2 ;;
esac
number=$(gh api "repos/$GITHUB_REPOSITORY/commits/$HEAD_SHA/pulls" --jq '[.[] | select(.state == "open")][0].number // empty')
if [ -z "$number" ]; then
    echo "no open pull request has the commit $HEAD_SHA"
    exit 0
fi
body=$(mktemp)
MARK=$mark python3 - "$1" > "$body" <<'PYTHON'
import json, os, sys
text = open(sys.argv[1], encoding="utf-8", errors="replace").read()
link = os.environ.get("RUN_URL", "")
limit = 60_000
if len(text) > limit:
    text = text[:limit].rsplit("\n", 1)[0] + "\n\nThe rest is in the summary of the job.\n"
print(json.dumps({"body": f"{os.environ['MARK']}\n{text}\n[Reports and test results]({link})\n"}))
PYTHON
comment=$(gh api --paginate "repos/$GITHUB_REPOSITORY/issues/$number/comments" --jq ".[] | select(.body | startswith(\"$mark\")) | .id" | head -n 1)
if [ -n "$comment" ]; then
    gh api --method PATCH "repos/$GITHUB_REPOSITORY/issues/comments/$comment" --input "$body" --silent
else
    gh api --method POST "repos/$GITHUB_REPOSITORY/issues/$number/comments" --input "$body" --silent
fi
rm -f "$body"
