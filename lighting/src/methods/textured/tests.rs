#[cfg(feature = "methods")]
#[path = "frame_tests.rs"]
mod frame_tests;

use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DVec2, Quat, Vec3};
use gpu_backend::{Cpu, Host};
use reference::random::{Random, noise};

use super::*;
use crate::airlight::{EquiAngular, Quadrature};
use crate::methods::epipolar::MapRuns;
use crate::methods::hybrid::ShadowVolumes;
use crate::scene::{
    Bounds, Cone, Emission, Falloff, Geometry, Medium, Mesh, PhaseFunction, Scene, Texture,
};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use crate::visibility::Unshadowed;
use crate::{AirlightEvaluator, Gather, LitRays, Ray};

/// Texels per side of shadow maps.
const MAP: u32 = 256;

/// Panes of glass with smooth leads between them.
fn window(side: u32) -> Texture {
    let texels = (0..side * side).map(|i| {
        let at = [i % side, i / side].map(|t| (t as f32 + 0.5) / side as f32 * 5.0);
        let lead = at.map(|t| (std::f32::consts::PI * t).sin().abs().min(0.5) * 2.0);
        let pane = u64::from(at[0] as u32 * 5 + at[1] as u32);
        let colour = [0, 1, 2].map(|c| 0.1 + noise(3 * pane + c));
        lead[0] * lead[1] * Vec3::from(colour)
    });
    Texture::new(side, side, texels.collect()).unwrap()
}

/// A light that shines down from the origin into a cone of this half angle.
fn spot(outer: f32, texture: Option<Texture>) -> Emitter {
    let cone = Cone {
        inner: 0.8 * outer,
        outer,
    };
    let down = Quat::from_rotation_x(-FRAC_PI_2);
    let emission = Emission::spot(down, cone, texture).unwrap();
    Emitter::point(Vec3::ZERO, Vec3::ONE, 9.0, emission).unwrap()
}

/// Balls of triangles in the beam, and some beside it.
fn casters(outer: f32) -> Geometry {
    let mut random = Random::new(11);
    let mut positions = Vec::new();
    for i in 0..5 {
        let aside = 3.0 * outer.tan().min(2.0);
        let centre = Vec3::from(random.vector(1.0)) * Vec3::new(aside, 0.5, aside);
        let centre = centre - (2.0 + 0.4 * i as f32) * Vec3::Y;
        for _ in 0..10 {
            positions.extend([0; 3].map(|_| centre + Vec3::from(random.vector(0.15 * aside))));
        }
    }
    let count = positions.len() as u32 / 3;
    let mesh = Mesh {
        positions,
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    Geometry::new(&Scene::from(mesh)).unwrap()
}

fn fog() -> Medium {
    Medium::new(
        Vec3::new(0.1, 0.15, 0.2),
        Vec3::splat(0.02),
        PhaseFunction::HenyeyGreenstein { g: 0.3 },
    )
    .unwrap()
}

type Shadows<'a> = ShadowSpans<&'a ShadowMap<Host>, Host>;

/// A light with its shadow map and its volumes.
struct Lamp {
    light: Emitter,
    map: ShadowMap<Host>,
    volumes: Arc<ShadowVolumes<Host>>,
    cookie: Option<Arc<MipCookie<Host>>>,
}

impl Lamp {
    fn new(light: Emitter, geometry: &Geometry) -> Self {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, geometry).unwrap();
        let cookie = light.spot().and_then(|spot| spot.texture());
        Self {
            map: cpu.shadow_map(&casters, &light, MAP).unwrap(),
            volumes: Arc::new(ShadowVolumes::new(&cpu, geometry, &light, MAP).unwrap()),
            cookie: cookie.map(|texture| Arc::new(MipCookie::new(texture))),
            light,
        }
    }

    fn textured(&self, steps: u32, placement: Placement) -> Textured<Shadows<'_>, Host> {
        let (map, volumes) = (&self.map, Some(self.volumes.clone()));
        let shadows = ShadowSpans::new(map, volumes, &self.light, 2 * steps, placement).unwrap();
        let cookie = self.cookie.clone();
        Textured::new(shadows, &self.light, cookie, steps, placement)
    }

    /// The runs of the map with the exact integral over the cookie.
    fn truth(&self, rays: &Vec<Ray>, fog: &Medium) -> Vec<[f32; 4]> {
        let exact = Quadrature::with_tolerance(fog.phase(), 1e-5).unwrap();
        let lit = LitRays::new(rays, &self.light, fog).joined();
        gathered(&lit, &MapRuns::walked(&self.map), &exact)
    }
}

