//! The shadow maps of several lights on surfaces, in shaders.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{Argument, GpuMemory, InShader};
use gpu_backend::shader::Part;

use super::scene::PicturesRecord;
use super::{FACE, PLACE};
use crate::direct_light::ManySurfacesSlot;
use crate::shadow_map::FilteredMapsOfMany;

/// `light_MapOfMany` of `many_maps.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct MapRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) first: u32,
    pub(crate) bias: f32,
    pub(crate) padding_a: u32,
    pub(crate) padding_b: u32,
}

impl InShader<ManySurfacesSlot> for FilteredMapsOfMany<'_, GpuMemory> {
    fn part() -> Part {
        Part::new("light_many_maps")
            .sources(&[FACE, PLACE, include_str!("many_maps.wgsl")])
            .read("light_many_maps", "array<light_MapOfMany>")
            .read("light_many_maps_depths", "array<f32>")
            .uniform("light_many_maps_half", "u32")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let maps = self.maps();
        let records: Vec<_> = (maps.pictures())
            .map(|(faces, first, bias)| MapRecord {
                pictures: PicturesRecord::new(faces, maps.resolution()),
                first,
                bias,
                padding_a: 0,
                padding_b: 0,
            })
            .collect();
        vec![
            Argument::table(&records),
            Argument::read(maps.depth()),
            Argument::uniform(self.width() / 2),
        ]
    }
}
