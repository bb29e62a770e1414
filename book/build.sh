#!/usr/bin/env bash
# Builds the book with all its numbers into target/book/html and, with it, the site into target/site: front page, gallery of all experiments, play page,
# book and documentation of the libraries. Checks all links. Without the engine (CONTRIBUTING.md), the site has no simulations.
#   book/build.sh            all laws, and the pages that compare with other programs
#   book/build.sh --quick    one law per model; REBOUND and LAMMPS only if they are installed
# The programs must be built (cargo build --release); another folder of programs is given by --bin FOLDER.
set -euo pipefail
cd "$(dirname "$0")/.."
mdbook=target/tools/bin/mdbook
version=0.5.4
if command -v mdbook > /dev/null; then
    mdbook=mdbook
elif ! [ -x "$mdbook" ] || [ "$("$mdbook" --version)" != "mdbook v$version" ]; then
    # Not optimized, and without the server: it compiles in half the time and builds the book in seconds.
    CARGO_PROFILE_DEV_DEBUG=0 cargo install mdbook --version "$version" --locked --quiet --debug --no-default-features --features search \
        --root target/tools --target-dir target/tools/build
fi
tools=target/tools/python
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/pip" install --quiet --disable-pip-version-check --requirement book/generator/requirements.txt
# A package that cannot be installed is skipped, and its page says so.
if [[ " $* " != *" --quick "* ]]; then
    [ -x target/cross_code/bin/python ] || python3 -m venv target/cross_code
    grep '^[a-z]' book/cross_code/requirements.txt | while read -r package; do
        target/cross_code/bin/pip install --quiet --disable-pip-version-check "$package" || echo "not installed: $package"
    done
fi
python=python3
[ -x target/cross_code/bin/python ] && python=$PWD/target/cross_code/bin/python
rm -rf target/book/html
"$tools/bin/python" book/generator --cross-code-python "$python" "$@"
"$mdbook" build target/book
python3 book/check_words.py target/book/src
python3 book/generator/site.py "$@"
python3 book/check_links.py target/book/html
python3 book/check_links.py target/site
echo "the book: $PWD/target/book/html/index.html, the site: $PWD/target/site/index.html ($SECONDS s)"