fn gathered<V: VisibilitySource, A: AirlightEvaluator>(
    lit: &LitRays<'_, Host>,
    source: &V,
    airlight: &A,
) -> Vec<[f32; 4]> {
    let mut radiance = vec![[0.0; 4]; lit.rays.len()];
    Cpu::new()
        .gather(lit, source, airlight, &mut radiance)
        .unwrap();
    assert!(radiance.iter().flatten().all(|light| light.is_finite()));
    radiance
}

/// The bare light through a source of shares.
fn textured<V: VisibilitySource>(
    rays: &Vec<Ray>,
    (light, fog): (&Emitter, &Medium),
    source: &V,
) -> Vec<[f32; 4]> {
    let bare = bare(light);
    let airlight = EquiAngular::new(2).unwrap();
    gathered(&LitRays::new(rays, &bare, fog), source, &airlight)
}

/// Relative to the mean.
fn rmse(found: &[[f32; 4]], truth: &[[f32; 4]]) -> f64 {
    let channels = |all: &[[f32; 4]]| -> Vec<f64> {
        let light = all.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]);
        light.map(f64::from).collect()
    };
    let (found, truth) = (channels(found), channels(truth));
    let count = truth.len() as f64;
    let mean = truth.iter().sum::<f64>() / count;
    let square: f64 = (found.iter().zip(&truth))
        .map(|(f, t)| (f - t).powi(2))
        .sum();
    (square / count).sqrt() / mean
}

/// Rays from an eye to places all over the beam.
fn rays(eye: Vec3, outer: f32, length: f32) -> Vec<Ray> {
    let unit = |i: u64| noise(i) - 0.5;
    let towards = |i: u64| {
        let depth = 0.5 + 5.0 * noise(5 * i);
        let aside = 1.8 * depth * outer.tan().min(3.0);
        let aim = Vec3::new(aside * unit(5 * i + 1), -depth, aside * unit(5 * i + 2));
        Ray::new(eye, aim - eye, length).unwrap()
    };
    (0..300).map(towards).collect()
}

/// Eyes beside the beam, in it, above the light, below it; narrow beams and wide ones;
/// fog without an end, and in a box around the light or below it.
#[test]
fn light_converges_to_that_of_the_exact_cookie_behind_the_runs_of_the_map() {
    let open = fog();
    let boxed = |low: f32, high: f32| {
        let half = 3.5;
        let bounds = Bounds::new(Vec3::new(-half, low, -half), Vec3::new(half, high, half));
        open.within(bounds.unwrap())
    };
    for (name, outer, eye, medium) in [
        ("beside the beam", 0.45, Vec3::new(5.0, -2.0, 1.0), open),
        ("in the beam", 0.45, Vec3::new(0.3, -4.0, 0.2), open),
        ("above the light", 0.45, Vec3::new(0.1, 2.0, 0.05), open),
        ("below it", 0.45, Vec3::new(0.2, -7.5, 0.1), open),
        ("on the axis", 0.45, Vec3::new(0.0, 1.0, 0.0), open),
        (
            "a beam of 2 degrees",
            1_f32.to_radians(),
            Vec3::new(2.0, -3.0, 1.0),
            open,
        ),
        (
            "the same along it",
            1_f32.to_radians(),
            Vec3::new(0.05, 1.0, 0.02),
            open,
        ),
        (
            "a beam of 170 degrees",
            85_f32.to_radians(),
            Vec3::new(5.0, -2.0, 1.0),
            open,
        ),
        (
            "light and eye in a box",
            0.45,
            Vec3::new(2.5, -2.0, 1.0),
            boxed(-5.0, 1.0),
        ),
        (
            "both outside of it",
            0.45,
            Vec3::new(5.0, -1.5, 0.5),
            boxed(-5.0, -1.0),
        ),
    ] {
        let lamp = Lamp::new(spot(outer, Some(window(32))), &casters(outer));
        let mut rays = rays(eye, outer, 12.0);
        // Close by the light, where its airlight has no pole, and along the axis.
        for aim in [
            Vec3::new(4e-3, 0.0, 0.0),
            Vec3::new(0.0, 0.0, 0.1),
            eye + Vec3::new(0.02, -1.0, 0.0),
        ] {
            rays.extend(Ray::new(eye, aim - eye, 12.0));
        }
        let truth = lamp.truth(&rays, &medium);
        let errors = [8, 32, 128, 1024].map(|steps| {
            let source = lamp.textured(steps, Placement::Angle);
            rmse(&textured(&rays, (&lamp.light, &medium), &source), &truth)
        });
        println!("{name}: {errors:.5?}");
        assert!(
            errors[1] < 0.7 * errors[0] && errors[2] < 0.4 * errors[1],
            "{name}"
        );
        assert!(errors[3] < 4e-3, "{name}: {errors:?}");
    }
}

