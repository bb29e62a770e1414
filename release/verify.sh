#!/usr/bin/env bash
# Builds a commit again in another folder, and compares the SHA-256 of every file.
# Usage: release/verify.sh SHA256SUMS [COMMIT]
set -euo pipefail
sums=$(realpath "$1")
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
git clone --quiet --no-local . "$folder/another-folder"
git -C "$folder/another-folder" checkout --quiet "${2:-$(git rev-parse HEAD)}"
"$folder/another-folder/release/build.sh" "$folder/files" > /dev/null
cd "$folder/files"
sha256sum --check "$sums" || {
    echo "error: the rebuilt files differ" >&2
    echo "help: use the commit, the Rust of rust-toolchain.toml and the linker of release/requirements.txt of the release" >&2
    exit 1
}
