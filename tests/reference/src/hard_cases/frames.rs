//! Small pictures of whole scenes at which methods are known to break: what is extreme
//! is the fog, the light, the view, the casters, the place of all of it or the picture.

use std::f32::consts::PI;

use glam::{Affine3A, Quat, Vec3};
use scene::{
    AreaLight, AreaShape, Bounds, Camera, Cone, DensityGrid, DirectionalLight, HeightFog, Instance,
    Interpolation, Light, Medium, Mesh, PhaseFunction, PointLight, Scene, SpotLight, StrandPoint,
    Strands,
};

use super::casters::solid_room;
use crate::random::Random;

/// A scene that is hard in one respect.
#[derive(Debug, Clone)]
pub struct FrameCase {
    /// What is hard about it.
    pub name: &'static str,
    /// With a camera, lights and a medium.
    pub scene: Scene,
    /// Width and height of its picture, pixels; no side is longer than 32.
    pub size: [u32; 2],
}

/// All of them.
pub fn frame_cases() -> Vec<FrameCase> {
    let mut list = List::default();
    fogs(&mut list);
    lights(&mut list);
    spots(&mut list);
    views(&mut list);
    casters(&mut list);
    places(&mut list);
    smoke(&mut list);
    pictures(&mut list);
    list.0
}

/// A case that is hard because there is so much of something: its scene takes minutes and
/// gigabytes, and is made only when it is asked for.
#[derive(Debug, Clone, Copy)]
pub struct LargeCase {
    /// What there is so much of.
    pub name: &'static str,
    scene: fn() -> Scene,
}

impl LargeCase {
    /// Makes the scene.
    pub fn make(&self) -> FrameCase {
        FrameCase {
            name: self.name,
            scene: (self.scene)(),
            size: SIZE,
        }
    }
}

/// All of those, for release builds: the library of the hierarchy of triangles checks chains of
/// nodes by recursion in debug builds.
pub fn large_frame_cases() -> Vec<LargeCase> {
    let cases: [(_, fn() -> Scene); 4] = [
        ("ten million triangles", || hills(2237)),
        ("a triangle 100,000 times at one place", || {
            behind(TRIANGLE.to_vec(), vec![[0, 1, 2]; 100_000])
        }),
        ("100,000 hairs at one place", || hairs(100_000)),
        ("smoke of 256³ voxels", || {
            in_smoke(256, 1.0, Interpolation::Linear)
        }),
    ];
    let case = |(name, scene)| LargeCase { name, scene };
    cases.map(case).into()
}

const SIZE: [u32; 2] = [13, 7];
const EYE: Vec3 = Vec3::new(-0.3, 0.4, 2.5);
const LAMP: Vec3 = Vec3::new(0.9, 1.1, -0.6);
const FIELD_OF_VIEW: f32 = 0.9;

#[derive(Default)]
struct List(Vec<FrameCase>);

impl List {
    fn add(&mut self, name: &'static str, scene: Scene) {
        self.sized(name, scene, SIZE);
    }

    fn sized(&mut self, name: &'static str, scene: Scene, size: [u32; 2]) {
        self.0.push(FrameCase { name, scene, size });
    }
}

/// A room with a beam and a card, in fog, and this light alone.
fn lit_by(light: Light) -> Scene {
    Scene {
        lights: vec![light],
        ..solid_room()
    }
}

fn lamp_at(position: Vec3) -> Light {
    Light::Point(PointLight {
        position,
        intensity: Vec3::splat(2.0),
        range: f32::INFINITY,
        ..PointLight::default()
    })
}

fn sun_along(direction: Vec3) -> Light {
    Light::Directional(DirectionalLight {
        direction,
        irradiance: Vec3::ONE,
        ..DirectionalLight::default()
    })
}

/// By the lamp of the room.
fn lamp() -> Scene {
    lit_by(lamp_at(LAMP))
}

fn sun() -> Scene {
    lit_by(sun_along(Vec3::new(-0.4, -0.6, -1.0)))
}

