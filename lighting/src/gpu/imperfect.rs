//! Imperfect shadow maps on a GPU.

use bytemuck::{Pod, Zeroable};
use gpu_backend::Backend;
use gpu_backend::gpu::{Argument, Encode, Gpu, GpuMemory, INDEX_WGSL, Kernel, Workgroups};

use super::scene::FaceRecord;
use super::{FACE, OCTAHEDRON, PLACE};
use crate::Emitter;
use crate::shadow_map::{
    CasterPoints, Layout, LevelOfDetail, MOST_TEXELS, RenderImperfectMaps, ShadowMapAtlas,
    ShadowMapError, check_size, place, splat_scale,
};

/// Invocations per workgroup of `imperfect.wgsl`.
const GROUP: u32 = 64;

pub(super) const SPLAT: [&str; 5] = [
    INDEX_WGSL,
    FACE,
    PLACE,
    OCTAHEDRON,
    include_str!("imperfect.wgsl"),
];

/// `Splats` of `imperfect.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Splats {
    pub(super) resolution: u32,
    pub(super) lights: u32,
    pub(super) clusters: u32,
    pub(super) most_texels: f32,
}

/// `Picture` of `imperfect.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Picture {
    pub(super) face: FaceRecord,
    pub(super) scale: [f32; 2],
    pub(super) kind: u32,
    pub(super) padding: u32,
}

impl<E: Encode> RenderImperfectMaps for Gpu<E> {
    /// What each light takes is decided on the CPU, as it is there: about a
    /// microsecond for each cluster of each light.
    fn imperfect_maps(
        &self,
        casters: &CasterPoints<GpuMemory>,
        emitters: &[Emitter],
        resolution: u32,
        points: u32,
        level: LevelOfDetail,
    ) -> Result<ShadowMapAtlas<GpuMemory>, ShadowMapError> {
        check_size(emitters.len(), resolution)?;
        let layout = Layout::imperfect(casters.bounds(), emitters);
        let texels = emitters.len() * (resolution as usize).pow(2);
        let mut depth = self.zeros::<f32>(texels)?;
        let pictures: Vec<_> = (layout.faces.iter().zip(&layout.lights))
            .map(|((face, _), [_, kind])| Picture {
                face: FaceRecord::new(face),
                scale: splat_scale(face, *kind, resolution),
                kind: *kind,
                padding: 0,
            })
            .collect();
        let clusters: Vec<u32> = casters.clusters().iter().map(|c| c.first).collect();
        let taken: Vec<_> = (emitters.iter())
            .flat_map(|emitter| casters.taken(place(emitter), points, level))
            .collect();
        let splats = Splats {
            resolution,
            // More than that are refused with their pictures.
            lights: emitters.len() as u32,
            clusters: clusters.len() as u32,
            most_texels: MOST_TEXELS,
        };
        for (entry, items) in [("clear", texels), ("splat", taken.len())] {
            self.dispatch(
                &Kernel {
                    label: "imperfect shadow maps",
                    parts: &SPLAT,
                    entry,
                    constants: &[],
                },
                &[&[
                    Argument::uniform(splats),
                    Argument::table(&pictures),
                    Argument::table(&clusters),
                    Argument::table(&taken),
                    Argument::read(casters.points()),
                    Argument::write(&mut depth),
                ]],
                Workgroups::covering(items, GROUP),
            )?;
        }
        Ok(ShadowMapAtlas::from_depth(layout, resolution, depth))
    }
}
