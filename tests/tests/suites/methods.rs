//! `lighting`'s methods against the truth, on every backend.

use airlight::Table;
use crepuscular_tests::suite::Subject;
use glam::{DVec3, Quat, Vec2, Vec3};
use gpu_backend::{Backend, Cpu};
use lighting::airlight::{Analytic, EquiAngular, Midpoint, Quadrature};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{
    AlphaMode, Camera, Emission, Geometry, Instance, Material, Medium, Mesh, PhaseFunction, Scene,
    Texture,
};
use lighting::visibility::{Exact, Unshadowed};
use lighting::{Emitter, EyePanes, Gather, LightPath, LitRays, Ray, VisibilitySource};
use proptest::prelude::*;
use reference::generators::{bulb, ray, solids, soup, sun};
use reference::hard_cases::{HardCase, hard_cases};
use reference::metrics::image_error;
use reference::oracle::airlight::{Airlight, Tolerance, reach};
use reference::oracle::image::{Options, reference};
use reference::oracle::visibility::{Blockers, Search};
use reference::oracle::{Fog, Lamp, Line};
use reference::property::holds_for;
use reference::random::Random;
use reference::scenes::TestScene;
use reference::shapes;
use reference::tolerances::Allowed;

crepuscular_tests::on_every_backend!(
    quadrature_converges_to_the_oracle_on_every_hard_case,
    evaluators_keep_their_tolerance_on_every_hard_case,
    nothing_to_gather_leaves_the_buffer_alone,
);
crepuscular_tests::on_every_backend!(
    traced: exact_intervals_with_quadrature_are_the_reference_image,
    the_exact_evaluator_is_exact_in_scenes_too,
);

/// The radiance of rays without shadows.
fn unshadowed<B, A>(
    backend: &B,
    rays: &[Ray],
    emitter: &Emitter,
    medium: &Medium,
    airlight: &A,
) -> Vec<[f32; 4]>
where
    B: Subject + Gather<Unshadowed, A>,
{
    let rays = backend.upload(rays).unwrap();
    let mut radiance = backend.zeros::<[f32; 4]>(rays_len::<B>(&rays)).unwrap();
    backend
        .gather(
            &LitRays::new(&rays, emitter, medium),
            &Unshadowed,
            airlight,
            &mut radiance,
        )
        .unwrap();
    backend.download(&radiance).unwrap()
}

fn rays_len<B: Subject>(rays: &gpu_backend::BufferOf<B, Ray>) -> usize {
    use gpu_backend::Buffer;
    rays.len()
}

fn truth(ray: &Ray, emitter: &Emitter, medium: &Medium) -> DVec3 {
    let (line, fog, lamp) = (Line::new(ray), Fog::new(medium), Lamp::new(emitter));
    let mut airlight = Airlight::new(&line, &fog);
    if let Some(reach) = reach(&line, &lamp, &fog) {
        airlight.add_off_the_light(&lamp, reach, &[reach]);
    }
    airlight.total(Tolerance::relative(1e-10)).value
}

fn quadrature_converges_to_the_oracle_on_every_hard_case<B: Subject>(backend: &B) {
    let quadrature = EquiAngular::new(512).unwrap();
    let errors = hard_cases()
        .into_iter()
        .map(|case| (hard_error(backend, &case, &quadrature), case.name));
    require_within(errors, Allowed::Quadrature.error());
}

fn the_exact_evaluator_is_exact_in_scenes_too<B>(backend: &B)
where
    B: Subject + Gather<Unshadowed, Analytic<airlight::Exact>>,
{
    let errors = hard_cases().into_iter().map(|case| {
        let phase = case.medium.phase();
        let fallback = Quadrature::with_tolerance(phase, 1e-5).unwrap();
        let exact = Analytic::new(airlight::Exact::new(phase).unwrap(), fallback);
        (hard_error(backend, &case, &exact), case.name)
    });
    require_within(errors, Allowed::Evaluator.error());
}

fn evaluators_keep_their_tolerance_on_every_hard_case<B: Subject>(backend: &B) {
    let mut tables: Vec<(PhaseFunction, Table)> = Vec::new();
    let mut errors = Vec::new();
    for case in hard_cases() {
        let phase = case.medium.phase();
        let quadrature = Quadrature::with_tolerance(phase, 1e-5).unwrap();
        errors.push((hard_error(backend, &case, &quadrature), case.name));
        let known = tables.iter().position(|(other, _)| *other == phase);
        let index = known.unwrap_or_else(|| {
            tables.push((phase, Table::new(&phase, 64).unwrap()));
            tables.len() - 1
        });
        let table = &tables[index].1;
        // What a table says of itself comes on top.
        let own = f64::from(table.error_bound());
        let found = hard_error(backend, &case, &Analytic::new(table.clone(), quadrature));
        errors.push(((found - own).max(0.0), case.name));
    }
    require_within(errors.into_iter(), Allowed::Evaluator.error());
}

