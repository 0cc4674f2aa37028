#!/usr/bin/env bash
# Packages all crates that are published, unpacks the archives, and checks each of them from
# its archive, with those of the others in place of what a registry would give: a file, a
# feature or a version that only this repository has is found here. Then what tools say that
# not every machine has: cargo-deny (deny.toml), cargo-semver-checks (against the last tag),
# and the oldest Rust that Cargo.toml promises. What is skipped is named.
#
# With --tools it does the latter alone, as `.ci/run` does. Other arguments go to
# `cargo package`, such as --allow-dirty. The whole is to be run by hand: it builds all
# dependencies once more, into target/packages.
set -euo pipefail
cd "$(dirname "$0")/../.."

export CARGO_TERM_COLOR=never CARGO_INCREMENTAL=0
target=${CARGO_TARGET_DIR:-$PWD/target}/packages
export CARGO_TARGET_DIR=$target

published=$(cargo metadata --format-version 1 --no-deps | python3 -c '
import json, sys
for package in json.load(sys.stdin)["packages"]:
    if package["publish"] != []:
        print(package["name"], package["version"])
')

step() { printf '\n=== %s (after %d s)\n' "$1" "$SECONDS"; }
skipped() { printf 'SKIPPED %s: %s\n' "$1" "$2"; }

names=()
while read -r name _; do names+=(--package "$name"); done <<<"$published"

# Packages, and checks each from its archive.
archives() {
    step 'packages'
    cargo package --no-verify "${names[@]}" "$@"

    step 'archives'
    # Outside of the repository, whose workspace cargo would take them for members of.
    unpacked=$(mktemp -d)
    trap 'rm -rf "$unpacked"' EXIT
    patches=()
    while read -r name version; do
        tar -xzf "$target/package/$name-$version.crate" -C "$unpacked"
        patches+=(--config "patch.crates-io.$name.path='$unpacked/$name-$version'")
        for file in README.md LICENSE-MIT LICENSE-APACHE; do
            [[ -s $unpacked/$name-$version/$file ]] || { echo "$name has no $file" >&2; exit 1; }
        done
    done <<<"$published"

    while read -r name version; do
        for all in '' --all-features; do
            printf 'cargo check %s of the archive of %s\n' "$all" "$name"
            # The versions of dependencies that all else was tested with.
            cp Cargo.lock "$unpacked/$name-$version/Cargo.lock"
            # shellcheck disable=SC2086
            RUSTFLAGS='-D warnings' cargo check --quiet $all "${patches[@]}" \
                --manifest-path "$unpacked/$name-$version/Cargo.toml" 2> >(grep -v -e 'was not used in the crate graph' -e '^$' >&2)
        done
    done <<<"$published"
}

if [[ ${1:-} != --tools ]]; then
    archives "$@"
fi

step 'licences and sources'
if cargo deny --version >/dev/null 2>&1; then
    cargo deny check bans licenses sources
else
    skipped cargo-deny 'it is not installed'
fi

step 'changes of the interface'
if ! cargo semver-checks --version >/dev/null 2>&1; then
    skipped cargo-semver-checks 'it is not installed'
elif ! tag=$(git describe --tags --abbrev=0 2>/dev/null); then
    skipped cargo-semver-checks 'there is no tag to compare with'
else
    cargo semver-checks "${names[@]}" --baseline-rev "$tag"
fi

step 'the oldest Rust'
oldest=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
if cargo "+$oldest" --version >/dev/null 2>&1; then
    cargo "+$oldest" check --quiet "${names[@]}" --all-features
else
    skipped "Rust $oldest" "rustup toolchain install $oldest"
fi
printf '\n=== passed in %d s\n' "$SECONDS"
