//! Media that are not uniform against uniform ones, sums by brute force, and each other.

use glam::{Quat, Vec3};
use gpu_backend::Cpu;

use super::{AddEmission, DoubleMarch, EmittingRays, GatherMedia, MediaRays, PartsAndPoints};
use crate::airlight::{AirlightEvaluator, Quadrature};
use crate::scene::{
    Bounds, Cone, DensityGrid, Emission, Emitter, HeightFog, Interpolation, Media, Medium,
    Particle, Particles, PhaseFunction, Profile, Translucent,
};
use crate::visibility::{LitInterval, PointVisibility, VisibilitySource};
use crate::{Interval, LightPath, Ray};

/// Nothing is in the way.
struct Clear;

impl PointVisibility for Clear {
    type Share = f32;

    fn visibility(&self, _: Vec3) -> f32 {
        1.0
    }
}

fn gathered<V>(
    rays: &[Ray],
    emitter: &Emitter,
    media: &Media<'_>,
    visibility: &V,
    steps: u32,
) -> Vec<Vec3>
where
    Cpu: GatherMedia<V>,
{
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let rays = rays.to_vec();
    let lit = MediaRays {
        rays: &rays,
        emitter,
        media,
        steps,
        panes: None,
        watch: &(),
    };
    Cpu::new()
        .gather_media(&lit, visibility, &mut radiance)
        .unwrap();
    radiance
        .iter()
        .map(|&[r, g, b, _]| Vec3::new(r, g, b))
        .collect()
}

/// Steps, and the largest error of any pixel beside the mean that they may have: of the
/// second order, with lights next to rays, in fog of up to ten mean free paths.
const ALLOWED: [(u32, f32); 3] = [(16, 0.5), (64, 0.13), (256, 0.045)];

pub(super) const HAZE: PhaseFunction = PhaseFunction::HenyeyGreenstein { g: 0.6 };

pub(super) fn box_of(half: f32) -> Bounds {
    Bounds::new(Vec3::splat(-half), Vec3::splat(half)).unwrap()
}

pub(super) fn lights() -> Vec<Emitter> {
    let point = |position, emission| {
        Emitter::point(position, Vec3::new(8.0, 9.0, 10.0), f32::INFINITY, emission)
    };
    let cone = Cone {
        inner: 0.3,
        outer: 0.5,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let spot = Emission::spot(down, cone, None).unwrap();
    vec![
        point(Vec3::new(0.3, 2.0, -0.2), Emission::Isotropic).unwrap(),
        point(Vec3::new(0.2, 0.4, 0.1), Emission::Isotropic).unwrap(),
        point(Vec3::new(0.0, 2.5, 0.0), spot).unwrap(),
        Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::new(3.0, 2.0, 1.0)).unwrap(),
    ]
}

pub(super) fn rays() -> Vec<Ray> {
    let eye = Vec3::new(0.5, 0.3, 4.0);
    let mut rays: Vec<Ray> = (0..64)
        .map(|i| {
            let target = Vec3::new((i % 8) as f32 / 4.0 - 0.87, (i / 8) as f32 / 4.0 - 0.9, 0.1);
            Ray::new(
                eye,
                target - eye,
                if i % 3 == 0 { f32::INFINITY } else { 4.5 },
            )
            .unwrap()
        })
        .collect();
    // From inside, and to the sky.
    rays.push(
        Ray::new(
            Vec3::new(0.1, -0.2, 0.3),
            Vec3::new(0.2, 1.0, -0.4),
            f32::INFINITY,
        )
        .unwrap(),
    );
    rays
}

/// The light that an evaluator of even media finds.
fn even(rays: &[Ray], emitter: &Emitter, medium: &Medium) -> Vec<Vec3> {
    let quadrature = Quadrature::with_tolerance(medium.phase(), 1e-5).unwrap();
    let light = |ray: &Ray| {
        LightPath::new(ray, emitter, medium).map_or(Vec3::ZERO, |path| {
            let path = path.off_the_light();
            quadrature.radiance(&path, path.span())
        })
    };
    rays.iter().map(light).collect()
}

