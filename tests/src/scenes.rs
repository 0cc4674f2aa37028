//! What methods take, made from a [`TestScene`].

use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::voxelized::Eye;
use reference::scenes::TestScene;

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
