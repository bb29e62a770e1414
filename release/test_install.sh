#!/usr/bin/env bash
# Installs the built files in empty Debian 11 and 12 roots without Rust, and checks the programs, the manual pages and the
# completions. As root, with debootstrap; packages come from the mirror that apt of this machine uses. `bookworm:arm64` is Debian 12 for
# aarch64, whose programs are emulated (qemu-user-static and binfmt-support); there, only the wheel is checked.
# Usage: release/test_install.sh [FILES] [SUITE[:ARCHITECTURE] ...]     (default: target/release-files bullseye bookworm)
set -euo pipefail
# In a mount namespace of its own: what is mounted below ends with this process, however it ends, and no folder that is removed
# later contains a mount.
own_mounts=$(readlink /proc/self/ns/mnt)
[ "${KINETOSCOPE_OWN_MOUNTS:-}" = "$own_mounts" ] ||
    exec unshare --mount bash -c 'KINETOSCOPE_OWN_MOUNTS=$(readlink /proc/self/ns/mnt) exec "$@"' bash bash "$0" "$@"
cd "$(dirname "$0")/.."
files=$(realpath "${1:-target/release-files}")
shift || true
[ $# -gt 0 ] || set -- bullseye bookworm
roots=$PWD/target/install-roots
# Seconds from `pip install` to the report.
LIMIT=20

mirror=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | grep '/debian/*$' | head -n 1)
[ -n "$mirror" ] || { echo "error: apt names no mirror of Debian" >&2; exit 1; }

native=$(dpkg --print-architecture)
for wanted in "$@"; do
    suite=${wanted%%:*} architecture=$native
    case $wanted in *:*) architecture=${wanted#*:} ;; esac
    root=$roots/$suite limit=$LIMIT
    wheel_only=
    if [ "$architecture" != "$native" ]; then
        wheel_only=1
        # An emulated processor is some thirty times slower.
        root=$roots/$suite-$architecture limit=$((30 * LIMIT))
    fi
    case $architecture in
    amd64) machine=x86_64 ;;
    arm64) machine=aarch64 ;;
    *) echo "error: there is no wheel for $architecture" >&2; exit 2 ;;
    esac
    # pip evaluates the wheel's conditions for its own Python, so that what only an older one needs is named.
    case $suite in bullseye) python=3.9 needs='tomli>=2' ;; *) python=3.11 needs='' ;; esac
    if [ ! -e "$root/complete" ]; then
        rm -rf --one-file-system "$root"
        mkdir -p "$roots"
        debootstrap --arch "$architecture" --variant=minbase --include=python3,python3-venv,man-db,bash-completion,zsh \
            "$suite" "$root" "$mirror" > "$root.log" || { tail -n 5 "$root.log" >&2; exit 1; }
        touch "$root/complete"
    fi
    # The local index: the wheel, and the wheels that it needs for this Python.
    rm -rf --one-file-system "$root/index" "$root/work" "$root/environment"
    mkdir -p "$root/index" "$root/work"
    python3 -m pip download --quiet --disable-pip-version-check --dest "$root/index" --only-binary=:all: \
        --python-version "$python" --platform "manylinux2014_$machine" --platform "manylinux_2_17_$machine" \
        "$files"/kinetoscope-*-manylinux*"_$machine.whl" $needs
    cp experiments/first_run.toml release/installed.sh release/completion.zsh "$root/work"
    [ "$architecture" != "$native" ] || cp "$files"/*.deb "$root/work"
    mountpoint --quiet "$root/proc" || mount -t proc proc "$root/proc"
    # zsh completes in a pseudo terminal.
    mountpoint --quiet "$root/dev/pts" || mount --bind /dev/pts "$root/dev/pts"
    echo "== $suite on $machine, Python $python"
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 TERM=dumb LIMIT=$limit WHEEL_ONLY=$wheel_only \
        chroot "$root" bash /work/installed.sh
done
