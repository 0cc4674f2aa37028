//! Tables of Sun et al. as shaders take them.

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::{EvaluatorSlot, NUMERIC, SUN_TABLE};
use crate::SunTable;

impl InShader<EvaluatorSlot> for SunTable {
    fn part() -> Part {
        Part::new("air_sun_table")
            .sources(&[NUMERIC, SUN_TABLE, include_str!("sun_table_bindings.wgsl")])
            .uniform("air_rows", "f32")
            .read("air_values", "array<f32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.gpu_rows()),
            Argument::table(self.gpu_values()),
        ]
    }
}