#[test]
fn all_placements_converge() {
    let (outer, medium) = (0.45, fog());
    let lamp = Lamp::new(spot(outer, Some(window(32))), &casters(outer));
    let rays = rays(Vec3::new(5.0, -2.0, 1.0), outer, 12.0);
    let truth = lamp.truth(&rays, &medium);
    for placement in [
        Placement::Angle,
        Placement::Length { reach: 9.0 },
        Placement::Span,
    ] {
        let errors = [16, 512].map(|steps| {
            let source = lamp.textured(steps, placement);
            rmse(&textured(&rays, (&lamp.light, &medium), &source), &truth)
        });
        println!("{placement:?}: {errors:.5?}");
        assert!(
            errors[1] < 0.1 * errors[0] && errors[1] < 1e-2,
            "{placement:?}"
        );
    }
}

#[test]
fn a_constant_cookie_is_a_factor_and_a_white_one_is_none() {
    let outer = 0.6;
    let medium = fog();
    let colour = Vec3::new(1.0, 0.25, 3.0);
    let constant = Texture::new(9, 5, vec![colour; 45]).unwrap();
    let plain = Lamp::new(spot(outer, None), &casters(outer));
    let coloured = Lamp::new(spot(outer, Some(constant)), &casters(outer));
    let eye = Vec3::new(4.0, -2.0, 1.0);
    let rays = rays(eye, outer, 12.0);
    for steps in [5, 50] {
        let light = [&plain, &coloured].map(|lamp| {
            let source = lamp.textured(steps, Placement::Angle);
            textured(&rays, (&lamp.light, &medium), &source)
        });
        for (plain, coloured) in light[0].iter().zip(&light[1]) {
            for c in 0..3 {
                let expected = colour[c] * plain[c];
                let off = (coloured[c] - expected).abs();
                assert!(
                    off <= 16.0 * f32::EPSILON * expected,
                    "{coloured:?} {plain:?}"
                );
            }
        }
    }
    // Without shadows it is the light of the plain spot.
    let white = MipCookie::new(&Texture::new(4, 4, vec![Vec3::ONE; 16]).unwrap());
    let source = Textured::new(
        Unshadowed,
        &plain.light,
        Some(Arc::new(white)),
        400,
        Placement::Angle,
    );
    let found = textured(&rays, (&plain.light, &medium), &source);
    let exact = Quadrature::with_tolerance(medium.phase(), 1e-5).unwrap();
    let lit = LitRays::new(&rays, &plain.light, &medium);
    let error = rmse(&found, &gathered(&lit, &Unshadowed, &exact));
    assert!(error < 2e-4, "{error}");
}

