//! Lights, media, rays and casters of every kind.

use glam::{Quat, Vec2, Vec3};
use reference::random::Random;

use crate::scene::{
    AlphaMode, Bounds, Cone, Emission, Filter, Geometry, Instance, Material, Medium, Mesh,
    PhaseFunction, Sampler, Scene, Texture, Wrap,
};
use crate::{Emitter, Ray};

const LIGHT: Vec3 = Vec3::new(1.0, 2.0, -4.0);

pub(super) fn lights() -> Vec<(&'static str, Emitter)> {
    let point = |range, emission| {
        Emitter::point(LIGHT, Vec3::new(50.0, 30.0, 5.0), range, emission).unwrap()
    };
    let spot = |inner, outer, cookie| {
        let rotation = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-0.7);
        Emission::spot(rotation, Cone { inner, outer }, cookie).unwrap()
    };
    let texels = (0..35)
        .map(|i| Vec3::new(i as f32, 1.0, (i % 3) as f32))
        .collect();
    let cookie = Texture::new(7, 5, texels).unwrap();
    vec![
        ("point", point(f32::INFINITY, Emission::Isotropic)),
        ("range", point(3.0, Emission::Isotropic)),
        (
            "cosine",
            point(
                f32::INFINITY,
                Emission::Cosine {
                    normal: Vec3::new(0.6, -0.8, 0.0),
                },
            ),
        ),
        ("spot", point(f32::INFINITY, spot(0.2, 0.6, None))),
        (
            "half space",
            point(9.0, spot(0.0, std::f32::consts::FRAC_PI_2, None)),
        ),
        ("cookie", point(f32::INFINITY, spot(0.1, 0.8, Some(cookie)))),
        (
            "sun",
            Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::splat(4.0)).unwrap(),
        ),
        (
            "sun along an axis",
            Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap(),
        ),
    ]
}

pub(super) fn media() -> Vec<(&'static str, Medium)> {
    let medium = |s: Vec3, a: Vec3, phase| Medium::new(s, a, phase).unwrap();
    let thin = medium(
        Vec3::splat(0.02),
        Vec3::new(0.0, 0.01, 0.02),
        PhaseFunction::Isotropic,
    );
    let forward = PhaseFunction::HenyeyGreenstein { g: 0.8 };
    let bounds = Bounds::new(Vec3::new(-3.0, -1.0, -8.0), Vec3::new(4.0, 3.0, 1.0)).unwrap();
    vec![
        ("thin", thin),
        (
            "dense",
            medium(
                Vec3::new(1.0, 0.5, 2.0),
                Vec3::ZERO,
                PhaseFunction::Rayleigh,
            ),
        ),
        (
            "forward",
            medium(Vec3::splat(0.1), Vec3::splat(0.1), forward),
        ),
        (
            "backward",
            medium(
                Vec3::splat(0.1),
                Vec3::ZERO,
                PhaseFunction::HenyeyGreenstein { g: -0.5 },
            ),
        ),
        // The other colours are clear all the way to the sky.
        (
            "red",
            medium(
                Vec3::new(0.1, 0.0, 0.0),
                Vec3::ZERO,
                PhaseFunction::Isotropic,
            ),
        ),
        (
            "box",
            medium(Vec3::splat(0.3), Vec3::splat(0.1), forward).within(bounds),
        ),
    ]
}

fn vector(random: &mut Random) -> Vec3 {
    random.vector(1.0).into()
}

/// A third passes the light at `closest` to 1 of its distance.
pub(super) fn rays(count: usize, closest: f32) -> Vec<Ray> {
    let mut random = Random::new(7);
    (0..count)
        .map(|i| {
            let origin = 5.0 * vector(&mut random);
            let direction = match i % 3 {
                0 => {
                    let to_light = LIGHT - origin;
                    let aside = to_light.cross(vector(&mut random)).normalize_or(Vec3::X);
                    to_light + to_light.length() * closest.powf(random.unit()) * aside
                }
                _ => vector(&mut random),
            };
            let length = match i % 5 {
                0 => f32::INFINITY,
                1 => 0.0,
                _ => 30.0 * random.unit(),
            };
            Ray::new(origin, direction, length).unwrap()
        })
        .collect()
}

/// Two hundred triangles in the space around the light.
pub(super) fn casters() -> Geometry {
    let mut random = Random::new(99);
    let positions: Vec<Vec3> = (0..200)
        .flat_map(|_| {
            let corner = 6.0 * vector(&mut random);
            [
                corner,
                corner + vector(&mut random),
                corner + vector(&mut random),
            ]
        })
        .collect();
    let mesh = Mesh {
        triangles: (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        positions,
        ..Mesh::default()
    };
    let scene = Scene::from(mesh);
    Geometry::new(&scene).unwrap()
}

/// The same triangles, of which two of three are see-through, in colours and in grey.
#[cfg(feature = "translucent")]
pub(super) fn glass_casters() -> Geometry {
    let mut scene = Scene::default();
    for (color, transmission, opacity) in [
        (Vec3::new(0.9, 0.5, 0.2), 0.9, 1.0),
        (Vec3::new(0.3, 0.6, 1.0), 0.8, 1.0),
        (Vec3::ONE, 0.0, 0.35),
        (Vec3::ONE, 0.0, 1.0),
    ] {
        scene.materials.push(Material {
            base_color: color,
            transmission,
            opacity,
            alpha: AlphaMode::Blend,
            ..Material::default()
        });
    }
    for (index, corners) in casters().triangles().iter().enumerate() {
        scene.meshes.push(Mesh {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            material: Some(if index % 3 == 0 { 3 } else { index % 4 }),
            ..Mesh::default()
        });
        scene.instances.push(Instance {
            mesh: index,
            ..Instance::default()
        });
    }
    Geometry::new(&scene).unwrap()
}

/// The same triangles, of which every other is masked and every fifth see-through.
pub(super) fn masked_casters() -> Geometry {
    let solid = casters();
    let mut random = Random::new(98);
    let alpha = (0..64).map(|_| random.unit()).collect();
    let texture = Texture::new(8, 8, vec![Vec3::ONE; 64]).unwrap();
    let texture = texture.with_alpha(alpha).unwrap();
    let masks = [
        (Wrap::Repeat, Filter::Linear),
        (Wrap::Mirror, Filter::Linear),
        (Wrap::Clamp, Filter::Nearest),
        (Wrap::Repeat, Filter::Nearest),
    ];
    let mask = |(wrap, filter): (Wrap, Filter)| Material {
        base_color_texture: Some(texture.clone().with_sampler(Sampler {
            wrap: [wrap; 2],
            filter,
        })),
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        ..Material::default()
    };
    let mut scene = Scene {
        materials: masks.map(mask).to_vec(),
        ..Scene::default()
    };
    scene.materials.push(Material {
        transmission: 0.5,
        ..Material::default()
    });
    for (index, corners) in solid.triangles().iter().enumerate() {
        let mut coordinate = || 4.0 * Vec2::new(random.unit(), random.unit()) - 2.0;
        scene.meshes.push(Mesh {
            positions: corners.to_vec(),
            texture_coordinates: vec![coordinate(), coordinate(), coordinate()],
            triangles: vec![[0, 1, 2]],
            material: match index {
                _ if index % 5 == 0 => Some(4),
                _ if index % 2 == 0 => Some(index / 2 % 4),
                _ => None,
            },
            ..Mesh::default()
        });
        scene.instances.push(Instance {
            mesh: index,
            ..Instance::default()
        });
    }
    Geometry::new(&scene).unwrap()
}
