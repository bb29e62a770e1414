#!/bin/sh
# Builds the engine of report pages: target/browser/kinetoscope-engine.wasm, and the same as gzip. On a machine with rustup, the
# target is installed if it is missing.
#
#     src/browser/build.sh
#     KINETOSCOPE_ENGINE=$PWD/target/browser/kinetoscope-engine.wasm.gz cargo build --release --features kinetoscope-program/engine
set -eu
cd "$(dirname "$0")/../.."
target=wasm32-unknown-unknown
if [ ! -d "$(rustc --print target-libdir --target $target)" ]; then
    rustup target add $target
fi
# Registers of two numbers, and no path of this machine.
flags="-C target-feature=+simd128 --remap-path-prefix=$PWD=. --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="$flags" \
    cargo rustc --locked --quiet --profile browser --package kinetoscope-browser --lib --crate-type staticlib --target $target
# Linked here and not by rustc, which would export every function that a package of the drawing declares for JavaScript.
exports="$(sed -n 's/^pub extern "C" fn \([a-z]*\).*/--export=\1/p' src/browser/lib.rs)"
linker="$(rustc --print sysroot)/lib/rustlib/$(rustc -vV | sed -n 's/^host: //p')/bin/rust-lld"
mkdir -p target/browser
# shellcheck disable=SC2086
"$linker" -flavor wasm --no-entry --gc-sections --strip-all --compress-relocations --stack-first -z stack-size=1048576 --max-memory=536870912 $exports \
    -o target/browser/kinetoscope-engine.wasm target/$target/browser/libkinetoscope_browser.a
python3 src/browser/strip.py target/browser/kinetoscope-engine.wasm
# Without name and time, equal modules give equal bytes by the same program. The module is smaller with zopfli, which a release needs.
if command -v zopfli > /dev/null; then
    zopfli --i5 -c target/browser/kinetoscope-engine.wasm > target/browser/kinetoscope-engine.wasm.gz
else
    gzip --best --no-name --keep --force target/browser/kinetoscope-engine.wasm
fi
wc -c target/browser/kinetoscope-engine.wasm target/browser/kinetoscope-engine.wasm.gz
