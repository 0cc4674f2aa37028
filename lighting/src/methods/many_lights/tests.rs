use airlight::{PhaseFunction, Table};
use glam::Vec3;
use gpu_backend::{Cpu, Error};
use reference::random::Random;

use super::*;
use crate::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use crate::culling::RayTiles;
use crate::culling::tests::{WIDTH, lights, rays};
use crate::scene::{Bounds, Camera, Emission};
use crate::{Gather, LitRays};

fn fog() -> Medium {
    let sigma = Vec3::new(0.05, 0.04, 0.03);
    Medium::new(sigma, 0.2 * sigma, PhaseFunction::Isotropic).unwrap()
}

pub(super) fn bits(picture: &[[f32; 4]]) -> Vec<[u32; 4]> {
    let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
    picture.iter().map(bits).collect()
}

/// What was there before.
pub(super) fn before(rays: usize) -> Vec<[f32; 4]> {
    (0..rays).map(|i| [0.1 * i as f32, 0.0, 0.5, 7.0]).collect()
}

/// The picture of lights one by one.
fn one_by_one<V: VisibilityOfMany, A: AirlightEvaluator>(
    rays: &Vec<Ray>,
    emitters: &[Emitter],
    medium: &Medium,
    touching: Touching,
    (sources, airlight): (&V, &A),
) -> Vec<[f32; 4]> {
    let mut sums = before(rays.len());
    for (light, emitter) in emitters.iter().enumerate() {
        let lit = LitRays {
            touching,
            ..LitRays::new(rays, emitter, medium)
        };
        let source = sources.of_light(light).unwrap();
        Cpu::new()
            .gather(&lit, source, airlight, &mut sums)
            .unwrap();
    }
    sums
}

fn check_pair<V: VisibilityOfMany, A: AirlightEvaluator>(
    rays: &Vec<Ray>,
    emitters: &[Emitter],
    medium: &Medium,
    touching: Touching,
    (sources, airlight): (&V, &A),
) {
    let cpu = Cpu::new();
    let expected = one_by_one(rays, emitters, medium, touching, (sources, airlight));
    let tiles = RayTiles::new(&cpu, rays, WIDTH, None).unwrap();
    let culled = TileLights::new(&cpu, &tiles, emitters).unwrap();
    let all = TileLights::all(&tiles, emitters.len());
    assert!(culled.entries() < all.entries());
    for lists in [culled, all] {
        let lit = LitByMany {
            touching,
            ..LitByMany::new(rays, emitters, &lists, medium)
        };
        let mut found = before(rays.len());
        cpu.gather_many(&lit, sources, airlight, &mut found)
            .unwrap();
        assert!(bits(&found) == bits(&expected));
    }
}

#[test]
fn lights_together_are_lights_one_by_one_bit_for_bit() {
    let mut random = Random::new(1);
    let quadrature = Quadrature::with_tolerance(PhaseFunction::Isotropic, 1e-3).unwrap();
    let table = Table::new(&PhaseFunction::Isotropic, 64).unwrap();
    let table = Analytic::new(table, quadrature.clone());
    let gauss = EquiAngular::new(5).unwrap();
    let open = fog();
    for set in 0..8 {
        let rays = rays(&mut random);
        let lights = lights(&mut random, &rays, 9 + set);
        let middle = rays[0].origin();
        let bounds = Bounds::new(middle - 3.0, middle + Vec3::new(9.0, 1.0, 20.0)).unwrap();
        for medium in [open, open.within(bounds)] {
            let apart = Touching::Apart;
            check_pair(&rays, &lights, &medium, apart, (&Unshadowed, &Midpoint));
            check_pair(&rays, &lights, &medium, apart, (&Unshadowed, &gauss));
            check_pair(&rays, &lights, &medium, apart, (&Unshadowed, &quadrature));
            check_pair(&rays, &lights, &medium, apart, (&Unshadowed, &table));
        }
    }
}

#[cfg(feature = "shadow-dag")]
pub(crate) mod shadowed {
    use std::sync::Arc;

    use super::*;
    use crate::precomputed::{BakedShadow, Builder, Resolution};
    use crate::scene::{Geometry, Mesh, Scene};

    /// Plates between lamps and rays.
    pub(crate) fn scattered_plates(random: &mut Random, rays: &[Ray]) -> Geometry {
        let mut positions = Vec::new();
        for _ in 0..40 {
            let ray = &rays[random.below(rays.len() as u32) as usize];
            let distance = random.log_uniform(0.1, 100.0) as f32;
            let mut corner =
                || ray.at(distance) + 0.3 * distance * Vec3::from_array(random.vector(1.0));
            positions.extend([corner(), corner(), corner()]);
        }
        let triangles = (0..40).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let scene = Scene::from(Mesh {
            triangles: triangles.collect(),
            positions,
            ..Mesh::default()
        });
        Geometry::new(&scene).unwrap()
    }

