//! Casters that are not solid, in a room with fog, at which maps, marches and bakes
//! are known to break.

use glam::{Affine3A, Mat2, Quat, Vec2, Vec3};
use scene::{
    AlphaMode, Camera, DirectionalLight, Filter, Instance, Light, Material, Medium, Mesh,
    PhaseFunction, PointLight, Sampler, Scene, Texture, Wrap,
};

use crate::random::Random;

/// A room, and something in it that is not solid.
#[derive(Debug, Clone)]
pub struct CasterCase {
    /// What is hard about it.
    pub name: &'static str,
    /// With a camera, lights and a medium.
    pub scene: Scene,
    /// A scene with the same picture in which all is solid.
    pub twin: Option<Scene>,
}

/// All of them.
pub fn caster_cases() -> Vec<CasterCase> {
    let mut list = Vec::new();
    let mut add = |name, scene, twin| list.push(CasterCase { name, scene, twin });
    let blend = |opacity| Material {
        opacity,
        alpha: AlphaMode::Blend,
        ..white()
    };
    let empty = room(Vec::new());
    let solid = room(vec![card(white())]);

    let masked = |texture: Texture| Material {
        base_color_texture: Some(texture),
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        ..white()
    };
    let mosaic = |filter| pattern(8, 8, filter, Wrap::Clamp);
    add(
        "a mask",
        room(vec![card(masked(mosaic(Filter::Linear)))]),
        None,
    );
    add(
        "a mask of squares",
        room(vec![card(masked(mosaic(Filter::Nearest)))]),
        None,
    );
    let texel = |alpha| {
        let texture = Texture::new(1, 1, vec![Vec3::ONE]).expect("a texel");
        masked(texture.with_alpha(vec![alpha]).expect("an opacity"))
    };
    let there = room(vec![card(texel(0.7))]);
    add(
        "a mask of one texel that is there",
        there,
        Some(solid.clone()),
    );
    let missing = room(vec![card(texel(0.3))]);
    add(
        "a mask of one texel that is not there",
        missing,
        Some(empty.clone()),
    );
    let turned = pattern(5, 3, Filter::Linear, Wrap::Mirror);
    let mut turned = card(masked(turned));
    let turn = Mat2::from_angle(0.7) * Mat2::from_diagonal(Vec2::new(2.3, -1.7));
    for uv in &mut turned.mesh.texture_coordinates {
        *uv = turn * *uv + Vec2::new(-0.4, 3.3);
    }
    add("a mask with a transform", room(vec![turned]), None);
    for (name, value) in [
        ("a mask whose coordinates are not numbers", f32::NAN),
        ("a mask whose coordinates are infinite", f32::INFINITY),
    ] {
        // The first texel is all there is.
        let mut alpha = vec![0.0; 4];
        alpha[0] = 1.0;
        let texture = Texture::new(2, 2, vec![Vec3::ONE; 4]).expect("four texels");
        let mut card = card(masked(texture.with_alpha(alpha).expect("opacities")));
        card.mesh.texture_coordinates[1].x = value;
        card.mesh.texture_coordinates[3].y = value;
        add(name, room(vec![card]), Some(solid.clone()));
    }

    add("alpha 0", room(vec![card(blend(0.0))]), Some(empty.clone()));
    add("alpha 1", room(vec![card(blend(1.0))]), Some(solid.clone()));
    add("alpha 0.4", room(vec![card(blend(0.4))]), None);
    let film = Material {
        base_color_texture: Some(pattern(6, 6, Filter::Linear, Wrap::Clamp)),
        ..blend(1.0)
    };
    add("a film", room(vec![card(film)]), None);
    add("a coloured pane", room(vec![card(glass())]), None);
    let etched = Material {
        transmission_texture: Some(pattern(4, 4, Filter::Nearest, Wrap::Clamp)),
        ..glass()
    };
    let mut etched = card(etched);
    etched.mesh.transmission_coordinates = etched.mesh.texture_coordinates.clone();
    add("a pane whose transmission varies", room(vec![etched]), None);
    // In the plane of the wall, and before it by less than a shadow map knows.
    let mut on_the_wall = Piece {
        transform: Affine3A::from_translation(Vec3::new(0.2, 0.1, -4.0)),
        ..card(glass())
    };
    on_the_wall.mesh.transmission_coordinates = Vec::new();
    add("a pane on a wall", room(vec![on_the_wall]), None);
    add("a lamp in a bulb", room(vec![bulb()]), None);
    let stack = (0..20).map(|i| Piece {
        transform: Affine3A::from_translation(Vec3::new(0.02, 0.0, 0.04) * i as f32)
            * card(white()).transform,
        ..card(Material {
            transmission: 0.9,
            ..white()
        })
    });
    add("twenty panes", room(stack.collect()), None);
    let mut absent = room(vec![card(glass())]);
    absent.instances[1].no_shadow = true;
    add("a pane that casts no shadow", absent, None);
    list
}

