//! Shaders without a device, and evaluators against the CPU with one.

mod agreement;
mod nodes;

use gpu_backend::assert_same_layout;
use gpu_backend::testing::Shader;

use super::batch::{Batch, parts};
use super::*;
use crate::{Quadrature, Segment, Table};

/// Stand for the bindings.
const TABLE_DATA: &str = "
    fn air_table_uniforms() -> air_Table { return air_Table(); }
    fn air_table_cell(index: u32) -> vec4<u32> { return vec4(index); }";
const QUADRATURE_DATA: &str = "
    fn air_quadrature_uniforms() -> air_Quadrature { return air_Quadrature(); }
    fn air_quadrature_entry(index: u32) -> vec4<f32> { return vec4(f32(index)); }";

#[test]
fn all_parts_are_fit_for_other_shaders() {
    let shared = [SEGMENT, NUMERIC];
    let table = [SCALED, TABLE, TABLE_DATA];
    let quadrature = [SCALED, PHASE, NODES, QUADRATURE, QUADRATURE_DATA];
    let nodes = [SCALED, NODES, QUADRATURE_DATA];
    let all = [SCALED, PHASE, TABLE, NODES, QUADRATURE];
    let data = [TABLE_DATA, QUADRATURE_DATA];
    for parts in [
        &table[..],
        &quadrature,
        &nodes,
        &[all.as_slice(), &data].concat(),
    ] {
        let shader = Shader::new(&[&shared, parts].concat()).unwrap();
        shader.require_part(&["air_"]).unwrap();
    }
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

    let shader = Shader::new(&parts::<Quadrature>()).unwrap();
    assert_same_layout!(
        shader,
        "air_Quadrature",
        QuadratureUniforms {
            phase_kind,
            phase_parameter,
            rules,
            opacity,
            far,
            finest_front,
            finest_behind,
            thin,
            growth,
            fade,
            padding_a,
            padding_b
        }
    );
}
