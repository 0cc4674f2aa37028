//! Slices through the shadow map of every light.

use std::sync::Arc;

use glam::Vec3;
use gpu_backend::Cpu;

use super::Slices;
use crate::airlight::far_end;
use crate::methods::march::STEPS;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, Role, SourceAbout, SourceOn,
    SourceQuality, Work,
};
use crate::shadow_map::{RenderShadowMap, ShadowMap};
use crate::{LightPath, Touching};

/// Slices of every light's shadow map.
#[derive(Debug, Clone, Copy)]
struct OfMaps;

fn forward(inputs: &FrameInputs<'_>) -> Vec3 {
    inputs.camera.rotation() * Vec3::NEG_Z
}

/// The depths in front of the eye between which a light reaches what the eye sees through the
/// fog.
fn depths(inputs: &FrameInputs<'_>, light: usize) -> [f32; 2] {
    let (forward, fog) = (forward(inputs), far_end(inputs.medium));
    let of_rays = Cpu::new().map(inputs.rays.len(), |i| {
        let path = LightPath::new(&inputs.rays[i], &inputs.emitters[light], inputs.medium)?;
        let (span, cos) = (path.span(), path.ray().direction().dot(forward));
        Some([span.start, span.end.min(span.start + fog)].map(|x| x * cos))
    });
    let all = of_rays.into_iter().flatten();
    let [near, far] = all.fold([f32::INFINITY, 0.0], |[near, far], [start, end]| {
        [start.min(near), end.max(far)]
    });
    [near.min(far), far]
}

impl LightSources for OfMaps {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: "slices",
            title: "slices",
            quality: Some(SourceQuality {
                unit: "slices",
                ..STEPS
            }),
            touching: Touching::Apart,
            is_sampled: true,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, slices: u32) -> Work {
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(slices),
            ..inputs.map_work()
        }
    }
}

impl<B: RenderShadowMap> SourceOn<B> for OfMaps {
    type Source = Slices<Arc<ShadowMap<B::Memory>>>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, _: u32) -> Result<(), MethodError> {
        frame.shadow_map(light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        slices: u32,
    ) -> Result<Self::Source, MethodError> {
        let (map, inputs) = (frame.shadow_map(light)?, &frame.inputs);
        Ok(Slices::new(
            map,
            slices,
            forward(inputs),
            depths(inputs, light),
        ))
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    pairs!(
        OfMaps,
        &[Compared {
            airlight: "midpoint",
            detail: Some(1),
            title: "slices",
            purpose: "what marches replaced: planes that are blended into the picture",
            paper: "Dobashi et al., Graphics Hardware 2002; Mitchell, ShaderX3, 2004",
            qualities: (&[16, 64, 256], &[32], 64),
            role: Role::Variant,
            is_baseline: false,
        }]
    )
}
