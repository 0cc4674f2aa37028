//! Textured spotlights in shaders.

use std::borrow::Borrow;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;

use super::cookie::{Level, MOST_LEVELS};
#[cfg(test)]
use super::lattice;
use super::lattice::{Placement, Steps};
use super::{Outside, ShadowSpans, Textured};
use crate::Emitter;
use crate::gpu::{PointSlot, Shadows, VisibilitySlot};
use crate::methods::hybrid::gpu::{HybridRecord, SEARCH, STORED_SHADOW};
use crate::shadow_map::ShadowMap;

/// `light_Steps` of `lattice.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct StepsRecord {
    pub(crate) axis: Vec3,
    pub(crate) placement: u32,
    pub(crate) count: f32,
    pub(crate) turn: f32,
    pub(crate) length: f32,
    pub(crate) stretch: f32,
}

impl StepsRecord {
    fn new(steps: &Steps) -> Self {
        let count = steps.count as f32;
        let (placement, length) = match steps.placement {
            Placement::Angle => (0, 0.0),
            Placement::Length { reach } => (1, reach / count),
            Placement::Span => (2, 0.0),
        };
        Self {
            axis: steps.axis.as_vec3(),
            placement,
            count,
            turn: steps.turn as f32,
            length,
            stretch: steps.stretch as f32,
        }
    }
}

/// `light_Textured` of `textured.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct TexturedRecord {
    pub(crate) axis: Vec3,
    pub(crate) outer_versine: f32,
    pub(crate) right: Vec3,
    pub(crate) rim: f32,
    pub(crate) up: Vec3,
    pub(crate) tan_outer: f32,
    pub(crate) range: f32,
    pub(crate) fades: u32,
    pub(crate) is_spot: u32,
    pub(crate) is_open: u32,
    pub(crate) finer: f32,
    pub(crate) level_count: u32,
    pub(crate) padding: [u32; 2],
    pub(crate) steps: StepsRecord,
    pub(crate) levels: [[u32; 4]; MOST_LEVELS],
}

/// The constants of the shaders, as the CPU has them.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f64); 5] = [
    ("light_steps_THROUGH", lattice::THROUGH),
    ("light_steps_AT_THE_LIGHT", lattice::AT_THE_LIGHT),
    ("light_steps_LEAST_STEP", lattice::LEAST_STEP),
    ("light_steps_MOST_BEAMS", lattice::MOST_BEAMS),
    ("light_spans_HALVINGS", super::spans::HALVINGS as f64),
];

impl<V> Textured<V, GpuMemory> {
    fn record(&self) -> TexturedRecord {
        let mut record = TexturedRecord {
            steps: StepsRecord::new(&self.steps),
            finer: self.finer,
            is_open: u32::from(self.outside == Outside::Lit),
            ..TexturedRecord::zeroed()
        };
        if let (Emitter::Point(point), Some(spot)) = (&self.light, self.light.spot()) {
            record.is_spot = 1;
            record.axis = spot.axis();
            record.right = spot.rotation() * Vec3::X;
            record.up = spot.rotation() * Vec3::Y;
            record.outer_versine = spot.outer_versine();
            record.rim = spot.rim();
            record.tan_outer = spot.tan_outer().min(f32::MAX);
            record.range = point.range().min(f32::MAX);
            record.fades = u32::from(point.fades());
        }
        if let Some(cookie) = &self.cookie {
            record.level_count = cookie.levels() as u32;
            for (slot, level) in record.levels.iter_mut().zip(cookie.all_levels()) {
                let Level {
                    width,
                    height,
                    first,
                } = *level;
                *slot = [width, height, first, 0];
            }
        }
        record
    }
}

impl<V: InShader<VisibilitySlot>> InShader<VisibilitySlot> for Textured<V, GpuMemory> {
    fn part() -> Part {
        let shadows = V::part();
        Part::new("light_textured")
            .glue::<Shadows>(&shadows)
            .with(shadows)
            .uniform("light_textured", "light_Textured")
            .read("light_textured_texels", "array<f32>")
            .source(include_str!("lattice.wgsl"))
            .source(include_str!("textured.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.shadows.constants()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.shadows.arguments();
        arguments.push(Argument::uniform(self.record()));
        arguments.push(match &self.cookie {
            Some(cookie) => Argument::read(cookie.texels()),
            None => Argument::table::<f32>(&[]),
        });
        arguments
    }
}

impl<P: Borrow<ShadowMap<GpuMemory>>> InShader<VisibilitySlot> for ShadowSpans<P, GpuMemory> {
    fn part() -> Part {
        let points = <ShadowMap<GpuMemory> as InShader<PointSlot>>::part();
        Part::new("light_spans")
            .glue::<PointSlot>(&points)
            .with(points)
            // The search for volumes.
            .uniform("light_hybrid", "light_Hybrid")
            .read("light_hybrid_near", "array<f32>")
            .source(STORED_SHADOW)
            .source(SEARCH)
            .uniform("light_spans", "light_Steps")
            .source(include_str!("lattice.wgsl"))
            .source(include_str!("spans.wgsl"))
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        InShader::<PointSlot>::constants(self.map())
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = InShader::<PointSlot>::arguments(self.map());
        let volumes = self.volumes();
        arguments.push(Argument::uniform(HybridRecord {
            steps: self.steps().count,
            cell: volumes.map_or(0, |volumes| volumes.cell()),
            side: volumes.map_or(0, |volumes| volumes.cells_per_side()),
            has_shadow: u32::from(volumes.is_some()),
            ..HybridRecord::zeroed()
        }));
        arguments.push(match volumes {
            Some(volumes) => Argument::read(volumes.near()),
            None => Argument::table::<f32>(&[]),
        });
        arguments.push(Argument::uniform(StepsRecord::new(self.steps())));
        arguments
    }
}
