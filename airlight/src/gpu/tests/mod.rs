//! Shaders without a device, and evaluators against the CPU with one.

mod agreement;
mod nodes;
mod sun_table;
mod surface;

use gpu_backend::assert_same_layout;
use gpu_backend::testing::Shader;

use super::batch::{self, Batch};
use super::*;
use crate::quadrature::profile;
use crate::{Framed, Quadrature, Segment, SunTable, Table};

/// Stand for the bindings.
const TABLE_DATA: &str = "
    fn air_table_uniforms() -> air_Table { return air_Table(); }
    fn air_table_cell(index: u32) -> vec4<u32> { return vec4(index); }";
const QUADRATURE_DATA: &str = "
    fn air_quadrature_uniforms() -> air_Quadrature { return air_Quadrature(); }
    fn air_quadrature_entry(index: u32) -> vec4<f32> { return vec4(f32(index)); }";
const SUN_TABLE_DATA: &str = "
    fn air_sun_table_rows() -> f32 { return 1.0; }
    fn air_sun_table_value(index: u32) -> f32 { return f32(index); }";
const FRAME_TABLE_DATA: &str = "
    fn air_frame_cell(index: u32) -> vec4<f32> { return vec4(f32(index)); }";

#[test]
fn all_parts_are_fit_for_other_shaders() {
    let shared = [SEGMENT, NUMERIC];
    let table = [SCALED, TABLE, TABLE_DATA];
    let quadrature = [SCALED, PHASE, NODES, QUADRATURE, QUADRATURE_DATA];
    let nodes = [SCALED, NODES, QUADRATURE_DATA];
    let sun_table = [SUN_TABLE, SUN_TABLE_DATA];
    let frame_table = [FRAME_TABLE, FRAME_TABLE_DATA];
    let all = [
        SCALED,
        PHASE,
        TABLE,
        NODES,
        QUADRATURE,
        SUN_TABLE,
        FRAME_TABLE,
    ];
    let data = [
        TABLE_DATA,
        QUADRATURE_DATA,
        SUN_TABLE_DATA,
        FRAME_TABLE_DATA,
    ];
    for parts in [
        &table[..],
        &quadrature,
        &nodes,
        &sun_table,
        &frame_table,
        &[all.as_slice(), &data].concat(),
    ] {
        let shader = Shader::new(&[&shared, parts].concat()).unwrap();
        shader.require_part(&["air_"]).unwrap();
    }
}

#[test]
fn structures_and_constants_are_those_of_rust() {
    let shader = Shader::new(&batch::shader::<Table>().unwrap().finish(1)).unwrap();
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
            near_nodes
        }
    );
    assert_eq!(shader.values("air_FAR").unwrap(), [f64::from(f32::MAX)]);

    let shader = Shader::new(&batch::shader::<Quadrature>().unwrap().finish(1)).unwrap();
    assert_same_layout!(
        shader,
        "air_Quadrature",
        QuadratureUniforms {
            phase_parameters,
            phase_kind,
            rules,
            opacity,
            far,
            finest_front,
            finest_behind,
            thin,
            growth,
            fade,
            plain_rules,
            tolerance,
            padding
        }
    );
    for (name, value) in [
        ("air_EXTRA_COSINE", profile::COSINE as f64),
        ("air_EXTRA_SPOT", profile::SPOT as f64),
        ("air_EXTRA_FADING", profile::FADING as f64),
        ("air_DEEPER", profile::DEEPER),
        ("air_UNFADED", f64::from(profile::UNFADED as f32)),
    ] {
        assert_eq!(shader.values(name).unwrap(), [value], "{name}");
    }

    let shader = Shader::new(&batch::shader::<Framed<Quadrature>>().unwrap().finish(1)).unwrap();
    assert_same_layout!(
        shader,
        "air_FrameTable",
        FrameTableRecord {
            distance,
            transmittance,
            sigma_t,
            rows,
            cells,
            first,
            padding_a,
            padding_b
        }
    );

    let shader = Shader::new(&batch::shader::<SunTable>().unwrap().finish(1)).unwrap();
    let side = shader.values("air_SUN_TABLE_SIDE").unwrap();
    let entries = SunTable::new().gpu_values().len();
    assert_eq!(side[0] * side[0], entries as f64);
}
