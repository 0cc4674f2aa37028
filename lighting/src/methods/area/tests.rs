//! Many lights against one at a time.

use glam::Vec3;
use gpu_backend::{Cpu, Host};

use super::*;
use crate::airlight::{EquiAngular, Quadrature};
use crate::scene::raster::Rays;
use crate::scene::{
    AreaLight, Bounds, Camera, Emission, Geometry, Medium, Mesh, Pattern, PhaseFunction, Scene,
    Texture,
};
use crate::shadow_map::{Casters, EMPTY, RenderShadowMap, RenderShadowMapAtlas, ShadowMapAtlas};
use crate::voxelized::{Detail, Eye, Resolution, VoxelVolume};
use crate::{Emitter, Gather, Interleaving, LitRays, Ray};

/// Two plates under the panel and a floor.
pub(super) fn geometry() -> Geometry {
    let plate = |low: Vec3, high: Vec3| {
        [
            low,
            Vec3::new(high.x, low.y, low.z),
            high,
            Vec3::new(low.x, high.y, high.z),
        ]
    };
    let plates = [
        plate(Vec3::new(-1.4, 2.0, -7.0), Vec3::new(-0.3, 2.2, -5.0)),
        plate(Vec3::new(0.5, 2.4, -7.0), Vec3::new(1.6, 2.4, -4.5)),
        plate(Vec3::new(-6.0, 0.0, -14.0), Vec3::new(6.0, 0.0, 0.0)),
    ];
    let scene = Scene::from(Mesh {
        positions: plates.concat(),
        triangles: (0..3)
            .flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]])
            .collect(),
        ..Mesh::default()
    });
    Geometry::new(&scene).unwrap()
}

pub(super) fn panel() -> AreaLight {
    AreaLight {
        corner: Vec3::new(-0.8, 4.0, -6.8),
        edges: [1.6 * Vec3::X, 1.2 * Vec3::Z],
        radiance: Vec3::new(40.0, 30.0, 20.0),
        ..AreaLight::default()
    }
}

pub(super) fn fog() -> Medium {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.4 };
    Medium::new(Vec3::new(0.1, 0.12, 0.15), Vec3::splat(0.02), phase).unwrap()
}

pub(super) fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.1, 1.6, 0.5), Vec3::new(0.0, 1.8, -6.0), 1.0).unwrap()
}

pub(super) const SIZE: [u32; 2] = [24, 16];

pub(super) fn rays() -> Vec<Ray> {
    let camera = camera();
    let [width, height] = SIZE;
    (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let direction = camera.direction(x, y, width, height);
            let length = if i % 5 == 0 { f32::INFINITY } else { 9.0 };
            Ray::new(camera.eye(), direction, length).unwrap()
        })
        .collect()
}

pub(super) fn eye(medium: &Medium) -> Eye {
    Eye::of_camera(&camera(), SIZE, &rays(), medium)
}

pub(super) fn resolution() -> Resolution {
    Resolution::new(64, 48, 64).unwrap()
}

/// Points of the panel, a lamp, one at the eye, one that shines away, and a sun.
pub(super) fn lights() -> Vec<Emitter> {
    let mut lights = panel().virtual_lights(Pattern::Lattice, 7).unwrap();
    let point = |position, emission| {
        Emitter::point(position, Vec3::new(3.0, 5.0, 4.0), f32::INFINITY, emission).unwrap()
    };
    lights.push(point(Vec3::new(2.0, 3.0, -4.0), Emission::Isotropic));
    lights.push(point(camera().eye(), Emission::Isotropic));
    let away = Emission::Cosine { normal: Vec3::Y };
    lights.push(point(Vec3::new(0.0, 30.0, -4.0), away));
    let sun = Emitter::directional(Vec3::new(0.3, -1.0, -0.2), Vec3::splat(0.2));
    lights.push(sun.unwrap());
    lights
}

pub(super) fn maps(lights: &[Emitter]) -> ShadowMapAtlas<Host> {
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &geometry()).unwrap();
    cpu.shadow_map_atlas(&casters, lights, 64).unwrap()
}

fn volumes(lights: &[Emitter], medium: &Medium) -> LightVolumes<Host> {
    let cpu = Cpu::new();
    let mut volumes = LightVolumes::new(&cpu, resolution(), lights.len()).unwrap();
    volumes
        .update(&cpu, lights, &eye(medium), &maps(lights))
        .unwrap();
    volumes
}

fn gathered(cpu: &Cpu, lights: &[Emitter], detail: Detail) -> Vec<[f32; 4]> {
    let medium = fog();
    let rays = rays();
    let many = ManyLights {
        rays: &rays,
        emitters: lights,
        medium: &medium,
        detail,
        interleaving: Interleaving::NONE,
    };
    let mut radiance = vec![[0.0, 0.0, 0.0, 7.0]; rays.len()];
    let airlight = EquiAngular::new(4).unwrap();
    let volumes = volumes(lights, &medium);
    cpu.gather_many(&many, &volumes, &airlight, &mut radiance)
        .unwrap();
    radiance
}

