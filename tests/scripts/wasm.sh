#!/usr/bin/env bash
# Checks for wasm32-unknown-unknown, the target of browsers, that
#
# * the CPU parts of all libraries compile, with and without default features;
# * their GPU parts compile with wgpu's driver for browsers (feature `webgpu` of
#   crepuscular-backend), where nothing may wait for the device.
#
# Nothing is run. Without the target it says so and passes; REQUIRE_WASM=1 makes that a
# failure.
set -euo pipefail
cd "$(dirname "$0")/../.."

export CARGO_TERM_COLOR=never CARGO_INCREMENTAL=0
target=wasm32-unknown-unknown
if [[ ! -d $(rustc --print sysroot)/lib/rustlib/$target/lib ]]; then
    printf 'SKIPPED %s: rustup target add %s\n' "$0" "$target" >&2
    [[ ${REQUIRE_WASM:-} != 1 ]]
    exit
fi

libraries=(--package=crepuscular-{backend,epipolar,airlight,transmittance,shadow-dag,voxel-shadow,scene,lighting})
# Every feature of crepuscular-lighting that needs no GPU.
cpu=(methods area shadow-dag translucent procedural gltf ply obj hair vol nvdb vdb)

check() {
    printf 'cargo check %s\n' "$*"
    RUSTFLAGS='-D warnings' cargo check --quiet --target "$target" "$@"
}

check "${libraries[@]}"
check "${libraries[@]}" --no-default-features
check --package=crepuscular-lighting --features "${cpu[*]}"
check "${libraries[@]}" --features "crepuscular-backend/webgpu crepuscular-epipolar/wgpu crepuscular-airlight/wgpu \
crepuscular-transmittance/wgpu crepuscular-shadow-dag/wgpu crepuscular-voxel-shadow/wgpu crepuscular-scene/wgsl \
crepuscular-lighting/wgpu ${cpu[*]/#/crepuscular-lighting/}"
printf 'passed in %d s\n' "$SECONDS"
