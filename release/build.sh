#!/usr/bin/env bash
# Builds everything that is released, from the files of this folder: wheel, archive, Debian package, list of packages (CycloneDX)
# and SHA-256 checksums. Needs Rust with rustup or its wasm32-unknown-unknown target, Python 3.11 and git.
# Usage: release/build.sh [OUTPUT]     (default: target/release-files)
set -euo pipefail
cd "$(dirname "$0")/.."
source release/stage.sh
root=$PWD
output=$(realpath --canonicalize-missing "${1:-target/release-files}")
target=x86_64-unknown-linux-gnu
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)

if [ ! -x target/linker/bin/cargo-zigbuild ]; then
    python3 -m venv target/linker
    target/linker/bin/pip install --quiet --disable-pip-version-check --requirement release/requirements.txt
fi
export PATH="$root/target/linker/bin:$PATH"

# No path and no time of this machine is in the programs.
cargo_home=${CARGO_HOME:-$HOME/.cargo}
folders=("$root=/kinetoscope" "$cargo_home=/cargo" "$(rustc --print sysroot)=/rust")
RUSTFLAGS=$(printf -- '--remap-path-prefix=%s ' "${folders[@]}")
CFLAGS=$(printf -- '-ffile-prefix-map=%s ' "${folders[@]}")
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
export RUSTFLAGS CFLAGS SOURCE_DATE_EPOCH CARGO_INCREMENTAL=0 LC_ALL=C TZ=UTC
umask 022

# The identifier of the source, which bundles name.
KINETOSCOPE_COMMIT=$(git rev-parse HEAD)
export KINETOSCOPE_COMMIT

command -v zopfli > /dev/null || {
    echo "error: zopfli, which makes the bytes of the engine, is not installed; try \`apt-get install zopfli\`" >&2
    exit 1
}
# The engine of report pages. Its flags replace those of the program.
env -u RUSTFLAGS src/browser/build.sh
export KINETOSCOPE_ENGINE=$root/target/browser/kinetoscope-engine.wasm.gz

# glibc 2.17: manylinux_2_17, and every distribution since 2014.
cargo zigbuild --locked --profile dist --target "$target.2.17" --target-dir "$root/target" \
    --package kinetoscope-program --features parquet,engine --bin kinetoscope
program=$root/target/$target/dist/kinetoscope

stage=$root/target/stage
rm -rf "$output"
mkdir -p "$output"
make_stage "$stage" "$target" "$program" "$program"
python3 release/pack.py "$stage" "$version" "$output"
cp "$stage/share/doc/kinetoscope.cdx.json" "$output/kinetoscope-$version.cdx.json"
(cd "$output" && sha256sum -- * > SHA256SUMS && cat SHA256SUMS)
