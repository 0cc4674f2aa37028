//! Casters that are not solid.

use glam::Vec2;
use reference::random::Random;

use super::*;
use crate::Ray;
use crate::scene::{
    AlphaMode, Emission, Filter as TexelFilter, Geometry, Instance, Material, Medium, Mesh,
    PhaseFunction, Sampler, Scene, Texture, Wrap,
};

/// A square of side 2 at this height, of `material`.
fn plate(height: f32, material: Material) -> Scene {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let mut scene = Scene::from(Mesh {
        name: "plate".into(),
        positions: corners.map(|(x, z)| Vec3::new(x, height, z)).into(),
        texture_coordinates: corners
            .map(|(x, z)| 0.5 * Vec2::new(x + 1.0, z + 1.0))
            .into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..Mesh::default()
    });
    scene.materials.push(material);
    scene
}

fn tracer(scene: &Scene) -> Tracer {
    Tracer::new(&Geometry::new(scene).unwrap())
}

/// Opacities of 8 by 8 texels, at random.
fn pattern(filter: TexelFilter) -> Texture {
    let mut random = Random::new(4);
    let alpha = (0..64).map(|_| random.unit()).collect();
    let texture = Texture::new(8, 8, vec![Vec3::ONE; 64]).unwrap();
    texture.with_alpha(alpha).unwrap().with_sampler(Sampler {
        wrap: [Wrap::Clamp; 2],
        filter,
    })
}

fn lit(tracer: &Tracer, light: &Emitter, ray: &Ray) -> Vec<LitInterval<Vec3>> {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let mut lit = Vec::new();
    if let Some(path) = LightPath::new(ray, light, &medium) {
        Exact::new(tracer).lit_intervals(&path, &mut lit);
    }
    lit
}

fn lamp(position: Vec3) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
}

fn at(parts: &[LitInterval<Vec3>], x: f32) -> Vec3 {
    let part = parts
        .iter()
        .find(|p| p.interval.start <= x && x < p.interval.end);
    part.map_or(Vec3::ZERO, |part| part.visibility)
}

/// What gets to points of rays, by their shadow rays.
fn compare(scene: &Scene, allowed: f32, steps: bool) {
    let tracer = tracer(scene);
    let mut random = Random::new(11);
    let mut unit = || random.unit();
    let mut checked = 0;
    for round in 0..120 {
        let mut vector = |scale: f32| Vec3::new(unit(), unit(), unit()) * scale - 0.5 * scale;
        let position = Vec3::new(0.0, 2.0, 0.0) + vector(1.5);
        let light = if round % 2 == 0 {
            lamp(position)
        } else {
            Emitter::directional(-position, Vec3::ONE).unwrap()
        };
        let (origin, direction) = (vector(4.0), vector(1.0));
        let ray = Ray::new(origin, direction, 6.0).unwrap();
        let parts = lit(&tracer, &light, &ray);
        for k in 0..200 {
            let x = 6.0 * (k as f32 + 0.5) / 200.0;
            let is_end = |p: &LitInterval<Vec3>| {
                (p.interval.start - x).abs() < 1e-3 || (p.interval.end - x).abs() < 1e-3
            };
            if steps && parts.iter().any(is_end) {
                continue;
            }
            let here = ray.at(x);
            let (to_light, distance) = match &light {
                Emitter::Point(_) => (position - here, (position - here).length()),
                Emitter::Directional(sun) => (-sun.direction(), f32::INFINITY),
            };
            let share = tracer.transmittance(here, to_light.normalize(), 0.0, distance);
            let off = (at(&parts, x) - share).abs().max_element();
            assert!(off <= allowed, "round {round}, {x}: {off}, {share}");
            checked += usize::from(share != Vec3::ONE);
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn points_behind_a_mask_are_lit_where_their_shadow_rays_pass() {
    for filter in [TexelFilter::Linear, TexelFilter::Nearest] {
        let scene = plate(
            0.7,
            Material {
                base_color_texture: Some(pattern(filter)),
                alpha: AlphaMode::Mask { cutoff: 0.5 },
                ..Material::default()
            },
        );
        compare(&scene, 0.0, true);
    }
}

#[test]
fn points_behind_panes_get_what_their_shadow_rays_do() {
    let constant = Material {
        base_color: Vec3::new(0.2, 0.5, 0.9),
        transmission: 0.8,
        ..Material::default()
    };
    compare(&plate(0.7, constant), 1e-6, true);
    let varying = Material {
        base_color_texture: Some(pattern(TexelFilter::Linear)),
        alpha: AlphaMode::Blend,
        ..Material::default()
    };
    // Parts stand for as much as 1/64.
    compare(&plate(0.7, varying), 1.0 / 64.0, false);
}

#[test]
fn half_a_card_casts_the_shadow_of_half_a_card() {
    let texture = Texture::new(2, 1, vec![Vec3::ONE; 2]).unwrap();
    let texture = texture.with_alpha(vec![1.0, 0.0]).unwrap();
    let masked = tracer(&plate(
        1.0,
        Material {
            base_color_texture: Some(texture.with_sampler(Sampler {
                wrap: [Wrap::Clamp; 2],
                filter: TexelFilter::Linear,
            })),
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        },
    ));
    let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.1), Vec3::X, 10.0).unwrap();
    let parts = lit(&masked, &lamp(Vec3::new(0.0, 2.0, 0.1)), &ray);
    let ends: Vec<_> = parts
        .iter()
        .map(|p| [p.interval.start, p.interval.end])
        .collect();
    assert_eq!(ends, [[0.0, 3.0], [5.0, 10.0]]);
}

#[test]
fn what_casts_no_shadow_or_is_clear_is_as_if_it_were_not_there() {
    let clear = Material {
        opacity: 0.0,
        alpha: AlphaMode::Blend,
        ..Material::default()
    };
    let mut hidden = plate(1.0, Material::default());
    assert_eq!(hidden.set_casts_shadow("plate", false), 1);
    for scene in [plate(1.0, clear), hidden] {
        let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.1), Vec3::X, 10.0).unwrap();
        let parts = lit(&tracer(&scene), &lamp(Vec3::new(0.0, 2.0, 0.1)), &ray);
        assert_eq!(parts, [LitInterval::unshadowed(0.0, 10.0)]);
    }
}

#[test]
fn a_lamp_in_a_bulb_of_glass_lights_the_room() {
    let glass = Material {
        base_color: Vec3::new(1.0, 0.9, 0.5),
        transmission: 1.0,
        ..Material::default()
    };
    let mut scene = plate(0.5, glass);
    // A tetrahedron around the lamp.
    let tip = [
        (1.0, 1.0, 1.0),
        (1.0, -1.0, -1.0),
        (-1.0, 1.0, -1.0),
        (-1.0, -1.0, 1.0),
    ];
    scene.meshes[0] = Mesh {
        positions: tip.map(|(x, y, z)| Vec3::new(x, y + 3.0, z)).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        material: Some(0),
        ..Mesh::default()
    };
    scene.instances = vec![Instance::default()];
    let ray = Ray::new(Vec3::new(-5.0, -0.5, 0.1), Vec3::X, 10.0).unwrap();
    let parts = lit(&tracer(&scene), &lamp(Vec3::new(0.0, 3.0, 0.0)), &ray);
    assert_eq!(parts[0].interval.start, 0.0);
    assert_eq!(parts[parts.len() - 1].interval.end, 10.0);
    for part in &parts {
        let off = (part.visibility - Vec3::new(1.0, 0.9, 0.5))
            .abs()
            .max_element();
        assert!(off < 1e-6, "{part:?}");
    }
}