/// Voxels know where lights are and not how bright: those of one frame of a video are
/// those of the next.
#[test]
fn a_changing_texture_changes_weights_and_needs_no_new_voxels() {
    let screen = |texels: [Vec3; 4]| AreaLight {
        texture: Some(Texture::new(2, 2, texels.to_vec()).unwrap()),
        ..panel()
    };
    let [before, after] = [
        screen([Vec3::X, Vec3::Y, Vec3::Z, Vec3::ZERO]),
        screen([Vec3::ZERO, Vec3::ONE, Vec3::new(0.1, 0.2, 0.0), Vec3::Z]),
    ];
    let (medium, rays) = (fog(), rays());
    let image = |made_for: &[Emitter], emitters: &[Emitter]| {
        let many = ManyLights {
            rays: &rays,
            emitters,
            medium: &medium,
            detail: Detail::Runs,
            interleaving: Interleaving::NONE,
        };
        let mut radiance = vec![[0.0; 4]; rays.len()];
        let airlight = EquiAngular::new(4).unwrap();
        Cpu::new()
            .gather_many(&many, &volumes(made_for, &medium), &airlight, &mut radiance)
            .unwrap();
        radiance
    };
    for pattern in [Pattern::Importance, Pattern::Halton] {
        let old = before.virtual_lights(pattern, 16).unwrap();
        let new = after
            .virtual_lights_placed_by(&before, pattern, 16)
            .unwrap();
        assert_eq!(image(&old, &new), image(&new, &new));
        assert_ne!(image(&old, &old), image(&old, &new));
    }
}

const DETAILS: [Detail; 3] = [Detail::Average, Detail::Voxels, Detail::Runs];

#[test]
fn many_lights_are_the_sum_of_one_after_the_other_to_the_last_bit() {
    let lights = lights();
    let (medium, rays) = (fog(), rays());
    for detail in DETAILS {
        let mut expected = vec![[0.0, 0.0, 0.0, 7.0]; rays.len()];
        for light in &lights {
            let one = std::slice::from_ref(light);
            let many = ManyLights {
                rays: &rays,
                emitters: one,
                medium: &medium,
                detail,
                interleaving: Interleaving::NONE,
            };
            let airlight = EquiAngular::new(4).unwrap();
            let volumes = volumes(one, &medium);
            Cpu::new()
                .gather_many(&many, &volumes, &airlight, &mut expected)
                .unwrap();
        }
        for cpu in [Cpu::single_threaded(), Cpu::with_threads(3).unwrap()] {
            assert_eq!(gathered(&cpu, &lights, detail), expected, "{detail:?}");
        }
        assert!(expected.iter().any(|pixel| pixel[0] > 0.0));
    }
}

/// A sun has no direction by which its space could be turned, so its voxels are
/// those of a single volume.
#[test]
fn a_light_by_itself_is_what_a_single_volume_gives() {
    let lights = lights();
    let sun = &lights[lights.len() - 1..];
    let (medium, rays, cpu) = (fog(), rays(), Cpu::new());
    let casters = Casters::upload(&cpu, &geometry()).unwrap();
    let map = cpu.shadow_map(&casters, &sun[0], 64).unwrap();
    let mut volume = VoxelVolume::new(&cpu, resolution()).unwrap();
    volume.update(&cpu, &sun[0], &eye(&medium), &map).unwrap();
    for detail in DETAILS {
        let mut expected = vec![[0.0, 0.0, 0.0, 7.0]; rays.len()];
        let lit = LitRays::new(&rays, &sun[0], &medium);
        let airlight = EquiAngular::new(4).unwrap();
        cpu.gather(&lit, &volume.source(detail), &airlight, &mut expected)
            .unwrap();
        assert_eq!(gathered(&cpu, sun, detail), expected);
    }
}

#[test]
fn the_order_of_lights_changes_rounding_only() {
    let lights = lights();
    let mut others = lights.clone();
    others.reverse();
    others.rotate_left(3);
    for detail in DETAILS {
        let [a, b] = [&lights, &others].map(|lights| gathered(&Cpu::new(), lights, detail));
        for (a, b) in a.iter().zip(&b) {
            for channel in 0..3 {
                let sum = a[channel].max(b[channel]);
                // As many roundings as parts of rays, of which each is a share.
                assert!((a[channel] - b[channel]).abs() <= 1e-5 * sum);
            }
        }
    }
}