fn fog(sigma_s: Vec3, sigma_a: Vec3, phase: PhaseFunction) -> Option<Medium> {
    Some(Medium::new(sigma_s, sigma_a, phase).expect("fog"))
}

fn even(sigma: f32) -> Option<Medium> {
    fog(Vec3::splat(sigma), Vec3::ZERO, PhaseFunction::Isotropic)
}

fn in_fog(scene: Scene, medium: Option<Medium>) -> Scene {
    Scene { medium, ..scene }
}

fn fogs(list: &mut List) {
    list.add("an optical depth of 1e-6", in_fog(lamp(), even(3e-7)));
    list.add(
        "an optical depth of 1e3, a lamp",
        in_fog(lamp(), even(300.0)),
    );
    list.add("an optical depth of 1e3, a sun", in_fog(sun(), even(300.0)));
    list.add("an optical depth of 1e6", in_fog(lamp(), even(3e5)));
    let colours = Vec3::new(0.0, 1e-3, 1e3);
    list.add(
        "a channel that scatters nothing, one little, one 1e3 a metre",
        in_fog(lamp(), fog(colours, Vec3::ZERO, PhaseFunction::Isotropic)),
    );
    list.add(
        "a channel that only absorbs",
        in_fog(
            sun(),
            fog(
                Vec3::new(0.2, 0.1, 0.0),
                Vec3::new(0.0, 10.0, 1.0),
                PhaseFunction::Isotropic,
            ),
        ),
    );
    list.add(
        "the least extinction that there is",
        in_fog(lamp(), even(1e-15)),
    );
    for (name, g) in [("g = 0.999", 0.999), ("g = −0.999", -0.999)] {
        let phase = PhaseFunction::HenyeyGreenstein { g };
        let medium = fog(Vec3::splat(0.1), Vec3::ZERO, phase);
        list.add(name, in_fog(lamp(), medium));
    }
}

fn lights(list: &mut List) {
    let ahead = Vec3::NEG_Z;
    for (name, distance) in [
        ("a lamp at the eye", 0.0),
        ("a lamp 1e-7 m from the eye", 1e-7),
        ("a lamp 1e-5 m from the eye", 1e-5),
        ("a lamp 1e-3 m from the eye", 1e-3),
    ] {
        list.add(
            name,
            lit_by(lamp_at(EYE + distance * Vec3::new(0.6, -0.8, 0.0))),
        );
    }
    list.add("a lamp behind the eye", lit_by(lamp_at(EYE - 0.5 * ahead)));
    list.add(
        "a lamp in the middle of a pixel",
        lit_by(lamp_at(EYE + 3.0 * ahead)),
    );
    list.add(
        "a lamp 1e-7 beside the middle of a pixel",
        lit_by(lamp_at(EYE + 3.0 * ahead + 3e-7 * Vec3::X)),
    );
    list.add(
        "a lamp in the wall",
        lit_by(lamp_at(Vec3::new(-0.3, 0.4, -4.0))),
    );
    list.add(
        "a lamp in a corner",
        lit_by(lamp_at(Vec3::new(3.0, -1.5, -4.0))),
    );
    list.add(
        "a lamp 1e-6 m before the wall",
        lit_by(lamp_at(Vec3::new(0.5, 0.5, -4.0 + 1e-6))),
    );
    let mut distant = lamp_at(1e6 * Vec3::new(0.36, 0.48, 0.8));
    if let Light::Point(lamp) = &mut distant {
        lamp.intensity *= 1e12;
    }
    list.add("a lamp 1e6 m away", lit_by(distant));
    let mut bright = lamp_at(LAMP);
    if let Light::Point(lamp) = &mut bright {
        lamp.intensity = Vec3::new(1e-20, 1.0, 1e20);
    }
    list.add("a lamp of 1e-20 red and 1e20 blue", lit_by(bright));
    let mut short = lamp_at(LAMP);
    if let Light::Point(lamp) = &mut short {
        lamp.range = 1e-3;
    }
    list.add("a range of a millimetre", lit_by(short));
    list.add("a sun along the view", lit_by(sun_along(ahead)));
    list.add("a sun against the view", lit_by(sun_along(-ahead)));
    list.add(
        "a sun along the floor",
        lit_by(sun_along(Vec3::new(-1.0, 0.0, 0.0))),
    );
    list.add(
        "an area light of a micrometre",
        lit_by(Light::Area(AreaLight {
            name: String::new(),
            shape: AreaShape::Rectangle,
            corner: LAMP,
            edges: [1e-6 * Vec3::X, 1e-6 * Vec3::Z],
            radiance: Vec3::splat(1e12),
            texture: None,
        })),
    );
}

