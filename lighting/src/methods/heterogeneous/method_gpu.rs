//! Gathers through media on GPUs, in the list of methods.

use std::fmt;
use std::sync::Arc;

use gpu_backend::Cpu;
use gpu_backend::gpu::{Encode, Gpu, GpuBuffer, GpuMemory, InShader};
use transmittance::Evaluate;
use transmittance::gpu::{WgslRule, WgslStored};

use super::exact_triangles::ExactTriangles;
use super::method::{
    ByArea, Curves, Gathered, NoCurves, OfSize, Panes, STEPS, casters, check, key,
};
use super::{GatherMedia, MediaRays, UploadedMedia};
use crate::EyePanes;
use crate::gpu::PointSlot;
use crate::methods::translucent::{TransmittanceMap, made};
use crate::methods::{Frame, MethodError, OfScene, RunOn};
use crate::shadow_map::ShadowMap;
use crate::visibility::{Both, Exact};

/// Maps that shaders read.
pub(super) trait CurvesInShaders: Curves {
    /// The visibility of a light, past opaque and translucent casters.
    type Visibility: InShader<PointSlot>;

    /// The visibility of a light of the frame.
    fn visibility<E: Encode>(
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
    ) -> Result<Self::Visibility, MethodError>;
}

impl CurvesInShaders for NoCurves {
    type Visibility = Arc<ShadowMap<GpuMemory>>;

    fn visibility<E: Encode>(
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
    ) -> Result<Self::Visibility, MethodError> {
        frame.shadow_map(light)
    }
}

impl<A, T> CurvesInShaders for OfSize<A, T>
where
    A: WgslRule + Default + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + WgslStored + fmt::Debug,
{
    type Visibility = Both<Arc<ShadowMap<GpuMemory>>, Arc<TransmittanceMap<GpuMemory, T>>>;

    fn visibility<E: Encode>(
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
    ) -> Result<Self::Visibility, MethodError> {
        let curves = Self::in_shaders(frame, light, Panes::InMap)?;
        Ok(Both(frame.shadow_map(light)?, curves))
    }
}

impl<A, T> OfSize<A, T>
where
    A: WgslRule + Default + Clone + Sync + 'static,
    A::Curve: Into<T>,
    T: Evaluate + WgslStored + fmt::Debug,
{
    /// The map of a light, for shaders.
    fn in_shaders<E: Encode>(
        frame: &Frame<'_, Gpu<E>>,
        light: usize,
        panes: Panes,
    ) -> Result<Arc<TransmittanceMap<GpuMemory, T>>, MethodError> {
        let inputs = &frame.inputs;
        let key = key::<A>(inputs, light, panes);
        frame
            .store
            .get("map of transmittance", key, TransmittanceMap::bytes, || {
                let whose = (&casters(inputs, panes), light, key.2);
                made(frame, whose, &A::default(), || {
                    Self::on_host(inputs, light, panes)
                })
            })
    }
}

fn uploaded<E: Encode>(frame: &Frame<'_, Gpu<E>>) -> Result<Arc<UploadedMedia>, MethodError> {
    frame.store.get("media", OfScene, UploadedMedia::bytes, || {
        UploadedMedia::new(frame.backend, &frame.inputs.media())
            .map_err(MethodError::resource("what fills the air"))
    })
}

impl<C: CurvesInShaders, E: Encode> RunOn<Gpu<E>> for Gathered<C> {
    fn prepare(&self, frame: &Frame<'_, Gpu<E>>, steps: u32) -> Result<(), MethodError> {
        Self::check(steps)?;
        uploaded(frame)?;
        (0..frame.inputs.emitters.len()).try_for_each(|light| {
            frame.inputs.go_on(light)?;
            C::visibility(frame, light).map(|_| ())
        })
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        steps: u32,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), MethodError> {
        Self::check(steps)?;
        let inputs = &frame.inputs;
        let media = uploaded(frame)?;
        let panes = inputs.panes()?;
        for (light, emitter) in inputs.emitters.iter().enumerate() {
            inputs.go_on(light)?;
            let visibility = C::visibility(frame, light)?;
            let lit = MediaRays {
                rays: &frame.rays,
                emitter,
                media: &*media,
                steps,
                panes: panes.as_ref(),
                watch: inputs.watch,
            };
            frame.pass("gather through media", || {
                Ok(frame.backend.gather_media(&lit, &visibility, radiance)?)
            })?;
        }
        Ok(())
    }
}

impl<E: Encode, const N: usize> RunOn<Gpu<E>> for ExactTriangles<N> {
    fn prepare(&self, frame: &Frame<'_, Gpu<E>>, steps: u32) -> Result<(), MethodError> {
        check(steps, STEPS)?;
        uploaded(frame)?;
        frame.inputs.tracer()?;
        (0..frame.inputs.emitters.len()).try_for_each(|light| {
            frame.inputs.go_on(light)?;
            ByArea::<N>::in_shaders(frame, light, Panes::Apart).map(|_| ())
        })
    }

    /// The CPU finds the lit parts, and shaders do the rest.
    fn add_radiance(
        &self,
        frame: &Frame<'_, Gpu<E>>,
        steps: u32,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), MethodError> {
        check(steps, STEPS)?;
        let inputs = &frame.inputs;
        let media = uploaded(frame)?;
        let panes = inputs.panes()?;
        let exact = Exact::new(inputs.tracer()?);
        let most = frame
            .backend
            .context()
            .limits()
            .max_storage_buffer_binding_size;
        for (light, emitter) in inputs.emitters.iter().enumerate() {
            inputs.go_on(light)?;
            let curves = ByArea::<N>::in_shaders(frame, light, Panes::Apart)?;
            let seen = frame.pass("lit parts", || {
                let lit = (inputs.rays, emitter);
                Ok(EyePanes::lit(
                    &Cpu::new(),
                    panes.as_ref(),
                    lit,
                    &exact,
                    most,
                )?)
            })?;
            let lit = MediaRays {
                rays: &frame.rays,
                emitter,
                media: &*media,
                steps,
                panes: Some(&seen),
                watch: inputs.watch,
            };
            frame.pass("gather through media", || {
                Ok(frame.backend.gather_media(&lit, &curves, radiance)?)
            })?;
        }
        Ok(())
    }
}
