//! Pictures from the samples of lines on a GPU.

use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Buffer, Error};

use super::choice::Choice;
use super::fill::{FillFromLines, check};

/// Invocations per workgroup in `fill.wgsl`.
const GROUP: u32 = 64;

/// The shader.
pub(super) const FILL: [&str; 2] = [INDEX_WGSL, include_str!("fill.wgsl")];

impl<E: Encode> FillFromLines for Gpu<E> {
    fn fill_from_lines(
        &self,
        choice: &Choice,
        gathered: &GpuBuffer<[f32; 4]>,
        radiance: &mut GpuBuffer<[f32; 4]>,
    ) -> Result<(), Error> {
        check(choice, gathered.len(), radiance.len())?;
        let mixtures = self.upload(&choice.mixtures)?;
        let pixels = radiance.len();
        self.dispatch(
            &Kernel {
                label: "fill from lines",
                parts: &FILL,
                entry: "fill_from_lines",
                constants: &[],
            },
            &[&[
                Argument::read(&mixtures),
                Argument::read(gathered),
                Argument::write(radiance),
            ]],
            Workgroups::covering(pixels, GROUP),
        )
    }
}
