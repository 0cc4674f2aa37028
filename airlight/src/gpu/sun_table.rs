//! Tables of Sun et al. as shaders take them.

use gpu_backend::gpu::Argument;

use super::{NUMERIC, SUN_TABLE, WgslEvaluator};
use crate::SunTable;

impl WgslEvaluator for SunTable {
    fn parts() -> &'static [&'static str] {
        &[NUMERIC, SUN_TABLE, include_str!("sun_table_bindings.wgsl")]
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.gpu_rows()),
            Argument::table(self.gpu_values()),
        ]
    }
}
