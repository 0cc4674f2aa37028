//! The contents of a table for shaders.

use super::Table;
use crate::gpu::TableUniforms;

impl Table {
    /// What `air_table_uniforms` returns in a shader with the part
    /// [`TABLE`](crate::gpu::TABLE).
    pub fn gpu_uniforms(&self) -> TableUniforms {
        let axes = &self.axes;
        let [front, behind] = axes.slope;
        TableUniforms {
            slope: [front[0], front[1], behind[0], behind[1]],
            units: self.units,
            offset: axes.offset,
            steps: axes.steps,
            radial: axes.radial,
            rows_front: axes.rows[0],
            rows: axes.all_rows(),
            nodes: self.rule.len() as u32,
            is_constant: u32::from(self.constant.is_some()),
            constant: self.constant.unwrap_or(0.0),
            near_nodes: self.near_rule.len() as u32,
        }
    }

    /// The array behind `air_table_cell`: the bits of the cells, of the rows of
    /// the phase function if it is not constant, and of the nodes of both rules.
    ///
    /// A shader must take them as integers: not all of them are numbers.
    pub fn gpu_cells(&self) -> Vec<[u32; 4]> {
        let nodes = self.rule.iter().chain(&self.near_rule);
        let nodes = nodes.map(|&[t, weight]| [t, weight, 0.0, 0.0]);
        let entries = self.cells.iter().chain(&self.phase).copied().chain(nodes);
        entries.map(|entry| entry.map(f32::to_bits)).collect()
    }
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use crate::gpu::{NUMERIC, SCALED, SEGMENT, TABLE};
    use crate::table::{LARGEST_REST, near};

    #[test]
    fn shaders_integrate_the_parts_that_the_cpu_integrates() {
        const DATA: &str = "
            fn air_table_uniforms() -> air_Table { return air_Table(); }
            fn air_table_cell(index: u32) -> vec4<u32> { return vec4(index); }";
        let shader = Shader::new(&[SEGMENT, NUMERIC, SCALED, TABLE, DATA]).unwrap();
        for (name, value) in [
            ("air_TABLE_NEAR", near::NEAR),
            ("air_TABLE_THIN", near::THIN),
            ("air_TABLE_REST", LARGEST_REST),
        ] {
            assert_eq!(shader.values(name).unwrap(), [f64::from(value)], "{name}");
        }
    }
}
