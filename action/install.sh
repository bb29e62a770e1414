#!/bin/sh
# Installs the program for a job: a wheel with a known hash, or a build of this repository.
#
#     WHEEL=path-or-address SHA256=hash action/install.sh
#
# In a GitHub job, the folder of the programs is added to the path of the next steps.
set -eu
if [ -z "${WHEEL:-}" ]; then
    here=$(cd "$(dirname "$0")/.." && pwd)
    cargo build --release --locked --quiet --package kinetoscope-program --manifest-path "$here/Cargo.toml"
    programs=${CARGO_TARGET_DIR:-$here/target}/release
    [ -z "${GITHUB_PATH:-}" ] || echo "$programs" >> "$GITHUB_PATH"
    echo "$programs"
    exit 0
fi
folder=$(mktemp -d)
case $WHEEL in
    http://* | https://*)
        [ -n "${SHA256:-}" ] || { echo "SHA256 of the wheel is required for an address" >&2; exit 2; }
        name=${WHEEL##*/}
        file=$folder/${name%%\?*}
        python3 -I -c 'import sys, urllib.request; urllib.request.urlretrieve(*sys.argv[1:])' "$WHEEL" "$file" ;;
    *) file=$WHEEL ;;
esac
if [ -n "${SHA256:-}" ]; then
    echo "$SHA256  $file" | sha256sum --check --quiet || { echo "$file does not have the SHA-256 $SHA256" >&2; exit 1; }
fi
python3 -I -m venv "$folder/programs"
"$folder/programs/bin/pip" install --quiet --disable-pip-version-check --no-deps "$file"
[ -z "${GITHUB_PATH:-}" ] || echo "$folder/programs/bin" >> "$GITHUB_PATH"
echo "$folder/programs/bin"
