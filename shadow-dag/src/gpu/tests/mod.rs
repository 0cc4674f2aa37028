//! Shaders without a device, and steps against the CPU with one.

mod agreement;
mod peel;
mod rays_agree;
mod space;

use gpu_backend::assert_same_layout;
use gpu_backend::testing::Shader;

use super::peel::{PEEL, PeelParameters, TriangleRecord, number_of};
use super::query::{QueryParameters, RayParameters, query, rays};
use super::*;
use crate::mesh::Kind;
use crate::pool::{LIT, SHADOWED};
use crate::{Form, RayRecord};

const WORD: &str = "fn dag_word(index: u32) -> u32 { return index; }";

#[test]
fn parts_are_fit_for_other_shaders() {
    for nodes in [PLAIN, PACKED] {
        for parts in [
            &[POINT, nodes, WORD][..],
            &[POINT, nodes, EXTENT, WORD],
            &[POINT, nodes, SPACE, RAY, WORD],
            &[POINT, nodes, EXTENT, SPACE, RAY, WORD],
            &[SPACE],
        ] {
            let shader = Shader::new(parts).unwrap();
            shader.require_part(&["dag_"]).unwrap();
        }
    }
}

#[test]
fn structures_and_constants_are_those_of_rust() {
    for form in [Form::Plain, Form::Packed] {
        let shader = Shader::new(&query(form)).unwrap();
        assert_same_layout!(
            shader,
            "dag_Shadows",
            DagRecord {
                log2,
                root,
                top,
                cells,
                masks,
                levels,
                slice_shapes,
                node_shapes
            }
        );
        assert_same_layout!(
            shader,
            "Parameters",
            QueryParameters {
                dag,
                count,
                width,
                padding_a,
                padding_b
            }
        );
        let value = |name: &str| shader.values(name).unwrap();
        assert_eq!(value("dag_LIT"), [f64::from(LIT)]);
        assert_eq!(value("dag_SHADOWED"), [f64::from(SHADOWED)]);

        let shader = Shader::new(&rays(form)).unwrap();
        assert_same_layout!(
            shader,
            "dag_Space",
            SpaceRecord {
                x,
                y,
                depth,
                w,
                side,
                stretch,
                near,
                padding
            }
        );
        assert_same_layout!(
            shader,
            "Parameters",
            RayParameters {
                dag,
                space,
                count,
                places,
                padding_a,
                padding_b
            }
        );
        assert_same_layout!(
            shader,
            "Ray",
            RayRecord {
                origin,
                length,
                direction,
                padding
            }
        );
    }
    let shader = Shader::new(&PEEL).unwrap();
    assert_same_layout!(
        shader,
        "Parameters",
        PeelParameters {
            first,
            step,
            side,
            block,
            slices,
            near,
            stretch
        }
    );
    assert_same_layout!(
        shader,
        "Triangle",
        TriangleRecord {
            a,
            b,
            c,
            kind,
            nearer,
            depth,
            deeper_b,
            deeper_c,
            inverse_area,
            least,
            most,
            padding_a,
            padding_b
        }
    );
    let value = |name: &str| shader.values(name).unwrap();
    let kinds = [Kind::Front, Kind::Open, Kind::Back].map(number_of);
    for (name, number) in ["FRONT", "OPEN", "BACK"].into_iter().zip(kinds) {
        assert_eq!(value(name), [f64::from(number)]);
    }
}