fn spots(list: &mut List) {
    for (name, degrees) in [("a spot of 0.1°", 0.1_f32), ("a spot of 179.9°", 179.9)] {
        let outer = 0.5 * degrees.to_radians();
        let spot = SpotLight {
            position: LAMP,
            rotation: Quat::from_rotation_arc(
                Vec3::NEG_Z,
                (Vec3::new(-0.3, 0.2, -2.0) - LAMP).normalize(),
            ),
            intensity: Vec3::splat(3.0),
            cone: Cone {
                inner: 0.5 * outer,
                outer,
            },
            ..SpotLight::default()
        };
        list.add(name, lit_by(Light::Spot(spot)));
    }
}

fn seen(scene: Scene, eye: Vec3, rotation: Quat, field_of_view: f32) -> Scene {
    let camera = Camera::new(eye, rotation, field_of_view).expect("a camera");
    Scene {
        camera: Some(camera),
        ..scene
    }
}

fn views(list: &mut List) {
    for (name, degrees) in [("a view of 0.1°", 0.1_f32), ("a view of 177°", 177.0)] {
        list.add(
            name,
            seen(lamp(), EYE, Quat::IDENTITY, degrees.to_radians()),
        );
    }
    let to_wall = Vec3::new(0.5, 0.5, -4.0 + 1e-6);
    list.add(
        "an eye 1e-6 m before the wall",
        seen(lamp(), to_wall, Quat::IDENTITY, FIELD_OF_VIEW),
    );
    list.add(
        "an eye that looks up into endless fog",
        seen(sun(), EYE, Quat::from_rotation_x(0.5 * PI), FIELD_OF_VIEW),
    );
    list.add(
        "an eye inside of the beam",
        seen(
            lamp(),
            Vec3::new(-1.1, 0.5, -2.45),
            Quat::IDENTITY,
            FIELD_OF_VIEW,
        ),
    );
    list.add(
        "a view turned upside down, whose light comes from where angles wrap",
        seen(lamp(), EYE, Quat::from_rotation_z(PI), FIELD_OF_VIEW),
    );
}

