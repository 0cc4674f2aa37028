//! Taking pixels out of a picture and putting them back, on a GPU.

use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Buffer, Error};

use super::pick::{PickPixels, check};

/// The shader.
pub(super) const PICK: [&str; 2] = [INDEX_WGSL, include_str!("pick.wgsl")];

/// Invocations per workgroup of that shader.
const GROUP: u32 = 64;

fn run<E: Encode>(
    gpu: &Gpu<E>,
    entry: &'static str,
    which: &GpuBuffer<u32>,
    from: &GpuBuffer<[f32; 4]>,
    to: &mut GpuBuffer<[f32; 4]>,
) -> Result<(), Error> {
    let items = which.len();
    gpu.dispatch(
        &Kernel {
            label: entry,
            parts: &PICK,
            entry,
            constants: &[],
        },
        &[&[
            Argument::read(which),
            Argument::read(from),
            Argument::write(to),
        ]],
        Workgroups::covering(items, GROUP),
    )
}

impl<E: Encode> PickPixels for Gpu<E> {
    fn pick(
        &self,
        picture: &GpuBuffer<[f32; 4]>,
        which: &GpuBuffer<u32>,
    ) -> Result<GpuBuffer<[f32; 4]>, Error> {
        let mut pixels = self.zeros::<[f32; 4]>(which.len())?;
        run(self, "pick", which, picture, &mut pixels)?;
        Ok(pixels)
    }

    fn put_back(
        &self,
        pixels: &GpuBuffer<[f32; 4]>,
        which: &GpuBuffer<u32>,
        picture: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check(pixels.len(), which.len())?;
        run(self, "put_back", which, pixels, picture)
    }
}
