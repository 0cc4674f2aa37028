//! The contents of a table for shaders.

use super::{SIDE, SunTable};

impl SunTable {
    /// What `air_sun_table_rows` returns in a shader with the part
    /// [`SUN_TABLE`](crate::gpu::SUN_TABLE): rows per mean free path. At most
    /// 1e30, so that a thousand times as much is a number.
    pub fn gpu_rows(&self) -> f32 {
        ((SIDE - 1) as f32 / self.largest).min(1e30)
    }

    /// The array behind `air_sun_table_value`: rows of 512.
    pub fn gpu_values(&self) -> &[f32] {
        &self.values
    }
}