/// A part of a scene.
#[derive(Debug, Clone)]
struct Piece {
    mesh: Mesh,
    material: Material,
    transform: Affine3A,
}

fn white() -> Material {
    Material {
        base_color: Vec3::ONE,
        ..Material::default()
    }
}

fn glass() -> Material {
    Material {
        base_color: Vec3::new(0.9, 0.45, 0.1),
        transmission: 0.9,
        ..white()
    }
}

/// Opacities and reds at random.
fn pattern(width: u32, height: u32, filter: Filter, wrap: Wrap) -> Texture {
    let mut random = Random::new(21);
    let count = (width * height) as usize;
    let texels = (0..count).map(|_| Vec3::new(random.unit(), 1.0, 1.0));
    let texture = Texture::new(width, height, texels.collect()).expect("texels");
    let alpha = (0..count).map(|_| random.unit()).collect();
    let wrap = [wrap; 2];
    let texture = texture.with_alpha(alpha).expect("opacities");
    texture.with_sampler(Sampler { wrap, filter })
}

/// A square of side 1.6 between the lights and the wall, that the eye sees beside and
/// through.
fn card(material: Material) -> Piece {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Piece {
        mesh: Mesh {
            positions: corners
                .map(|(x, y)| Vec3::new(0.8 * x, 0.8 * y, 0.0))
                .into(),
            texture_coordinates: corners
                .map(|(x, y)| Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y))
                .into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        },
        material,
        transform: Affine3A::from_rotation_translation(
            Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-0.2),
            Vec3::new(0.3, 0.4, -1.5),
        ),
    }
}

/// An octahedron of glass around the lamp.
fn bulb() -> Piece {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let positions: Vec<Vec3> = axes.into_iter().flat_map(|axis| [axis, -axis]).collect();
    let mut triangles = Vec::new();
    for x in [0, 1] {
        for y in [2, 3] {
            for z in [4, 5] {
                let is_even = (x + y + z) % 2 == 0;
                triangles.push(if is_even { [x, y, z] } else { [x, z, y] });
            }
        }
    }
    Piece {
        mesh: Mesh {
            positions: positions.iter().map(|p| 0.25 * *p).collect(),
            triangles,
            ..Mesh::default()
        },
        material: glass(),
        transform: Affine3A::from_rotation_translation(
            Quat::from_rotation_y(0.3) * Quat::from_rotation_z(0.5),
            LAMP,
        ),
    }
}

const LAMP: Vec3 = Vec3::new(0.9, 1.1, -0.6);

/// The room with an opaque card.
pub(super) fn solid_room() -> Scene {
    room(vec![card(white())])
}

/// A back wall, a floor and a beam, which hold whatever else there is, a sun, a lamp
/// and fog.
fn room(pieces: Vec<Piece>) -> Scene {
    let quad =
        |corner: Vec3, u: Vec3, v: Vec3| vec![corner, corner + u, corner + u + v, corner + v];
    let mut positions = quad(Vec3::new(-3.0, -1.5, -4.0), 6.0 * Vec3::X, 4.0 * Vec3::Y);
    positions.extend(quad(
        Vec3::new(-3.0, -1.5, -4.0),
        5.0 * Vec3::Z,
        6.0 * Vec3::X,
    ));
    positions.extend(quad(
        Vec3::new(-1.2, -1.0, -2.5),
        Vec3::new(0.1, 3.0, 0.0),
        0.15 * Vec3::X,
    ));
    let walls = Mesh {
        positions,
        triangles: (0..3)
            .flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]])
            .collect(),
        material: Some(0),
        ..Mesh::default()
    };
    let mut scene = Scene {
        name: "a room".into(),
        meshes: vec![walls],
        materials: vec![Material::default()],
        instances: vec![Instance::default()],
        camera: Some(
            Camera::new(Vec3::new(-0.3, 0.4, 2.5), Quat::IDENTITY, 0.9).expect("a camera"),
        ),
        lights: vec![
            Light::Directional(DirectionalLight {
                direction: Vec3::new(-0.4, -0.6, -1.0),
                irradiance: Vec3::new(1.0, 1.1, 1.2),
                ..DirectionalLight::default()
            }),
            Light::Point(PointLight {
                position: LAMP,
                intensity: Vec3::splat(2.0),
                ..PointLight::default()
            }),
        ],
        medium: Some(
            Medium::new(
                Vec3::splat(0.09),
                Vec3::splat(0.01),
                PhaseFunction::Isotropic,
            )
            .expect("fog"),
        ),
        ..Scene::default()
    };
    for piece in pieces {
        scene.instances.push(Instance {
            mesh: scene.meshes.len(),
            transform: piece.transform,
            ..Instance::default()
        });
        scene.meshes.push(Mesh {
            material: Some(scene.materials.len()),
            ..piece.mesh
        });
        scene.materials.push(piece.material);
    }
    scene
}
