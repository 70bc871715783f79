#!/usr/bin/env bash
# All checks of the project: format, lints, packages, tests. Needs Rust 1.95 and a C compiler to link with; a
# software Vulkan driver and Xvfb are installed where there are none and apt-get can do it.
#
#   bash tests/run.sh
#
# The release profile is used, so that what `cargo run --release` built is not built again. With CI
# set, nothing is skipped.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '\n== %s\n' "$*"; }

if ! command -v cargo >/dev/null; then
    echo "error: cargo: expected on the PATH, found nothing; Rust comes from https://rustup.rs" >&2
    exit 2
fi

# have COMPONENT COMMAND: whether a cargo command is there; gets it from rustup if that can.
have() {
    if cargo "$2" --version >/dev/null 2>&1; then
        return 0
    fi
    if command -v rustup >/dev/null && rustup component add "$1"; then
        return 0
    fi
    if [ -n "${CI:-}" ]; then
        echo "error: $1: expected with CI set, found nothing" >&2
        exit 2
    fi
    return 1
}

# The tests of the GPU need a Vulkan driver (macOS has Metal, Windows Direct3D), those of the window an X
# server and what a window on X11 loads.
has_vulkan() {
    [ "$(uname)" != Linux ] && return 0
    compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null && return 0
    compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null
}

has_windows() {
    [ "$(uname)" != Linux ] && return 0
    command -v Xvfb >/dev/null || return 1
    local library
    for library in libX11.so.6 libX11-xcb.so.1 libXcursor.so.1 libXi.so.6 libxkbcommon-x11.so.0; do
        { PATH="$PATH:/sbin:/usr/sbin" ldconfig -p || true; } | grep -F "$library" >/dev/null || return 1
    done
}

missing=()
has_vulkan || missing+=(mesa-vulkan-drivers)
has_windows || missing+=(xvfb libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0)
if [ "${#missing[@]}" -gt 0 ]; then
    say "Vulkan driver and X server: ${missing[*]}"
    root=()
    [ "$(id -u)" -eq 0 ] || root=(sudo -n)
    if command -v apt-get >/dev/null; then
        ${root[@]+"${root[@]}"} apt-get update -qq || true
        ${root[@]+"${root[@]}"} env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends "${missing[@]}" || true
    fi
    if ! has_vulkan; then
        echo "error: Vulkan: expected a driver, found none; install mesa-vulkan-drivers (Debian," \
            "Ubuntu) or your system's" >&2
        exit 2
    fi
fi

skipped=()
if ! has_windows; then
    if [ -n "${CI:-}" ]; then
        echo "error: windows: expected Xvfb and the libraries of X11 with CI set, found not all of" \
            "them; install ${missing[*]} (Debian, Ubuntu)" >&2
        exit 2
    fi
    # the errors are tested all the same
    skipped+=("windows (no Xvfb, or not all libraries of X11)")
fi

if have rustfmt fmt; then
    say "format"
    cargo fmt --all --check
else
    skipped+=("format (no rustfmt)")
fi

if have clippy clippy; then
    say "lints"
    cargo clippy --workspace --all-targets --locked -- -D warnings
else
    skipped+=("lints (no clippy)")
fi

say "packages"
bash tests/package.sh

say "tests"
cargo test --workspace --release --locked

for what in ${skipped[@]+"${skipped[@]}"}; do
    say "skipped: $what"
done
say "all passed"