/// A light whose window dims it towards its range, and one with a hard rim.
#[test]
fn windows_and_hard_rims_are_shares_too() {
    let medium = fog();
    let cone = Cone {
        inner: 0.4999,
        outer: 0.5,
    };
    let down = Quat::from_rotation_x(-FRAC_PI_2);
    let emission = Emission::spot(down, cone, None).unwrap();
    let light = Emitter::point(Vec3::ZERO, Vec3::ONE, 6.0, emission).unwrap();
    let light = light.with_falloff(Falloff::Smooth);
    let rays = rays(Vec3::new(5.0, -2.0, 1.0), 0.5, 12.0);
    let exact = Quadrature::with_tolerance(medium.phase(), 1e-5).unwrap();
    let truth = gathered(&LitRays::new(&rays, &light, &medium), &Unshadowed, &exact);
    let source = Textured::new(Unshadowed, &light, None, 300, Placement::Angle);
    let error = rmse(&textured(&rays, (&light, &medium), &source), &truth);
    assert!(error < 1e-3, "{error}");
}

/// A view that turns in small steps over the border of the beam: surfaces of equal angle
/// and those of lengths go on there, and parts of each ray's own span do not.
#[test]
fn steps_of_neighbours_go_on_over_the_border_of_the_beam() {
    let light = spot(0.45, None);
    let medium = fog();
    let eye = Vec3::new(5.0, -2.0, 0.0);
    let turn = 1e-4;
    // Columns of a picture, from beside the beam into it.
    let ray = |column: u32| {
        let angle = turn * column as f32 - 0.4;
        let direction = Vec3::new(-angle.cos(), 0.1, angle.sin());
        Ray::new(eye, direction, 20.0).unwrap()
    };
    // The farthest that the end of a whole step is from the nearest one of the ray beside.
    let farthest = |placement| {
        let source: Textured<_, Host> = Textured::new(Unshadowed, &light, None, 12, placement);
        let ends = |column: u32| -> Vec<f32> {
            let ray = ray(column);
            let Some(path) = LightPath::new(&ray, &light, &medium) else {
                return Vec::new();
            };
            let bare = bare(&light);
            let path = LightPath::new(&ray, &bare, &medium)
                .unwrap()
                .within(path.span());
            let steps = source.steps.of_path(&path.unwrap(), path.unwrap().span());
            let span = path.unwrap().span();
            let mut marks = steps.behind(span.start);
            let marks = std::iter::from_fn(|| Some(marks.advance()));
            marks.take_while(|x| *x < span.end - 1e-4).collect()
        };
        let (mut farthest, mut compared) = (0.0_f32, 0);
        let mut before = ends(0);
        for column in 1..8000 {
            let here = ends(column);
            for x in &here {
                let distances = before.iter().map(|other| (x - other).abs());
                let nearest = distances.fold(f32::INFINITY, f32::min);
                // What begins or ends between the two rays has no neighbour.
                let inside = ray(column - 1);
                let cone = LightPath::new(&inside, &light, &medium).map(|path| path.span());
                let near = |span: Interval| span.start + 0.01 < *x && *x < span.end - 0.01;
                if cone.is_some_and(near) && before.len() > 1 {
                    farthest = farthest.max(nearest);
                    compared += 1;
                }
            }
            before = here;
        }
        assert!(compared > 3000, "{placement:?}: {compared}");
        farthest / turn
    };
    // Metres per radian: rays that turn by one are 5 m apart in the beam.
    let [angle, length, span] = [
        Placement::Angle,
        Placement::Length { reach: 9.0 },
        Placement::Span,
    ]
    .map(farthest);
    println!("angle {angle:.1}, length {length:.1}, span {span:.1} m/rad");
    assert!(angle < 12.0 && length < 12.0, "{angle} {length}");
    assert!(span > 3.0 * angle.max(length), "{span}");
}

