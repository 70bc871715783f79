#!/usr/bin/env bash
# Compares the transport engine with the public solver sasktran2; see README.md. Needs Python 3.11 or
# later with venv, and the network once.
#
#   bash tests/cross_check/run.sh [--quick] [--speed] [...]
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cd "$here/../.."

python="${PYTHON:-python3}"
venv="target/cross_check/venv"
if ! [ -x "$venv/bin/python" ]; then
    "$python" -m venv "$venv"
fi
"$venv/bin/python" -m pip install --quiet --requirement "$here/requirements.txt"
cargo build --release --locked -p sky-cli
exec "$venv/bin/python" "$here/cross_check.py" --utm-sky "${CARGO_TARGET_DIR:-target}/release/utm-sky" "$@"
