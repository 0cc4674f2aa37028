use std::f32::consts::PI;

use glam::{Quat, Vec3};
use gpu_backend::{Cpu, Download, Error};
use reference::random::Random;
use transmittance::Stream;

use super::{AddHairLight, Fibre, LitHair, SeenHair};
use crate::methods::heterogeneous::{GatherMedia, MediaRays};
use crate::methods::translucent::{Casters, TransmittanceMap};
use crate::scene::trace::Tracer;
use crate::scene::view::{Cover, View};
use crate::scene::{
    AlphaMode, Camera, Emission, Emitter, Geometry, Instance, Material, Media, Medium, Mesh,
    Particle, Particles, PhaseFunction, Profile, Scene, StrandPoint, Strands, Translucent,
};
use crate::visibility::Unshadowed;
use crate::{EyePanes, Gather, LitRays, Ray, airlight, surface};

pub(super) const FIBRES: [Fibre; 2] = [Fibre::KajiyaKay, Fibre::Marschner];

/// Rows and columns of pictures.
pub(super) const SIDE: u32 = 32;

/// An eye at the origin that looks along −Z; at 1 m, pictures are 2 m wide and high.
pub(super) fn camera() -> Camera {
    Camera::new(Vec3::ZERO, Quat::IDENTITY, 0.5 * PI).unwrap()
}

/// A strand through each of these lists of points.
pub(super) fn strands(lines: &[Vec<Vec3>], thickness: f32, opacity: f32) -> Strands {
    let (mut points, mut ends) = (Vec::new(), Vec::new());
    for line in lines {
        points.extend(line.iter().map(|&position| StrandPoint {
            position,
            thickness,
            opacity,
        }));
        ends.push(points.len() as u32);
    }
    Strands::new(points, ends).unwrap()
}

/// One across the picture, at this height and distance.
fn across(y: f32, z: f32, thickness: f32, opacity: f32) -> Strands {
    let ends = [-1.2 * z, 1.2 * z].map(|x| Vec3::new(x, y, -z));
    strands(&[ends.to_vec()], thickness, opacity)
}

/// A scene with all that its pictures are made from.
pub(super) struct Seen {
    pub(super) scene: Scene,
    geometry: Geometry,
    pub(super) tracer: Tracer,
    pub(super) view: View,
    pub(super) hair: SeenHair,
}

impl Seen {
    pub(super) fn new(scene: Scene, side: u32) -> Self {
        let cpu = Cpu::new();
        let geometry = Geometry::new(&scene).unwrap();
        let tracer = Tracer::new(&geometry);
        let view = View::new(&cpu, &camera(), &tracer, side, side).unwrap();
        let hair = SeenHair::new(&cpu, &camera(), &view, &scene.translucent).unwrap();
        Self {
            scene,
            geometry,
            tracer,
            view,
            hair,
        }
    }

    fn of(strands: Strands) -> Self {
        Self::new(with(strands), SIDE)
    }

    fn radiance(&self, emitter: &Emitter, fibre: Fibre) -> Vec<[f32; 4]> {
        self.radiance_on(&Cpu::new(), emitter, fibre)
    }

    fn radiance_on(&self, cpu: &Cpu, emitter: &Emitter, fibre: Fibre) -> Vec<[f32; 4]> {
        let casters = Casters::new(&self.scene.translucent, None);
        let clear = Stream::<8>::new();
        let map: TransmittanceMap =
            TransmittanceMap::build(cpu, &casters, emitter, 256, &clear).unwrap();
        let lit = LitHair {
            view: &self.view,
            translucent: &self.scene.translucent,
            media: &Media::of(&self.scene),
            tracer: &self.tracer,
            lights: &[(emitter, &map)],
            fibre,
        };
        added(cpu, &self.hair, &lit)
    }

    /// The share of a pixel that is covered.
    fn alpha(&self, pixel: usize) -> f32 {
        1.0 - self.hair.share(pixel, f32::INFINITY)
    }
}

/// The light of hair alone, on any backend.
pub(super) fn added<T, B>(
    backend: &B,
    hair: &SeenHair,
    lit: &LitHair<'_, B::Memory, T>,
) -> Vec<[f32; 4]>
where
    B: AddHairLight<T> + Download,
{
    let mut radiance = backend.zeros(lit.view.rays().len()).unwrap();
    backend.add_hair_light(hair, lit, &mut radiance).unwrap();
    backend.download(&radiance).unwrap()
}