#[test]
fn a_beam_has_as_many_steps_as_were_asked_for() {
    for outer in [0.02, 0.45, 1.4] {
        let light = spot(outer, None);
        let source = Textured::new(Unshadowed, &light, None, 20, Placement::Angle);
        let rays = rays(Vec3::new(4.0, -3.0, 1.0), outer, f32::INFINITY);
        let mut most = 0;
        let bare = bare(&light);
        let medium = fog();
        for ray in &rays {
            let Some(path) = LightPath::new(ray, &bare, &medium) else {
                continue;
            };
            let mut lit = Vec::new();
            source.lit_intervals(&path, &mut lit);
            let touch = |w: &[LitInterval<Vec3>]| w[0].interval.end <= w[1].interval.start;
            assert!(lit.windows(2).all(touch));
            most = most.max(lit.len());
        }
        // And one that begins before the beam, one that ends behind it, two of the rim.
        assert!((12..=24).contains(&most), "{outer}: {most}");
    }
}

/// Moved off the light as a gather does it, which must not make a turn of half a circle of
/// what has no angle.
#[test]
fn rays_through_the_light_are_a_step_before_it_and_one_behind_it() {
    let medium = fog();
    for outer in [1e-3, 0.02, 0.45, 1.4] {
        let light = spot(outer, None);
        let bare = bare(&light);
        let steps = 100;
        let source: Textured<_, Host> =
            Textured::new(Unshadowed, &light, None, steps, Placement::Angle);
        // Distances of the eye along the axis, and how far rays pass the light in parts of
        // them.
        for eye in [0.0, 1e-6, 0.3, 4.0, -0.3, -4.0] {
            for aside in [0.0, 1e-6, 0.5e-4, 0.99e-4, 1.01e-4, 3e-4] {
                for aim in [Vec3::Y, -Vec3::Y] {
                    let origin = eye * Vec3::Y + eye * aside * Vec3::X;
                    let ray = Ray::new(origin, aim, 7.0).unwrap();
                    let path = LightPath::new(&ray, &bare, &medium).unwrap();
                    let path = path.off_the_light();
                    let mut marks = source.steps.of_path(&path, path.span()).behind(0.0);
                    let marks: Vec<f32> = std::iter::from_fn(|| Some(marks.advance()))
                        .take_while(|x| *x < 7.0)
                        .collect();
                    if aside < 1e-4 {
                        let is_ahead = 0.0 < path.foot() && path.foot() < 7.0;
                        assert_eq!(marks.len(), usize::from(is_ahead), "{eye} {aside} {aim}");
                        assert!(marks.iter().all(|mark| *mark == path.foot()));
                    }
                    let mut lit = Vec::new();
                    source.lit_intervals(&path, &mut lit);
                    // Two more where the rim begins and ends.
                    let most = if aside < 1e-4 { 4 } else { steps as usize + 4 };
                    assert!(
                        lit.len() <= most,
                        "{outer} {eye} {aside} {aim}: {}",
                        lit.len()
                    );
                    // What looks along the axis from the light on is lit.
                    let is_lit = aside == 0.0 && aim == -Vec3::Y;
                    assert!(!is_lit || !lit.is_empty(), "{outer} {eye}");
                }
            }
        }
    }
}

#[test]
fn numbers_that_make_no_steps_count_as_the_nearest_that_do() {
    let light = spot(0.45, None);
    let steps = |count, placement| Steps::new(&light, count, placement);
    let angle = Placement::Angle;
    assert_eq!(steps(0, angle), steps(1, angle));
    assert_eq!(steps(u32::MAX, angle), steps(1 << 20, angle));
    assert_ne!(steps((1 << 20) - 1, angle), steps(1 << 20, angle));
    let length = |reach| steps(10, Placement::Length { reach });
    for none in [f32::NAN, -1.0, f32::NEG_INFINITY] {
        assert_eq!(length(none), length(0.0));
    }
    assert_eq!(length(f32::INFINITY), length(f32::MAX));
    let finer = |finer| {
        let source: Textured<_, Host> = Textured::new(Unshadowed, &light, None, 10, angle);
        source.with_finer_levels(finer).finer
    };
    assert_eq!(
        [f32::NAN, -2.0, 0.5, f32::INFINITY].map(finer),
        [1.0, 0.0, 0.5, 32.0]
    );
}

