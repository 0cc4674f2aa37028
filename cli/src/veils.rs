//! Maps of what hair and smoke let through, and the surfaces behind them.

use gpu_backend::Cpu;
use lighting::scene::Geometry;
use lighting::scene::view::View;
use lighting::translucent::{Casters, TransmittanceMap};
use lighting::visibility::SurfaceShadow;
use lighting::{Emitter, surface};
use transmittance::Stream;

use crate::failure::Failure;
use crate::input::Input;

/// Memory that the maps of all lights may take together.
const MAX_BYTES: u64 = 1 << 29;

/// Texels per side of each face: a half of those of a shadow map, because a
/// texel holds a curve, or less if the maps of all `emitters` would take more
/// than 512 MiB.
pub(crate) fn resolution(map: u32, emitters: &[Emitter]) -> u32 {
    let faces = |emitter: &Emitter| match emitter {
        Emitter::Directional(_) => 1,
        _ => 6,
    };
    let faces: u64 = emitters.iter().map(faces).sum();
    let texel = size_of::<transmittance::Packed<8>>() as u64;
    let bytes = |side: u32| texel * faces * u64::from(side) * u64::from(side);
    let mut side = (map / 2).max(1);
    while side > 16 && bytes(side) > MAX_BYTES {
        side /= 2;
    }
    side
}

/// The maps of all emitters, in order; `geometry` is of the opaque casters that
/// enter them.
pub(crate) fn veils(
    input: &Input,
    geometry: Option<&Geometry>,
    emitters: &[Emitter],
    resolution: u32,
) -> Result<Vec<TransmittanceMap>, Failure> {
    let cpu = Cpu::new();
    let casters = Casters::new(&input.scene.translucent, geometry);
    let mut veils = Vec::with_capacity(emitters.len());
    for emitter in emitters {
        let clear = Stream::<8>::new();
        let veil = TransmittanceMap::build(&cpu, &casters, emitter, resolution, &clear)?;
        veils.push(veil);
    }
    Ok(veils)
}

/// The light of the surfaces of a view, behind whatever is translucent: opaque
/// shadows are traced, translucent ones are looked up in maps of `map` / 2
/// texels per side.
pub(crate) fn surfaces(view: &View, input: &Input, map: u32) -> Result<Vec<[f32; 4]>, Failure> {
    let Input {
        scene,
        geometry,
        tracer,
        emitters,
        ..
    } = input;
    let medium = scene.medium.as_ref();
    let cpu = Cpu::new();
    if scene.translucent.is_empty() {
        return Ok(surface::radiance(
            &cpu, view, scene, geometry, tracer, emitters, medium,
        ));
    }
    let maps = veils(input, None, emitters, resolution(map, emitters))?;
    let shadows = maps.iter().map(|map| map as &dyn SurfaceShadow);
    let lights: Vec<_> = emitters.iter().zip(shadows).collect();
    Ok(surface::radiance_behind(
        &cpu, view, scene, geometry, tracer, &lights, medium,
    ))
}