/// A scene has a triangle; this one is far below all else.
pub(super) fn with(strands: Strands) -> Scene {
    let speck = Mesh {
        positions: [Vec3::X, Vec3::Y, Vec3::Z]
            .map(|corner| 0.1 * corner - 900.0 * Vec3::Y)
            .to_vec(),
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    Scene {
        translucent: vec![strands.into()],
        meshes: vec![speck],
        instances: vec![Instance::default()],
        ..Scene::default()
    }
}

/// Sunlight from behind the eye, from above.
pub(super) fn sun() -> Emitter {
    Emitter::directional(Vec3::new(0.2, -0.5, -1.0), Vec3::new(3.0, 2.0, 1.0)).unwrap()
}

/// Curved strands in front of the eye.
pub(super) fn tangle(seed: u64, count: usize) -> Vec<Vec<Vec3>> {
    let mut random = Random::new(seed);
    let line = |random: &mut Random| {
        let mut at = Vec3::from_array(random.vector(1.0)) + 2.0 * Vec3::NEG_Z;
        let towards = Vec3::from_array(random.vector(1.0));
        let mut step = 0.2 * towards.normalize_or(Vec3::X);
        let next = |random: &mut Random| {
            at += step;
            step += 0.02 * Vec3::from_array(random.vector(1.0));
            at
        };
        let mut next = next;
        (0..8).map(|_| next(random)).collect()
    };
    (0..count).map(|_| line(&mut random)).collect()
}

#[test]
fn a_ribbon_covers_the_share_of_its_width_from_a_micrometre_to_a_metre() {
    let (distance, height) = (5.0, 0.34375);
    let scale = 0.5 * f64::from(SIDE);
    // It faces the eye, which sees it from below.
    let (cos, sin) = {
        let sight = f64::hypot(height, distance);
        (distance / sight, height / sight)
    };
    for thickness in [1e-6_f32, 1e-4, 0.01, 0.1, 0.3, 1.0] {
        let seen = Seen::of(across(height as f32, distance as f32, thickness, 1.0));
        let edge = |radius: f64| {
            let (y, z) = (height + radius * cos, distance - radius * sin);
            scale - scale * y / z
        };
        let radius = 0.5 * f64::from(thickness);
        let [first, last] = [edge(radius), edge(-radius)];
        for row in 0..SIDE {
            let (top, end) = (f64::from(row), f64::from(row + 1));
            let expected = (last.min(end) - first.max(top)).max(0.0);
            for column in [0, 11, SIDE - 1] {
                let pixel = (row * SIDE + column) as usize;
                let found: f32 = seen.hair.of(pixel).iter().map(|f| f.alpha).sum();
                // The angle of the picture is rounded.
                let error = (f64::from(found) - expected).abs();
                assert!(
                    error <= 1e-5 * expected + 1e-6 * f64::from(thickness),
                    "{thickness} {row}: {found} {expected}"
                );
                if let [fragment] = seen.hair.of(pixel) {
                    let x = (f64::from(column) + 0.5 - scale) / scale * distance;
                    let truth = x.hypot(height).hypot(distance);
                    let error = (f64::from(fragment.distance) - truth).abs();
                    assert!(error < 1e-5 * truth, "{thickness}: {error}");
                }
            }
        }
    }
}

#[test]
fn the_joints_of_a_strand_are_not_seen() {
    let ends = [Vec3::new(-2.0, -1.0, -3.0), Vec3::new(2.0, 1.5, -4.0)];
    for thickness in [0.001, 0.05, 0.8] {
        let whole = Seen::of(strands(&[ends.to_vec()], thickness, 0.7));
        let points = (0..=100).map(|i| ends[0].lerp(ends[1], i as f32 / 100.0));
        let cut = Seen::of(strands(&[points.collect()], thickness, 0.7));
        for pixel in 0..(SIDE * SIDE) as usize {
            // The ends are seen from other sides, and turned by as much.
            let error = (whole.alpha(pixel) - cut.alpha(pixel)).abs();
            assert!(error < 0.03 * thickness.min(0.1), "{thickness}: {error}");
        }
    }
}

#[test]
fn what_is_kept_and_what_is_let_through_is_all_there_is() {
    let seen = Seen::of(strands(&tangle(1, 400), 0.03, 0.6));
    let (mut most, cover) = (0, seen.hair.cover(&Cpu::new()));
    for pixel in 0..(SIDE * SIDE) as usize {
        let fragments = seen.hair.of(pixel);
        most = most.max(fragments.len());
        assert!(fragments.is_sorted_by_key(|fragment| fragment.distance));
        let kept = fragments.iter();
        let kept: f32 = kept
            .map(|f| f.alpha * seen.hair.share(pixel, f.distance))
            .sum();
        let left = seen.hair.share(pixel, f32::INFINITY);
        assert!((kept + left - 1.0).abs() < 1e-5);
        // The curve ends with the product, and is exact as long as there is room.
        assert!((cover.share(pixel, f32::INFINITY) - left).abs() < 1e-5);
        let [Some(first), Some(last)] = [fragments.first(), fragments.last()] else {
            continue;
        };
        if fragments.len() <= 8 {
            for fragment in fragments {
                let at = fragment.distance;
                assert!((cover.share(pixel, at) - seen.hair.share(pixel, at)).abs() < 1e-5);
            }
        }
        // Else what counts is the area between the curves.
        let (from, length) = (first.distance, last.distance - first.distance);
        let area = (0..256).map(|i| {
            let at = from + length * (i as f32 + 0.5) / 256.0;
            (cover.share(pixel, at) - seen.hair.share(pixel, at)).abs()
        });
        let mean = area.sum::<f32>() / 256.0;
        assert!(mean < 0.02, "{}: {mean}", fragments.len());
    }
    assert!(most > 12, "{most}");
}

#[test]
fn the_order_of_strands_and_threads_change_no_bit() {
    let mut lines = tangle(2, 300);
    // Some are there twice.
    lines.extend_from_within(..20);
    let forward = Seen::of(strands(&lines, 0.02, 0.5));
    lines.reverse();
    let back = Seen::of(strands(&lines, 0.02, 0.5));
    let cpu = Cpu::new();
    assert!(forward.hair.len() > 1000, "{}", forward.hair.len());
    assert_eq!(forward.hair.cover(&cpu), back.hair.cover(&cpu));
    let alone = Cpu::single_threaded();
    let again = SeenHair::new(&alone, &camera(), &forward.view, &forward.scene.translucent);
    assert_eq!(again.as_ref(), Some(&forward.hair));
    for fibre in FIBRES {
        let once = forward.radiance(&sun(), fibre);
        assert_eq!(once, forward.radiance_on(&alone, &sun(), fibre));
        // Maps of light depend on the order within their error bounds.
        for (a, b) in once.iter().zip(back.radiance(&sun(), fibre)) {
            for channel in 0..3 {
                let (a, b) = (a[channel], b[channel]);
                assert!((a - b).abs() < 0.02 * (a + b) + 1e-3, "{a} {b}");
            }
        }
    }
}

#[test]
fn strands_at_and_behind_the_eye_and_of_no_length_are_drawn_as_far_as_they_are_seen() {
    let forward = Vec3::NEG_Z;
    let through = vec![-2.0 * forward, 5.0 * forward];
    let beside = vec![
        -2.0 * forward + 0.1 * Vec3::Y,
        5.0 * forward + 0.1 * Vec3::Y,
    ];
    let cases = [
        (
            "behind the eye",
            vec![-forward, -3.0 * forward + Vec3::X],
            0.1,
            1.0,
            false,
        ),
        ("through the eye", through.clone(), 0.1, 1.0, false),
        ("past the eye", beside.clone(), 0.05, 1.0, true),
        (
            "from beside the eye",
            vec![Vec3::new(0.01, -0.02, 0.0), forward + 0.2 * Vec3::X],
            1e-3,
            1.0,
            true,
        ),
        ("of no length", vec![forward; 3], 0.1, 1.0, false),
        (
            "of no thickness",
            vec![forward, forward + Vec3::X],
            0.0,
            1.0,
            false,
        ),
        (
            "of no opacity",
            vec![forward, forward + Vec3::X],
            0.1,
            0.0,
            false,
        ),
        ("of one point", vec![forward], 0.1, 1.0, false),
        (
            "around the eye",
            vec![Vec3::NEG_X, Vec3::X],
            5.0,
            1.0,
            false,
        ),
    ];
    for (what, line, thickness, opacity, is_seen) in cases {
        let seen = Seen::of(strands(&[line], thickness, opacity));
        assert_eq!(!seen.hair.is_empty(), is_seen, "{what}");
        for fibre in FIBRES {
            let radiance = seen.radiance(&sun(), fibre);
            assert!(
                radiance.as_flattened().iter().all(|c| c.is_finite()),
                "{what}"
            );
        }
    }
    // What passes the eye is seen from as near as its thickness on.
    let seen = Seen::of(strands(&[beside], 0.05, 1.0));
    let pixels = 0..(SIDE * SIDE) as usize;
    let nearest = pixels
        .flat_map(|pixel| seen.hair.of(pixel))
        .map(|f| f.distance);
    let nearest = nearest.fold(f32::INFINITY, f32::min);
    assert!(nearest > 0.1 && nearest < 0.2, "{nearest}");
}

#[test]
fn a_scene_without_strands_has_no_hair_and_empty_strands_change_no_bit() {
    let wall = |translucent| Scene {
        translucent,
        ..before_a_wall(None)
    };
    let without = wall(vec![]);
    let cpu = Cpu::new();
    let geometry = Geometry::new(&without).unwrap();
    let tracer = Tracer::new(&geometry);
    let view = View::new(&cpu, &camera(), &tracer, SIDE, SIDE).unwrap();
    assert_eq!(SeenHair::new(&cpu, &camera(), &view, &[]), None);
    let seen = Seen::new(wall(vec![strands(&[], 1.0, 1.0).into()]), SIDE);
    let cover = seen.hair.cover(&cpu);
    assert!(seen.hair.is_empty() && cover.is_clear());
    let surfaces =
        |view: &View| surface::radiance(&cpu, view, &without, &geometry, &tracer, &[sun()], None);
    assert_eq!(surfaces(&view.clone().with_cover(cover)), surfaces(&view));
    assert_eq!(seen.radiance(&sun(), Fibre::Marschner), [[0.0; 4]; 1024]);
}

/// `∫ L cos θ_o dω_o / (E cos θ_i)` by a fine grid.
fn albedo(fibre: Fibre, colour: Vec3, theta_i: f32) -> Vec3 {
    let (rows, columns) = (400, 64);
    let light = Vec3::new(theta_i.cos(), 0.0, theta_i.sin());
    let mut sum = Vec3::ZERO;
    for row in 0..rows {
        // Even in θ_o, in the middles of cells.
        let theta = PI * ((row as f32 + 0.5) / rows as f32 - 0.5);
        let mut around = Vec3::ZERO;
        for column in 0..columns {
            let phi = 2.0 * PI * (column as f32 + 0.5) / columns as f32;
            let eye = Vec3::new(
                theta.cos() * phi.cos(),
                theta.cos() * phi.sin(),
                theta.sin(),
            );
            around += fibre.radiance(colour, Vec3::Z, light, eye);
        }
        sum += around * theta.cos().powi(2);
    }
    sum * (2.0 * PI * PI / (rows * columns) as f32) / theta_i.cos()
}

#[test]
fn fibres_send_back_the_share_of_their_albedo() {
    let colours = [Vec3::ONE, Vec3::new(0.4, 0.2, 0.05), Vec3::ZERO];
    for colour in colours {
        for theta in [-1.3_f32, -0.7, 0.0, 0.2, 0.9, 1.45] {
            let (found, stated) = (
                albedo(Fibre::Marschner, colour, theta),
                Fibre::Marschner.albedo(colour, theta.cos()),
            );
            assert!(found.abs_diff_eq(stated, 2e-3), "{theta}: {found} {stated}");
            assert!(stated.max_element() <= 1.0 + 1e-6);
            let (found, most) = (
                albedo(Fibre::KajiyaKay, colour, theta),
                Fibre::KajiyaKay.albedo(colour, theta.cos()),
            );
            assert!(found.cmple(most + 1e-3).all(), "{theta}: {found} {most}");
            assert!(found.cmpge(most - 0.02).all() || theta.abs() > 1.2);
            if theta == 0.0 {
                assert!(found.abs_diff_eq(most, 1e-3), "{found} {most}");
            }
        }
    }
}

#[test]
fn light_and_eyes_along_a_strand_see_nothing_and_numbers_stay_finite() {
    for fibre in FIBRES {
        let light = |to_light: Vec3, to_eye: Vec3| {
            fibre.radiance(Vec3::ONE, Vec3::Z, to_light.normalize(), to_eye.normalize())
        };
        assert_eq!(light(Vec3::Z, Vec3::X), Vec3::ZERO);
        assert_eq!(light(Vec3::X, Vec3::NEG_Z), Vec3::ZERO);
        for small in [1e-30, 1e-7, 1e-5, 1e-3] {
            let beside = Vec3::new(small, 0.0, 1.0);
            for found in [
                light(beside, Vec3::X),
                light(Vec3::X, beside),
                light(beside, beside),
            ] {
                assert!(found.is_finite() && found.min_element() >= 0.0);
            }
        }
        // The same to the left and to the right of the light.
        let (left, right) = (Vec3::new(0.5, 0.3, 0.2), Vec3::new(0.5, -0.3, 0.2));
        assert!((light(Vec3::X, left) - light(Vec3::X, right)).length() < 1e-6);
    }
}

/// A wall 8 m before the eye and, 2 m before it, a card of this material.
fn before_a_wall(card: Option<Material>) -> Scene {
    let square = |half: f32, z: f32, material| Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(half * x, half * y, z))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(material),
        ..Mesh::default()
    };
    let mut scene = Scene {
        meshes: vec![square(20.0, -8.0, 0)],
        materials: vec![Material::default()],
        instances: vec![Instance::default()],
        ..Scene::default()
    };
    if let Some(card) = card {
        scene.meshes.push(square(9.0, -2.0, 1));
        scene.materials.push(card);
        scene.instances.push(Instance {
            mesh: 1,
            ..Instance::default()
        });
    }
    scene
}