#[test]
fn rays_through_the_light_and_eyes_at_it_have_finite_light() {
    let medium = fog();
    let bounds = Bounds::new(Vec3::splat(-4.0), Vec3::splat(4.0)).unwrap();
    for outer in [0.01, 0.45, 1.48] {
        let lamp = Lamp::new(spot(outer, Some(window(8))), &casters(outer));
        for medium in [medium, medium.within(bounds)] {
            let mut rays = Vec::new();
            for eye in [
                Vec3::ZERO,
                Vec3::Y,
                -Vec3::Y,
                Vec3::new(0.0, -1.0, 1e-6),
                Vec3::X,
            ] {
                for aim in [
                    Vec3::Y,
                    -Vec3::Y,
                    Vec3::X,
                    -Vec3::X,
                    Vec3::new(1e-6, -1.0, 0.0),
                ] {
                    for length in [0.0, 1.0, 9.0, f32::INFINITY] {
                        rays.push(Ray::new(eye, aim, length).unwrap());
                    }
                }
            }
            for placement in [
                Placement::Angle,
                Placement::Length { reach: 1e-9 },
                Placement::Length { reach: 1e9 },
                Placement::Span,
            ] {
                for outside in [Outside::Dark, Outside::Lit] {
                    let source = lamp.textured(20, placement).with_outside(outside);
                    let light = textured(&rays, (&lamp.light, &medium), &source);
                    assert!(light.iter().any(|light| light[0] > 0.0));
                }
            }
        }
    }
}

