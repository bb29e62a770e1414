#!/usr/bin/env bash
# Builds the book with all its numbers into target/book/html, and checks its links.
#   book/build.sh            all laws and the pages that compare with other programs
#   book/build.sh --quick    one law per model
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
rm -rf target/book/html
python3 book/generator "$@"
"$mdbook" build target/book
python3 book/check_links.py target/book/html
echo "the book: $PWD/target/book/html/index.html ($SECONDS s)"
