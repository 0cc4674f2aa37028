//! Grids around one blocker whose shadow is known.

use glam::{Quat, Vec2, Vec3};
use gpu_backend::Cpu;

use super::*;
use crate::scene::{
    AlphaMode, Cone, Emission, Geometry, Instance, Material, Medium, Mesh, PhaseFunction, Scene,
    Texture,
};
use crate::visibility::{Both, SurfaceShadow};
use crate::{Emitter, LightPath, LitInterval, Ray, VisibilitySource};

/// A box with its corners at `min` and `max`, outside faces out.
fn solid(min: Vec3, max: Vec3) -> Mesh {
    let corner = |i: usize| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 1 {
                max[axis]
            } else {
                min[axis]
            }
        };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..Mesh::default()
    }
}

fn geometry(meshes: &[Mesh]) -> Geometry {
    let mut scene = Scene::default();
    for mesh in meshes {
        let part = Scene::from(mesh.clone());
        let mut instance = part.instances[0].clone();
        instance.mesh = scene.meshes.len();
        scene.meshes.extend(part.meshes);
        scene.instances.push(instance);
    }
    Geometry::new(&scene).unwrap()
}

/// A roof 0.5 thick over |x|, |z| ≤ 1 at the height 1, and a floor.
fn roof_and_floor() -> Geometry {
    geometry(&[
        solid(Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, 1.5, 1.0)),
        solid(Vec3::new(-9.0, -1.0, -9.0), Vec3::new(9.0, 0.0, 9.0)),
    ])
}

fn lamp(position: Vec3, emission: Emission) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).unwrap()
}

fn spot(position: Vec3) -> Emitter {
    let cone = Cone {
        inner: 0.1,
        outer: 1.2,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    lamp(position, Emission::spot(down, cone, None).unwrap())
}

fn bake(geometry: &Geometry, light: &Emitter, side: u32) -> BakedShadow {
    let resolution = Resolution::new(side).unwrap();
    let cpu = Cpu::new();
    BakedShadow::bake(&cpu, geometry, light, resolution, Builder::new())
        .unwrap()
        .0
}

/// The shadows of a file of one light.
fn read(file: &[u8]) -> BakedShadow {
    let mut read = BakedShadow::of_set(&ShadowSet::from_bytes(file).unwrap()).unwrap();
    assert_eq!(read.len(), 1);
    read.swap_remove(0)
}

fn lit(
    source: &impl VisibilitySource<Share = f32>,
    ray: &Ray,
    light: &Emitter,
) -> Vec<LitInterval> {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let mut lit = Vec::new();
    if let Some(path) = LightPath::new(ray, light, &medium) {
        source.lit_intervals(&path, &mut lit);
        let ordered = |w: &[LitInterval]| w[0].interval.end <= w[1].interval.start;
        assert!(lit.windows(2).all(ordered), "{lit:?}");
        let inside = |part: &LitInterval| {
            path.span().start <= part.interval.start && part.interval.end <= path.span().end
        };
        assert!(lit.iter().all(inside), "{lit:?} in {:?}", path.span());
    }
    lit
}

#[test]
fn a_roof_shadows_what_is_below_from_lights_of_every_kind() {
    let scene = roof_and_floor();
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let high = Vec3::new(0.0, 4.0, 0.0);
    let ray = Ray::new(Vec3::new(-5.0, 0.5, 0.1), Vec3::X, 10.0).unwrap();
    // The upper edges of the roof are 2.5 below the lamp, the ray is 3.5.
    for (light, half, grids) in [
        (sun, 1.0, 1),
        (lamp(high, Emission::Isotropic), 1.4, 6),
        (spot(high), 1.4, 1),
    ] {
        let baked = bake(&scene, &light, 1024);
        let found = lit(&baked, &ray, &light);
        assert_eq!(
            (found.len(), baked.grids().len()),
            (2, grids),
            "{light:?}: {found:?}"
        );
        let ends = [found[0].interval.end, found[1].interval.start];
        for (end, expected) in ends.into_iter().zip([5.0 - half, 5.0 + half]) {
            assert!((end - expected).abs() < 0.05, "{light:?}: {found:?}");
        }
        assert_eq!(found[1].interval.end, 10.0);
        // Above the roof all is lit.
        let above = Ray::new(Vec3::new(-3.0, 2.0, 0.1), Vec3::X, 6.0).unwrap();
        assert_eq!(lit(&baked, &above, &light).len(), 1);
    }
}

#[test]
fn a_lamp_among_walls_sees_through_its_windows_and_over_the_rims_of_its_grids() {
    // Posts in the diagonal directions, where grids meet.
    let posts = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, z)| {
        let centre = 2.0 * Vec3::new(x, 0.0, z);
        let half = Vec3::new(0.5, 3.0, 0.5);
        solid(centre - half, centre + half)
    });
    let scene = geometry(&posts);
    let light = lamp(Vec3::ZERO, Emission::Isotropic);
    let baked = bake(&scene, &light, 1024);
    let mut dark = 0;
    for i in 0..720 {
        // A ray along the circle of radius 5 around the lamp.
        let angle = (i as f32 * 0.5 + 0.1).to_radians();
        let at = 5.0 * Vec3::new(angle.cos(), 0.0, angle.sin());
        let ray = Ray::new(at, at, 0.5).unwrap();
        let found = lit(&baked, &ray, &light);
        let length: f32 = found.iter().map(|part| part.interval.length()).sum();
        // The shadow of a post reaches 14.04° to either side of the diagonal:
        // its corners are at (1.5, 2.5).
        let off = (angle.to_degrees() % 90.0 - 45.0).abs();
        let expected = off > 14.036;
        if (off - 14.036).abs() > 0.2 {
            assert!((length > 0.49) == expected, "{i}: {found:?}");
            assert!((length < 1e-4) != expected, "{i}: {found:?}");
        }
        dark += u32::from(!expected);
    }
    assert!(dark > 100);
}

