//! What maps must say of see-through triangles.

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use reference::random::Random;
use transmittance::baseline::{Captured, Uncompressed};
use transmittance::{Filter, Packed, Stream};

use super::{Casters, TransmittanceMap};
use crate::Emitter;
use crate::scene::trace::Tracer;
use crate::scene::{AlphaMode, Emission, Geometry, Instance, Material, Mesh, Scene};
use crate::shadow_map::{Casters as Solid, RenderShadowMap};
use crate::visibility::{Both, PointVisibility};

type Exact = TransmittanceMap<Host, Uncompressed>;

/// Squares of side 2 over each other at these heights.
fn plates(plates: &[(f32, Material)]) -> Geometry {
    let mut scene = Scene::default();
    for (index, (height, material)) in plates.iter().enumerate() {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        scene.meshes.push(Mesh {
            positions: corners.map(|(x, z)| Vec3::new(x, *height, z)).into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(index),
            ..Mesh::default()
        });
        scene.materials.push(material.clone());
        scene.instances.push(Instance {
            mesh: index,
            ..Instance::default()
        });
    }
    Geometry::new(&scene).expect("plates are a scene")
}

fn glass(color: Vec3) -> Material {
    Material {
        base_color: color,
        transmission: 1.0,
        ..Material::default()
    }
}

fn film(opacity: f32) -> Material {
    Material {
        opacity,
        alpha: AlphaMode::Blend,
        ..Material::default()
    }
}

fn lights() -> [Emitter; 2] {
    let lamp = Vec3::new(0.1, 4.0, 0.2);
    [
        Emitter::directional(Vec3::new(0.1, -1.0, 0.05), Vec3::ONE).expect("a sun"),
        Emitter::point(lamp, Vec3::ONE, f32::INFINITY, Emission::Isotropic).expect("a lamp"),
    ]
}

fn exact(casters: &Casters<'_>, light: &Emitter) -> Exact {
    TransmittanceMap::build(&Cpu::new(), casters, light, 64, &Captured::new()).expect("a small map")
}

fn packed(casters: &Casters<'_>, light: &Emitter) -> TransmittanceMap<Host, Packed<8>> {
    TransmittanceMap::build(&Cpu::new(), casters, light, 64, &Stream::<8>::new())
        .expect("a small map")
}

#[test]
fn light_takes_the_colour_of_a_pane_behind_it_and_not_before() {
    let color = Vec3::new(0.9, 0.4, 0.1);
    let geometry = plates(&[(1.0, glass(color)), (-3.0, Material::default())]);
    for light in lights() {
        let casters = Casters::new(&[], Some(&geometry));
        assert_eq!(casters.channels(), 3);
        let map = packed(&casters, &light);
        assert_eq!(
            (map.channels(), map.curves().len()),
            (3, 3 * map.faces().len())
        );
        let close = |point: Vec3, expected: Vec3| {
            let off = (map.transmittance(point) - expected).abs().max_element();
            assert!(off < 1e-5, "{light:?} {point}: {off}");
        };
        // The diagonal of the square goes through its middle.
        for (x, z) in [(0.0, 0.0), (0.3, -0.2), (0.5, 0.5), (-0.4, 0.4)] {
            close(Vec3::new(x, 0.9, z), color);
            close(Vec3::new(x, -2.0, z), color);
            close(Vec3::new(x, 1.1, z), Vec3::ONE);
        }
        close(Vec3::new(0.2, -3.2, 0.2), Vec3::ZERO);
    }
}

#[test]
fn grey_panes_take_one_curve_and_clear_ones_none() {
    let thin = plates(&[(1.0, film(0.25)), (-3.0, Material::default())]);
    let clear = plates(&[(1.0, film(0.0)), (-3.0, Material::default())]);
    let whole = plates(&[(1.0, film(1.0)), (-3.0, Material::default())]);
    let solid = plates(&[(1.0, Material::default()), (-3.0, Material::default())]);
    let none = plates(&[(-3.0, Material::default())]);
    for light in lights() {
        let below = Vec3::new(0.2, 0.0, 0.1);
        let of = |geometry| packed(&Casters::new(&[], Some(geometry)), &light);
        let map = of(&thin);
        assert_eq!(map.channels(), 1);
        assert!((map.transmittance(below) - 0.75).abs().max_element() < 1e-6);
        assert_eq!(of(&clear).transmittance(below), Vec3::ONE);
        assert_eq!(of(&whole), of(&solid));
        let panes = Casters::see_through(&[], &none);
        assert!(panes.bounds().is_none());
        assert_eq!(packed(&panes, &light).transmittance(below), Vec3::ONE);
    }
}