/// The largest error of a channel, relative to the light without its cone and
/// range.
fn hard_error<B, A>(backend: &B, case: &HardCase, airlight: &A) -> f64
where
    B: Subject + Gather<Unshadowed, A>,
{
    let HardCase {
        emitter,
        medium,
        ray,
        ..
    } = case;
    let found = unshadowed(backend, &[*ray], emitter, medium, airlight)[0];
    let expected = truth(ray, emitter, medium);
    let bare = truth(ray, &bare(emitter), medium);
    (0..3)
        .map(|channel| {
            let (found, expected) = (f64::from(found[channel]), expected[channel]);
            (found - expected).abs() / bare[channel].max(f64::from(f32::MIN_POSITIVE))
        })
        .fold(0.0, f64::max)
}

fn require_within(errors: impl Iterator<Item = (f64, &'static str)>, allowed: f64) {
    let failures: Vec<String> = errors
        .filter(|(error, _)| !(*error <= allowed))
        .map(|(error, name)| format!("{name}: {error:.1e}"))
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The light without its cone and its range.
fn bare(emitter: &Emitter) -> Emitter {
    match emitter {
        Emitter::Point(point) => {
            let (position, intensity) = (point.position(), point.intensity());
            Emitter::point(position, intensity, f32::INFINITY, Emission::Isotropic).unwrap()
        }
        other => other.clone(),
    }
}

/// The embedded scenes by exact intervals and quadratures to a tolerance, as pictures
/// are made: hair and smoke left out, an area light given as points. That it converges
/// shows that nothing but the tolerance stands between the two.
fn exact_intervals_with_quadrature_are_the_reference_image<B>(backend: &B)
where
    B: Subject + for<'a> Gather<Exact<&'a Tracer>, Quadrature>,
{
    for embedded in Embedded::ALL {
        let test_scene = TestScene::new(embedded, 24, 13);
        let truth = test_scene.truth();
        let rays = backend.upload(&test_scene.rays).unwrap();
        for (tolerance, allowed) in [
            (1e-4, Allowed::DefaultImage.error()),
            (1e-6, Allowed::ExactImage.error()),
        ] {
            let phase = test_scene.medium.phase();
            let quadrature = Quadrature::with_tolerance(phase, tolerance).unwrap();
            let mut radiance = backend.zeros::<[f32; 4]>(test_scene.rays.len()).unwrap();
            for emitter in &test_scene.emitters {
                let exact = Exact::new(&test_scene.tracer);
                let lit = LitRays::new(&rays, emitter, &test_scene.medium);
                backend
                    .gather(&lit, &exact, &quadrature, &mut radiance)
                    .unwrap();
            }
            let error = image_error(&backend.download(&radiance).unwrap(), &truth);
            println!("{} {tolerance} {error:?}", test_scene.name);
            assert!(
                error.rmse <= allowed,
                "{} {tolerance}: {error:?}",
                test_scene.name
            );
        }
    }
}

fn nothing_to_gather_leaves_the_buffer_alone<B: Subject>(backend: &B) {
    let vacuum = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap();
    let ray = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap();
    assert_eq!(
        unshadowed(backend, &[ray], &sun, &vacuum, &Midpoint),
        [[0.0; 4]]
    );
    assert!(unshadowed(backend, &[], &sun, &vacuum, &Midpoint).is_empty());
}

#[test]
fn exact_lit_intervals_are_the_oracles() {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let triangles = prop_oneof![soup(10.0, 40).boxed(), solids(10.0, 5).boxed()];
    let emitter = prop_oneof![2 => bulb(10.0).boxed(), 1 => sun().boxed()];
    let rays = prop::collection::vec((ray(10.0), emitter), 20);
    holds_for(400, (triangles, rays), |(triangles, rays)| {
        let geometry = shapes::geometry(&triangles);
        let (tracer, blockers) = (Tracer::new(&geometry), Blockers::new(&geometry));
        for (ray, emitter) in rays {
            let Some(path) = LightPath::new(&ray, &emitter, &medium) else {
                prop_assert_eq!(ray.length(), 0.0);
                continue;
            };
            let mut found = Vec::new();
            Exact::new(&tracer).lit_intervals(&path, &mut found);
            let expected = blockers.lit_parts(&ray, &Lamp::new(&emitter), Search::Tree);
            // No stretch on which the two disagree is longer than rounding, as
            // if infinity were 1e4; slivers that one of them lacks pass.
            let found: Vec<[f64; 2]> = found
                .iter()
                .map(|part| [f64::from(part.interval.start), f64::from(part.interval.end)])
                .collect();
            let expected: Vec<[f64; 2]> =
                expected.iter().map(|part| [part.start, part.end]).collect();
            for (a, b) in [(&found, &expected), (&expected, &found)] {
                for (x, apart) in uncovered(a, b) {
                    let allowed = 2.0 * Allowed::ExactEnds.error() * x.max(20.0);
                    prop_assert!(
                        apart <= allowed,
                        "{apart} at {x}: {found:?} {expected:?} {ray:?} {emitter:?}"
                    );
                }
            }
        }
        Ok(())
    });
}

/// A wall, and before it a card of random opacities, seen from the side of a light.
fn card(material: Material) -> Geometry {
    let square = |half: f32, z: f32, material| Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(half * x, half * y, z))
            .to_vec(),
        texture_coordinates: vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(material),
        ..Mesh::default()
    };
    let mut scene = Scene {
        meshes: vec![square(1.0, -2.0, 1), square(4.0, -5.0, 0)],
        materials: vec![Material::default(), material],
        ..Scene::default()
    };
    scene.instances = (0..2)
        .map(|mesh| Instance {
            mesh,
            ..Instance::default()
        })
        .collect();
    Geometry::new(&scene).unwrap()
}