#[test]
fn filtered_shadows_on_surfaces_add_up_over_the_rims_of_grids() {
    let scene = roof_and_floor();
    let high = Vec3::new(0.0, 4.0, 0.0);
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    for (light, half) in [
        (sun, 1.0),
        (lamp(high, Emission::Isotropic), 1.6),
        (spot(high), 1.6),
    ] {
        let baked = bake(&scene, &light, 1024);
        for size in [1, 9] {
            let shadow = baked.filtered(FilterSize::new(size).unwrap());
            let at = |x: f32| shadow.visibility(Vec3::new(x, 0.0, 0.3), Vec3::Y).x;
            assert_eq!(at(0.0), 0.0, "{light:?}");
            assert_eq!(at(half + 0.5), 1.0, "{light:?}");
            // The floor does not shadow itself, however flat the light.
            for x in [2.5, 4.0, 5.5, 7.0, 8.9] {
                assert_eq!(at(x), 1.0, "{light:?} {x} {size}");
            }
            if size > 1 {
                let edge: Vec<f32> = (-40..40).map(|i| at(half + 0.005 * i as f32)).collect();
                assert!(edge.is_sorted(), "{edge:?}");
                assert!(
                    edge.iter().any(|share| (0.2..0.8).contains(share)),
                    "{edge:?}"
                );
            }
            // The top of the roof is lit.
            assert_eq!(shadow.visibility(Vec3::new(0.2, 1.5, 0.3), Vec3::Y).x, 1.0);
        }
    }
    // A wall around the lamp whose middle is where grids meet.
    let walls = [solid(Vec3::new(1.0, -1.0, -1.0), Vec3::new(2.0, 3.0, 3.0))];
    let scene = geometry(
        &[
            &walls[..],
            &[solid(Vec3::new(-9.0, -9.0, 8.0), Vec3::new(9.0, 9.0, 9.0))],
        ]
        .concat(),
    );
    let light = lamp(Vec3::ZERO, Emission::Isotropic);
    let baked = bake(&scene, &light, 512);
    let shadow = baked.filtered(FilterSize::new(15).unwrap());
    for i in 0..100 {
        // Deep inside of the shadow of the wall, across the rim of +X and +Z.
        let x = 7.5 + 0.01 * i as f32;
        let point = Vec3::new(x, 0.0, 7.9);
        assert!(shadow.visibility(point, Vec3::NEG_Z).x < 0.06, "{x}");
    }
}