fn worst(found: &[Vec3], truth: &[Vec3]) -> f32 {
    let mean = truth.iter().map(|v| v.max_element()).sum::<f32>() / truth.len() as f32;
    let errors = found
        .iter()
        .zip(truth)
        .map(|(a, b)| (*a - *b).abs().max_element());
    errors.fold(0.0, f32::max) / mean
}

#[test]
fn even_fog_is_what_its_evaluators_say() {
    for (sigma, phase) in [
        (0.02_f32, HAZE),
        (0.5, HAZE),
        (8.0, HAZE),
        (0.02, PhaseFunction::Isotropic),
        (0.5, PhaseFunction::HenyeyGreenstein { g: -0.14 }),
        (8.0, PhaseFunction::Rayleigh),
    ] {
        let open = Medium::new(
            Vec3::new(sigma, 0.5 * sigma, 0.2 * sigma),
            Vec3::splat(0.1 * sigma),
            phase,
        )
        .unwrap();
        for medium in [open, open.within(box_of(1.0))] {
            let media = Media::new(Some(&medium), None, &[]);
            for (index, emitter) in lights().iter().enumerate() {
                let truth = even(&rays(), emitter, &medium);
                for (steps, allowed) in [(16, 0.03), (64, 0.015), (256, 0.01)] {
                    let found = gathered(&rays(), emitter, &media, &Clear, steps);
                    let error = worst(&found, &truth);
                    assert!(
                        error < allowed,
                        "{phase:?} {sigma} {index} {steps}: {error:.1e}"
                    );
                }
            }
        }
    }
}

/// A smooth but uneven grid, random numbers but for that.
pub(super) fn smoke(scale: f32, interpolation: Interpolation) -> DensityGrid {
    let resolution = [5, 4, 6];
    let count = resolution.iter().product::<u32>();
    let density = (0..count)
        .map(|i| reference::random::noise(u64::from(i)))
        .collect();
    DensityGrid::new(box_of(0.9), resolution, density, scale, interpolation)
        .unwrap()
        .with_albedo(Vec3::new(0.9, 0.8, 0.6))
        .unwrap()
        .with_phase(HAZE)
        .unwrap()
}

/// The exact optical depth on the way to a light.
struct Through<'a>(&'a Media<'a>, &'a Emitter);

impl PointVisibility for Through<'_> {
    type Share = Vec3;

    fn visibility(&self, point: Vec3) -> Vec3 {
        // Fog in closed form is the gather's.
        let (direction, distance) = match self.1 {
            Emitter::Directional(sun) => (-sun.direction(), f32::INFINITY),
            Emitter::Point(lamp) => {
                let way = lamp.position() - point;
                (way.normalize(), way.length())
            }
        };
        let (origin, direction) = (point.as_dvec3(), direction.as_dvec3().normalize());
        (-self
            .0
            .optical_depth(origin, direction, 0.0, distance.into()))
        .exp()
        .as_vec3()
    }
}

#[test]
fn a_grid_of_one_density_is_a_box_of_fog() {
    let medium = Medium::new(Vec3::new(0.9, 0.8, 0.6), Vec3::new(0.1, 0.2, 0.4), HAZE)
        .unwrap()
        .within(box_of(1.0));
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for resolution in [[1, 1, 1], [3, 4, 5]] {
            let count = resolution.iter().product::<u32>() as usize;
            let grid = DensityGrid::new(
                box_of(1.0),
                resolution,
                vec![0.5; count],
                2.0,
                interpolation,
            )
            .unwrap()
            .with_albedo(Vec3::new(0.9, 0.8, 0.6))
            .unwrap()
            .with_phase(HAZE)
            .unwrap();
            let casters = [Translucent::Grid(grid)];
            let media = Media::new(None, None, &casters);
            for emitter in &lights() {
                let truth = even(&rays(), emitter, &medium);
                let through = Through(&media, emitter);
                for (steps, allowed) in ALLOWED {
                    let found = gathered(&rays(), emitter, &media, &through, steps);
                    let error = worst(&found, &truth);
                    assert!(error < allowed, "{interpolation:?} {steps}: {error:.1e}");
                }
            }
        }
    }
}

