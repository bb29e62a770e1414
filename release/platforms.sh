#!/usr/bin/env bash
# Builds wheels for other platforms than that of build.sh: aarch64 Linux (glibc 2.17), Windows x86-64, and `any`, the Python package without
# programs. Needs rustup, gcc-mingw-w64-x86-64 for Windows, and what build.sh has built: the engine of report pages, and the program of this
# machine, which prints the documents. Installs Rust's standard libraries for the targets.
# Usage: release/platforms.sh [OUTPUT] [PLATFORM...]     (default: target/release-files, all platforms)
set -euo pipefail
cd "$(dirname "$0")/.."
source release/stage.sh
root=$PWD
output=$(realpath --canonicalize-missing "${1:-target/release-files}")
shift || true
platforms=${*:-any aarch64 windows}
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
KINETOSCOPE_COMMIT=$(git rev-parse HEAD)
RUSTFLAGS=$(printf -- '--remap-path-prefix=%s ' "$root=/kinetoscope" "${CARGO_HOME:-$HOME/.cargo}=/cargo" "$(rustc --print sysroot)=/rust")
export SOURCE_DATE_EPOCH KINETOSCOPE_COMMIT RUSTFLAGS CARGO_INCREMENTAL=0 LC_ALL=C TZ=UTC
umask 022
mkdir -p "$output"
host=$root/target/x86_64-unknown-linux-gnu/dist/kinetoscope
export KINETOSCOPE_ENGINE=$root/target/browser/kinetoscope-engine.wasm.gz
if [ "$platforms" != any ] && { [ ! -x "$host" ] || [ ! -e "$KINETOSCOPE_ENGINE" ]; }; then
    echo "error: the program of this machine is missing; execute release/build.sh first" >&2
    exit 1
fi

for platform in $platforms; do
    case $platform in
    any)
        mkdir -p target/stage-any
        python3 release/pack.py target/stage-any "$version" "$output" any
        ;;
    aarch64)
        target=aarch64-unknown-linux-gnu
        if [ ! -x target/linker/bin/cargo-zigbuild ]; then
            python3 -m venv target/linker
            target/linker/bin/pip install --quiet --disable-pip-version-check --requirement release/requirements.txt
        fi
        rustup --quiet target add "$target"
        PATH="$root/target/linker/bin:$PATH" cargo zigbuild --locked --profile dist --target "$target.2.17" --target-dir target \
            --package kinetoscope-program --features parquet,engine --bin kinetoscope
        make_stage "$root/target/stage-$target" "$target" "target/$target/dist/kinetoscope" "$host"
        python3 release/pack.py "target/stage-$target" "$version" "$output" manylinux_2_17_aarch64
        ;;
    windows)
        target=x86_64-pc-windows-gnu
        rustup --quiet target add "$target"
        cargo build --locked --profile dist --target "$target" --target-dir target \
            --package kinetoscope-program --features parquet,engine --bin kinetoscope
        make_stage "$root/target/stage-$target" "$target" "target/$target/dist/kinetoscope.exe" "$host"
        python3 release/pack.py "target/stage-$target" "$version" "$output" win_amd64
        ;;
    *)
        echo "error: unknown platform $platform: any, aarch64 or windows" >&2
        exit 2
        ;;
    esac
done
