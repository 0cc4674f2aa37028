//! Questions whose answers are whole numbers, and filters.

use glam::{IVec3, UVec2};
use gpu_backend::{Backend, BufferOf, Cpu, Download, Element, testing};
use proptest::prelude::*;
use reference::tolerances::Allowed;

use crate::tests::Hills;
use crate::tests::maps::{self, Map};
use crate::{Builder, Error, FilterSize, Form, Query, ResidentDag, Resolution, Rule, ShadowDag};

const RULES: [Rule; 3] = [Rule::Sintorn2014, Rule::Kampe2015, Rule::Aligned];

/// What is asked.
#[derive(Debug, Default)]
struct Questions {
    voxels: Vec<[i32; 4]>,
    texels: Vec<[u32; 2]>,
    boxes: Vec<[[i32; 4]; 2]>,
    positions: Vec<[f32; 4]>,
    widths: Vec<u32>,
}

/// Answers that are the same on any backend.
#[derive(Debug, Default, PartialEq)]
struct Answers {
    lit: Vec<u32>,
    counts: Vec<Vec<u32>>,
    depths: Vec<u32>,
    seen: Vec<u32>,
}

/// Answers with a fraction.
type Shares = Vec<[Vec<f32>; 2]>;

/// Uploads questions, asks and downloads the answers.
fn batch<B: Download, Q: Element, A: Element>(
    backend: &B,
    questions: &[Q],
    ask: impl FnOnce(&BufferOf<B, Q>, &mut BufferOf<B, A>) -> Result<(), Error>,
) -> Result<Vec<A>, Error> {
    let questions_there = backend.upload(questions)?;
    let mut answers = backend.zeros(questions.len())?;
    ask(&questions_there, &mut answers)?;
    Ok(backend.download(&answers)?)
}

fn ask<B: Query + Download>(
    backend: &B,
    dag: &ResidentDag<B::Memory>,
    questions: &Questions,
) -> Result<(Answers, Shares), Error> {
    let voxels = &questions.voxels;
    let mut answers = Answers {
        lit: batch(backend, voxels, |voxels, lit| {
            backend.is_lit(dag, voxels, lit)
        })?,
        counts: Vec::new(),
        depths: batch(backend, &questions.texels, |texels, depths| {
            backend.depth(dag, texels, depths)
        })?,
        seen: batch(backend, &questions.boxes, |boxes, seen| {
            backend.visibility(dag, boxes, seen)
        })?,
    };
    let mut shares = Vec::new();
    for &width in &questions.widths {
        let size = FilterSize::new(width)?;
        answers
            .counts
            .push(batch(backend, voxels, |voxels, counts| {
                backend.count_lit(dag, size, voxels, counts)
            })?);
        shares.push([
            batch(backend, voxels, |voxels, lit| {
                backend.filter(dag, size, voxels, lit)
            })?,
            batch(backend, &questions.positions, |positions, lit| {
                backend.filter_bilinear(dag, size, positions, lit)
            })?,
        ]);
    }
    Ok((answers, shares))
}

/// All questions in both forms, with and without a top grid, on both backends.
fn agrees<G: Query + Download>(gpu: &G, dag: &ShadowDag, questions: &Questions) {
    let cpu = Cpu::new();
    let resident = dag.upload(&cpu).unwrap();
    let (expected, expected_shares) = ask(&cpu, &resident, questions).unwrap();
    for form in [Form::Plain, Form::Packed] {
        let dag = dag.to_form(form).unwrap();
        for dag in [dag.clone().with_top_grid(0), dag.with_top_grid(5)] {
            let there = dag.upload(gpu).unwrap();
            let (answers, shares) = ask(gpu, &there, questions).unwrap();
            assert!(
                answers == expected,
                "{form:?}: {}",
                difference(&expected, &answers)
            );
            let close = |expected: &[f32], found: &[f32], allowed: Allowed| {
                for (e, f) in expected.iter().zip(found) {
                    assert!(f64::from((e - f).abs()) <= allowed.error(), "{e} {f}");
                }
            };
            for ([hard, soft], [hard_there, soft_there]) in expected_shares.iter().zip(&shares) {
                close(hard, hard_there, Allowed::GpuFilteredShare);
                close(soft, soft_there, Allowed::GpuWeightedShare);
            }
        }
    }
}