#[test]
fn marches_of_many_steps_come_to_the_same() {
    let fog = Medium::new(
        Vec3::splat(0.05),
        Vec3::splat(0.01),
        PhaseFunction::Isotropic,
    )
    .unwrap();
    let mist = HeightFog::new(Vec3::splat(0.2), Vec3::ZERO, -0.5, 0.4, HAZE).unwrap();
    let puffs = vec![
        Particle {
            centre: Vec3::new(0.4, 0.3, 0.2),
            radius: 0.4,
            sigma_t: 3.0,
        },
        Particle {
            centre: Vec3::new(-0.5, -0.2, 0.4),
            radius: 0.5,
            sigma_t: 1.0,
        },
    ];
    let rays: Vec<Ray> = rays()
        .into_iter()
        .filter(|ray| ray.length().is_finite())
        .collect();
    for scale in [0.3, 3.0] {
        let casters = [
            Translucent::Grid(smoke(scale, Interpolation::Linear)),
            Translucent::Particles(Particles::new(puffs.clone(), Profile::Soft).unwrap()),
        ];
        let media = Media::new(Some(&fog), Some(&mist), &casters);
        let smoke = Media::new(None, None, &casters);
        for (index, emitter) in lights().iter().enumerate() {
            let march = DoubleMarch::new(emitter, &media, &casters, Clear, [1000, 200]);
            let truth: Vec<Vec3> = rays.iter().map(|ray| march.radiance(ray)).collect();
            let through = Through(&smoke, emitter);
            for (steps, allowed) in ALLOWED {
                let found = gathered(&rays, emitter, &media, &through, steps);
                let error = worst(&found, &truth);
                assert!(error < allowed, "{scale} {index} {steps}: {error:.1e}");
            }
        }
    }
}

/// Rays to the sky where a colour is not extinguished at all or hardly, and where fog begins
/// far below the eye: they end, with the light that there is.
#[test]
fn endless_rays_end() {
    let up = Ray::new(Vec3::ZERO, Vec3::new(0.3, 0.9, -0.2), f32::INFINITY).unwrap();
    let level = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap();
    let casters = [Translucent::Grid(smoke(1.0, Interpolation::Linear))];
    for sigma in [
        Vec3::new(0.05, 0.0, 0.0),
        Vec3::new(0.05, 1e-6, 1e-9),
        Vec3::new(0.05, 1e-9, 1e-15),
    ] {
        let fog = Medium::new(sigma, Vec3::ZERO, HAZE).unwrap();
        for emitter in &lights() {
            let of_fog = Media::new(Some(&fog), None, &[]);
            let truth = even(&[up, level], emitter, &fog);
            let found = gathered(&[up, level], emitter, &of_fog, &Clear, 64);
            for (found, truth) in found.iter().zip(&truth) {
                // The last colours are seen up to where 1e-7 of all light is left.
                assert!((found.x / truth.x - 1.0).abs() < 0.02, "{found} {truth}");
            }
            let media = Media::new(Some(&fog), None, &casters);
            let light = gathered(&[up, level], emitter, &media, &Clear, 64);
            assert!(light.iter().all(|light| light.is_finite()));
        }
    }
    let sun = Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap();
    for scale in [1e-3, 1.0, 100.0] {
        let fog = HeightFog::new(Vec3::splat(0.1), Vec3::ZERO, 0.0, scale, HAZE).unwrap();
        let media = Media::new(None, Some(&fog), &[]);
        let ray = |height: f32, slope: f32| {
            let direction = Vec3::new(1.0, slope, 0.0);
            Ray::new(Vec3::new(0.0, height, 0.0), direction, f32::INFINITY).unwrap()
        };
        let through = |height, slope| gathered(&[ray(height, slope)], &sun, &media, &Clear, 64)[0];
        let marched = DoubleMarch::new(&sun, &media, &[], Clear, [64, 16]);
        for (height, slope) in [
            (1e6, -1.0),
            (1e4, -0.1),
            (0.0, 1.0),
            (5.0, 0.0),
            (-3.0, 0.2),
            (5.0, -0.2),
            (5.0, -1e-3),
        ] {
            for light in [
                through(height, slope),
                marched.radiance(&ray(height, slope)),
            ] {
                assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
            }
        }
        // Fog so dense at the eye that a part of it is shorter than floats beside a metre.
        for (altitude, sigma) in [(40.0 * scale, 0.02), (80.0 * scale, 0.02), (0.0, 1e15)] {
            let fog = HeightFog::new(Vec3::splat(sigma), Vec3::ZERO, altitude, scale, HAZE);
            let fog = fog.unwrap();
            let media = Media::new(None, Some(&fog), &[]);
            for emitter in lights().iter().chain([&sun]) {
                for slope in [-0.3, 0.0, 0.3] {
                    let light = gathered(&[ray(0.0, slope)], emitter, &media, &Clear, 64)[0];
                    assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
                }
            }
        }
        // Seen from far above the fog is as bright as from near.
        let (far, near) = (through(1e5, -1.0).x, through(30.0 * scale, -1.0).x);
        assert!((far / near - 1.0).abs() < 0.05, "{scale}: {far} {near}");
    }
}

