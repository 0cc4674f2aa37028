//! Imperfect maps against exact ones.

use glam::{Vec2, Vec3};
use gpu_backend::{Cpu, Error, Host};

use super::points::LevelOfDetail;
use super::{
    CasterPoints, Casters, EMPTY, RenderImperfectMaps, RenderShadowMapAtlas, ShadowMapAtlas,
};
use crate::Emitter;
use crate::scene::{AlphaMode, Emission, Geometry, Material, Mesh, Scene, Texture};

/// A square around `centre`, of sides 2 `u` and 2 `v`.
fn square(mesh: &mut Mesh, centre: Vec3, u: Vec3, v: Vec3) {
    let first = mesh.positions.len() as u32;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    mesh.positions
        .extend(corners.map(|(x, y)| centre + x * u + y * v));
    let corner = |i: u32| first + i;
    mesh.triangles
        .extend([[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(corner)));
}

fn geometry(mesh: Mesh) -> Geometry {
    Geometry::new(&Scene::from(mesh)).expect("a mesh is a scene")
}

/// A plate of 1 m² half a metre below the light, far above a large floor.
fn plate() -> Geometry {
    let mut mesh = Mesh::default();
    let (x, z) = (Vec3::X, Vec3::Z);
    square(&mut mesh, Vec3::new(0.0, 2.5, 0.0), 0.5 * x, 0.5 * z);
    square(&mut mesh, Vec3::ZERO, 20.0 * x, 20.0 * z);
    geometry(mesh)
}

fn light(emission: Emission) -> [Emitter; 1] {
    let position = Vec3::new(0.01, 3.0, 0.02);
    [Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).expect("a lamp")]
}

fn down() -> [Emitter; 1] {
    light(Emission::Cosine {
        normal: Vec3::NEG_Y,
    })
}

fn imperfect(
    geometry: &Geometry,
    lights: &[Emitter],
    points: u32,
    level: LevelOfDetail,
) -> ShadowMapAtlas<Host> {
    let cpu = Cpu::new();
    let casters = CasterPoints::sample(&cpu, geometry, 1 << 16).expect("few points");
    cpu.imperfect_maps(&casters, lights, 128, points, level)
        .expect("small maps")
}

fn depth(maps: &ShadowMapAtlas<Host>, direction: Vec3) -> f32 {
    use voxel_shadow::AtlasBlocker;
    let ray = epipolar::LightRay {
        origin: [0.01, 3.0, 0.02],
        direction: direction.normalize().into(),
    };
    maps.of_tiles(&[0])
        .expect("maps of one tile")
        .distance(0, &ray)
}

/// Directions from the light towards points of a horizontal square.
fn towards(y: f32, half: f32) -> Vec<Vec3> {
    let at = |i: i32| (i as f32 + 0.5) / 40.0 * half;
    (-40..40)
        .flat_map(|i| (-40..40).map(move |k| Vec3::new(at(i), y, at(k))))
        .map(|point| point - Vec3::new(0.01, 3.0, 0.02))
        .collect()
}

#[test]
fn the_level_of_detail_cuts_leaks_near_the_light_at_least_five_times() {
    let geometry = plate();
    // The border of the plate is left out: texels there may see either.
    let inside = towards(2.5, 0.45);
    let leaks = |level, points| {
        let maps = imperfect(&geometry, &down(), points, level);
        let leaks = inside.iter().filter(|v| depth(&maps, **v) > 1.0).count();
        println!("{level:?} {points}: {leaks} of {} leak", inside.len());
        leaks
    };
    for points in [512, 2048, 8192] {
        let even = leaks(LevelOfDetail::Even, points);
        let near = leaks(LevelOfDetail::Near, points);
        assert!(5 * near <= even, "{points}: {near} {even}");
    }
}

#[test]
fn splats_are_where_the_surface_is_and_leave_few_holes() {
    let mut mesh = Mesh::default();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for i in 0..3 {
        let [n, u, v] = [0, 1, 2].map(|k| 2.0 * axes[(i + k) % 3]);
        let centre = Vec3::new(0.01, 3.0, 0.02);
        square(&mut mesh, centre + n, u, v);
        square(&mut mesh, centre - n, u, v);
    }
    let room = geometry(mesh);
    for emission in [Emission::Isotropic, Emission::Cosine { normal: Vec3::Y }] {
        let lights = light(emission);
        let maps = imperfect(&room, &lights, 16_384, LevelOfDetail::Near);
        let empty = maps.depth().iter().filter(|depth| **depth == EMPTY).count();
        // Splats of twice the area of a surface leave e⁻² of it uncovered if they are
        // independent, and even ones leave less.
        let most = (-2.0_f64).exp() * maps.depth().len() as f64;
        assert!((empty as f64) < most, "{empty} holes");
        for direction in [Vec3::new(0.1, 1.0, 0.3), Vec3::new(1.0, 0.9, -0.7)] {
            let exact = 2.0 / direction.normalize().abs().max_element();
            let found = depth(&maps, direction);
            assert!((found / exact - 1.0).abs() < 0.1, "{found} {exact}");
        }
    }
    // Behind a hemisphere there is nothing.
    let maps = imperfect(&room, &down(), 4096, LevelOfDetail::Near);
    assert_eq!(depth(&maps, Vec3::new(0.3, 1.0, 0.1)), EMPTY);
}