/// Of a light all around with a map of a part of it: nothing is lost at the border.
#[test]
fn light_outside_of_the_cone_goes_on_without_a_border() {
    let medium = fog();
    let far = Geometry::new(&Scene::from(Mesh {
        positions: vec![50.0 * Vec3::Y, 51.0 * Vec3::Y, Vec3::new(1.0, 50.0, 0.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    }));
    let lamp = Lamp::new(spot(0.45, None), &far.unwrap());
    let rays = rays(Vec3::new(5.0, -2.0, 1.0), 1.2, 12.0);
    let exact = Quadrature::with_tolerance(medium.phase(), 1e-5).unwrap();
    let bare = lamp.light.bare();
    let truth = gathered(&LitRays::new(&rays, &bare, &medium), &Unshadowed, &exact);
    let source = lamp
        .textured(50, Placement::Angle)
        .with_outside(Outside::Lit);
    let error = rmse(&textured(&rays, (&lamp.light, &medium), &source), &truth);
    assert!(error < 1e-4, "{error}");
    // And in the cone there are shadows.
    let shaded = Lamp::new(spot(0.45, None), &casters(0.45));
    let source = shaded
        .textured(50, Placement::Angle)
        .with_outside(Outside::Lit);
    let rays = self::rays(Vec3::new(5.0, -2.0, 1.0), 0.45, 12.0);
    let truth = gathered(&LitRays::new(&rays, &bare, &medium), &Unshadowed, &exact);
    let found = textured(&rays, (&shaded.light, &medium), &source);
    let pairs = || found.iter().zip(&truth);
    assert!(pairs().all(|(f, t)| f[0] <= 1.001 * t[0]));
    assert!(pairs().any(|(f, t)| f[0] < 0.97 * t[0]));
}

#[test]
fn cookies_are_looked_up_by_the_length_of_a_step() {
    let texture = window(32);
    let cookie = MipCookie::new(&texture);
    assert_eq!((cookie.levels(), cookie.size()), (6, [32, 32]));
    assert_eq!(cookie.bytes(), 12 * (1024 + 256 + 64 + 16 + 4 + 1));
    for i in 0..100 {
        let uv = DVec2::new(1.2, 1.2) * DVec2::new(noise(2 * i).into(), noise(2 * i + 1).into());
        let plain = texture.clamp(uv.as_vec2());
        for texels in [0.0, 0.3, 1.0, f64::NAN] {
            let off = (cookie.sample(uv, texels) - plain).abs().max_element();
            assert!(off < 1e-4, "{uv} {texels}");
        }
        let half = texture.halved().clamp(uv.as_vec2());
        assert!((cookie.sample(uv, 2.0) - half).abs().max_element() < 1e-4);
        let between = plain.lerp(half, 0.5);
        let found = cookie.sample(uv, 2_f64.sqrt());
        assert!((found - between).abs().max_element() < 1e-4);
        for texels in [32.0, 1e9, f64::INFINITY] {
            let off = (cookie.sample(uv, texels) - texture.mean())
                .abs()
                .max_element();
            assert!(off < 1e-4, "{uv} {texels}");
        }
    }
    // No side is a power of two.
    let odd = Texture::new(5, 3, (0..15).map(|i| Vec3::splat(i as f32)).collect());
    assert_eq!(MipCookie::new(&odd.unwrap()).levels(), 4);
}

#[test]
fn a_blur_loses_no_light() {
    for (width, height) in [(64, 64), (37, 10), (1, 1), (3, 200)] {
        let texels = (0..width * height).map(|i| Vec3::splat(noise(u64::from(i)).powi(3)));
        let cookie = Texture::new(width, height, texels.collect()).unwrap();
        let variance = |image: &Texture| -> f32 {
            let mean = image.mean();
            let texels = image.texels().iter();
            texels.map(|t| (*t - mean).length_squared()).sum::<f32>() / image.texels().len() as f32
        };
        for blur in [0.0, 1e-3, 1.0 / 32.0, 0.3, 1.0] {
            let image = blurred(&cookie, blur).unwrap();
            let off = (image.mean() - cookie.mean()).abs().max_element();
            assert!(
                off <= 1e-5 * cookie.mean().x,
                "{width} x {height}, {blur}: {off}"
            );
            assert!(variance(&image) <= 1.0001 * variance(&cookie));
        }
        assert_eq!(blurred(&cookie, 0.0).unwrap().texels(), cookie.texels());
    }
    // However long a side is, few of its texels are as wide as the blur, and few are summed
    // for each.
    for (width, height) in [(1, 65536), (65536, 1), (3, 20000), (500, 2)] {
        let texels = (0..width * height).map(|i| Vec3::splat(noise(u64::from(i))));
        let cookie = Texture::new(width, height, texels.collect()).unwrap();
        for blur in [0.01, 1.0] {
            let image = blurred(&cookie, blur).unwrap();
            let sides = [image.width(), image.height()];
            assert!(
                sides.iter().all(|side| blur * *side as f32 <= 4.0),
                "{sides:?}"
            );
            // And no side has fewer than it needs.
            let halved = [width, height].into_iter().zip(sides);
            let mut halved = halved.filter(|(before, after)| before > after);
            assert!(
                halved.all(|(_, side)| blur * side as f32 >= 2.0),
                "{sides:?}"
            );
            let off = (image.mean() - cookie.mean()).abs().max_element();
            assert!(off <= 1e-5 * cookie.mean().x, "{width} x {height}: {off}");
        }
    }
    let wide = blurred(&window(64), 0.3).unwrap();
    assert!(wide.width() < 64);
    for bad in [-0.1, 1.1, f32::NAN] {
        assert!(blurred(&window(4), bad).is_err());
    }
}

/// And so the picture has as much light, and less contrast.
#[test]
fn a_blurred_light_is_as_bright() {
    let (outer, medium) = (0.45, fog());
    let light = spot(outer, Some(window(32)));
    let rays = rays(Vec3::new(5.0, -2.0, 1.0), outer, 12.0);
    let sums = [0.0, 1.0 / 32.0].map(|width| {
        let cookie = blurred(&window(32), width).unwrap();
        let cookie = Some(Arc::new(MipCookie::new(&cookie)));
        let source = Textured::new(Unshadowed, &light, cookie, 100, Placement::Angle);
        let found = textured(&rays, (&light, &medium), &source);
        found.iter().map(|light| f64::from(light[0])).sum::<f64>()
    });
    assert!((sums[1] / sums[0] - 1.0).abs() < 0.03, "{sums:?}");
}
