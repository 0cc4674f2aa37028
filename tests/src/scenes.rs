//! What methods take, made from a [`TestScene`].

use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::voxelized::Eye;
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

/// The shadow maps of all lights.
///
/// # Panics
/// If they do not fit into memory.
pub fn maps<B: RenderShadowMap>(
    backend: &B,
    scene: &TestScene,
    resolution: u32,
) -> Vec<ShadowMap<B::Memory>> {
    let casters = Casters::upload(backend, &scene.geometry).expect("memory");
    let render = |emitter| {
        backend
            .shadow_map(&casters, emitter, resolution)
            .expect("memory")
    };
    scene.emitters.iter().map(render).collect()
}

/// What voxels are made for.
pub fn eye(scene: &TestScene) -> Eye {
    Eye::of_camera(&scene.camera, scene.size, &scene.rays, &scene.medium)
}

/// The order of convergence that refined maps and grids must show on an embedded
/// scene.
///
/// The edges of equal slats lie alike in their texels, so their errors do not average:
/// they stay within a bound of first order, but come near it at some resolutions and
/// not at others. There it is asked that they fall.
pub fn least_order(embedded: Embedded) -> f64 {
    match embedded {
        Embedded::Pergola => 0.0,
        _ => 1.0 - Allowed::Order.error(),
    }
}
