//! Bounds against distributions that are known, bleeding behind casters in line, and
//! both backends.

use gpu_backend::Cpu;
use reference::random::Random;
use reference::tolerances::Allowed;

use super::*;
use crate::Emitter;
use crate::scene::{Emission, Geometry, Mesh, Scene};
use crate::shadow_map::{Casters, RenderShadowMap};

const ALL: [Moments; 4] = [
    Moments::Variance,
    Moments::ExponentialVariance,
    Moments::Four,
    Moments::Six,
];

/// Depths and their shares, `count` of them, a thirtieth apart at least.
fn distribution(random: &mut Random, count: usize) -> Vec<[f64; 2]> {
    let mut depths: Vec<f64> = Vec::new();
    while depths.len() < count {
        let z = 2.0 * random.unit_f64() - 1.0;
        if depths.iter().all(|other| (other - z).abs() > 1.0 / 30.0) {
            depths.push(z);
        }
    }
    let weights: Vec<f64> = (0..count).map(|_| 0.05 + random.unit_f64()).collect();
    let sum: f64 = weights.iter().sum();
    depths
        .into_iter()
        .zip(weights)
        .map(|(z, weight)| [z, weight / sum])
        .collect()
}

fn moments_of(distribution: &[[f64; 2]], count: i32) -> Vec<f64> {
    (1..=count)
        .map(|k| distribution.iter().map(|[z, w]| w * z.powi(k)).sum())
        .collect()
}

#[test]
fn without_a_bias_no_shadow_is_darker_than_the_truth() {
    let mut random = Random::new(2015);
    let mut sharp = [0.0_f64; 2];
    for number in 0..20_000 {
        let depths = distribution(&mut random, 3 + number % 6);
        let z = 2.2 * random.unit_f64() - 1.1;
        let truth: f64 = depths.iter().filter(|d| d[0] < z).map(|d| d[1]).sum();
        let allowed = truth + Allowed::MomentShare.error();
        let m = moments_of(&depths, 6);
        let shadow = 1.0 - not_before(m[0], m[1], 0.0, z);
        assert!(
            shadow <= allowed,
            "variance: {shadow} {truth} {z} {depths:?}"
        );
        let four = least_before(&m[..4], 0.0, z);
        assert!(four <= allowed, "four: {four} {truth} {z} {depths:?}");
        assert!(
            four >= shadow - Allowed::MomentShare.error(),
            "{four} {shadow}"
        );
        if depths.len() > 3 {
            let six = least_before(&m, 0.0, z);
            assert!(six <= allowed, "six: {six} {truth} {z} {depths:?}");
            assert!(six >= four - Allowed::MomentShare.error(), "{six} {four}");
            sharp = [sharp[0] + truth - four, sharp[1] + truth - six];
        }
    }
    // More moments let less light through.
    assert!(sharp[1] < 0.8 * sharp[0], "{sharp:?}");
}

#[test]
fn two_casters_are_known_by_four_moments_and_three_by_six() {
    let asked = |kind: Moments, depths: &[[f32; 2]], z: f32| {
        let mut moments = [0.0; MOST];
        for [depth, weight] in depths {
            for (sum, moment) in moments.iter_mut().zip(kind.of(*depth)) {
                *sum += weight * moment;
            }
        }
        kind.visibility(&moments, z)
    };
    // A leaf over half of a filtered square, a roof below, and the room below that.
    let two = [[-0.8, 0.5], [0.2, 0.5]];
    // A branch between the two.
    let three = [[-0.8, 0.4], [-0.2, 0.3], [0.2, 0.3]];
    let bleeds = |depths: &[[f32; 2]]| ALL.map(|kind| asked(kind, depths, 0.4));
    let ([a, b, c, d], [e, f, g, h]) = (bleeds(&two), bleeds(&three));
    println!("light that bleeds behind two casters in line:   {a:.4} {b:.4} {c:.4} {d:.4}");
    println!("light that bleeds behind three casters in line: {e:.4} {f:.4} {g:.4} {h:.4}");
    assert!(a > 0.2 && e > 0.1, "{a} {e}");
    assert!(b < 0.01 && f < 0.01, "{b} {f}");
    assert!(c < 0.01 && d < 0.01, "{c} {d}");
    assert!(g > 0.02 && h < 0.01 && h < g, "{g} {h}");
    // In front of all of them, and in their midst.
    for kind in ALL {
        assert!(asked(kind, &two, -0.9) > 0.999, "{kind:?}");
        let half = asked(kind, &two, -0.5);
        assert!(half > 0.499 && half <= 1.0, "{kind:?} {half}");
    }
}

/// A square of side 2 at z = −2 and a far larger one at z = −6.
fn squares() -> Geometry {
    let square = |half: f32, z: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(half * x, half * y, z))
    };
    let mesh = Mesh {
        positions: [square(1.0, -2.0), square(40.0, -6.0)].concat(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).unwrap()
}

