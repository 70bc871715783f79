#!/usr/bin/env bash
# Packs every package that is meant to be published, unpacks them side by side and checks that they
# build from what is in them alone. Third-party packages are those of the workspace, so that this costs
# seconds; `cargo package --workspace --exclude sky-tests` builds all of it anew, before a release.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packed=target/package
unpacked="$packed/unpacked"
rm -rf "$unpacked" "$packed"/*.crate
mkdir -p "$unpacked"
cargo package --workspace --exclude sky-tests --no-verify --locked --allow-dirty --quiet

{
    echo '[workspace]'
    echo 'resolver = "3"'
    echo 'members = ["*-[0-9]*"]'
    sed -n '/^\[profile\.dev\]/,/^$/p' Cargo.toml
    echo '[patch.crates-io]'
} > "$unpacked/Cargo.toml"
for crate in "$packed"/*.crate; do
    # packed files are all of one old date: with the date of today, what was built before is not kept
    tar -xzmf "$crate" -C "$unpacked"
    directory="$(basename "$crate" .crate)"
    for license in LICENSE-MIT LICENSE-APACHE README.md; do
        if [ ! -f "$unpacked/$directory/$license" ]; then
            echo "error: $directory: expected $license in the package, found none" >&2
            exit 1
        fi
    done
    echo "${directory%-*} = { path = \"$directory\" }" >> "$unpacked/Cargo.toml"
done
cp Cargo.lock "$unpacked/"
# offline: what is not in a package must not come from elsewhere
cargo check --manifest-path "$unpacked/Cargo.toml" --workspace --all-targets --offline \
    --target-dir target --quiet
