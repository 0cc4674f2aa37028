//! Precomputed shadows of static casters, combined with shadow maps of dynamic ones.

use std::sync::Arc;

use gpu_backend::{Backend, Host, Memory};
#[cfg(feature = "wgpu")]
use gpu_backend::{
    Error,
    gpu::{Encode, Gpu, GpuBuffer, GpuMemory, InShader},
};

use super::BakedShadow;
#[cfg(feature = "wgpu")]
use crate::gpu::AirlightSlot;
use crate::methods::epipolar::{BuildLineTrees, BuildMapBlocks, MapBlocks, MapRuns};
use crate::methods::{Frame, FrameInputs, MethodError, OfDynamic, OfLight};
use crate::shadow_map::{RenderShadowMap, ShadowMap};
use crate::visibility::Both;
#[cfg(feature = "wgpu")]
use crate::{Gather, LitRays};
use crate::{LightPath, LitInterval, VisibilitySource};

/// The lit runs of the map of the dynamic casters.
type Runs<M> = MapRuns<Arc<ShadowMap<M>>, M>;

/// The shadows of a light: those of the static casters, and those of the dynamic ones if these
/// can shade anything that the light lights.
///
/// A light without such dynamic casters has the same source and shader as in a scene in which
/// nothing moves.
#[derive(Debug)]
pub(crate) enum BesideDynamic<M: Memory> {
    /// Shadows of static casters alone.
    Static(Arc<BakedShadow<M>>),
    /// Lit where both the bake and the map of the dynamic casters say so.
    Both(Box<Both<Arc<BakedShadow<M>>, Runs<M>>>),
}

impl<M: Memory> BesideDynamic<M> {
    /// The source of a light in a frame. The geometry of the frame says where the dynamic
    /// casters are.
    pub(super) fn new<B>(
        frame: &Frame<'_, B>,
        light: usize,
        baked: Arc<BakedShadow<M>>,
    ) -> Result<Self, MethodError>
    where
        B: RenderShadowMap + BuildMapBlocks + BuildLineTrees + Backend<Memory = M>,
    {
        let Some((map, blocks)) = mapped(frame, light)? else {
            return Ok(Self::Static(baked));
        };
        let FrameInputs {
            emitters,
            medium,
            rays,
            ..
        } = frame.inputs;
        let runs = frame.pass("line trees", || {
            let emitter = &emitters[light];
            Ok(MapRuns::with_blocks(
                frame.backend,
                map,
                &blocks,
                rays,
                emitter,
                medium,
            )?)
        })?;
        Ok(Self::Both(Box::new(Both(baked, runs))))
    }
}

/// A map with its blocks.
type Mapped<M> = (Arc<ShadowMap<M>>, Arc<MapBlocks<M>>);

/// The map of the dynamic casters that a light reaches, if it reaches any. The store keeps it.
pub(super) fn mapped<B: RenderShadowMap + BuildMapBlocks>(
    frame: &Frame<'_, B>,
    light: usize,
) -> Result<Option<Mapped<B::Memory>>, MethodError> {
    let Some(map) = frame.dynamic_map(light)? else {
        return Ok(None);
    };
    let resolution = frame.inputs.map;
    let key = OfDynamic(OfLight { light, resolution });
    let what = "blocks of the map of dynamic casters";
    let blocks = frame.store.get(what, key, MapBlocks::bytes, || {
        Ok(frame.backend.map_blocks(&map)?)
    })?;
    Ok(Some((map, blocks)))
}

impl VisibilitySource for BesideDynamic<Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        match self {
            Self::Static(baked) => baked.lit_intervals(path, lit),
            Self::Both(both) => both.lit_intervals(path, lit),
        }
    }
}

/// There is a shader for each of the two cases.
#[cfg(feature = "wgpu")]
impl<A: InShader<AirlightSlot>, E: Encode> Gather<BesideDynamic<GpuMemory>, A> for Gpu<E> {
    fn gather(
        &self,
        lit: &LitRays<'_, GpuMemory>,
        visibility: &BesideDynamic<GpuMemory>,
        airlight: &A,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        match visibility {
            BesideDynamic::Static(baked) => self.gather(lit, baked, airlight, radiance),
            BesideDynamic::Both(both) => self.gather(lit, &**both, airlight, radiance),
        }
    }
}