/// Where answers differ first.
fn difference(expected: &Answers, found: &Answers) -> String {
    let first = |what: &str, expected: &[u32], found: &[u32]| {
        let at = (0..expected.len()).find(|&i| expected[i] != found[i]);
        at.map_or(String::new(), |i| {
            format!("{what} {i}: {} instead of {}; ", found[i], expected[i])
        })
    };
    let counts = expected.counts.iter().zip(&found.counts);
    first("voxel", &expected.lit, &found.lit)
        + &first("texel", &expected.depths, &found.depths)
        + &first("box", &expected.seen, &found.seen)
        + &counts
            .map(|(e, f)| first("window", e, f))
            .collect::<String>()
}

fn every_voxel(side: u32) -> Questions {
    let all = |i: u32| [i % side, i / side % side, i / side / side];
    Questions {
        voxels: (0..side * side * side)
            .map(|i| {
                let [x, y, z] = all(i).map(|at| at as i32);
                [x, y, z, 0]
            })
            .collect(),
        texels: (0..side * side).map(|i| [i % side, i / side]).collect(),
        ..Questions::default()
    }
}

#[test]
fn every_voxel_of_named_maps_is_that_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    for side in [8, 16, 32] {
        let questions = every_voxel(side);
        for (_, map) in maps::named(side) {
            for map in [map.clone(), map.open()] {
                for rule in RULES {
                    let dag = Builder::new().rule(rule).build(&Cpu::new(), &map).unwrap();
                    agrees(&gpu, &dag, &questions);
                }
            }
        }
    }
}

/// Numbers that are on the grid, near it or at the ends of the integers.
fn number(side: i32) -> impl Strategy<Value = i32> {
    prop_oneof![
        8 => 0..side,
        4 => -20..side + 20,
        1 => Just(i32::MIN),
        1 => Just(i32::MAX),
    ]
}

fn questions(side: i32) -> impl Strategy<Value = Questions> {
    let triple = || (number(side), number(side), number(side)).prop_map(|(x, y, z)| [x, y, z, 0]);
    let extent = (0..20_i32, 0..20_i32, 0..20_i32);
    let ends = prop_oneof![
        3 => (triple(), extent).prop_map(|(first, (x, y, z))| {
            let far = |at: i32, by: i32| at.saturating_add(by);
            [first, [far(first[0], x), far(first[1], y), far(first[2], z), 0]]
        }),
        1 => (triple(), triple()).prop_map(|(first, last)| [first, last]),
    ];
    let real = || {
        prop_oneof![
            6 => -20.0..side as f32 + 20.0,
            2 => (0..2 * side).prop_map(|i| 0.5 * i as f32),
            1 => Just(3e38_f32),
            1 => Just(-3e38_f32),
        ]
    };
    let many = 0..400_usize;
    (
        proptest::collection::vec(triple(), many.clone()),
        proptest::collection::vec((0..side as u32 + 9, 0..side as u32 + 9), many.clone()),
        proptest::collection::vec(ends, many.clone()),
        proptest::collection::vec((real(), real(), real()), many),
        proptest::collection::vec(
            prop_oneof![Just(9_u32), (0..40_u32).prop_map(|i| 2 * i + 1)],
            2,
        ),
    )
        .prop_map(|(voxels, texels, boxes, positions, widths)| Questions {
            voxels,
            texels: texels.into_iter().map(|(x, y)| [x, y]).collect(),
            boxes,
            positions: positions
                .into_iter()
                .map(|(x, y, z)| [x, y, z, 0.0])
                .collect(),
            widths,
        })
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    #[test]
    fn answers_of_any_kind_are_those_of_the_cpu(
        map in prop_oneof![
            maps::arbitrary(8), maps::arbitrary(64), maps::arbitrary(128),
            maps::noise(8), maps::noise(16),
        ],
        rule in proptest::sample::select(&RULES[..]),
        questions in questions(128),
    ) {
        let Some(gpu) = testing::gpu() else { return Ok(()) };
        let dag = Builder::new().rule(rule).build(&Cpu::new(), &map).unwrap();
        agrees(&gpu, &dag, &questions);
    }
}

