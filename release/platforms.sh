#!/usr/bin/env bash
# Builds wheels for other platforms than that of build.sh: aarch64 Linux (glibc 2.17), Windows x86-64, and `any`, the Python package without
# programs. Needs rustup, and gcc-mingw-w64-x86-64 for Windows; installs Rust's standard libraries for the targets.
# Usage: release/platforms.sh [OUTPUT] [PLATFORM...]     (default: target/release-files, all platforms)
set -euo pipefail
cd "$(dirname "$0")/.."
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

# The stage of a target: its program under three names.
stage() { # TARGET PROGRAM
    local folder=$root/target/stage-$1
    rm -rf "$folder"
    mkdir -p "$folder/bin"
    install -m 755 "$2" "$folder/bin/$(basename "$2")"
    for name in run-experiment analyze-recordings; do
        ln -s kinetoscope "$folder/bin/$name"
    done
    echo "$folder"
}

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
            --package kinetoscope-program --features parquet --bin kinetoscope
        python3 release/pack.py "$(stage "$target" "target/$target/dist/kinetoscope")" "$version" "$output" manylinux_2_17_aarch64
        ;;
    windows)
        target=x86_64-pc-windows-gnu
        rustup --quiet target add "$target"
        cargo build --locked --profile dist --target "$target" --target-dir target \
            --package kinetoscope-program --features parquet --bin kinetoscope
        python3 release/pack.py "$(stage "$target" "target/$target/dist/kinetoscope.exe")" "$version" "$output" win_amd64
        ;;
    *)
        echo "error: unknown platform $platform: any, aarch64 or windows" >&2
        exit 2
        ;;
    esac
done
