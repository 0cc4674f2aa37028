//! Shaders without a device, and evaluators against the CPU with one.

mod agreement;

use gpu_backend::assert_same_layout;
use gpu_backend::testing::Shader;

use super::batch::{Batch, parts};
use super::*;
use crate::{Segment, Table};

/// Stand for the bindings.
const TABLE_DATA: &str = "
    fn air_table_uniforms() -> air_Table { return air_Table(); }
    fn air_table_cell(index: u32) -> vec4<u32> { return vec4(index); }";

#[test]
fn all_parts_are_fit_for_other_shaders() {
    let shader = Shader::new(&[SEGMENT, NUMERIC, SCALED, TABLE, TABLE_DATA]).unwrap();
    shader.require_part(&["air_"]).unwrap();
}

#[test]
fn structures_and_constants_are_those_of_rust() {
    let shader = Shader::new(&parts::<Table>()).unwrap();
    assert_same_layout!(shader, "air_Segment", Segment { x, s, h, length });
    assert_same_layout!(
        shader,
        "Batch",
        Batch {
            sigma_t,
            segments,
            padding_a,
            padding_b
        }
    );
    assert_same_layout!(
        shader,
        "air_Table",
        TableUniforms {
            slope,
            units,
            offset,
            steps,
            radial,
            rows_front,
            rows,
            nodes,
            is_constant,
            constant,
            padding
        }
    );
    assert_eq!(shader.values("air_FAR").unwrap(), [f64::from(f32::MAX)]);
}