#[test]
fn parallel_light_sees_the_points_in_parallel() {
    let geometry = plate();
    let sun = [Emitter::directional(Vec3::new(0.2, -1.0, 0.1), Vec3::ONE).unwrap()];
    let found = imperfect(&geometry, &sun, 1 << 16, LevelOfDetail::Near);
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &geometry).unwrap();
    let exact = cpu.shadow_map_atlas(&casters, &sun, 128).unwrap();
    let near = |(a, b): (&f32, &f32)| a == b || (a - b).abs() < 0.3;
    let same = found.depth().iter().zip(exact.depth()).filter(|p| near(*p));
    let share = same.count() as f64 / exact.depth().len() as f64;
    // All but a row of texels along the borders.
    assert!(share > 0.93, "{share}");
}

#[test]
fn a_light_takes_what_it_is_allowed_and_each_point_stands_for_its_area() {
    let geometry = plate();
    let casters = CasterPoints::sample(&Cpu::new(), &geometry, 10_000).unwrap();
    assert_eq!(casters.points().len(), 10_000);
    let place = Some(Vec3::new(0.0, 3.0, 0.0));
    for level in [LevelOfDetail::Even, LevelOfDetail::Near] {
        for budget in [0, 1, 100, 5000, 10_000, 1 << 20] {
            let taken = casters.taken(place, budget, level);
            let count: u32 = taken.iter().map(|taken| taken.count).sum();
            let expected = f64::from(budget.min(10_000));
            let off = (f64::from(count) - expected).abs();
            assert!(off <= 0.02 * expected + 12.0, "{level:?} {budget}: {count}");
            for (cluster, taken) in casters.clusters().iter().zip(&taken) {
                assert!(taken.count <= cluster.count && taken.area > 0.0);
            }
        }
    }
    let taken = casters.taken(place, 1000, LevelOfDetail::Even);
    let area: f64 = taken
        .iter()
        .map(|t| f64::from(t.count) * f64::from(t.area))
        .sum();
    assert!((area / 1601.0 - 1.0).abs() < 0.02, "{area}");
    // A parallel light has no near.
    let [even, near] = [LevelOfDetail::Even, LevelOfDetail::Near];
    assert_eq!(casters.taken(None, 99, even), casters.taken(None, 99, near));
}

#[test]
fn more_points_than_memory_should_hold_are_refused() {
    let sample = |count| CasterPoints::sample(&Cpu::new(), &plate(), count);
    for count in [(1 << 24) + 1, u32::MAX] {
        assert!(matches!(sample(count), Err(Error::TooLarge { .. })));
    }
}

#[test]
fn holes_of_masks_have_no_points_and_no_scene_has_no_maps() {
    let mut mesh = Mesh {
        material: Some(0),
        texture_coordinates: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|(u, v)| Vec2::new(u, v))
            .into(),
        ..Mesh::default()
    };
    square(&mut mesh, Vec3::ZERO, Vec3::X, Vec3::Z);
    let texture = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
    let material = Material {
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(texture.with_alpha(vec![0.0, 1.0]).unwrap()),
        ..Material::default()
    };
    let scene = Scene {
        materials: vec![material],
        ..Scene::from(mesh)
    };
    let cpu = Cpu::new();
    let geometry = Geometry::new(&scene).unwrap();
    let casters = CasterPoints::sample(&cpu, &geometry, 1000).unwrap();
    let left = casters.points().iter().filter(|point| point[0] < 0.0);
    assert!((400..600).contains(&casters.points().len()));
    assert!(left.count() * 20 < casters.points().len());

    let none = CasterPoints::sample(&cpu, &geometry, 0).unwrap();
    let maps = cpu.imperfect_maps(&none, &down(), 8, 100, LevelOfDetail::Near);
    assert!(maps.unwrap().depth().iter().all(|depth| *depth == EMPTY));
    let maps = cpu.imperfect_maps(&casters, &[], 8, 100, LevelOfDetail::Near);
    assert_eq!(maps.unwrap().lights(), 0);
    let maps = cpu.imperfect_maps(&casters, &down(), 0, 100, LevelOfDetail::Near);
    assert!(maps.is_err());
}
