//! Voxels of one blocker whose shadow is known.

use glam::{Vec2, Vec3};
use gpu_backend::Cpu;

use super::*;
use crate::scene::{
    AlphaMode, Bounds, Cone, Emission, Filter, Geometry, Material, Medium, Mesh, PhaseFunction,
    Sampler, Scene, Texture, Wrap,
};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use crate::{Emitter, Interval, LightPath, LitInterval, Ray, VisibilitySource};

/// A plate between x = −1 and x = 1 at the height 1, endless in depth.
fn plate() -> Geometry {
    let scene = Scene::from(Mesh {
        positions: vec![
            Vec3::new(-1.0, 1.0, -900.0),
            Vec3::new(1.0, 1.0, -900.0),
            Vec3::new(1.0, 1.0, 900.0),
            Vec3::new(-1.0, 1.0, 900.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    });
    Geometry::new(&scene).unwrap()
}

fn fog() -> Medium {
    Medium::new(Vec3::splat(0.2), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

fn lamp(position: Vec3) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
}

fn map(cpu: &Cpu, light: &Emitter) -> ShadowMap<gpu_backend::Host> {
    let casters = Casters::upload(cpu, &plate()).unwrap();
    cpu.shadow_map(&casters, light, 2048).unwrap()
}

/// All directions from one place.
fn around(position: Vec3, rays: &[Ray], medium: &Medium) -> Eye {
    Eye {
        position,
        corners: None,
        depths: depth_range(rays, medium),
        lamp_spacing: Spacing::Angle,
        sun_spacing: Spacing::Angle,
    }
}

fn lit(
    volume: &VoxelVolume<gpu_backend::Host>,
    detail: Detail,
    (ray, light, medium): (&Ray, &Emitter, &Medium),
) -> Vec<LitInterval> {
    let path = LightPath::new(ray, light, medium).unwrap();
    let mut lit = Vec::new();
    volume.source(detail).lit_intervals(&path, &mut lit);
    let mut last = path.span().start;
    for part in &lit {
        assert!(last <= part.interval.start && part.interval.start < part.interval.end);
        assert!(part.interval.end <= path.span().end);
        assert!(part.visibility > 0.0 && part.visibility <= 1.0);
        last = part.interval.end;
    }
    lit
}

/// Length that is lit, weighted with visibility.
fn length(lit: &[LitInterval]) -> f32 {
    lit.iter()
        .map(|part| part.visibility * part.interval.length())
        .sum()
}

#[test]
fn paths_together_have_the_lit_parts_of_each_by_itself() {
    let cpu = Cpu::new();
    let eye = Vec3::new(-5.0, 0.0, 0.5);
    let rays: Vec<Ray> = (0..300)
        .map(|i| {
            let direction = Vec3::new(1.0, 0.005 * i as f32 - 0.7, 0.002 * i as f32 - 0.3);
            let length = [7.0, 30.0, f32::INFINITY][i % 3];
            Ray::new(eye, direction, length).unwrap()
        })
        .collect();
    let bounds = Bounds::new(Vec3::new(-4.0, -9.0, -9.0), Vec3::new(6.0, 9.0, 9.0)).unwrap();
    let medium = fog().within(bounds);
    let mut volume = VoxelVolume::new(&cpu, Resolution::new(64, 64, 96).unwrap()).unwrap();
    let range = |position| Emitter::point(position, Vec3::ONE, 9.0, Emission::Isotropic).unwrap();
    let lights = [
        range(Vec3::new(0.0, 2.0, 0.0)),
        // All rays are lit as far as it reaches.
        range(eye),
        Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap(),
    ];
    let mut shadowed = 0;
    for light in lights {
        let map = map(&cpu, &light);
        let around = around(eye, &rays, &medium);
        volume.update(&cpu, &light, &around, &map).unwrap();
        let paths: Vec<LightPath<'_>> = (rays.iter())
            .filter_map(|ray| LightPath::new(ray, &light, &medium))
            .collect();
        for detail in [Detail::Average, Detail::Voxels, Detail::Runs] {
            let mut number = 0;
            let source = volume.source(detail);
            source.lit_of_neighbours(&paths, &mut |index, together| {
                assert_eq!(index, number);
                number += 1;
                let mut alone = Vec::new();
                source.lit_intervals(&paths[index], &mut alone);
                assert_eq!(*together, alone);
                let span = paths[index].span();
                shadowed += usize::from(alone != [LitInterval::unshadowed(span.start, span.end)]);
            });
            assert_eq!(number, paths.len());
        }
    }
    assert!(shadowed > 300, "{shadowed}");
}

#[test]
fn every_detail_finds_the_shadow_of_a_plate_from_a_lamp_and_from_a_sun() {
    let cpu = Cpu::new();
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let origin = Vec3::new(-5.0, 0.0, 0.5);
    let ray = Ray::new(origin, Vec3::X, 10.0).unwrap();
    let mut volume = VoxelVolume::new(&cpu, Resolution::new(512, 512, 512).unwrap()).unwrap();
    // Twice as wide from the lamp at twice the height.
    for (light, half) in [(lamp(Vec3::new(0.0, 2.0, 0.0)), 2.0), (sun, 1.0)] {
        let map = map(&cpu, &light);
        for medium in [
            fog(),
            fog().within(
                Bounds::new(Vec3::new(-4.0, -9.0, -9.0), Vec3::new(0.5, 9.0, 9.0)).unwrap(),
            ),
        ] {
            let eye = around(origin, &[ray], &medium);
            volume.update(&cpu, &light, &eye, &map).unwrap();
            let path = LightPath::new(&ray, &light, &medium).unwrap();
            let span = path.span();
            let shadow = (span.end.min(5.0 + half) - span.start.max(5.0 - half)) / span.length();
            for detail in [Detail::Runs, Detail::Voxels] {
                let lit = lit(&volume, detail, (&ray, &light, &medium));
                let share = length(&lit) / span.length();
                assert!((share - (1.0 - shadow)).abs() < 0.02, "{detail:?}: {share}");
                if detail == Detail::Voxels {
                    // The fewest are the lamp's in the box: 0.33 rad of 512 voxels
                    // for half a turn.
                    assert!(lit.len() > 50, "{}", lit.len());
                }
            }
            let average = lit(&volume, Detail::Average, (&ray, &light, &medium));
            assert_eq!(average.len(), 1);
            assert_eq!(average[0].interval, span);
            // The sun's voxels are equal distances, so their share is that
            // of the length; a lamp's are equal angles.
            if matches!(light, Emitter::Directional(_)) {
                assert!((average[0].visibility - (1.0 - shadow)).abs() < 0.02);
            } else {
                // Seen from the lamp, 2 m above the ray.
                let angle = |x: f32| ((x - 5.0) / 2.0).atan();
                let [start, end] = [span.start, span.end].map(angle);
                let dark = end.min(angle(7.0)) - start.max(angle(3.0));
                let lit = 1.0 - dark / (end - start);
                assert!(
                    (average[0].visibility - lit).abs() < 0.02,
                    "{average:?} {lit}"
                );
            }
        }
    }
}

#[test]
fn an_eye_at_the_light_sees_no_shadow() {
    let cpu = Cpu::new();
    let origin = Vec3::new(0.0, 2.0, 0.0);
    let light = lamp(origin);
    let ray = Ray::new(origin, Vec3::NEG_Y, 1.0).unwrap();
    let mut volume = VoxelVolume::new(&cpu, Resolution::new(32, 32, 32).unwrap()).unwrap();
    let eye = around(origin, &[ray], &fog());
    volume
        .update(&cpu, &light, &eye, &map(&cpu, &light))
        .unwrap();
    assert!(volume.lattice_in_use().is_none());
    let lit = lit(&volume, Detail::Runs, (&ray, &light, &fog()));
    assert_eq!(lit, [LitInterval::unshadowed(0.0, 1.0)]);
}

#[test]
fn a_cone_that_misses_the_view_lights_nothing_of_it() {
    let cpu = Cpu::new();
    let cone = Cone {
        inner: 0.2,
        outer: 0.3,
    };
    let away = glam::Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::X);
    let spot = Emission::spot(away, cone, None).unwrap();
    let position = Vec3::new(3.0, 2.0, 0.0);
    let light = Emitter::point(position, Vec3::ONE, f32::INFINITY, spot).unwrap();
    let origin = Vec3::ZERO;
    let rays = [Ray::new(origin, Vec3::NEG_X, 9.0).unwrap()];
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let eye = Eye {
        corners: Some(corners.map(|(y, z)| Vec3::new(-5.0, y, z))),
        ..around(origin, &rays, &fog())
    };
    let mut volume = VoxelVolume::new(&cpu, Resolution::new(32, 32, 32).unwrap()).unwrap();
    volume
        .update(&cpu, &light, &eye, &map(&cpu, &light))
        .unwrap();
    assert!(volume.lattice_in_use().is_none());
    assert!(LightPath::new(&rays[0], &light, &fog()).is_none());
}

#[test]
fn what_cannot_be_divided_is_an_error_and_leaves_no_shadow() {
    let cpu = Cpu::new();
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let map = map(&cpu, &sun);
    let good = around(Vec3::ZERO, &[], &fog());
    let good = Eye {
        depths: Interval::new(0.0, 10.0),
        ..good
    };
    let resolution = Resolution::new(32, 32, 32).unwrap();
    let mut volume = VoxelVolume::new(&cpu, resolution).unwrap();
    for bad in [
        Eye {
            depths: Interval::new(0.0, f32::INFINITY),
            ..good
        },
        Eye {
            depths: Interval::new(-1.0, 1.0),
            ..good
        },
        Eye {
            depths: Interval::new(f32::NAN, f32::NAN),
            ..good
        },
        Eye {
            depths: Interval::new(0.0, f32::NAN),
            ..good
        },
        Eye {
            depths: Interval::new(0.0, -1.0),
            ..good
        },
        Eye {
            position: Vec3::splat(f32::INFINITY),
            ..good
        },
        Eye {
            corners: Some([Vec3::X; 4]),
            ..good
        },
        Eye {
            sun_spacing: Spacing::Airlight { sigma_t: -1.0 },
            ..good
        },
    ] {
        volume.update(&cpu, &sun, &good, &map).unwrap();
        assert!(volume.lattice_in_use().is_some());
        let error = volume.update(&cpu, &sun, &bad, &map).unwrap_err();
        assert!(matches!(error, VoxelError::Epipolar(_)), "{error}");
        assert!(volume.lattice_in_use().is_none());
    }
    let sampling = Sampling {
        phi_bias: f32::NAN,
        ..Sampling::PAPER
    };
    volume.update(&cpu, &sun, &good, &map).unwrap();
    let mut volume = volume.with_sampling(sampling);
    assert!(volume.lattice_in_use().is_none());
    let error = volume.update(&cpu, &sun, &good, &map).unwrap_err();
    assert!(matches!(error, VoxelError::Voxels(_)), "{error}");
}

#[test]
fn depths_are_those_of_what_scatters_before_surfaces() {
    let ray = |direction, length| Ray::new(Vec3::ZERO, direction, length).unwrap();
    let rays = [ray(Vec3::X, 3.0), ray(Vec3::Y, 7.0)];
    assert_eq!(depth_range(&rays, &fog()), Interval::new(0.0, 7.0));
    let sky = [ray(Vec3::X, 3.0), ray(Vec3::Y, f32::INFINITY)];
    assert_eq!(depth_range(&sky, &fog()), Interval::new(0.0, 50.0));
    let red = Vec3::new(0.2, 0.0, 0.0);
    let red = Medium::new(red, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    assert_eq!(depth_range(&sky, &red), Interval::new(0.0, 50.0));
    let bounds = Bounds::new(Vec3::new(2.0, -1.0, -1.0), Vec3::new(6.0, 1.0, 1.0)).unwrap();
    let bank = fog().within(bounds);
    assert_eq!(depth_range(&rays, &bank), Interval::new(2.0, 3.0));
    assert_eq!(depth_range(&rays[1..], &bank), Interval::new(0.0, 0.0));
    assert_eq!(depth_range(&[], &bank), Interval::new(0.0, 0.0));
}

/// The plate, of which the texture leaves the half at negative x.
fn half_a_plate() -> Geometry {
    let texture = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
    let texture = texture.with_alpha(vec![1.0, 0.0]).unwrap();
    let mut scene = Scene::from(Mesh {
        positions: vec![
            Vec3::new(-1.0, 1.0, -900.0),
            Vec3::new(1.0, 1.0, -900.0),
            Vec3::new(1.0, 1.0, 900.0),
            Vec3::new(-1.0, 1.0, 900.0),
        ],
        texture_coordinates: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..Mesh::default()
    });
    scene.materials.push(Material {
        base_color_texture: Some(texture.with_sampler(Sampler {
            wrap: [Wrap::Clamp; 2],
            filter: Filter::Linear,
        })),
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::default()
    });
    Geometry::new(&scene).unwrap()
}

#[test]
fn voxels_from_triangles_know_their_masks() {
    let cpu = Cpu::new();
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let origin = Vec3::new(-5.0, 0.0, 0.5);
    let ray = Ray::new(origin, Vec3::X, 10.0).unwrap();
    let resolution = Resolution::new(512, 512, 512).unwrap();
    let medium = fog();
    let eye = around(origin, &[ray], &medium);
    let casters = Casters::upload(&cpu, &half_a_plate()).unwrap();
    assert_eq!((casters.masked(), casters.solid()), (2, 0));
    for (light, start, end) in [(sun, 4.0, 5.0), (lamp(Vec3::new(0.0, 2.0, 0.5)), 3.0, 5.0)] {
        let mut volume = VoxelVolume::new(&cpu, resolution).unwrap();
        volume
            .update_from_triangles(&cpu, &light, &eye, &casters)
            .unwrap();
        let lit = lit(&volume, Detail::Runs, (&ray, &light, &medium));
        let shadow = (length(&lit) - 10.0).abs();
        assert!((shadow - (end - start)).abs() < 0.06, "{shadow}");
        let inside = |part: &LitInterval| {
            let middle = 0.5 * (start + end);
            part.interval.start < middle && middle < part.interval.end
        };
        assert!(!lit.iter().any(inside), "{lit:?}");
        #[cfg(feature = "wgpu")]
        on_a_gpu(&light, &eye, &volume);
    }
}

/// The same voxels, but for light rays within rounding of a rim.
#[cfg(feature = "wgpu")]
fn on_a_gpu(light: &Emitter, eye: &Eye, expected: &VoxelVolume<gpu_backend::Host>) {
    use gpu_backend::{Download, testing};

    let Some(gpu) = testing::gpu() else { return };
    let casters = Casters::upload(&gpu, &half_a_plate()).unwrap();
    let mut volume = VoxelVolume::new(&gpu, expected.resolution()).unwrap();
    volume
        .update_from_triangles(&gpu, light, eye, &casters)
        .unwrap();
    let found = gpu.download(volume.grid().words()).unwrap();
    let words = expected.grid().words().iter().zip(&found);
    let others: u32 = words.map(|(a, b)| (a ^ b).count_ones()).sum();
    let set: u32 = found.iter().map(|word| word.count_ones()).sum();
    assert!(
        set > 1000 && f64::from(others) < 2e-3 * f64::from(set),
        "{others} of {set}"
    );
}
