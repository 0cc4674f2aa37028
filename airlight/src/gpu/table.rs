//! Tables as shaders take them.

use bytemuck::{Pod, Zeroable};

/// What `air_table_uniforms` returns, fit for a uniform buffer.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct TableUniforms {
    /// How rows lie in front of the foot point and behind it, two numbers each.
    pub slope: [f32; 4],
    /// Units of the coefficients of second order.
    pub units: [f32; 3],
    /// Where cells begin to widen along v.
    pub offset: f32,
    /// log2 of the cells per doubling along v.
    pub steps: u32,
    /// Cells along v.
    pub radial: u32,
    /// Rows in front of the foot point.
    pub rows_front: u32,
    /// All rows.
    pub rows: u32,
    /// Nodes for parts that are not looked up.
    pub nodes: u32,
    /// 1 for a constant phase function, else 0.
    pub is_constant: u32,
    /// The logarithm for base 2 of that.
    pub constant: f32,
    /// Nodes for parts that are short enough to need few.
    pub near_nodes: u32,
}

#[cfg(feature = "wgpu")]
mod step {
    use gpu_backend::gpu::{Argument, InShader};
    use gpu_backend::shader::Part;

    use crate::Table;
    use crate::gpu::{EvaluatorSlot, NUMERIC, SCALED, TABLE};

    impl InShader<EvaluatorSlot> for Table {
        fn part() -> Part {
            Part::new("air_table")
                .sources(&[NUMERIC, SCALED, TABLE, include_str!("table_bindings.wgsl")])
                .uniform("air_table", "air_Table")
                .read("air_cells", "array<vec4<u32>>")
        }

        fn arguments(&self) -> Vec<Argument<'_>> {
            vec![
                Argument::uniform(self.gpu_uniforms()),
                Argument::table(&self.gpu_cells()),
            ]
        }
    }
}