#[test]
fn grids_are_told_apart_and_read_from_files() {
    let scene = roof_and_floor();
    let resolution = Resolution::new(64).unwrap();
    let lights = [
        Emitter::directional(Vec3::new(0.1, -1.0, 0.2), Vec3::ONE).unwrap(),
        Emitter::directional(Vec3::new(0.1, -1.0, 0.3), Vec3::ONE).unwrap(),
        lamp(Vec3::new(0.0, 4.0, 0.0), Emission::Isotropic),
        lamp(Vec3::new(0.0, 4.1, 0.0), Emission::Isotropic),
        lamp(Vec3::new(0.0, 90.0, 0.0), Emission::Isotropic),
    ];
    for (i, light) in lights.iter().enumerate() {
        let baked = bake(&scene, light, 64);
        let file = baked.to_bytes();
        let read = read(&file);
        assert_eq!(read.to_bytes(), file);
        for (j, other) in lights.iter().enumerate() {
            let spaces = light_spaces(&scene, other, resolution).unwrap();
            assert_eq!(read.fits(&spaces), i == j, "{i} {j}");
        }
        let two: Vec<_> = read.grids().iter().cycle().take(2).cloned().collect();
        let error = BakedShadow::new(&two).unwrap_err();
        assert!(matches!(error, BakedError::Grids(2)), "{error}");
    }
    // A grid that was built from depths of nobody knows where.
    let empty = vec![f32::INFINITY; 64 * 64];
    let map = shadow_dag::DepthMap::new(resolution, shadow_dag::Slices::Linear, &empty).unwrap();
    let nowhere = Builder::new().build(&Cpu::new(), &map).unwrap();
    let error = BakedShadow::new(&[nowhere]).unwrap_err();
    assert!(matches!(error, BakedError::NoLight(0)), "{error}");
    // Six grids, one of them finer.
    let mut mixed = bake(&scene, &lights[2], 64).grids().to_vec();
    mixed[4] = bake(&scene, &lights[2], 128).grids()[4].clone();
    let error = BakedShadow::new(&mixed).unwrap_err();
    let expected = matches!(
        error,
        BakedError::Resolutions {
            grid: 4,
            side: 128,
            expected: 64,
        }
    );
    assert!(expected, "{error}");
    // The same grids in another order are those of no light.
    let mut turned = bake(&scene, &lights[2], 64).grids().to_vec();
    turned.swap(0, 1);
    let spaces = light_spaces(&scene, &lights[2], resolution).unwrap();
    assert!(!BakedShadow::new(&turned).unwrap().fits(&spaces));
}

#[test]
fn what_moves_shadows_beside_what_does_not() {
    let still = solid(Vec3::new(-3.0, 1.0, -1.0), Vec3::new(-1.0, 1.5, 1.0));
    let moving = solid(Vec3::new(1.0, 1.0, -1.0), Vec3::new(2.0, 1.5, 1.0));
    let floor = solid(Vec3::new(-9.0, -1.0, -9.0), Vec3::new(9.0, 0.0, 9.0));
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let scenery = bake(&geometry(&[still, floor.clone()]), &sun, 1024);
    let guest = bake(&geometry(&[moving]), &sun, 1024);
    let ray = Ray::new(Vec3::new(-5.0, 0.5, 0.1), Vec3::X, 10.0).unwrap();
    let found = lit(&Both(&scenery, &guest), &ray, &sun);
    let expected = [(0.0, 2.0), (4.0, 6.0), (7.0, 10.0)];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (part, (start, end)) in found.iter().zip(expected) {
        assert!((part.interval.start - start).abs() < 0.03, "{found:?}");
        assert!((part.interval.end - end).abs() < 0.03, "{found:?}");
    }
}

