//! The oracle of area lights against what else is known of them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use glam::Vec3;
use reference::oracle::area;
use reference::oracle::image::{Options, reference};
use reference::scenes::TestScene;
use scene::procedural::Embedded;
use scene::{
    AreaLight, AreaShape, Geometry, Medium, Mesh, Pattern, PhaseFunction, Ray, Scene, Texture,
};

fn options(tolerance: f64) -> Options<'static> {
    Options {
        tolerance,
        ..Options::default()
    }
}

/// Something far away that blocks nothing.
fn empty() -> Geometry {
    let scene = Scene::from(Mesh {
        positions: vec![
            Vec3::new(0.0, -900.0, 0.0),
            Vec3::new(1.0, -900.0, 0.0),
            Vec3::new(0.0, -900.0, 1.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    Geometry::new(&scene).unwrap()
}

fn panel(shape: AreaShape) -> AreaLight {
    AreaLight {
        shape,
        corner: Vec3::new(-1.0, 3.0, -1.0),
        edges: [2.0 * Vec3::X, 2.0 * Vec3::Z],
        radiance: Vec3::new(3.0, 2.0, 1.0),
        ..AreaLight::default()
    }
}

fn fog() -> Medium {
    Medium::new(
        Vec3::splat(0.2),
        Vec3::splat(0.05),
        PhaseFunction::Isotropic,
    )
    .unwrap()
}

/// Past the light at several distances, and none through it.
fn rays() -> Vec<Ray> {
    (0..8)
        .map(|i| {
            let origin = Vec3::new(-4.0, 0.3 * i as f32, 0.5 * i as f32 - 1.0);
            Ray::new(origin, Vec3::new(1.0, 0.02, 0.1), 9.0 + i as f32).unwrap()
        })
        .collect()
}

#[test]
fn the_oracle_is_the_limit_of_many_points_within_its_bound() {
    let texels = (0..12).map(|i| Vec3::splat(i as f32 % 5.0 + 0.2)).collect();
    let texture = Some(Texture::new(4, 3, texels).unwrap());
    let mut lights = Vec::new();
    for shape in [AreaShape::Rectangle, AreaShape::Disk] {
        lights.push(panel(shape));
        lights.push(AreaLight {
            texture: texture.clone(),
            ..panel(shape)
        });
    }
    let (rays, fog, geometry) = (rays(), fog(), empty());
    for light in lights {
        let found = area::reference(
            &rays,
            &[],
            std::slice::from_ref(&light),
            &fog,
            &geometry,
            options(1e-4),
        );
        let points = light.virtual_lights(Pattern::Regular, 1600).unwrap();
        let expected = reference(&rays, &points, &fog, &geometry, options(1e-6));
        for (f, e) in found.radiance.iter().zip(&expected.radiance) {
            for channel in 0..3 {
                // Midpoints of cells of 1/40 of the light, at a distance of half its
                // size: a second derivative of a few, over 24 × 40².
                let off = (f[channel] / e[channel] - 1.0).abs();
                assert!(off < 1e-3, "{light:?}: {f:?} {e:?}");
            }
        }
        // A texture has a kink at each of its texels, which takes more parts than
        // there may be.
        let allowed = if light.texture.is_some() {
            1e-3
        } else {
            1.2e-4
        };
        let dark = area::DARKEST * found.mean();
        for (bound, value) in found.bound.iter().zip(&found.radiance) {
            let most = value[0].max(dark);
            assert!(
                *bound <= allowed * most,
                "{:?}: {bound} of {most}",
                light.shape
            );
        }
    }
}

/// The shadows of beams, with the tolerance a tenth of what is asked for and by
/// points.
#[test]
fn bounds_hold_in_soft_shadows() {
    let scene = TestScene::new(Embedded::Pergola, 6, 4);
    let areas: Vec<_> = scene.areas.iter().map(|area| area.light.clone()).collect();
    let made = |tolerance| {
        let (medium, geometry) = (&scene.medium, &scene.geometry);
        area::reference(
            &scene.rays,
            &[],
            &areas,
            medium,
            geometry,
            options(tolerance),
        )
    };
    let [coarse, fine] = [2e-2, 1e-3].map(made);
    let points = areas[0].virtual_lights(Pattern::Lattice, 2000).unwrap();
    let many = reference(
        &scene.rays,
        &points,
        &scene.medium,
        &scene.geometry,
        options(1e-4),
    );
    let mean = fine.mean();
    for i in 0..scene.rays.len() {
        for channel in 0..3 {
            let [c, f, m] = [&coarse, &fine, &many].map(|image| image.radiance[i][channel]);
            assert!(
                (c - f).abs() <= coarse.bound[i] + fine.bound[i],
                "{i}: {c} {f}"
            );
            // 2000 points leave about 2 of them in doubt in each shadow.
            assert!((m - f).abs() <= 2e-3 * f.max(mean), "{i}: {m} {f}");
        }
    }
    assert!(coarse.max_bound() > fine.max_bound());
}

/// What `tests/scripts/area_light.py` prints: the mean and its standard error by
/// Mitsuba 3, for each of its rays.
const MITSUBA: [(f64, f64); 6] = [
    (0.283_850, 0.000_227),
    (0.095_467, 0.000_070),
    (0.274_125, 0.000_156),
    (0.212_289, 0.000_115),
    (0.432_799, 0.000_294),
    (0.006_216, 0.000_024),
];

/// The scene of that script.
fn three_boxes() -> (AreaLight, Geometry, Vec<Ray>) {
    let boxes = [
        [Vec3::new(-2.2, 3.1, -2.6), Vec3::new(-1.3, 3.2, 2.6)],
        [Vec3::new(-0.5, 3.3, -2.6), Vec3::new(0.4, 3.4, 2.6)],
        [Vec3::new(1.2, 3.0, -2.6), Vec3::new(2.0, 3.1, 2.6)],
    ];
    let mut mesh = Mesh::default();
    for ends in boxes {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend((0..8).map(|corner: usize| {
            let pick = |axis: usize| ends[corner >> axis & 1][axis];
            Vec3::new(pick(0), pick(1), pick(2))
        }));
        // Two triangles for each side, whose corners share a bit.
        for (bit, [a, b]) in [(1_u32, [2_u32, 4_u32]), (2, [4, 1]), (4, [1, 2])] {
            for side in [0, bit] {
                let at = |offset: u32| first + side + offset;
                mesh.triangles.push([at(0), at(a), at(b)]);
                mesh.triangles.push([at(a), at(a + b), at(b)]);
            }
        }
    }
    let light = AreaLight {
        corner: Vec3::new(-0.7, 5.2, -0.5),
        edges: [1.4 * Vec3::X, Vec3::Z],
        radiance: Vec3::splat(300.0),
        ..AreaLight::default()
    };
    let eye = Vec3::new(0.6, 2.2, 8.2);
    let rays = [
        (eye, Vec3::new(0.0, 0.0, -1.0)),
        (eye, Vec3::new(-0.1, 0.07, -1.0)),
        (eye, Vec3::new(0.12, 0.02, -1.0)),
        (Vec3::new(-6.0, 1.0, 0.3), Vec3::new(1.0, 0.05, 0.02)),
        (Vec3::new(-6.0, 2.6, 0.3), Vec3::new(1.0, 0.0, -0.1)),
        (Vec3::new(0.1, 0.5, 0.2), Vec3::new(0.05, 1.0, 0.3)),
    ];
    // All but the last miss the boxes, and the air ends where Mitsuba's does.
    let end = 2.8 * rays[5].1.length();
    let lengths = [150.0, 150.0, 150.0, 150.0, 150.0, end];
    let rays = rays.into_iter().zip(lengths);
    let rays = rays.map(|((origin, way), length)| Ray::new(origin, way.normalize(), length));
    let rays = rays.map(|ray| ray.unwrap()).collect();
    (light, Geometry::new(&Scene::from(mesh)).unwrap(), rays)
}

#[test]
fn mitsuba_agrees_within_three_standard_errors() {
    let (light, geometry, rays) = three_boxes();
    let fog = Medium::new(
        Vec3::splat(0.1),
        Vec3::splat(0.01),
        PhaseFunction::Isotropic,
    )
    .unwrap();
    let found = area::reference(&rays, &[], &[light], &fog, &geometry, options(1e-3));
    for ((value, bound), (mean, error)) in found.radiance.iter().zip(&found.bound).zip(MITSUBA) {
        let off = (value[0] - mean).abs();
        println!("{} {mean} ± {error}, bound {bound}", value[0]);
        assert!(off <= 3.0 * error + bound, "{value:?} {mean} ± {error}");
    }
}

#[test]
fn points_and_areas_add_up() {
    let (rays, fog, geometry) = (rays(), fog(), empty());
    let light = panel(AreaShape::Rectangle);
    let lamp = light.virtual_lights(Pattern::Lattice, 1).unwrap();
    let alone = reference(&rays, &lamp, &fog, &geometry, options(1e-4));
    let areas = [light.clone(), light];
    let one = area::reference(&rays, &[], &areas[..1], &fog, &geometry, options(1e-4));
    let all = area::reference(&rays, &lamp, &areas, &fog, &geometry, options(1e-4));
    for i in 0..rays.len() {
        let expected = alone.radiance[i][0] + 2.0 * one.radiance[i][0];
        assert!((all.radiance[i][0] / expected - 1.0).abs() < 3e-4);
    }
    let none = area::reference(&rays, &[], &[], &fog, &geometry, options(1e-4));
    assert!(none.radiance.iter().all(|pixel| *pixel == [0.0; 3]));
    assert_eq!(none.max_bound(), 0.0);
}