/// What is not solid, with the error that the picture may have.
fn coats() -> Vec<(&'static str, Material, f64)> {
    let mut random = Random::new(8);
    let alpha = (0..25).map(|_| random.unit()).collect();
    let texture = Texture::new(5, 5, vec![Vec3::new(1.0, 0.5, 0.2); 25]).unwrap();
    let texture = Some(texture.with_alpha(alpha).unwrap());
    let plain = Material::default();
    vec![
        (
            "a mask",
            Material {
                base_color_texture: texture.clone(),
                alpha: AlphaMode::Mask { cutoff: 0.5 },
                ..plain.clone()
            },
            Allowed::ExactImage.error(),
        ),
        (
            "glass",
            Material {
                base_color: Vec3::new(0.2, 0.5, 0.9),
                transmission: 0.8,
                ..plain.clone()
            },
            Allowed::ExactImage.error(),
        ),
        (
            "a clear window",
            Material {
                opacity: 0.0,
                alpha: AlphaMode::Blend,
                ..plain.clone()
            },
            Allowed::ExactImage.error(),
        ),
        (
            "a film",
            Material {
                base_color_texture: texture,
                alpha: AlphaMode::Blend,
                ..plain
            },
            Allowed::ExactFilm.error(),
        ),
    ]
}

#[test]
fn exact_pictures_behind_casters_that_are_not_solid_are_the_oracles() {
    let medium = Medium::new(Vec3::splat(0.05), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let lights = [
        Emitter::directional(Vec3::new(0.3, -0.2, -1.0), Vec3::ONE).unwrap(),
        Emitter::point(
            Vec3::new(0.7, 0.6, 0.5),
            Vec3::ONE,
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap(),
    ];
    let cpu = Cpu::new();
    for (name, material, allowed) in coats() {
        let geometry = card(material);
        let tracer = Tracer::new(&geometry);
        let camera = Camera::new(Vec3::new(-0.4, 0.3, 1.0), Quat::IDENTITY, 0.9).unwrap();
        let view = View::new(&cpu, &camera, &tracer, 16, 16).unwrap();
        let mut radiance = cpu.zeros(view.rays().len()).unwrap();
        let rays = view.rays().to_vec();
        let quadrature = Quadrature::with_tolerance(medium.phase(), 1e-6).unwrap();
        let panes = EyePanes::new(&cpu, &tracer, &rays);
        for light in &lights {
            let lit = LitRays {
                panes: panes.as_ref(),
                ..LitRays::new(&rays, light, &medium)
            };
            cpu.gather(&lit, &Exact::new(&tracer), &quadrature, &mut radiance)
                .unwrap();
        }
        let truth = reference(&rays, &lights, &medium, &geometry, Options::default());
        let error = image_error(&radiance, &truth);
        println!("{name} {error:?}");
        assert!(error.rmse <= allowed, "{name}: {error:?}");
    }
}

/// The gaps of `cover` within `parts`: where each ends, and its length.
fn uncovered(parts: &[[f64; 2]], cover: &[[f64; 2]]) -> Vec<(f64, f64)> {
    let mut gaps = Vec::new();
    for [start, end] in parts.iter().map(|part| part.map(|x| x.min(1e4))) {
        let mut from = start;
        for [a, b] in cover.iter().map(|part| part.map(|x| x.min(1e4))) {
            if b > from && a < end {
                gaps.push((a, a - from));
                from = from.max(b);
            }
        }
        gaps.push((end, end - from));
    }
    gaps
}