fn lights() -> [Emitter; 3] {
    let point =
        |position| Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    [
        point(Vec3::ZERO),
        point(Vec3::new(1.0, 2.0, 90.0)),
        Emitter::directional(Vec3::NEG_Z, Vec3::ONE).unwrap(),
    ]
}

#[test]
fn points_are_lit_before_casters_and_dark_behind_them() {
    let cpu = Cpu::new();
    let geometry = squares();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    for light in lights() {
        let map = cpu.shadow_map(&casters, &light, 250).unwrap();
        for kind in ALL {
            for level in [0, 1, 3] {
                let filtered =
                    PrefilteredMap::new(&cpu, &map, kind, &geometry.bounds(), level).unwrap();
                let at = |x: f32, z: f32| filtered.visibility(Vec3::new(x, 0.1, z));
                let context = format!("{light:?} {kind:?} {level}");
                assert!(at(0.0, -1.0) > 0.999, "{context}: {}", at(0.0, -1.0));
                // The small square is six texels in the map of the distant light.
                if level <= 1 {
                    assert!(at(0.0, -4.0) < 0.01, "{context}: {}", at(0.0, -4.0));
                }
                assert!(at(9.0, -4.0) > 0.99, "{context}: {}", at(9.0, -4.0));
                assert!(at(9.0, -9.0) < 0.01, "{context}: {}", at(9.0, -9.0));
                assert!(at(0.0, 95.0) > 0.999, "{context}");
            }
        }
    }
}

#[test]
fn maps_of_any_size_at_any_level_give_shares() {
    let cpu = Cpu::new();
    let geometry = squares();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let mut random = Random::new(6);
    for light in lights() {
        for resolution in [1, 2, 7, 33] {
            let map = cpu.shadow_map(&casters, &light, resolution).unwrap();
            for kind in ALL {
                for level in [0, 1, 6, u32::MAX] {
                    let bounds = geometry.bounds();
                    let filtered = PrefilteredMap::new(&cpu, &map, kind, &bounds, level).unwrap();
                    assert!(filtered.level() <= 6);
                    for _ in 0..100 {
                        let share = filtered.visibility(Vec3::from(random.vector(60.0)));
                        assert!((0.0..=1.0).contains(&share), "{kind:?} {level} {share}");
                    }
                }
            }
        }
    }
}

#[test]
fn levels_of_a_pyramid_are_those_made_from_the_map() {
    let cpu = Cpu::new();
    let geometry = squares();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let bounds = geometry.bounds();
    for light in lights() {
        for (resolution, finest) in [(1, 0), (7, 0), (64, 1), (250, 0)] {
            let map = cpu.shadow_map(&casters, &light, resolution).unwrap();
            for kind in [Moments::Variance, Moments::Six] {
                let pyramid = MomentPyramid::new(&cpu, &map, kind, &bounds, finest).unwrap();
                assert_eq!(pyramid.bytes(), 4 * pyramid.moments().len() as u64);
                let levels = pyramid.levels.iter().zip(&pyramid.firsts);
                for (level, first) in levels {
                    let alone =
                        PrefilteredMap::new(&cpu, &map, kind, &bounds, level.level).unwrap();
                    let own = &pyramid.moments()[*first..][..alone.moments().len()];
                    for (own, alone) in own.iter().zip(alone.moments()) {
                        // Means of means, level by level.
                        assert!((own - alone).abs() < 32.0 * f32::EPSILON, "{own} {alone}");
                    }
                }
            }
        }
    }
}

/// In parallel light a texel is as long as its share of the picture.
#[test]
fn ways_are_asked_about_at_the_level_below_their_length() {
    let cpu = Cpu::new();
    let geometry = squares();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let bounds = geometry.bounds();
    let sun = Emitter::directional(Vec3::NEG_Z, Vec3::ONE).unwrap();
    let map = cpu.shadow_map(&casters, &sun, 256).unwrap();
    let pyramid = MomentPyramid::new(&cpu, &map, Moments::Variance, &bounds, 0).unwrap();
    // 80 m on 256 texels, beside the small square and above the large one.
    let middle = Vec3::new(0.9, 0.1, -4.0);
    for (texels, level) in [
        (0.1, 0),
        (1.5, 0),
        (3.0, 0),
        (5.0, 1),
        (40.0, 4),
        (1000.0, 8),
    ] {
        let half = 0.5 * texels * (80.0 / 256.0) * Vec3::X;
        let alone = PrefilteredMap::new(&cpu, &map, Moments::Variance, &bounds, level).unwrap();
        let [between, at] = [
            pyramid.visibility_between(middle - half, middle + half),
            alone.visibility(middle),
        ];
        assert!((between - at).abs() < 1e-4, "{texels}: {between} {at}");
        // Along the light it is a point.
        let along = pyramid.visibility_between(middle - 1e-3 * Vec3::Z, middle + 1e-3 * Vec3::Z);
        assert_eq!(along, pyramid.visibility(middle));
    }
    // Lamps see what is close by larger.
    let lamp = lights()[0].clone();
    let map = cpu.shadow_map(&casters, &lamp, 256).unwrap();
    for (z, texels) in [(-1.0_f32, 128.0_f32), (-2.0, 64.0), (-32.0, 4.0)] {
        let v = Vec3::new(0.0, 0.1 * z, z);
        let face = locate(map.faces(), 256, v).unwrap().face;
        let found = pyramid::texels_along(&map.faces()[face], 256, v, Vec3::X);
        assert!(
            (found - texels).abs() < 1e-3 * texels,
            "{z}: {found} {texels}"
        );
    }
}

