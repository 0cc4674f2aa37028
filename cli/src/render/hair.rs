//! The hair of a picture.

use glam::Vec3;
use gpu_backend::Cpu;
use gpu_backend::gpu::{Gpu, GpuMemory, Queued};
use lighting::Emitter;
use lighting::hair::{Fibre, LitHair, SeenHair};
use lighting::methods::exact::UploadedTracer;
use lighting::scene::view::View;
use lighting::scene::{Camera, Scene, Translucent};
use lighting::translucent::TransmittanceMap;

use crate::args::FibreName;
use crate::devices::Device;
use crate::failure::Failure;
use crate::hair::{light_of, triangles_in_shaders};
use crate::input::Input;

impl FibreName {
    fn fibre(self) -> Fibre {
        match self {
            Self::Marschner => Fibre::Marschner,
            Self::KajiyaKay => Fibre::KajiyaKay,
        }
    }
}

/// Strands over the pixels of a view, and how they scatter light.
pub(super) struct Hair {
    seen: SeenHair,
    fibre: Fibre,
}

impl Hair {
    /// The strands of a scene, and the view of what is behind them; `None` if there is
    /// no hair.
    pub(super) fn before(
        view: View,
        camera: &Camera,
        scene: &Scene,
        fibre: Option<FibreName>,
    ) -> (Option<Self>, View) {
        let cpu = Cpu::new();
        let Some(seen) = SeenHair::new(&cpu, camera, &view, &scene.translucent) else {
            return (None, view);
        };
        let cover = seen.cover(&cpu);
        let fibre = fibre.map_or(Fibre::default(), FibreName::fibre);
        (Some(Self { seen, fibre }), view.with_cover(cover))
    }

    /// Its light on a device, of lights with their maps.
    pub(super) fn radiance(
        &self,
        (view, device): (&View, &Device),
        input: &mut Input,
        emitters: &[Emitter],
        maps: &[&TransmittanceMap],
    ) -> Result<Vec<[f32; 4]>, Failure> {
        let mut there = None;
        if let Some(context) = &device.context {
            let gpu = Gpu::new(context.clone());
            match uploaded(&gpu, input, maps)? {
                Ok((tracer, maps)) => there = Some((gpu, tracer, maps)),
                Err(why) => (input.notes).push(format!("hair is lit on the CPU: {why}")),
            }
        }
        let media = &input.media();
        let (translucent, fibre) = (&input.scene.translucent[..], self.fibre);
        let Some((gpu, tracer, maps)) = &there else {
            let lights: Vec<_> = emitters.iter().zip(maps.iter().copied()).collect();
            let lit = LitHair {
                view,
                translucent,
                media,
                tracer: input.tracer.as_ref(),
                lights: &lights,
                fibre,
            };
            return light_of(&Cpu::new(), &self.seen, &lit);
        };
        let lights: Vec<_> = emitters.iter().zip(maps).collect();
        let lit = LitHair {
            view,
            translucent,
            media,
            tracer,
            lights: &lights,
            fibre,
        };
        light_of(gpu, &self.seen, &lit)
    }
}

/// The triangles of a scene, and the maps of lights, where shaders read them.
type Uploaded = (UploadedTracer, Vec<TransmittanceMap<GpuMemory>>);

/// Triangles and maps on a GPU, or the reason why they are not there.
fn uploaded(
    gpu: &Gpu<Queued>,
    input: &Input,
    maps: &[&TransmittanceMap],
) -> Result<Result<Uploaded, String>, Failure> {
    let tracer = match triangles_in_shaders(gpu, &input.geometry, &input.tracer)? {
        Ok(tracer) => tracer,
        Err(why) => return Ok(Err(why.into())),
    };
    let maps: Result<_, _> = maps.iter().map(|map| map.upload(gpu)).collect();
    Ok(match maps {
        Ok(maps) => Ok((tracer, maps)),
        Err(error) => Err(error.to_string()),
    })
}

/// Gives all strands of a scene a colour.
pub(super) fn paint(scene: &mut Scene, colour: Vec3) -> Result<(), Failure> {
    for caster in &mut scene.translucent {
        if let Translucent::Strands(strands) = caster {
            *strands = strands
                .clone()
                .with_colours(vec![colour])
                .map_err(|error| Failure::from(error).about("--hair-colour"))?;
        }
    }
    Ok(())
}