/// A scene whose card is these triangles.
fn behind(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Scene {
    let mut scene = lamp();
    let index = scene.meshes.len();
    scene.meshes.push(Mesh {
        positions,
        triangles,
        ..Mesh::default()
    });
    scene.instances.push(Instance {
        mesh: index,
        ..Instance::default()
    });
    scene
}

/// Hills of `side`² squares of two triangles, over the floor and under the lamp.
fn hills(side: u32) -> Scene {
    let row = side + 1;
    let place = |i: u32| i as f32 / side as f32;
    let positions = (0..row * row).map(|i| {
        let (x, z) = (place(i % row), place(i / row));
        let height = 0.3 * (40.0 * x).sin() * (30.0 * z).cos() + 0.02 * (900.0 * (x + z)).sin();
        Vec3::new(6.0 * x - 3.0, height - 1.0, 5.0 * z - 4.0)
    });
    let squares = (0..side).flat_map(|z| (0..side).map(move |x| z * row + x));
    let triangles = squares.flat_map(|i| [[i, i + 1, i + row], [i + 1, i + row + 1, i + row]]);
    behind(positions.collect(), triangles.collect())
}

/// As many hairs before the wall, all at one place, which together hold back most of the light.
fn hairs(count: u32) -> Scene {
    let point = |y: f32| StrandPoint {
        position: Vec3::new(0.2, y, -1.5),
        thickness: 0.2,
        opacity: 3.0 / count as f32,
    };
    let points = (0..count).flat_map(|_| [point(-1.0), point(1.5)]);
    let ends = (1..=count).map(|strand| 2 * strand);
    let strands = Strands::new(points.collect(), ends.collect());
    Scene {
        translucent: vec![strands.expect("hairs").into()],
        ..lamp()
    }
}

/// Between the lamp and the wall.
const TRIANGLE: [Vec3; 3] = [
    Vec3::new(-0.5, 0.0, -1.5),
    Vec3::new(1.0, 0.2, -1.2),
    Vec3::new(0.2, 1.2, -1.8),
];

fn casters(list: &mut List) {
    let [a, b, c] = TRIANGLE;
    list.add("a triangle", {
        let mut scene = behind(vec![a, b, c], vec![[0, 1, 2]]);
        scene.instances.drain(..scene.instances.len() - 1);
        scene
    });
    list.add(
        // A hierarchy of them is a chain of as many nodes, which debug builds of its library
        // check by recursion.
        "a triangle 2000 times at one place",
        behind(vec![a, b, c], vec![[0, 1, 2]; 2000]),
    );
    list.add(
        "triangles without an area beside one that has some",
        behind(
            vec![a, b, c, 0.5 * (a + b)],
            vec![[0, 1, 2], [0, 0, 1], [0, 1, 3], [2, 2, 2]],
        ),
    );
    let mut random = Random::new(5);
    let mut slivers = (Vec::new(), Vec::new());
    for i in 0..200_u32 {
        let from = Vec3::new(-2.0, random.between(-1.0, 2.0), random.between(-3.0, -0.5));
        let to = from + Vec3::new(4.0, random.between(-0.5, 0.5), 0.0);
        slivers.0.extend([from, to, to + 1e-5 * Vec3::Y]);
        slivers.1.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    list.add(
        "slivers of a hundredth of a millimetre",
        behind(slivers.0, slivers.1),
    );
    let far = 1e6;
    list.add(
        "a triangle of a thousand kilometres",
        behind(
            vec![
                Vec3::new(-far, -0.2, -far),
                Vec3::new(far, -0.2, -far),
                Vec3::new(0.0, -0.2, far),
            ],
            vec![[0, 1, 2]],
        ),
    );
    list.add(
        "two walls at one place",
        behind(
            vec![
                Vec3::new(-3.0, -1.5, -4.0),
                Vec3::new(3.0, -1.5, -4.0),
                Vec3::new(3.0, 2.5, -4.0),
                Vec3::new(-3.0, 2.5, -4.0),
            ],
            vec![[0, 1, 2], [0, 2, 3]],
        ),
    );
    list.add("a lamp shut in by a caster", {
        let corners = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| [-1.0, 1.0].map(|z| (x, y, z))));
        let corners = corners.as_flattened().as_flattened();
        let positions = corners
            .iter()
            .map(|&(x, y, z)| LAMP + 0.05 * Vec3::new(x, y, z));
        let faces = [
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ];
        let triangles = faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        behind(positions.collect(), triangles.collect())
    });
}

/// All of a scene moved and scaled, with fog that is as dense for its size.
fn moved(scene: Scene, scale: f32, offset: Vec3) -> Scene {
    let place =
        Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::IDENTITY, offset);
    let mut scene = seen(
        scene,
        place.transform_point3(EYE),
        Quat::IDENTITY,
        FIELD_OF_VIEW,
    );
    for instance in &mut scene.instances {
        instance.transform = place * instance.transform;
    }
    for light in &mut scene.lights {
        if let Light::Point(lamp) = light {
            lamp.position = place.transform_point3(lamp.position);
            lamp.intensity *= scale * scale;
        }
    }
    in_fog(scene, even(0.1 / scale))
}

