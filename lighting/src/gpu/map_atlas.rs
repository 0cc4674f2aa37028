//! The shadow maps of many lights: how they are rendered, and in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuMemory, InShader};
use gpu_backend::shader::Part;
use voxel_shadow::gpu::AtlasBlockerSlot;

use super::scene::FaceRecord;
use super::{FACE, OCTAHEDRON, PLACE};
use crate::Emitter;
use crate::shadow_map::{
    Casters, Layout, RenderShadowMap, RenderShadowMapAtlas, ShadowMapAtlas, ShadowMapError,
    TileMaps, map_capacity,
};

/// `light_NO_PICTURE` of `map_atlas.wgsl`.
pub(super) const NO_PICTURE: u32 = u32::MAX;

/// `light_AtlasFace` of `map_atlas.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct AtlasFaceRecord {
    pub(super) face: FaceRecord,
    pub(super) picture: u32,
    padding: [u32; 3],
}

impl InShader<AtlasBlockerSlot> for TileMaps<'_, GpuMemory> {
    fn part() -> Part {
        Part::new("light_maps")
            .sources(&[FACE, PLACE, OCTAHEDRON, include_str!("map_atlas.wgsl")])
            .uniform("light_maps_side", "u32")
            .read("light_maps_faces", "array<light_AtlasFace>")
            .read("light_maps_tiles", "array<vec2<u32>>")
            .read("light_maps_depths", "array<f32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let layout = self.maps.layout();
        let faces: Vec<_> = (layout.faces.iter())
            .map(|(face, picture)| AtlasFaceRecord {
                face: FaceRecord::new(face),
                picture: picture.unwrap_or(NO_PICTURE),
                padding: [0; 3],
            })
            .collect();
        let tiles: Vec<[u32; 2]> = (self.lights.iter())
            .map(|light| layout.lights[*light as usize])
            .collect();
        vec![
            Argument::uniform(self.maps.resolution()),
            Argument::table(&faces),
            Argument::table(&tiles),
            Argument::read(self.maps.depth()),
        ]
    }
}

impl<E: Encode> RenderShadowMapAtlas for Gpu<E> {
    fn shadow_map_atlas(
        &self,
        casters: &Casters<GpuMemory>,
        emitters: &[Emitter],
        resolution: u32,
    ) -> Result<ShadowMapAtlas<GpuMemory>, ShadowMapError> {
        let layout = Layout::new(casters.bounds(), emitters);
        let depth = self.depths(casters, &layout.pictured(), resolution)?;
        Ok(ShadowMapAtlas::from_depth(layout, resolution, depth))
    }

    fn map_capacity(&self, resolution: u32) -> usize {
        let limits = self.context().limits();
        let bytes = limits.max_storage_buffer_binding_size;
        map_capacity(resolution, bytes.min(limits.max_buffer_size))
    }
}
