//! Shadow maps in shaders.

use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;
#[cfg(feature = "voxel-shadow")]
use voxel_shadow::gpu::{FirstBlockerSlot, HolesSlot};

#[cfg(feature = "voxel-shadow")]
use super::MASK;
use super::scene::PicturesRecord;
use super::{FACE, MAP, PLACE, PointSlot};
#[cfg(feature = "voxel-shadow")]
use crate::shadow_map::Casters;
use crate::shadow_map::ShadowMap;

/// The text and the variables of a shadow map.
fn map_part() -> Part {
    Part::new("light_map")
        .sources(&[FACE, PLACE, MAP])
        .uniform("light_map", "light_Pictures")
        .read("light_map_depths", "array<f32>")
}

fn map_arguments(map: &ShadowMap<GpuMemory>) -> Vec<Argument<'_>> {
    vec![
        Argument::uniform(PicturesRecord::new(map.faces(), map.resolution())),
        Argument::read(map.depth()),
    ]
}

impl InShader<PointSlot> for ShadowMap<GpuMemory> {
    fn part() -> Part {
        map_part()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        map_arguments(self)
    }
}

#[cfg(feature = "voxel-shadow")]
impl InShader<FirstBlockerSlot> for ShadowMap<GpuMemory> {
    fn part() -> Part {
        map_part()
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        map_arguments(self)
    }
}

/// The masks of the triangles that shadow maps are rendered from.
#[cfg(feature = "voxel-shadow")]
impl InShader<HolesSlot> for Casters<GpuMemory> {
    fn part() -> Part {
        Part::new("light_casters")
            .source(MASK)
            .uniform("light_solid_casters", "u32")
            .read("light_masks", "array<light_Mask>")
            .read("light_mask_opacities", "array<f32>")
            .source(include_str!("casters.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.solid() as u32),
            Argument::read(&self.masks().records),
            Argument::read(&self.masks().opacities),
        ]
    }
}
