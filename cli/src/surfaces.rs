//! The light of surfaces, behind whatever is translucent.

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::methods::curve_resolution;
use lighting::scene::view::View;
use lighting::surface;
use lighting::translucent::{Casters, TransmittanceMap};
use lighting::visibility::SurfaceShadow;
use transmittance::Stream;

use crate::failure::Failure;
use crate::input::Input;

/// The light of the surfaces of a view: opaque shadows are traced, translucent ones
/// are looked up in maps of `map` / 2 texels per side.
pub(crate) fn radiance(view: &View, input: &Input, map: u32) -> Result<Vec<[f32; 4]>, Failure> {
    radiance_of(view, input, &input.emitters, map)
}

/// The same by some emitters alone.
pub(crate) fn radiance_of(
    view: &View,
    input: &Input,
    emitters: &[Emitter],
    map: u32,
) -> Result<Vec<[f32; 4]>, Failure> {
    let Input {
        scene,
        geometry,
        tracer,
        ..
    } = input;
    let medium = scene.medium.as_ref();
    let cpu = Cpu::new();
    if scene.translucent.is_empty() {
        return Ok(surface::radiance(
            &cpu, view, scene, geometry, tracer, emitters, medium,
        ));
    }
    // Opaque casters are traced.
    let casters = Casters::new(&scene.translucent, None);
    let side = curve_resolution(map, emitters, casters.channels());
    let clear = Stream::<8>::new();
    let maps: Vec<TransmittanceMap> = emitters
        .iter()
        .map(|emitter| TransmittanceMap::build(&cpu, &casters, emitter, side, &clear))
        .collect::<Result<_, _>>()?;
    let shadows = maps.iter().map(|map| map as &dyn SurfaceShadow);
    let lights: Vec<_> = emitters.iter().zip(shadows).collect();
    Ok(surface::radiance_behind(
        &cpu, view, scene, geometry, tracer, &lights, medium,
    ))
}
