//! The light of surfaces, behind hair, smoke and other translucent casters.

use std::sync::Arc;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::scene::view::View;
use lighting::surface;
use lighting::translucent::{Casters, TransmittanceMap};
use lighting::visibility::SurfaceShadow;
use transmittance::Stream;

use crate::failure::Failure;
use crate::input::Input;

/// The light of the surfaces of a view: opaque shadows are traced, translucent ones
/// are looked up in transmittance maps beside shadow maps of `map` texels per side.
pub(crate) fn radiance(view: &View, input: &Input, map: u32) -> Result<Vec<[f32; 4]>, Failure> {
    let maps = maps(input, map)?;
    let maps: Vec<&TransmittanceMap> = maps.iter().map(Arc::as_ref).collect();
    Ok(radiance_of(view, input, &input.emitters, &maps))
}

/// Maps of the light that the translucent casters let through, one per light; none if there are
/// no such casters. Opaque casters are left to rays.
pub(crate) fn maps(input: &Input, map: u32) -> Result<Vec<Arc<TransmittanceMap>>, Failure> {
    if input.scene.translucent.is_empty() {
        return Ok(Vec::new());
    }
    let cpu = Cpu::new();
    let casters = Casters::new(&input.scene.translucent, None);
    let clear = Stream::<8>::new();
    let maps = input.emitters.iter().map(|light| {
        let side = casters.resolution(map, &input.emitters, light);
        TransmittanceMap::build_as_needed(&cpu, &casters, light, side, &clear).map(Arc::new)
    });
    Ok(maps.collect::<Result<_, _>>()?)
}

/// The light of some emitters alone, with the map of each if there are maps.
pub(crate) fn radiance_of(
    view: &View,
    input: &Input,
    emitters: &[Emitter],
    maps: &[&TransmittanceMap],
) -> Vec<[f32; 4]> {
    let Input {
        scene,
        geometry,
        tracer,
        ..
    } = input;
    let medium = scene.medium.as_ref();
    let cpu = Cpu::new();
    if scene.translucent.is_empty() {
        return surface::radiance(&cpu, view, scene, geometry, tracer, emitters, medium);
    }
    let shadows = maps.iter().map(|map| *map as &dyn SurfaceShadow);
    let lights: Vec<_> = emitters.iter().zip(shadows).collect();
    surface::radiance_behind(&cpu, view, scene, geometry, tracer, &lights, medium)
}