#[test]
fn voxels_at_surfaces_of_large_grids_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let resolution = Resolution::new(2048).unwrap();
    for rule in RULES {
        let dag = Builder::new()
            .rule(rule)
            .build(&Cpu::new(), &Hills(resolution))
            .unwrap();
        let mut questions = Questions {
            widths: vec![1, 9, 33, 301],
            ..Questions::default()
        };
        for i in 0..3000_u32 {
            let at = UVec2::new(
                i.wrapping_mul(2_654_435_761) >> 21,
                i.wrapping_mul(40_503) % 2048,
            );
            let z = dag.depth(at) as i32 + i as i32 % 7 - 3;
            let voxel = at.as_ivec2().extend(z);
            questions.voxels.push(voxel.extend(0).to_array());
            questions.texels.push(at.to_array());
            let reach = IVec3::new(1, 5, 9) * (i as i32 % 40);
            questions
                .boxes
                .push([voxel - reach, voxel + reach].map(|v| v.extend(0).to_array()));
            let position = voxel.as_vec3() + 0.3;
            questions.positions.push(position.extend(0.0).to_array());
        }
        agrees(&gpu, &dag, &questions);
    }
}

#[test]
fn the_widest_filters_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let side = 64;
    let map = Map::new(side, |x, y| [(x + 2 * y) / 4, (x + 2 * y) / 4 + 5]);
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let questions = Questions {
        voxels: vec![
            [32, 32, 32, 0],
            [-32_767, 5, 9, 0],
            [i32::MIN, i32::MAX, 0, 0],
            [32_830, 32_830, 20, 0],
        ],
        positions: vec![[f32::MAX; 4], [f32::NAN; 4], [f32::INFINITY; 4], [31.5; 4]],
        widths: vec![65_535, 127, 4097],
        ..Questions::default()
    };
    agrees(&gpu, &dag, &questions);
}

#[test]
fn empty_and_wrong_batches_are_handled_as_on_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let (_, map) = maps::named(16).swap_remove(0);
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    agrees(&gpu, &dag, &Questions::default());
    let there = dag.upload(&gpu).unwrap();
    let voxels = gpu.upload(&[[0_i32; 4]; 3]).unwrap();
    let mut lit = gpu.zeros::<u32>(2).unwrap();
    let error = gpu.is_lit(&there, &voxels, &mut lit).unwrap_err();
    assert!(
        matches!(
            error,
            Error::Length {
                given: 2,
                expected: 3,
                ..
            }
        ),
        "{error}"
    );
}

/// A graph of nothing but masks that nobody names.
fn of_masks(masks: usize) -> ShadowDag {
    let (_, map) = maps::named(8).swap_remove(3);
    let small = Builder::new().build(&Cpu::new(), &map).unwrap();
    let mut bytes = small.into_bytes();
    bytes[28..32].copy_from_slice(&(masks as u32).to_le_bytes());
    bytes.resize(bytes.len() + 8 * masks, 0);
    let sum = crc32fast::hash(&bytes[16..]);
    bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    ShadowDag::from_bytes(bytes).unwrap()
}

#[test]
fn shadows_that_a_device_cannot_bind_are_an_error_that_names_the_limit() {
    let Some(gpu) = testing::gpu() else { return };
    let limit = gpu.context().limits().max_storage_buffer_binding_size;
    // Devices that bind more are not asked to.
    if limit > 128 << 20 {
        return;
    }
    let error = of_masks(limit as usize / 8).upload(&gpu).unwrap_err();
    let expected = matches!(
        error,
        Error::Backend(gpu_backend::Error::TooLarge { limit: found, .. }) if found == limit
    );
    assert!(expected, "{error}");
}