#[test]
fn lights_in_awkward_places_are_answered() {
    let scene = roof_and_floor();
    let ray = Ray::new(Vec3::new(-5.0, 0.5, 0.1), Vec3::X, 10.0).unwrap();
    // At a corner, on a face, within a solid, on the ray, a grain away from
    // the roof, far away.
    for position in [
        Vec3::new(-1.0, 1.0, -1.0),
        Vec3::new(0.0, 1.0, 0.0),
        Vec3::new(0.0, 1.2, 0.0),
        Vec3::new(0.0, 0.5, 0.1),
        Vec3::new(0.0, 1.0 - 1e-6, 0.0),
        Vec3::new(3e6, 4e6, 1e6),
    ] {
        let light = lamp(position, Emission::Isotropic);
        let baked = bake(&scene, &light, 128);
        let length: f32 = lit(&baked, &ray, &light)
            .iter()
            .map(|part| part.interval.length())
            .sum();
        assert!((0.0..=10.001).contains(&length), "{position}: {length}");
        let surface = baked.filtered(FilterSize::new(3).unwrap());
        let share = surface.visibility(Vec3::new(0.0, 0.0, 2.0), Vec3::Y).x;
        assert!((0.0..=1.0).contains(&share), "{position}");
    }
    // So far that its rays are parallel to f32.
    let light = lamp(Vec3::new(0.0, 9e8, 0.0), Emission::Isotropic);
    match light_spaces(&scene, &light, Resolution::new(64).unwrap()) {
        Ok(spaces) => assert_eq!(spaces.len(), 1),
        Err(error) => assert!(matches!(error, Error::BadValue { .. }), "{error}"),
    }
}

