//! From the world to the grid in shaders.

use glam::{Vec3, Vec4};
use gpu_backend::gpu::{Argument, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Download, testing};
use proptest::prelude::*;
use reference::tolerances::Allowed;

use super::super::{SPACE, SpaceRecord};
use super::rays_agree::delta;
use crate::tests::light_spaces;
use crate::{FilterSize, Ray, Resolution};

const ENTRY: &str = "
    struct Parameters { space: dag_Space, count: u32, width: u32, padding_a: u32, padding_b: u32 }
    @group(0) @binding(0) var<uniform> parameters: Parameters;
    @group(0) @binding(1) var<storage> surfaces: array<array<vec4<f32>, 2>>;
    @group(0) @binding(2) var<storage, read_write> places: array<array<vec4<f32>, 3>>;

    @compute @workgroup_size(64)
    fn place(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i >= parameters.count { return; }
        let h = dag_homogeneous(parameters.space, vec4(surfaces[i][0].xyz, 1.0));
        let normal = dag_normal(parameters.space, h, surfaces[i][1].xyz);
        var position = vec3(0.0);
        if h.w > 0.0 { position = dag_position(parameters.space, h); }
        let biased = dag_bias(position, normal, parameters.width);
        places[i] = array(vec4(position, h.w), vec4(normal, 0.0), vec4(vec3<f32>(biased), 0.0));
    }";

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Parameters {
    space: SpaceRecord,
    count: u32,
    width: u32,
    padding: [u32; 2],
}

proptest! {
    #![proptest_config(reference::property::cases(16))]

    #[test]
    fn surfaces_are_where_they_are_on_the_cpu(
        surfaces in proptest::collection::vec(
            ((-0.4_f32..1.4, -0.4_f32..1.4, -0.4_f32..1.4), (-1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0)),
            1..200,
        ),
    ) {
        let Some(gpu) = testing::gpu() else { return Ok(()) };
        let resolution = Resolution::new(1024).unwrap();
        let side = f64::from(resolution.side());
        let size = FilterSize::new(9).unwrap();
        let records: Vec<[Vec4; 2]> = surfaces
            .iter()
            .map(|&(point, normal)| [point, normal].map(|v| Vec3::from(v).extend(0.0)))
            .collect();
        for space in light_spaces(1.0) {
            let parameters = Parameters {
                space: SpaceRecord::new(&space, resolution),
                count: records.len() as u32,
                width: size.width(),
                padding: [0; 2],
            };
            let mut places = gpu.zeros::<[Vec4; 3]>(records.len()).unwrap();
            let kernel = Kernel {
                label: "place",
                parts: &[INDEX_WGSL, SPACE, ENTRY],
                entry: "place",
                constants: &[],
            };
            let there = gpu.upload(&records).unwrap();
            let arguments = [
                Argument::uniform(parameters),
                Argument::read(&there),
                Argument::write(&mut places),
            ];
            gpu.dispatch(&kernel, &[&arguments], Workgroups::covering(records.len(), 64)).unwrap();
            for ([point, normal], place) in records.iter().zip(gpu.download(&places).unwrap()) {
                let (point, normal) = (point.truncate(), normal.truncate());
                let Some(expected) = space.voxel(resolution, point) else {
                    prop_assert!(!(place[0].w > 1e-6));
                    continue;
                };
                // Where all coordinates are good to a voxel.
                let ray = Ray::new(point, Vec3::X, 1.0).unwrap();
                let delta = delta(&space, side, &ray, 0.0);
                if delta.max_element() > 0.5 {
                    continue;
                }
                let found = place[0].truncate().as_dvec3();
                prop_assert!((found - expected).abs().cmple(delta).all(), "{} {}", found, expected);
                let turned = space.normal(point, normal);
                let off = f64::from((turned - place[1].truncate()).length());
                prop_assert!(off < Allowed::GpuTurnedNormal.error());
                let biased = size.bias(expected, turned).as_dvec3();
                let off = (biased - place[2].truncate().as_dvec3()).abs().max_element();
                prop_assert!(off <= 1.0, "{} {}", biased, place[2]);
            }
        }
    }
}