fn close(found: Vec3, expected: Vec3, tolerance: f32) -> bool {
    (found - expected).abs().max_element() <= tolerance * expected.abs().max_element()
}

/// Pixels of the row through the middle of the picture.
fn middle_row() -> impl Iterator<Item = usize> {
    let row = SIDE / 2 * SIDE;
    (row..row + SIDE).map(|pixel| pixel as usize)
}

#[test]
fn a_lone_strand_is_as_bright_as_its_equation_says() {
    let fog = Medium::new(
        Vec3::splat(0.05),
        Vec3::new(0.1, 0.05, 0.0),
        PhaseFunction::Isotropic,
    )
    .unwrap();
    let lamp = Emitter::point(
        Vec3::new(0.5, 2.0, -1.0),
        Vec3::new(9.0, 5.0, 2.0),
        f32::INFINITY,
        Emission::Isotropic,
    )
    .unwrap();
    let glass = Material {
        base_color: Vec3::new(0.9, 0.6, 0.3),
        transmission: 1.0,
        ..Material::default()
    };
    let puff = Particle {
        centre: Vec3::new(0.0, 0.0, -1.5),
        radius: 0.4,
        sigma_t: 1.7,
    };
    for (thickness, opacity) in [(0.01, 0.4), (0.6, 1.0)] {
        for (emitter, fog, card, puffs) in [
            (sun(), None, None, false),
            (lamp.clone(), None, None, true),
            (lamp.clone(), Some(fog), None, false),
            (sun(), None, Some(glass.clone()), false),
            (lamp.clone(), Some(fog), None, true),
        ] {
            let is_glazed = card.is_some();
            let hair = across(-0.05, 5.0, thickness, opacity);
            let mut translucent = vec![Translucent::from(hair)];
            if puffs {
                let puffs = Particles::new(vec![puff], Profile::Constant).unwrap();
                translucent.push(puffs.into());
            }
            let seen = Seen::new(
                Scene {
                    translucent,
                    medium: fog,
                    ..before_a_wall(card)
                },
                SIDE,
            );
            let media = Media::new(fog.as_ref(), None, &seen.scene.translucent[1..]);
            for fibre in FIBRES {
                let radiance = seen.radiance(&emitter, fibre);
                for pixel in middle_row() {
                    let [fragment] = seen.hair.of(pixel) else {
                        panic!("one strand crosses the row");
                    };
                    let ray = &seen.view.rays()[pixel];
                    let (share, piece) = (fragment.share, Vec3::X);
                    let at = Vec3::new(-6.0 + 12.0 * share, -0.05, -5.0);
                    let (to_light, distance, irradiance) = match &emitter {
                        Emitter::Directional(sun) => {
                            (-sun.direction(), f32::INFINITY, sun.irradiance())
                        }
                        Emitter::Point(lamp) => {
                            let offset = lamp.position() - at;
                            let square = offset.length_squared();
                            (offset.normalize(), square.sqrt(), lamp.intensity() / square)
                        }
                    };
                    let colour = Strands::COLOUR;
                    let own = fibre.radiance(colour, piece, to_light, (-at).normalize());
                    let mut expected = fragment.alpha * own * irradiance;
                    expected *= media.transmittance(ray, fragment.distance);
                    if distance.is_finite() {
                        let back = Ray::new(at, to_light, distance).unwrap();
                        expected *= media.transmittance(&back, distance);
                    }
                    if is_glazed {
                        // Light and sight go through the card.
                        expected *= Vec3::new(0.9, 0.6, 0.3).powf(2.0);
                    }
                    let [r, g, b, _] = radiance[pixel];
                    let found = Vec3::new(r, g, b);
                    assert!(close(found, expected, 1e-2), "{found} {expected} {fibre:?}");
                }
            }
        }
    }
}