#[test]
fn an_open_scene_is_baked_as_such_and_said_so() {
    let sheet = Mesh {
        positions: vec![
            Vec3::new(-1.0, 1.0, -1.0),
            Vec3::new(1.0, 1.0, -1.0),
            Vec3::new(0.0, 1.0, 2.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let floor = solid(Vec3::new(-9.0, -1.0, -9.0), Vec3::new(9.0, 0.0, 9.0));
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let resolution = Resolution::new(256).unwrap();
    let scene = geometry(&[sheet, floor]);
    let (baked, watertightness) =
        BakedShadow::bake(&Cpu::new(), &scene, &sun, resolution, Builder::new()).unwrap();
    assert_eq!(
        (
            watertightness.parts,
            watertightness.open_parts,
            watertightness.open_edges
        ),
        (2, 1, 3)
    );
    let ray = Ray::new(Vec3::new(0.0, 3.0, 0.1), Vec3::NEG_Y, 2.9).unwrap();
    let found = lit(&baked, &ray, &sun);
    assert_eq!(found.len(), 1);
    assert!((found[0].interval.end - 2.0).abs() < 0.03, "{found:?}");
}

#[test]
fn no_file_of_six_grids_is_read_past_its_end() {
    let light = lamp(Vec3::new(0.0, 4.0, 0.0), Emission::Isotropic);
    let file = bake(&roof_and_floor(), &light, 16).to_bytes();
    assert!(ShadowSet::from_bytes(&file).is_ok());
    for length in 0..file.len() {
        assert!(ShadowSet::from_bytes(&file[..length]).is_err(), "{length}");
    }
    let mut longer = file.clone();
    longer.push(0);
    assert!(ShadowSet::from_bytes(&longer).is_err());
    for at in 0..76 {
        for value in [0, 0x7f, 0xff] {
            let mut bytes = file.clone();
            bytes[at] = value;
            assert_eq!(ShadowSet::from_bytes(&bytes).is_ok(), bytes == file, "{at}");
        }
    }
}

#[test]
fn the_lights_of_a_scene_share_a_file_and_know_their_own() {
    let scene = roof_and_floor();
    let resolution = Resolution::new(64).unwrap();
    let lights = [
        Emitter::directional(Vec3::new(0.1, -1.0, 0.2), Vec3::ONE).unwrap(),
        lamp(Vec3::new(0.0, 4.0, 0.0), Emission::Isotropic),
        spot(Vec3::new(0.0, 3.0, 0.0)),
    ];
    let grids = lights
        .each_ref()
        .map(|light| light_grids(&scene, light, resolution).unwrap());
    let mut all = super::bake(&scene, grids.to_vec(), Builder::new()).unwrap();
    let never = std::sync::atomic::AtomicBool::new(false);
    all.advance(&Cpu::new(), usize::MAX, &never, |_| {})
        .unwrap();
    let file = all.finish().unwrap().to_bytes();
    let read = BakedShadow::of_set(&ShadowSet::from_bytes(&file).unwrap()).unwrap();
    assert_eq!(read.len(), lights.len());
    for (i, light) in lights.iter().enumerate() {
        let spaces = light_spaces(&scene, light, resolution).unwrap();
        for (j, shadow) in read.iter().enumerate() {
            assert_eq!(shadow.fits(&spaces), i == j, "{i} {j}");
        }
        assert!(read[i].to_bytes() == bake(&scene, light, 64).to_bytes());
    }
}

#[test]
fn grids_end_where_the_light_does() {
    let scene = roof_and_floor();
    let high = Vec3::new(0.0, 4.0, 0.0);
    let ray = Ray::new(Vec3::new(-1.7, 2.0, 0.1), Vec3::new(0.0, -1.0, 0.01), 10.0).unwrap();
    // The roof is 2.5 below the lamp, the floor 4.
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let cone = Cone {
        inner: 0.1,
        outer: 1.2,
    };
    let spot = Emission::spot(down, cone, None).unwrap();
    for emission in [Emission::Isotropic, spot] {
        let ends = |range: f32| Emitter::point(high, Vec3::ONE, range, emission.clone()).unwrap();
        let endless = bake(&scene, &ends(f32::INFINITY), 512);
        let resolution = Resolution::new(512).unwrap();
        for range in [3.8, 3.0, 2.0] {
            let light = ends(range);
            let baked = bake(&scene, &light, 512);
            for grid in baked.grids() {
                let slices = *grid.light().unwrap().slices();
                // One that sees no caster within the range is a slice or so of the first.
                let end = f64::from(range.max(2.5));
                assert!(slices.depth(1.0) <= end * 1.01, "{slices:?}");
            }
            let [found, expected] = [&baked, &endless].map(|baked| lit(baked, &ray, &light));
            assert_eq!(
                found.len(),
                expected.len(),
                "{range}: {found:?} {expected:?}"
            );
            for (found, expected) in found.iter().zip(&expected) {
                let apart = |a: f32, b: f32| (a - b).abs() > 0.03;
                let [found, expected] = [found.interval, expected.interval];
                assert!(
                    !apart(found.start, expected.start),
                    "{found:?} {expected:?}"
                );
                assert!(!apart(found.end, expected.end), "{found:?} {expected:?}");
            }
            // A file from before the light had a range still fits, but none that ends
            // earlier.
            let spaces = light_spaces(&scene, &light, resolution).unwrap();
            assert!(endless.fits(&spaces) && baked.fits(&spaces));
            let spaces = light_spaces(&scene, &ends(f32::INFINITY), resolution).unwrap();
            assert!(!baked.fits(&spaces));
        }
    }
}

#[test]
fn a_light_keeps_its_bias_in_its_file() {
    let scene = roof_and_floor();
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let resolution = Resolution::new(64).unwrap();
    let grids = LightGrids {
        bias: 3.0,
        ..light_grids(&scene, &sun, resolution).unwrap()
    };
    let mut bake = super::bake(&scene, vec![grids], Builder::new()).unwrap();
    let never = std::sync::atomic::AtomicBool::new(false);
    bake.advance(&Cpu::new(), usize::MAX, &never, |_| {})
        .unwrap();
    let file = bake.finish().unwrap().to_bytes();
    let baked = read(&file);
    assert_eq!(baked.bias(), 3.0);
    assert!(baked.to_bytes() == file);
    let moved = [
        baked.to_form(Form::Packed).unwrap(),
        baked.upload(&Cpu::new()).unwrap(),
    ];
    assert!(moved.iter().all(|moved| moved.bias() == 3.0));
    assert_eq!(self::bake(&scene, &sun, 64).bias(), LightGrids::BIAS);
}

#[test]
fn shadows_in_another_memory_answer_the_same() {
    let scene = roof_and_floor();
    let light = lamp(Vec3::new(0.0, 4.0, 0.0), Emission::Isotropic);
    let plain = bake(&scene, &light, 128);
    let packed = plain.to_form(Form::Packed).unwrap();
    let uploaded = packed.upload(&Cpu::new()).unwrap();
    assert!(
        uploaded
            .grids()
            .iter()
            .all(|grid| grid.form() == Form::Plain)
    );
    for i in 0..200 {
        let start = Vec3::new(-5.0, 0.01 * i as f32, 0.1);
        let ray = Ray::new(start, Vec3::new(1.0, 0.001 * i as f32, 0.3), 10.0).unwrap();
        let expected = lit(&plain, &ray, &light);
        assert_eq!(lit(&packed, &ray, &light), expected);
        assert_eq!(lit(&uploaded, &ray, &light), expected);
    }
}

#[test]
fn a_mask_is_baked_with_its_holes_and_without_what_casts_no_shadow() {
    let roof = |height: f32, material| {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        Mesh {
            positions: corners.map(|(x, z)| Vec3::new(x, height, z)).to_vec(),
            texture_coordinates: corners
                .map(|(x, z)| Vec2::new(x + 1.0, z + 1.0) / 2.0)
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(material),
            ..Mesh::default()
        }
    };
    let alpha = vec![1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0];
    let texture = Texture::new(3, 3, vec![Vec3::ONE; 9]).unwrap();
    let mut scene = Scene {
        meshes: vec![roof(1.0, 0), roof(1.5, 1), roof(1.2, 2), roof(-2.0, 1)],
        materials: vec![
            Material {
                base_color_texture: Some(texture.with_alpha(alpha).unwrap()),
                alpha: AlphaMode::Mask { cutoff: 0.5 },
                ..Material::default()
            },
            Material::default(),
            Material {
                transmission: 1.0,
                ..Material::default()
            },
        ],
        ..Scene::default()
    };
    scene.instances = (0..4)
        .map(|mesh| Instance {
            mesh,
            no_shadow: mesh == 1,
            ..Instance::default()
        })
        .collect();
    let geometry = Geometry::new(&scene).unwrap();
    let found = surfaces(&geometry).unwrap().watertightness();
    assert_eq!((found.parts, found.open_parts), (2, 2));
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let above = lamp(Vec3::new(0.1, 4.0, 0.2), Emission::Isotropic);
    for light in [sun, spot(Vec3::new(0.0, 4.0, 0.0)), above] {
        let baked = bake(&geometry, &light, 256);
        let baked = baked.filtered(FilterSize::new(1).unwrap());
        let (mut wrong, mut seen) = (0, [0; 2]);
        for i in 0..60 * 60 {
            let (x, z) = ((i % 60) as f32 / 32.0 - 0.93, (i / 60) as f32 / 32.0 - 0.93);
            // Points of the roof, seen from a point far below it.
            let below = match &light {
                Emitter::Directional(_) => Vec3::new(x, 0.0, z),
                Emitter::Point(point) => {
                    let roof = Vec3::new(x, 1.0, z);
                    roof + (roof - point.position()) / 3.0
                }
            };
            // (x + 1) / 2 along the second corner's edges: u is v of the texture.
            let triangle = usize::from(x > z);
            let (a, b) = (f64::from(x + 1.0) / 2.0, f64::from(z + 1.0) / 2.0);
            let (u, v) = if triangle == 0 {
                (b - a, a)
            } else {
                (b, a - b)
            };
            let lets_through = geometry.caster(triangle).transmittance_at(u, v) == Vec3::ONE;
            let is_lit = baked.visibility(below, Vec3::Y).x > 0.5;
            wrong += usize::from(lets_through != is_lit);
            seen[usize::from(is_lit)] += 1;
        }
        // Points within a texel of a rim: its length over the spacing of the points.
        assert!(wrong < 200, "{light:?}: {wrong}");
        assert!(seen[0] > 500 && seen[1] > 500, "{seen:?}");
    }
}
