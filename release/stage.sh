# The stage of a platform's wheel and archives: the program under its three names, manual pages, completions, licenses, and the list of
# packages. build.sh and platforms.sh source it.
# shellcheck shell=bash

# The documents are those that HOST_PROGRAM, a program of this machine, prints. Windows has neither man nor these shells.
make_stage() { # FOLDER TARGET PROGRAM HOST_PROGRAM
    local stage=$1 target=$2 program=$3 host=$4 name pair
    rm -rf "$stage"
    mkdir -p "$stage/bin" "$stage/share/doc"
    install -m 755 "$program" "$stage/bin/$(basename "$program")"
    # The other two names are links to it; pack.py writes scripts in their place where a format has no links.
    for name in run-experiment analyze-recordings; do
        ln -s kinetoscope "$stage/bin/$name"
    done
    python3 release/notices.py "$target" > "$stage/share/doc/kinetoscope-licenses.txt"
    python3 release/sbom.py "$target" > "$stage/share/doc/kinetoscope.cdx.json"
    case $target in *windows*) return ;; esac
    mkdir -p "$stage"/share/{man/man1,bash-completion/completions,zsh/site-functions,fish/vendor_completions.d}
    "$host" man-pages "$stage/share/man/man1"
    for pair in run-experiment:run analyze-recordings:analyze; do
        echo ".so man1/kinetoscope-${pair#*:}.1" > "$stage/share/man/man1/${pair%:*}.1"
    done
    for name in kinetoscope run-experiment analyze-recordings; do
        "$host" completions bash "$name" > "$stage/share/bash-completion/completions/$name"
        "$host" completions zsh "$name" > "$stage/share/zsh/site-functions/_$name"
        "$host" completions fish "$name" > "$stage/share/fish/vendor_completions.d/$name.fish"
    done
}