#[test]
fn strands_shade_each_other_and_walls_hide_them() {
    // The sun is above: the upper strand shades the lower one, by half.
    let noon = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let line = |y: f32| vec![Vec3::new(-4.0, y, -3.0), Vec3::new(4.0, y, -3.0)];
    let lower = strands(&[line(0.05)], 0.4, 0.5);
    let both = strands(&[line(0.05), line(1.0)], 0.4, 0.5);
    let row = (SIDE / 2 - 1) * SIDE;
    let (alone, shaded) = (Seen::of(lower), Seen::of(both));
    for fibre in FIBRES {
        let [alone, shaded] = [&alone, &shaded].map(|seen| seen.radiance(&noon, fibre));
        for pixel in row..row + SIDE {
            let (alone, shaded) = (alone[pixel as usize][1], shaded[pixel as usize][1]);
            assert!(alone > 0.0 && (shaded - 0.5 * alone).abs() < 0.02 * alone);
        }
    }
    // A wall is between.
    let hidden = Scene {
        translucent: vec![across(0.0, 9.0, 1.0, 1.0).into()],
        ..before_a_wall(None)
    };
    assert!(Seen::new(hidden, SIDE).hair.is_empty());
    // A card hides the sun.
    let shadowed = Scene {
        translucent: vec![across(0.0, 5.0, 0.5, 1.0).into()],
        ..before_a_wall(None)
    };
    let from_behind = Emitter::directional(Vec3::Z, Vec3::ONE).unwrap();
    let seen = Seen::new(shadowed, SIDE);
    let radiance = seen.radiance(&from_behind, Fibre::Marschner);
    assert!(!seen.hair.is_empty() && radiance == [[0.0; 4]; 1024]);
}

