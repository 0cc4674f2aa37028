//! A march between shadow volumes in shaders.

use std::borrow::Borrow;

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;

use super::Hybrid;
#[cfg(test)]
use super::search;
use crate::gpu::{PointSlot, VisibilitySlot};
use crate::shadow_map::ShadowMap;

/// `light_Hybrid` of `hybrid.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct HybridRecord {
    pub(crate) steps: u32,
    pub(crate) cell: u32,
    pub(crate) side: u32,
    pub(crate) padding: u32,
}

/// The constants of `hybrid.wgsl`, as the CPU has them.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f64); 6] = [
    ("light_hybrid_PAST", search::PAST),
    ("light_hybrid_MOST_PICTURES", search::MOST_PICTURES as f64),
    ("light_hybrid_MOST_TURNS", search::MOST_TURNS as f64),
    ("light_hybrid_START", search::START as f64),
    ("light_hybrid_HALVINGS", super::HALVINGS as f64),
    ("light_hybrid_LEAP", super::asking::LEAP as f64),
];

impl<P: Borrow<ShadowMap<GpuMemory>>> InShader<VisibilitySlot> for Hybrid<P, GpuMemory> {
    fn part() -> Part {
        let points = <ShadowMap<GpuMemory> as InShader<PointSlot>>::part();
        Part::new("light_hybrid")
            .glue::<PointSlot>(&points)
            .with(points)
            .uniform("light_hybrid", "light_Hybrid")
            .read("light_hybrid_near", "array<f32>")
            .source(include_str!("hybrid.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        InShader::<PointSlot>::constants(self.map())
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = InShader::<PointSlot>::arguments(self.map());
        let volumes = self.volumes();
        arguments.push(Argument::uniform(HybridRecord {
            steps: self.steps(),
            cell: volumes.map_or(0, |volumes| volumes.cell()),
            side: volumes.map_or(0, |volumes| volumes.side()),
            padding: 0,
        }));
        arguments.push(match volumes {
            Some(volumes) => Argument::read(volumes.near()),
            None => Argument::table::<f32>(&[]),
        });
        arguments
    }
}