#[cfg(feature = "wgpu")]
mod on_gpu {
    use gpu_backend::gpu::GpuMemory;
    use gpu_backend::testing::{self, Shader};
    use gpu_backend::{Download, assert_same_layout};

    use super::super::gpu::{
        BUILD, COARSEN, CoarserRecord, EXPONENTIAL, FOUR, LevelRecord, SIX, VARIANCE,
    };
    use super::*;

    #[test]
    fn the_shader_that_filters_sees_a_level_as_it_is() {
        let shader = Shader::new(&BUILD).unwrap();
        assert_same_layout!(
            shader,
            "light_Level",
            LevelRecord {
                pictures,
                kind,
                channels,
                level,
                side,
                near,
                far,
                padding_a,
                padding_b
            }
        );
        let kinds = [
            ("light_VARIANCE", VARIANCE),
            ("light_EXPONENTIAL", EXPONENTIAL),
            ("light_FOUR", FOUR),
            ("light_SIX", SIX),
        ];
        for (name, value) in kinds {
            assert_eq!(shader.values(name).unwrap(), [f64::from(value)], "{name}");
        }
        let constants = [
            ("light_DEEPEST", DEEPEST),
            ("light_BEHIND", BEHIND),
            ("light_WARP", WARP),
            ("light_DEVIATION", DEVIATION),
        ];
        for (name, value) in constants {
            assert_eq!(shader.values(name).unwrap(), [f64::from(value)], "{name}");
        }
    }

    #[test]
    fn the_shader_that_coarsens_sees_levels_as_they_are() {
        let shader = Shader::new(&COARSEN).unwrap();
        assert_same_layout!(
            shader,
            "Coarser",
            CoarserRecord {
                level,
                finer,
                own,
                padding_a,
                padding_b
            }
        );
    }

    #[test]
    fn pyramids_of_both_backends_agree() {
        let Some(gpu) = testing::gpu() else { return };
        let cpu = Cpu::new();
        let geometry = squares();
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        let bounds = geometry.bounds();
        for light in lights() {
            for (resolution, finest) in [(1, 0), (45, 0), (300, 1)] {
                let map = cpu.shadow_map(&casters, &light, resolution).unwrap();
                let there: ShadowMap<GpuMemory> = map.upload(&gpu).unwrap();
                let kind = Moments::Four;
                let expected = MomentPyramid::new(&cpu, &map, kind, &bounds, finest).unwrap();
                let actual = MomentPyramid::new(&gpu, &there, kind, &bounds, finest).unwrap();
                let actual = gpu.download(actual.moments()).unwrap();
                assert_eq!(actual.len(), expected.moments().len());
                for (e, g) in expected.moments().iter().zip(&actual) {
                    let error = f64::from((e - g).abs());
                    assert!(
                        error <= Allowed::GpuMoments.error(),
                        "{resolution}: {e} {g}"
                    );
                }
            }
        }
    }

    #[test]
    fn moments_of_both_backends_agree() {
        let Some(gpu) = testing::gpu() else { return };
        let cpu = Cpu::new();
        let geometry = squares();
        let casters = Casters::upload(&cpu, &geometry).unwrap();
        for light in lights() {
            // Level 7 is made in two steps.
            for (resolution, level) in [(45, 1), (300, 7)] {
                let map = cpu.shadow_map(&casters, &light, resolution).unwrap();
                let there: ShadowMap<GpuMemory> = map.upload(&gpu).unwrap();
                for kind in ALL {
                    let bounds = geometry.bounds();
                    let expected = PrefilteredMap::new(&cpu, &map, kind, &bounds, level).unwrap();
                    let actual = PrefilteredMap::new(&gpu, &there, kind, &bounds, level).unwrap();
                    let actual = gpu.download(actual.moments()).unwrap();
                    for (index, (e, g)) in expected.moments().iter().zip(&actual).enumerate() {
                        let scale = match kind {
                            Moments::ExponentialVariance => e.abs(),
                            _ => 1.0,
                        };
                        let error = f64::from((e - g).abs());
                        let allowed = Allowed::GpuMoments.error() * f64::from(scale);
                        assert!(error <= allowed, "{kind:?} {level} {index}: {e} {g}");
                    }
                }
            }
        }
    }
}
