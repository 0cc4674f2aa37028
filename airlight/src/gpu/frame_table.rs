//! Tables of a frame as shaders take them.

use bytemuck::{Pod, Zeroable};

/// `air_FrameTable`: one table, whose cells may lie behind those of others.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct FrameTableRecord {
    /// Between eye and light, m; a table of distance 0 knows nothing.
    pub distance: f32,
    /// `e^{−σ_t D}`.
    pub transmittance: f32,
    /// The extinction that it is for, 1/m.
    pub sigma_t: f32,
    /// Rows of each sheet.
    pub rows: u32,
    /// Cells of a row.
    pub cells: u32,
    /// Index of its first cell.
    pub first: u32,
    /// Not read.
    pub padding_a: u32,
    /// Not read.
    pub padding_b: u32,
}

#[cfg(feature = "wgpu")]
mod step {
    use gpu_backend::gpu::{Argument, InShader};
    use gpu_backend::shader::Part;

    use crate::gpu::{EvaluatorSlot, FRAME_TABLE};
    use crate::{Framed, Quadrature};

    impl InShader<EvaluatorSlot> for Framed<Quadrature> {
        fn part() -> Part {
            Part::new("air_framed")
                .with(Quadrature::part())
                .sources(&[FRAME_TABLE, include_str!("framed.wgsl")])
                .uniform("air_frame", "air_FrameTable")
                .read("air_frame_cells", "array<vec4<f32>>")
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            let mut arguments = self.fallback().arguments();
            arguments.push(Argument::uniform(self.table().gpu_record(0)));
            arguments.push(Argument::table(self.table().gpu_cells()));
            arguments
        }
    }
}