#[test]
fn stacked_panes_multiply() {
    let stack: Vec<_> = (0..20).map(|i| (0.1 * i as f32, film(0.1))).collect();
    let geometry = plates(&stack);
    let casters = Casters::see_through(&[], &geometry);
    for light in lights() {
        let (exact, packed) = (exact(&casters, &light), packed(&casters, &light));
        for k in 0..=20 {
            let point = Vec3::new(0.1, 0.1 * k as f32 - 0.05, 0.05);
            let expected = 0.9_f32.powi(20 - k);
            let found = exact.transmittance(point).x;
            assert!((found - expected).abs() < 1e-5, "{k}: {found} {expected}");
            // Eight nodes for twenty steps from 1 down to 0.12: half of a stretch of
            // seven, and what the nodes are off.
            let found = packed.transmittance(point).x;
            assert!((found - expected).abs() < 0.1, "{k}: {found} {expected}");
        }
    }
}

#[test]
fn a_lamp_in_a_bulb_lights_all_around_it_through_the_glass() {
    let color = Vec3::new(1.0, 0.8, 0.5);
    let tip = [
        (1.0, 1.0, 1.0),
        (1.0, -1.0, -1.0),
        (-1.0, 1.0, -1.0),
        (-1.0, -1.0, 1.0),
    ];
    let mut scene = Scene::from(Mesh {
        positions: tip.map(Vec3::from).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        material: Some(0),
        ..Mesh::default()
    });
    scene.materials.push(glass(color));
    let geometry = Geometry::new(&scene).unwrap();
    let lamp = Emitter::point(Vec3::ZERO, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    let map = packed(&Casters::new(&[], Some(&geometry)), &lamp);
    assert_eq!(map.faces().len(), 6);
    let mut random = Random::new(2);
    for _ in 0..2000 {
        let direction = Vec3::from(random.vector(1.0)).normalize_or(Vec3::X);
        let off = (map.transmittance(4.0 * direction) - color)
            .abs()
            .max_element();
        assert!(off < 1e-5, "{direction}: {off}");
        assert_eq!(map.transmittance(0.1 * direction), Vec3::ONE);
    }
}

/// Points off the borders of texels and of panes.
#[test]
fn a_map_beside_a_shadow_map_is_the_map_of_all() {
    let geometry = plates(&[
        (1.0, glass(Vec3::new(0.2, 0.9, 0.5))),
        (0.5, film(0.4)),
        (-1.0, Material::default()),
    ]);
    let tracer = Tracer::new(&geometry);
    let (cpu, mut random) = (Cpu::new(), Random::new(6));
    let solid = Solid::upload(&cpu, &geometry).unwrap();
    for light in lights() {
        let all = exact(&Casters::new(&[], Some(&geometry)), &light).with_filter(Filter::Nearest);
        let panes = exact(&Casters::see_through(&[], &geometry), &light);
        let shadows = cpu.shadow_map(&solid, &light, 256).unwrap();
        let both = Both(&shadows, panes.with_filter(Filter::Nearest));
        let (mut checked, mut coloured) = (0, 0);
        for _ in 0..500 {
            let point = 1.8 * Vec3::from(random.vector(1.0));
            let (to_light, distance) = match &light {
                Emitter::Directional(sun) => (-sun.direction(), f32::INFINITY),
                Emitter::Point(lamp) => {
                    let way = lamp.position() - point;
                    (way.normalize(), way.length())
                }
            };
            let at = |point| tracer.transmittance(point, to_light, 0.0, distance);
            let truth = at(point);
            let near = [
                Vec3::X,
                Vec3::NEG_X,
                Vec3::Z,
                Vec3::NEG_Z,
                Vec3::Y,
                Vec3::NEG_Y,
            ];
            if near.iter().any(|way| at(point + 0.1 * *way) != truth) {
                continue;
            }
            checked += 1;
            coloured += usize::from(truth.x != truth.y);
            for found in [all.visibility(point), both.visibility(point)] {
                let off = (found - truth).abs().max_element();
                assert!(off < 1e-5, "{point}: {found} for {truth}");
            }
        }
        assert!(checked > 100 && coloured > 10, "{checked} {coloured}");
    }
}