#[test]
fn a_light_in_the_hair_lights_it() {
    let seen = Seen::of(strands(&tangle(3, 300), 0.01, 0.5));
    for at in [tangle(3, 1)[0][2], Vec3::new(0.1, 0.0, -2.0)] {
        let lamp = Emitter::point(at, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let radiance = seen.radiance(&lamp, Fibre::Marschner);
        let sum: f32 = radiance.iter().map(|pixel| pixel[1]).sum();
        assert!(sum.is_finite() && sum > 0.0);
    }
}

#[test]
fn surfaces_and_glass_behind_hair_are_dimmed_by_it() {
    let glass = Material {
        base_color: Vec3::new(0.9, 0.6, 0.3),
        opacity: 0.5,
        alpha: AlphaMode::Blend,
        ..Material::default()
    };
    for (z, before_glass) in [(1.0, true), (5.0, false)] {
        let scene = Scene {
            translucent: vec![across(0.0, z, 0.3, 0.75).into()],
            ..before_a_wall(Some(glass.clone()))
        };
        let seen = Seen::new(scene, SIDE);
        let cpu = Cpu::new();
        let cover = seen.hair.cover(&cpu);
        let surfaces = |view: &View| {
            let Seen {
                scene,
                geometry,
                tracer,
                ..
            } = &seen;
            surface::radiance(&cpu, view, scene, geometry, tracer, &[sun()], None)
        };
        let (open, dimmed) = (
            surfaces(&seen.view),
            surfaces(&seen.view.clone().with_cover(cover)),
        );
        // What the glass shows of the wall, by the way of another picture without it.
        for pixel in 0..(SIDE * SIDE) as usize {
            let left = seen.hair.share(pixel, f32::INFINITY);
            let ratio = dimmed[pixel][1] / open[pixel][1];
            match before_glass {
                true => assert!((ratio - left).abs() < 1e-5),
                // The light of the glass itself is not behind the hair.
                false => assert!(left == 1.0 || (ratio > left + 0.05 && ratio < 1.0)),
            }
        }
    }
}

#[test]
fn air_behind_hair_is_dimmed_and_air_before_it_is_not() {
    let cpu = Cpu::new();
    let fog = Medium::new(
        Vec3::splat(0.2),
        Vec3::splat(0.05),
        PhaseFunction::Isotropic,
    )
    .unwrap();
    let lamp = Emitter::point(
        Vec3::new(0.5, 1.0, -4.0),
        Vec3::ONE,
        f32::INFINITY,
        Emission::Isotropic,
    )
    .unwrap();
    for opacity in [0.5, 1.0] {
        // They fill the picture, side by side.
        let lines = (0..40).map(|i| {
            let y = -3.9 + 0.2 * i as f32;
            vec![Vec3::new(-4.0, y, -3.0), Vec3::new(4.0, y, -3.0)]
        });
        let seen = Seen::of(strands(&lines.collect::<Vec<_>>(), 0.2, opacity));
        let rays = seen.view.rays().to_vec();
        let cover = seen.hair.cover(&cpu);
        let panes = EyePanes::with_cover(None, &cover, rays.len(), |ray| ray);
        let near = |pixel: usize| seen.hair.of(pixel)[0].distance;
        let cut: Vec<Ray> = (rays.iter().enumerate())
            .map(|(pixel, ray)| ray.with_length(near(pixel)))
            .collect();
        let quadrature = airlight::Quadrature::with_tolerance(fog.phase(), 1e-5).unwrap();
        let even = |rays: &Vec<Ray>, panes: Option<&EyePanes>| {
            let mut sum = vec![[0.0; 4]; rays.len()];
            let lit = LitRays {
                panes,
                ..LitRays::new(rays, &lamp, &fog)
            };
            cpu.gather(&lit, &Unshadowed, &quadrature, &mut sum)
                .unwrap();
            sum
        };
        let media = Media::new(Some(&fog), None, &[]);
        let uneven = |rays: &Vec<Ray>, panes: Option<&EyePanes>| {
            let mut sum = vec![[0.0; 4]; rays.len()];
            let lit = MediaRays {
                rays,
                emitter: &lamp,
                media: &media,
                steps: 256,
                panes,
                watch: &(),
            };
            cpu.gather_media(&lit, &Clear, &mut sum).unwrap();
            sum
        };
        type Gathered<'a> = &'a dyn Fn(&Vec<Ray>, Option<&EyePanes>) -> Vec<[f32; 4]>;
        let ways: [(Gathered<'_>, f32); 2] = [(&even, 1e-3), (&uneven, 0.02)];
        for (gather, tolerance) in ways {
            let (all, before, found) = (
                gather(&rays, None),
                gather(&cut, None),
                gather(&rays, panes.as_ref()),
            );
            for pixel in 0..rays.len() {
                let left = seen.hair.share(pixel, f32::INFINITY);
                let (all, before) = (all[pixel][0], before[pixel][0]);
                let expected = before + left * (all - before);
                let error = (found[pixel][0] - expected).abs();
                // Where two strands meet, they are at two distances.
                if seen.hair.of(pixel).len() == 1 {
                    assert!(error < tolerance * all, "{error} of {all}");
                }
            }
        }
    }
}

/// Nothing in the way.
struct Clear;

impl crate::visibility::PointVisibility for Clear {
    type Share = f32;

    fn visibility(&self, _: Vec3) -> f32 {
        1.0
    }
}

/// The share of a pixel that opaque strands cover, by this many rays a side: each is asked
/// how near it comes to every piece.
fn covered_by_rays(lines: &[Vec<Vec3>], thickness: f32, pixel: u32, rays: u32) -> f32 {
    let (x, y) = ((pixel % SIDE) as f32, (pixel / SIDE) as f32);
    let pieces: Vec<[Vec3; 2]> = lines
        .iter()
        .flat_map(|line| line.windows(2).map(|pair| [pair[0], pair[1]]))
        .collect();
    let is_met = |direction: Vec3| {
        pieces.iter().any(|[a, b]| {
            let along = *b - *a;
            let normal = direction.cross(along);
            let aside = a.dot(normal).abs() / normal.length();
            // Where the line comes nearest to the ray.
            let across = along.cross(normal);
            let t = a.dot(across) / direction.dot(across);
            let share = (t * direction - *a).dot(along) / along.length_squared();
            t > 0.0 && aside < 0.5 * thickness && (0.0..=1.0).contains(&share)
        })
    };
    let met = (0..rays * rays).filter(|ray| {
        let offset = |ray: u32| (ray as f32 + 0.5) / rays as f32;
        let (x, y) = (x + offset(ray % rays), y + offset(ray / rays));
        is_met(camera().direction(x, y, SIDE, SIDE))
    });
    met.count() as f32 / (rays * rays) as f32
}

#[test]
fn a_picture_is_that_of_a_thousand_rays_a_pixel() {
    for (count, thickness, mean_allowed, most_allowed) in [
        (1, 0.02, 0.0005, 0.03),
        (1, 0.1, 0.002, 0.08),
        (30, 0.02, 0.004, 0.15),
    ] {
        let lines = tangle(5, count);
        let seen = Seen::of(strands(&lines, thickness, 1.0));
        let errors: Vec<f32> = Cpu::new().map((SIDE * SIDE) as usize, |pixel| {
            let truth = covered_by_rays(&lines, thickness, pixel as u32, 32);
            seen.alpha(pixel) - truth
        });
        let mean = errors.iter().map(|error| error.abs()).sum::<f32>() / errors.len() as f32;
        let most = errors
            .iter()
            .fold(0.0_f32, |most, error| most.max(error.abs()));
        assert!(
            mean < mean_allowed && most < most_allowed,
            "{count}: {mean} {most}"
        );
    }
}

#[test]
fn thirty_thousand_strands_are_a_picture() {
    let seen = Seen::of(strands(&tangle(6, 30_000), 1e-3, 0.8));
    let radiance = seen.radiance(&sun(), Fibre::KajiyaKay);
    let sum: f32 = radiance.iter().map(|pixel| pixel[1]).sum();
    assert!(sum.is_finite() && sum > 1.0 && seen.hair.len() > 100_000);
}

#[test]
fn sums_and_hair_of_another_number_of_pixels_are_refused() {
    let seen = Seen::of(strands(&tangle(1, 10), 0.03, 0.6));
    let other = Seen::new(with(strands(&tangle(1, 10), 0.03, 0.6)), SIDE / 2);
    let cpu = Cpu::new();
    let lit: LitHair<'_> = LitHair {
        view: &seen.view,
        translucent: &seen.scene.translucent,
        media: &Media::of(&seen.scene),
        tracer: &seen.tracer,
        lights: &[],
        fibre: Fibre::Marschner,
    };
    let pixels = seen.view.rays().len();
    let mut radiance = vec![[1.0; 4]; pixels];
    let refused = cpu.add_hair_light(&other.hair, &lit, &mut radiance);
    assert!(
        matches!(refused, Err(Error::LengthMismatch { .. })),
        "{refused:?}"
    );
    let refused = cpu.add_hair_light(&seen.hair, &lit, &mut vec![[1.0; 4]; 3]);
    assert!(
        matches!(refused, Err(Error::LengthMismatch { .. })),
        "{refused:?}"
    );
    cpu.add_hair_light(&seen.hair, &lit, &mut radiance).unwrap();
    assert!(radiance.iter().all(|sum| *sum == [1.0; 4]));
}

#[test]
fn a_cover_has_few_steps() {
    let seen = Seen::of(strands(&tangle(7, 2000), 0.005, 0.8));
    let cover: Cover = seen.hair.cover(&Cpu::new());
    for pixel in 0..(SIDE * SIDE) as usize {
        assert!(cover.steps(pixel).len() <= 16);
    }
}