#[test]
fn pictures_are_those_of_single_maps_and_faces_without_light_have_none() {
    let cpu = Cpu::with_threads(2).unwrap();
    let lights = lights();
    let maps = maps(&lights);
    let casters = Casters::upload(&cpu, &geometry()).unwrap();
    let mut next = maps.depth().chunks_exact(64 * 64);
    for (index, light) in lights.iter().enumerate() {
        let single = cpu.shadow_map(&casters, light, 64).unwrap();
        for (face, picture) in single
            .faces()
            .iter()
            .zip(single.depth().chunks_exact(64 * 64))
        {
            let shines = match (light, face.rays) {
                (Emitter::Point(point), Rays::Central { tan }) => match point.emission() {
                    Emission::Cosine { normal } => {
                        [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
                            .iter()
                            .any(|(x, y)| {
                                let corner = face.forward + tan * (x * face.right + y * face.up);
                                normal.dot(corner) > 0.0
                            })
                    }
                    _ => true,
                },
                _ => true,
            };
            if shines {
                assert_eq!(next.next(), Some(picture), "{index}");
            }
        }
    }
    assert!(next.next().is_none());
    // A light inside of what casts shadows, which shines down.
    let inside = Emitter::point(
        Vec3::new(0.0, 1.0, -6.0),
        Vec3::ONE,
        f32::INFINITY,
        Emission::Cosine { normal: -Vec3::Y },
    );
    let inside = [inside.unwrap()];
    let maps = cpu.shadow_map_atlas(&casters, &inside, 32).unwrap();
    assert_eq!(maps.bytes(), 5 * 4 * 32 * 32);
    let tiles = maps.of_tiles(&[0]).unwrap();
    let ray = |direction: Vec3| epipolar::LightRay {
        origin: [0.0, 1.0, -6.0],
        direction: direction.into(),
    };
    use voxel_shadow::AtlasBlocker;
    assert!((tiles.distance(0, &ray(Vec3::NEG_Y)) - 1.0).abs() < 1e-3);
    assert_eq!(tiles.distance(0, &ray(Vec3::Y)), EMPTY);
    assert!(maps.of_tiles(&[1]).is_none());
}

#[test]
fn a_bounded_medium_and_a_dark_one_are_legal() {
    let bounds = Bounds::new(Vec3::new(-2.0, 0.0, -9.0), Vec3::new(2.0, 3.0, -3.0)).unwrap();
    let nothing = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let lights = lights();
    let rays = rays();
    for (medium, is_dark) in [(fog().within(bounds), false), (nothing, true)] {
        let many = ManyLights {
            rays: &rays,
            emitters: &lights,
            medium: &medium,
            detail: Detail::Runs,
            interleaving: Interleaving::NONE,
        };
        let mut radiance = vec![[0.0; 4]; rays.len()];
        let airlight = Quadrature::with_tolerance(medium.phase(), 1e-3).unwrap();
        Cpu::new()
            .gather_many(&many, &volumes(&lights, &medium), &airlight, &mut radiance)
            .unwrap();
        assert!(radiance.iter().flatten().all(|value| value.is_finite()));
        assert_eq!(radiance.iter().all(|pixel| pixel[0] == 0.0), is_dark);
    }
}

#[test]
fn what_does_not_belong_together_is_an_error() {
    let cpu = Cpu::new();
    let (lights, medium, rays) = (lights(), fog(), rays());
    let maps = maps(&lights);
    let mut few = LightVolumes::new(&cpu, resolution(), 3).unwrap();
    let error = few.update(&cpu, &lights, &eye(&medium), &maps);
    assert!(error.is_err() && few.lights() == 0);
    let error = few.update(&cpu, &lights[..2], &eye(&medium), &maps);
    assert!(error.unwrap_err().to_string().contains("shadow maps"));
    let volumes = volumes(&lights, &medium);
    let airlight = EquiAngular::new(2).unwrap();
    for (lights, pixels) in [(&lights[1..], rays.len()), (&lights[..], 3)] {
        let many = ManyLights {
            rays: &rays,
            emitters: lights,
            medium: &medium,
            detail: Detail::Runs,
            interleaving: Interleaving::NONE,
        };
        let mut radiance = vec![[1.0; 4]; pixels];
        let error = cpu.gather_many(&many, &volumes, &airlight, &mut radiance);
        assert!(error.is_err());
        assert!(radiance.iter().all(|pixel| *pixel == [1.0; 4]));
    }
    let casters = Casters::upload(&cpu, &geometry()).unwrap();
    assert!(cpu.shadow_map_atlas(&casters, &lights, 0).is_err());
}

#[test]
fn no_light_is_no_light() {
    assert!(
        gathered(&Cpu::new(), &[], Detail::Runs)
            .iter()
            .all(|pixel| *pixel == [0.0, 0.0, 0.0, 7.0])
    );
}
