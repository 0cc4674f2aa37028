//! The contents of a table for shaders.

use super::FrameTable;
use crate::gpu::FrameTableRecord;

impl FrameTable {
    /// What `air_frame_look_up` is told in a shader with the part
    /// [`FRAME_TABLE`](crate::gpu::FRAME_TABLE); `first` is the index of the first of
    /// its cells.
    pub fn gpu_record(&self, first: u32) -> FrameTableRecord {
        FrameTableRecord {
            distance: self.distance,
            transmittance: self.transmittance,
            sigma_t: self.sigma_t,
            rows: self.rows,
            cells: self.cells_of_row,
            first,
            ..FrameTableRecord::default()
        }
    }

    /// The array behind `air_frame_cell`.
    pub fn gpu_cells(&self) -> &[[f32; 4]] {
        &self.cells
    }
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use crate::frame_table::{ELSEWHERE, LEAST};
    use crate::gpu::{FRAME_TABLE, SEGMENT};

    #[test]
    fn shaders_refuse_what_the_cpu_refuses() {
        const DATA: &str = "fn air_frame_cell(index: u32) -> vec4<f32> { return vec4(0.0); }";
        let shader = Shader::new(&[SEGMENT, FRAME_TABLE, DATA]).unwrap();
        for (name, value) in [
            ("air_FRAME_LEAST", LEAST),
            ("air_FRAME_ELSEWHERE", ELSEWHERE),
        ] {
            assert_eq!(shader.values(name).unwrap(), [f64::from(value)], "{name}");
        }
    }
}
