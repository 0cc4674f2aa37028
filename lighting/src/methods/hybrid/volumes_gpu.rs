//! Shadow volumes made on a GPU.

use bytemuck::{Pod, Zeroable};
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};
use gpu_backend::{Backend, Buffer, Error};

use super::cells::{Cells, NOTHING};
use super::volumes::margin;
use super::{BuildShadowVolumes, ShadowVolumes};
use crate::Emitter;
use crate::gpu::scene::PicturesRecord;
use crate::gpu::{FACE, PLACE};
use crate::shadow_map::{Casters, faces};

/// `Near` of `near.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct NearRecord {
    pub(crate) pictures: PicturesRecord,
    pub(crate) cell: u32,
    pub(crate) side: u32,
    pub(crate) triangles: u32,
    pub(crate) level: u32,
    pub(crate) border: f32,
    pub(crate) factor: f32,
    pub(crate) less: f32,
    pub(crate) most: f32,
}

/// The shader that makes them.
pub(crate) const NEAR: [&str; 4] = [INDEX_WGSL, FACE, PLACE, include_str!("near.wgsl")];

/// Triangles of a workgroup that counts them.
const BATCH: u32 = 32;

/// The largest rounding error of a distance, relative to it: that of a position, as on the CPU,
/// and of a product with a root.
const DISTANCE: f32 = 6e-6;

impl<E: Encode> BuildShadowVolumes for Gpu<E> {
    fn shadow_volumes(
        &self,
        casters: &Casters<GpuMemory>,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<ShadowVolumes<GpuMemory>, Error> {
        let faces = faces(casters.bounds(), emitter);
        let cells = Cells::new(&faces, resolution);
        let triangles = casters.triangles().len();
        let border = cells.pictures.iter().map(|picture| picture.margin());
        let record = NearRecord {
            pictures: PicturesRecord::new(&faces, resolution),
            cell: cells.cell,
            side: cells.side,
            // A buffer with more corners than a u32 counts cannot be bound.
            triangles: triangles as u32,
            level: 0,
            border: border.fold(0.0, f64::max) as f32,
            factor: DISTANCE,
            less: margin(casters.bounds(), cells.origin) as f32,
            most: NOTHING,
        };
        let mut least: GpuBuffer<u32> = self.zeros(cells.finest())?;
        let mut near: GpuBuffer<f32> = self.zeros(cells.len())?;
        let mut run = |entry, level: u32, groups| {
            self.dispatch(
                &Kernel {
                    label: "shadow volumes",
                    parts: &NEAR,
                    entry,
                    constants: &[],
                },
                &[&[
                    Argument::uniform(NearRecord { level, ..record }),
                    Argument::read(casters.triangles()),
                    Argument::write(&mut least),
                    Argument::write(&mut near),
                ]],
                groups,
            )
        };
        let of_cells = Workgroups::covering(cells.finest(), 64);
        run("clear", 0, of_cells)?;
        let seen = triangles * faces.len();
        run("count", 0, Workgroups::covering(seen, BATCH))?;
        run("bound", 0, of_cells)?;
        for level in 1..=cells.top() {
            let width = (cells.side >> level) as usize;
            let coarser = Workgroups::covering(faces.len() * width * width, 64);
            run("lower", level, coarser)?;
        }
        Ok(ShadowVolumes { cells, near })
    }
}
