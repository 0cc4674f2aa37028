//! Methods on test scenes.

use gpu_backend::{Buffer, Download, Host};
use lighting::methods::{Entry, Frame, FrameInputs, MethodBackend, MethodError, Selection, Store};
use reference::scenes::TestScene;

/// What methods are told of a test scene, with shadow maps of `map` texels.
pub fn inputs<'a>(scene: &'a TestScene, map: u32, host: &'a Store<Host>) -> FrameInputs<'a> {
    FrameInputs {
        emitters: &scene.emitters,
        areas: &scene.areas,
        medium: &scene.medium,
        height_fog: scene.height_fog.as_ref(),
        geometry: &scene.geometry,
        translucent: &scene.translucent,
        camera: &scene.camera,
        size: scene.size,
        rays: &scene.rays,
        hits: &scene.hits,
        map,
        host,
        selection: Selection::default(),
        watch: &(),
    }
}

/// The image of a frame by a method, or `None` if the method does not run on the
/// backend.
///
/// # Errors
/// Those of the method.
pub fn image<B: MethodBackend + Download>(
    backend: &B,
    inputs: FrameInputs<'_>,
    entry: &Entry,
    quality: u32,
) -> Result<Option<Vec<[f32; 4]>>, MethodError> {
    let Some(method) = entry.on::<B>() else {
        return Ok(None);
    };
    let store = Store::new();
    let frame = Frame::new(backend, inputs, &store)?;
    let mut radiance = backend.zeros::<[f32; 4]>(frame.rays.len())?;
    method.add_radiance(&frame, quality, &mut radiance)?;
    Ok(Some(backend.download(&radiance)?))
}