/// Densities beyond all measure, an eye and a lamp inside, a single voxel: numbers all the
/// same, and no more light than there is.
#[test]
fn extremes_stay_finite() {
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for scale in [0.0, 1e-12, 1.0, 1e6, 1e12] {
            let one = DensityGrid::new(box_of(1.0), [1, 1, 1], vec![1.0], scale, interpolation);
            for grid in [one.unwrap(), smoke(scale, interpolation)] {
                let casters = [Translucent::Grid(grid)];
                let media = Media::new(None, None, &casters);
                for emitter in &lights() {
                    let through = Through(&media, emitter);
                    for steps in [1, 16] {
                        for light in gathered(&rays(), emitter, &media, &through, steps) {
                            assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
                            assert!(scale > 0.0 || light == Vec3::ZERO);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_the_eye_sees_through_media_is_their_optical_depth() {
    let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let grid = DensityGrid::new(
        box_of(1.0),
        [1, 1, 1],
        vec![2.0],
        0.5,
        Interpolation::Constant,
    );
    let casters = [Translucent::Grid(grid.unwrap())];
    let media = Media::new(Some(&fog), None, &casters);
    let ray = Ray::new(Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z, f32::INFINITY).unwrap();
    let share = |distance| media.transmittance(&ray, distance).x;
    assert!((share(2.0) - (-0.2_f32).exp()).abs() < 1e-6);
    assert!((share(6.0) - (-0.6_f32 - 2.0).exp()).abs() < 1e-6);
    assert_eq!(share(f32::INFINITY), 0.0);
}

/// Smoke that glows, unevenly.
pub(super) fn glowing(scale: f32, interpolation: Interpolation) -> DensityGrid {
    let glow = |i: u32| Vec3::new(2.0, 1.0, 0.3) * reference::random::noise(u64::from(i + 999));
    smoke(scale, interpolation)
        .with_emission((0..120).map(glow).collect())
        .unwrap()
}

fn emitted(rays: &[Ray], media: &Media<'_>) -> Vec<Vec3> {
    let rays = rays.to_vec();
    let mut radiance = vec![[0.0; 4]; rays.len()];
    let seen = EmittingRays {
        rays: &rays,
        media,
        panes: None,
    };
    Cpu::new().add_emission(&seen, &mut radiance).unwrap();
    radiance
        .iter()
        .map(|&[r, g, b, _]| Vec3::new(r, g, b))
        .collect()
}

/// Brighter, or darker, than that by a few roundings at most.
fn assert_close(found: Vec3, truth: Vec3, relative: f32) {
    let error = (found - truth).abs().max_element();
    assert!(
        error <= relative * truth.max_element() + 1e-30,
        "{found} {truth}"
    );
}

#[test]
fn an_even_glow_has_its_closed_form() {
    let glow = Vec3::new(3.0, 2.0, 1.0);
    let through = Ray::new(Vec3::new(0.1, 0.2, 4.0), Vec3::NEG_Z, 9.0).unwrap();
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for scale in [0.0, 1e-9, 0.3, 20.0, 1e6, 1e12] {
            let tint = Vec3::new(1.0, 0.5, 0.0);
            let bounds = box_of(1.0);
            let grid = DensityGrid::new(bounds, [2, 3, 4], vec![1.0; 24], scale, interpolation)
                .and_then(|grid| grid.with_tint(tint))
                .and_then(|grid| grid.with_emission(vec![glow; 24]));
            let casters = [Translucent::Grid(grid.unwrap())];
            let found = emitted(&[through], &Media::new(None, None, &casters))[0];
            let truth = (scale * tint).as_dvec3().map(|sigma| match sigma {
                0.0 => 2.0,
                sigma => -(-2.0 * sigma).exp_m1() / sigma,
            });
            assert_close(found, glow * truth.as_vec3(), 1e-6);
        }
    }
}

#[test]
fn what_a_split_ray_sees_glow_adds_up() {
    let fog = Medium::new(Vec3::splat(0.05), Vec3::ZERO, HAZE).unwrap();
    let mist = HeightFog::new(Vec3::splat(0.3), Vec3::ZERO, 0.0, 0.05, HAZE).unwrap();
    for interpolation in [Interpolation::Constant, Interpolation::Linear] {
        for scale in [0.0, 1.0, 1e3] {
            let casters = [
                Translucent::Grid(glowing(scale, interpolation)),
                Translucent::Grid(smoke(0.5, Interpolation::Linear)),
            ];
            let media = Media::new(Some(&fog), Some(&mist), &casters);
            for ray in rays() {
                let ray = ray.with_length(ray.length().min(9.0));
                let whole = emitted(&[ray], &media)[0];
                let cut = 3.9;
                let rest = Ray::new(ray.at(cut), ray.direction(), ray.length() - cut).unwrap();
                let [near, far] =
                    [ray.with_length(cut), rest].map(|ray| emitted(&[ray], &media)[0]);
                let sum = near + media.transmittance(&ray, cut) * far;
                // The second part begins at a point that was rounded.
                assert_close(sum, whole, 1e-4);
            }
        }
    }
}

#[test]
fn smoke_that_does_not_glow_changes_no_bit() {
    let dark = smoke(1.0, Interpolation::Linear).with_emission(vec![Vec3::ZERO; 120]);
    for grid in [dark.unwrap(), smoke(1.0, Interpolation::Linear)] {
        let casters = [Translucent::Grid(grid)];
        let media = Media::new(None, None, &casters);
        let before: Vec<[f32; 4]> = (0..rays().len()).map(|i| [1e-3 * i as f32; 4]).collect();
        let mut after = before.clone();
        let seen = EmittingRays {
            rays: &rays(),
            media: &media,
            panes: None,
        };
        Cpu::new().add_emission(&seen, &mut after).unwrap();
        assert_eq!(before, after);
    }
}

/// These parts of every ray are lit, the last first in the order of rays.
struct Parts<'a>(&'a [(f32, f32)]);

impl VisibilitySource for Parts<'_> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let span = path.span();
        lit.extend(self.0.iter().filter_map(|&(start, end)| {
            let interval = Interval::new(start.max(span.start), end.min(span.end));
            (interval.start < interval.end).then_some(LitInterval {
                interval,
                visibility: 1.0,
            })
        }));
    }

    fn neighbours(&self, rays: &[Ray], _: &Emitter) -> Option<Vec<u32>> {
        Some((0..rays.len() as u32).rev().collect())
    }
}

/// What is lit of a ray is all of it up to the end of the lit part less all up to its start.
#[test]
fn lit_parts_of_a_ray_are_what_they_are_by_themselves() {
    let casters = [Translucent::Grid(smoke(0.7, Interpolation::Linear))];
    let fog = Medium::new(Vec3::splat(0.05), Vec3::ZERO, HAZE).unwrap();
    let media = Media::new(Some(&fog), None, &casters);
    let rays = rays();
    let forever = f32::INFINITY;
    for emitter in &lights() {
        let lit = |rays: &[Ray], parts: &[(f32, f32)], steps| {
            let visibility = PartsAndPoints {
                parts: Parts(parts),
                points: Clear,
            };
            gathered(rays, emitter, &media, &visibility, steps)
        };
        let all = gathered(&rays, emitter, &media, &Clear, 16);
        assert_eq!(lit(&rays, &[(0.0, forever)], 16), all);
        // Parts that touch are one.
        assert_eq!(lit(&rays, &[(0.0, 3.9), (3.9, forever)], 16), all);
        let none = vec![Vec3::ZERO; rays.len()];
        assert_eq!(lit(&rays, &[], 16), none);
        let up_to = |end: f32| {
            let cut: Vec<Ray> = rays
                .iter()
                .map(|ray| ray.with_length(ray.length().min(end)))
                .collect();
            gathered(&cut, emitter, &media, &Clear, 256)
        };
        let ends = [3.3, 3.7, 4.1, 4.3].map(up_to);
        let found = lit(&rays, &[(3.3, 3.7), (4.1, 4.3)], 256);
        for (i, (found, all)) in found.iter().zip(&all).enumerate() {
            let expected = ends[1][i] - ends[0][i] + ends[3][i] - ends[2][i];
            let error = (*found - expected).abs().max_element();
            assert!(error < 0.03 * all.max_element(), "{i}: {found} {expected}");
        }
    }
}

/// What is behind a pane is dimmed by it, and nothing else.
#[cfg(feature = "trace")]
#[test]
fn panes_before_smoke_dim_and_tint_it() {
    use crate::EyePanes;
    use crate::scene::trace::Tracer;
    use crate::scene::{AlphaMode, Geometry, Instance, Material, Mesh, Scene};

    let casters = [Translucent::Grid(glowing(0.7, Interpolation::Linear))];
    let fog = Medium::new(Vec3::splat(0.05), Vec3::ZERO, HAZE).unwrap();
    let media = Media::new(Some(&fog), None, &casters);
    let rays: Vec<Ray> = rays().into_iter().take(64).collect();
    // Before, within and behind the smoke.
    for z in [2.0, 0.2, -2.0] {
        let (low, high) = (Vec3::new(-9.0, -9.0, z), Vec3::new(9.0, 9.0, z));
        let corners = [low, Vec3::new(9.0, -9.0, z), high, Vec3::new(-9.0, 9.0, z)];
        let scene = Scene {
            materials: vec![Material {
                base_color: Vec3::new(0.9, 0.5, 0.3),
                transmission: 0.8,
                alpha: AlphaMode::Opaque,
                ..Material::default()
            }],
            meshes: vec![Mesh {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material: Some(0),
                ..Mesh::default()
            }],
            instances: vec![Instance::default()],
            ..Scene::default()
        };
        let geometry = Geometry::new(&scene).unwrap();
        let panes = EyePanes::new(&Cpu::new(), &Tracer::new(&geometry), &rays).unwrap();
        for emitter in &lights() {
            let seen = |rays: &[Ray], panes: Option<&EyePanes>| {
                let rays = rays.to_vec();
                let mut radiance = vec![[0.0; 4]; rays.len()];
                let lit = MediaRays {
                    rays: &rays,
                    emitter,
                    media: &media,
                    steps: 256,
                    panes,
                    watch: &(),
                };
                let glow = EmittingRays {
                    rays: &rays,
                    media: &media,
                    panes,
                };
                let cpu = Cpu::new();
                cpu.gather_media(&lit, &Clear, &mut radiance).unwrap();
                cpu.add_emission(&glow, &mut radiance).unwrap();
                radiance
            };
            let (with, without) = (seen(&rays, Some(&panes)), seen(&rays, None));
            for (i, ray) in rays.iter().enumerate() {
                let (before, share) = match panes.of(i as u32) {
                    [] => (ray.length(), Vec3::ONE),
                    [pane, ..] => (pane.from, pane.share),
                };
                assert!(share != Vec3::ONE || z < 0.0);
                let near = seen(&[ray.with_length(before.min(ray.length()))], None)[0];
                for channel in 0..3 {
                    let (all, near) = (without[i][channel], near[channel]);
                    let expected = near + share[channel] * (all - near);
                    let error = (with[i][channel] - expected).abs();
                    assert!(error < 0.02 * all, "{z} {i}: {error} of {all}");
                }
            }
        }
    }
}
