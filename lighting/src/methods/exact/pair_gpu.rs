//! Pairs of exact visibility on GPUs.

use std::sync::Arc;

use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::{Backend, Buffer, Cpu, Error};

use super::UploadedTracer;
use super::gpu::are_in_shaders;
use super::method::Traced;
use super::pair::SolidInShaders;
use crate::gpu::AirlightSlot;
use crate::methods::{Evaluators, Frame, MethodError, OfScene, RunOn, SourceOn};

/// The message about triangles that the shader does not know.
const NOT_SOLID: &str = "exact visibility is found on the CPU: some triangles are masked or \
    see-through, which its shader does not know";

/// The message about too many triangles.
const TOO_MANY: &str = "exact visibility is found on the CPU: a software driver may end its walk \
    through so many triangles";

/// The message about triangles that do not fit.
const TOO_LARGE: &str = "exact visibility is found on the CPU: the GPU cannot bind so many \
    triangles at once";

/// Triangles that a software driver gets. Such drivers end the loops of a ray after 65,535
/// turns, which is no error: the rest of the ray would be lit. Each 16 shadows on a ray take
/// another walk, of at most two nodes for each triangle and some 18 turns of all loops for
/// each node, so a ray through T triangles side by side takes up to 2.25 T² turns.
const MOST_ON_SOFTWARE: usize = 150;

/// At least the bytes of a triangle in either buffer: 36 for its corners, 32 for each of at
/// most two nodes.
const BYTES: u64 = 64;

/// The shader that adds light.
pub(super) const ADD: [&str; 2] = [INDEX_WGSL, include_str!("add.wgsl")];

/// Invocations per workgroup in it.
const GROUP: u32 = 64;

impl<E: Encode> SourceOn<Gpu<E>> for Traced {
    type Source = Arc<UploadedTracer>;

    fn prepare(&self, frame: &Frame<'_, Gpu<E>>, _: usize, _: u32) -> Result<(), MethodError> {
        uploaded(frame).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        _: usize,
        _: u32,
    ) -> Result<Arc<UploadedTracer>, MethodError> {
        uploaded(frame)
    }
}

fn uploaded<E: Encode>(frame: &Frame<'_, Gpu<E>>) -> Result<Arc<UploadedTracer>, MethodError> {
    let what = "BVH for shaders";
    frame.store.get(what, OfScene, UploadedTracer::bytes, || {
        let tracer = frame.inputs.tracer()?;
        UploadedTracer::new(frame.backend, &tracer)
            .map_err(MethodError::resource("the triangles of exact visibility"))
    })
}

/// Why the CPU has to find what is lit in a frame, if it has to.
fn why_on_cpu<E: Encode>(frame: &Frame<'_, Gpu<E>>) -> Option<&'static str> {
    let geometry = frame.inputs.geometry;
    let triangles = geometry.triangles().len();
    if !are_in_shaders(geometry.coatings(), triangles) {
        return Some(NOT_SOLID);
    }
    let context = frame.backend.context();
    if BYTES * triangles as u64 > context.limits().max_storage_buffer_binding_size {
        return Some(TOO_LARGE);
    }
    let is_too_long = context.is_software() && triangles > MOST_ON_SOFTWARE;
    is_too_long.then_some(TOO_MANY)
}

impl<A, E> RunOn<Gpu<E>> for SolidInShaders<A>
where
    A: Evaluators,
    A::Evaluator: InShader<AirlightSlot>,
    E: Encode,
{
    fn prepare(&self, frame: &Frame<'_, Gpu<E>>, quality: u32) -> Result<(), MethodError> {
        if why_on_cpu(frame).is_none() {
            return self.0.prepare(frame, quality);
        }
        let cpu = Cpu::new();
        let on_cpu = Frame::new(&cpu, frame.inputs, frame.inputs.host)?;
        self.0.prepare(&on_cpu, quality)
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        quality: u32,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), MethodError> {
        let inputs = frame.inputs;
        let Some(why) = why_on_cpu(frame) else {
            return self.0.add_radiance(frame, quality, radiance);
        };
        inputs.watch.told(why);
        let light = frame.pass("gather on the CPU", || {
            let cpu = Cpu::new();
            let on_cpu = Frame::new(&cpu, inputs, inputs.host)?;
            let mut light = vec![[0.0; 4]; inputs.rays.len()];
            self.0.add_radiance(&on_cpu, quality, &mut light)?;
            Ok(light)
        })?;
        frame.pass("light of the CPU", || {
            Ok(add(frame.backend, &light, radiance)?)
        })
    }
}

/// Adds the light of rays to the first three components of their radiance.
fn add<E: Encode>(
    gpu: &Gpu<E>,
    light: &[[f32; 4]],
    radiance: &mut GpuBuffer<[f32; 4]>,
) -> Result<(), Error> {
    crate::gather::check_lengths(light.len(), radiance.len())?;
    let rays = light.len();
    let light = gpu.upload(light)?;
    gpu.dispatch(
        &Kernel {
            label: "light of the CPU",
            parts: &ADD,
            entry: "add_light",
            constants: &[],
        },
        &[&[
            // More rays than a u32 counts are refused by the dispatch.
            Argument::uniform(rays as u32),
            Argument::read(&light),
            Argument::write(radiance),
        ]],
        Workgroups::covering(rays, GROUP),
    )
}