fn places(list: &mut List) {
    list.add(
        "a scene of micrometres, a lamp",
        moved(lamp(), 1e-6, Vec3::ZERO),
    );
    list.add(
        "a scene of micrometres, a sun",
        moved(sun(), 1e-6, Vec3::ZERO),
    );
    list.add("a scene of 1000 km, a lamp", moved(lamp(), 1e6, Vec3::ZERO));
    list.add("a scene of 1000 km, a sun", moved(sun(), 1e6, Vec3::ZERO));
    let utm = Vec3::new(448_262.0, 0.0, -5_411_933.0);
    list.add(
        "coordinates of a map in metres, a lamp",
        moved(lamp(), 100.0, utm),
    );
    list.add(
        "coordinates of a map in metres, a sun",
        moved(sun(), 100.0, utm),
    );
}

/// A box before the wall, and in it as dense a medium at each of `side`³ places.
fn in_smoke(side: u32, density: f32, interpolation: Interpolation) -> Scene {
    let bounds = Bounds::new(Vec3::new(-1.5, -1.0, -3.5), Vec3::new(1.5, 1.6, -0.5));
    let mut random = Random::new(8);
    let samples = (0..side.pow(3)).map(|_| random.between(0.5, 1.0)).collect();
    let grid = DensityGrid::new(
        bounds.expect("a box"),
        [side; 3],
        samples,
        density,
        interpolation,
    );
    let grid = grid.expect("smoke").with_albedo(Vec3::splat(0.8));
    Scene {
        translucent: vec![grid.expect("an albedo").into()],
        ..lamp()
    }
}

fn in_height_fog(altitude: f32, scale_height: f32) -> Scene {
    let sigma = Vec3::new(0.1, 0.05, 0.02);
    let fog = HeightFog::new(
        sigma,
        Vec3::ZERO,
        altitude,
        scale_height,
        PhaseFunction::Isotropic,
    );
    Scene {
        height_fog: Some(fog.expect("fog")),
        medium: None,
        ..sun()
    }
}

fn smoke(list: &mut List) {
    let linear = Interpolation::Linear;
    list.add("smoke", in_smoke(8, 1.0, linear));
    list.add("smoke of 1e-6 a metre", in_smoke(8, 1e-6, linear));
    list.add("smoke of 1e6 a metre", in_smoke(8, 1e6, linear));
    list.add("a single voxel", in_smoke(1, 1.0, Interpolation::Constant));
    let inside = Vec3::new(0.2, 0.3, -1.5);
    list.add(
        "an eye in smoke",
        seen(
            in_smoke(8, 1.0, linear),
            inside,
            Quat::IDENTITY,
            FIELD_OF_VIEW,
        ),
    );
    let mut lit = in_smoke(8, 1.0, linear);
    lit.lights = vec![lamp_at(inside)];
    list.add("a lamp in smoke", lit);
    list.add(
        "fog that thins out by e every metre",
        in_height_fog(0.0, 1.0),
    );
    list.add(
        "fog that thins out, seen from above it",
        in_height_fog(-8.0, 0.5),
    );
}

fn pictures(list: &mut List) {
    for (name, size) in [
        ("one pixel", [1, 1]),
        ("a row of pixels", [32, 1]),
        ("a column of pixels", [1, 32]),
    ] {
        list.sized(name, lamp(), size);
    }
    let mut both = solid_room();
    both.lights.push(lamp_at(EYE + 1e-3 * Vec3::X));
    list.add("a sun, a lamp, and a lamp at the eye", both);
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::scenes::TestScene;

    #[test]
    fn names_are_unique() {
        let small = frame_cases();
        let large = large_frame_cases();
        let names = small.iter().map(|case| case.name);
        let names: HashSet<_> = names.chain(large.iter().map(|case| case.name)).collect();
        assert_eq!(names.len(), small.len() + large.len());
    }

    #[test]
    fn every_case_is_sound_and_its_picture_has_a_bound() {
        for FrameCase { name, scene, size } in frame_cases() {
            let scene = TestScene::of(name, scene, size[0], size[1]);
            assert!(size.iter().all(|side| *side <= 32), "{name}");
            let truth = scene.truth();
            for (light, bound) in truth.radiance.iter().zip(&truth.bound) {
                assert!(light.iter().all(|c| c.is_finite() && *c >= 0.0), "{name}");
                assert!(bound.is_finite(), "{name}: {bound:?}");
            }
        }
    }
}
