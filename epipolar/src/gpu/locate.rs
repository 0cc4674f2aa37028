//! Points located on a GPU.

use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Buffer, Error};

use super::{EPIPOLAR, LatticeRecord, PHI};
use crate::locate::check_lengths;
use crate::{Lattice, Locate};

/// Uniforms of `locate.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Parameters {
    pub(super) lattice: LatticeRecord,
    pub(super) count: u32,
    padding: [u32; 3],
}

pub(super) const LOCATE: &[&str] = &[INDEX_WGSL, EPIPOLAR, PHI, include_str!("locate.wgsl")];

/// Invocations per workgroup in `locate.wgsl`.
const GROUP: u32 = 64;

impl<E: Encode> Locate for Gpu<E> {
    fn locate(
        &self,
        lattice: &Lattice,
        points: &GpuBuffer<[f32; 4]>,
        positions: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(points.len(), positions.len())?;
        let parameters = Parameters {
            lattice: LatticeRecord::new(lattice),
            // More are refused by the dispatch.
            count: points.len() as u32,
            padding: [0; 3],
        };
        self.dispatch(
            &Kernel {
                label: "locate",
                parts: LOCATE,
                entry: "locate",
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::table(lattice.bounds()),
                Argument::read(points),
                Argument::write(positions),
            ]],
            Workgroups::covering(points.len(), GROUP),
        )
    }
}