    /// What they shadow.
    pub(crate) fn plates(
        random: &mut Random,
        rays: &[Ray],
        emitters: &[Emitter],
    ) -> Vec<Arc<BakedShadow>> {
        let geometry = scattered_plates(random, rays);
        let side = Resolution::new(32).unwrap();
        let bake = |emitter: &Emitter| {
            BakedShadow::bake(&Cpu::new(), &geometry, emitter, side, Builder::new())
        };
        emitters
            .iter()
            .map(|emitter| Arc::new(bake(emitter).unwrap().0))
            .collect()
    }

    #[test]
    fn shadowed_lights_together_are_lights_one_by_one_bit_for_bit() {
        let mut random = Random::new(2);
        let gauss = EquiAngular::new(3).unwrap();
        for _ in 0..4 {
            let rays = rays(&mut random);
            let lights = lights(&mut random, &rays, 11);
            let shadows = plates(&mut random, &rays, &lights);
            check_pair(&rays, &lights, &fog(), Touching::Joined, (&shadows, &gauss));
        }
    }
}

/// The rays of some pixels in any order, some of them twice.
#[test]
fn rays_need_not_be_those_of_the_pixels_in_order() {
    let mut random = Random::new(3);
    let all = rays(&mut random);
    let lights = lights(&mut random, &all, 20);
    let mut pixels: Vec<u32> = (0..all.len() as u32).collect();
    random.shuffle(&mut pixels);
    pixels.truncate(200);
    pixels.extend_from_within(..9);
    let some: Vec<Ray> = pixels.iter().map(|pixel| all[*pixel as usize]).collect();
    let medium = fog();
    let expected = one_by_one(
        &some,
        &lights,
        &medium,
        Touching::Apart,
        (&Unshadowed, &Midpoint),
    );
    let tiles = RayTiles::new(&Cpu::new(), &some, WIDTH, Some(&pixels)).unwrap();
    let lists = TileLights::new(&Cpu::new(), &tiles, &lights).unwrap();
    let on = |cpu: Cpu| {
        let mut found = before(some.len());
        let lit = LitByMany::new(&some, &lights, &lists, &medium);
        cpu.gather_many(&lit, &Unshadowed, &Midpoint, &mut found)
            .unwrap();
        bits(&found)
    };
    assert!(on(Cpu::new()) == bits(&expected));
    #[cfg(feature = "rayon")]
    assert!(on(Cpu::single_threaded()) == on(Cpu::with_threads(3).unwrap()));
}

/// A lamp that moves in small steps over the borders of tiles, blocks and slices: its
/// picture is that without lists in each place, so that nothing pops.
#[test]
fn nothing_pops_when_a_light_crosses_a_border() {
    let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0).unwrap();
    let rays: Vec<Ray> = (0..WIDTH * 21)
        .map(|i| {
            let (x, y) = ((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5);
            Ray::new(Vec3::ZERO, camera.direction(x, y, WIDTH, 21), 12.0).unwrap()
        })
        .collect();
    let medium = fog();
    let tiles = RayTiles::new(&Cpu::new(), &rays, WIDTH, None).unwrap();
    let mut last = 0;
    let mut changes = 0;
    for step in 0..300 {
        let at = Vec3::new(0.02 * step as f32 - 3.0, 0.004 * step as f32, -8.0);
        let lamp = Emitter::point(at, Vec3::ONE, 0.6, Emission::Isotropic).unwrap();
        let emitters = [lamp];
        let lists = TileLights::new(&Cpu::new(), &tiles, &emitters).unwrap();
        changes += usize::from(lists.entries() != last);
        last = lists.entries();
        let mut found = before(rays.len());
        let lit = LitByMany::new(&rays, &emitters, &lists, &medium);
        Cpu::new()
            .gather_many(&lit, &Unshadowed, &Midpoint, &mut found)
            .unwrap();
        let expected = one_by_one(
            &rays,
            &emitters,
            &medium,
            Touching::Apart,
            (&Unshadowed, &Midpoint),
        );
        assert!(bits(&found) == bits(&expected), "{at}");
    }
    assert!(changes > 8, "{changes}");
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let mut random = Random::new(5);
    let rays = rays(&mut random);
    let emitters = lights(&mut random, &rays, 9);
    let medium = fog();
    let tiles = RayTiles::new(&Cpu::new(), &rays, WIDTH, None).unwrap();
    let lists = TileLights::new(&Cpu::new(), &tiles, &emitters).unwrap();
    let gather = |rays: &Vec<Ray>, emitters: &[Emitter], sums: usize| {
        let mut sums = before(sums);
        let lit = LitByMany::new(rays, emitters, &lists, &medium);
        let result = Cpu::new().gather_many(&lit, &Unshadowed, &Midpoint, &mut sums);
        assert_eq!(sums, before(sums.len()));
        result.unwrap_err()
    };
    for error in [
        gather(&rays, &emitters, 3),
        gather(&rays[1..].to_vec(), &emitters, rays.len() - 1),
        gather(&rays, &emitters[1..], rays.len()),
    ] {
        assert!(matches!(error, Error::LengthMismatch { .. }), "{error}");
    }
}
