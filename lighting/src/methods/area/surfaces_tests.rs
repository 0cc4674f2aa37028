//! Surfaces against shadow rays, and many lights against one at a time.

use glam::Vec3;
use gpu_backend::{Cpu, Host};

use super::tests::{eye, fog, geometry, lights, panel};
use super::*;
use crate::scene::trace::Tracer;
use crate::scene::{Geometry, Mesh, Pattern, Scene};
use crate::shadow_map::{Casters, RenderShadowMapAtlas};
use crate::visibility::SurfaceShadow;
use crate::voxelized::Resolution;
use crate::{Emitter, SurfacePoint};

const LOOKUPS: [SurfaceLookup; 2] = [SurfaceLookup::Nearest, SurfaceLookup::Interpolated];

/// Points of the floor, and one that reflects nothing.
pub(super) fn floor() -> Vec<SurfacePoint> {
    let point = |i: i32| {
        let at = Vec3::new(
            0.25 * (i % 16) as f32 - 2.0,
            1e-4,
            -4.0 - 0.25 * (i / 16) as f32,
        );
        SurfacePoint::new(at, Vec3::Y, Vec3::new(0.3, 0.2, 0.1)).unwrap()
    };
    let mut points: Vec<_> = (0..256).map(point).collect();
    points.push(SurfacePoint::default());
    points
}

fn voxels(emitters: &[Emitter], casters: &Geometry, side: u32) -> LightVolumes<Host> {
    let cpu = Cpu::new();
    let resolution = Resolution::new(side, side, side).unwrap();
    let casters = Casters::upload(&cpu, casters).unwrap();
    let maps = cpu.shadow_map_atlas(&casters, emitters, side).unwrap();
    let mut volumes = LightVolumes::new(&cpu, resolution, emitters.len()).unwrap();
    volumes.update(&cpu, emitters, &eye(&fog()), &maps).unwrap();
    volumes
}

fn lit(
    emitters: &[Emitter],
    volumes: &LightVolumes<Host>,
    lookup: SurfaceLookup,
    radiance: &mut Vec<[f32; 4]>,
) {
    let (points, medium) = (floor(), fog());
    let lit = ManyOnSurfaces {
        points: &points,
        emitters,
        medium: &medium,
        lookup,
    };
    Cpu::with_threads(2)
        .unwrap()
        .light_many_surfaces(&lit, volumes, radiance)
        .unwrap();
}

fn start() -> Vec<[f32; 4]> {
    vec![[0.5, 0.25, 0.125, 7.0]; floor().len()]
}

#[test]
fn all_lights_together_are_one_after_the_other_bit_for_bit() {
    let lights = lights();
    for lookup in LOOKUPS {
        let mut together = start();
        lit(
            &lights,
            &voxels(&lights, &geometry(), 64),
            lookup,
            &mut together,
        );
        let mut separate = start();
        for light in &lights {
            let one = std::slice::from_ref(light);
            lit(one, &voxels(one, &geometry(), 64), lookup, &mut separate);
        }
        assert_eq!(together, separate);
        assert!(together.iter().all(|pixel| pixel[3] == 7.0));
        assert_eq!(together[256], start()[256], "it reflects nothing");
        assert!(together[0] != start()[0]);
    }
}

/// Against the equation, in f64.
#[test]
fn a_surface_in_full_light_has_no_shadow() {
    let far = Vec3::new(0.0, -90.0, -50.0);
    let nothing = Geometry::new(&Scene::from(Mesh {
        positions: vec![far, far + Vec3::X, far + Vec3::Z],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    }))
    .unwrap();
    let lights = panel().virtual_lights(Pattern::Lattice, 9).unwrap();
    let volumes = voxels(&lights, &nothing, 64);
    let sigma_t = fog().sigma_t().as_dvec3();
    for lookup in LOOKUPS {
        let mut found = vec![[0.0; 4]; floor().len()];
        lit(&lights, &volumes, lookup, &mut found);
        for (point, found) in floor().iter().zip(&found) {
            let mut expected = glam::DVec3::ZERO;
            for light in &lights {
                let Emitter::Point(lamp) = light else {
                    panic!("a panel is points")
                };
                let way = (lamp.position() - point.position()).as_dvec3();
                let d = way.length();
                // The panel shines down, onto a floor.
                let cos = way.y / d;
                expected +=
                    lamp.intensity().as_dvec3() * (cos * cos / (d * d)) * (-sigma_t * d).exp();
            }
            expected *= point.response().as_dvec3();
            for channel in 0..3 {
                let off = f64::from(found[channel]) - expected[channel];
                assert!(
                    off.abs() <= 1e-5 * expected[channel],
                    "{found:?} {expected}"
                );
            }
        }
    }
}

/// The bits around a point, found by way of its coordinates.
#[test]
fn nearest_is_the_voxel_of_the_point_and_interpolated_the_four_around() {
    let lights = panel().virtual_lights(Pattern::Lattice, 4).unwrap();
    let volumes = voxels(&lights, &geometry(), 64);
    let resolution = volumes.resolution();
    let biases = SurfaceLookup::Nearest.sampling();
    let mut seen = [0; 3];
    for (tile, (light, lattice)) in volumes.with_voxels().enumerate() {
        let words = &volumes.grid().words()[tile * resolution.words()..][..resolution.words()];
        let lit = |alpha: u32, theta: i32, bit: i32| {
            let turn = resolution.theta() as i32;
            let theta = match lattice.ranges().wraps() {
                true => theta.rem_euclid(turn),
                false => theta.clamp(0, turn - 1),
            };
            let bit = bit.clamp(0, resolution.bits() as i32 - 1) as usize;
            let texel = alpha as usize * resolution.theta() as usize + theta as usize;
            let word = words[texel * resolution.words_per_texel() + bit / 32];
            f32::from(u8::from(word >> (bit % 32) & 1 == 0))
        };
        for point in &floor()[..256] {
            let place = lattice.space().coordinates(point.position());
            let alpha = lattice.alpha_position(place.ray.alpha) + biases.alpha_bias;
            let alpha = alpha.clamp(0.0, (resolution.alpha() - 1) as f32) as u32;
            let theta = lattice.theta_position(place.ray.theta);
            let phi = lattice.phi_position(place.phi) + biases.phi_bias;
            let visibility = |lookup| {
                let shadow = volumes.on_surfaces(light, lookup);
                shadow.visibility(point.position(), Vec3::Y).x
            };
            let nearest = lit(alpha, theta.floor() as i32, phi.max(0.0) as i32);
            assert_eq!(visibility(SurfaceLookup::Nearest), nearest);
            let [t, p] = [theta - 0.5, phi - 0.5].map(|at| (at.floor() as i32, at - at.floor()));
            let along = |bit: i32| {
                let [a, b] = [0, 1].map(|k| lit(alpha, t.0 + k, bit));
                a + t.1 * (b - a)
            };
            let [a, b] = [along(p.0), along(p.0 + 1)];
            let expected = a + p.1 * (b - a);
            let found = visibility(SurfaceLookup::Interpolated);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
            seen[if found == 0.0 {
                0
            } else if found == 1.0 {
                1
            } else {
                2
            }] += 1;
        }
    }
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
}

/// The light of a panel with shadow rays towards points of it.
fn traced(lights: &[Emitter]) -> Vec<Vec3> {
    let geometry = geometry();
    let (tracer, medium) = (Tracer::new(&geometry), fog());
    let of_point = |point: &SurfacePoint| {
        let at = point.position();
        lights.iter().fold(Vec3::ZERO, |sum, light| {
            let Some(light) = crate::surface_point::Arriving::at(at, light) else {
                return sum;
            };
            let share = tracer.transmittance(at, light.to_light, 0.0, light.distance);
            let through = light.through(Some(&medium), at);
            sum + light.irradiance * light.to_light.y.max(0.0) * through * share
        }) * point.response()
    };
    floor()[..256].iter().map(of_point).collect()
}

#[test]
fn more_lights_and_finer_grids_converge_to_the_shadow_of_the_area() {
    let of = |count| panel().virtual_lights(Pattern::Lattice, count).unwrap();
    let truth = traced(&of(2048));
    let mean = truth.iter().map(|light| light.y).sum::<f32>() / truth.len() as f32;
    for lookup in LOOKUPS {
        let errors = [(4, 32), (16, 64), (64, 128), (256, 256)].map(|(count, side)| {
            let lights = of(count);
            let mut found = vec![[0.0; 4]; floor().len()];
            lit(
                &lights,
                &voxels(&lights, &geometry(), side),
                lookup,
                &mut found,
            );
            let squares = found.iter().zip(&truth).map(|(a, b)| (a[1] - b.y).powi(2));
            (squares.sum::<f32>() / truth.len() as f32).sqrt() / mean
        });
        println!("{lookup:?}: {errors:?}");
        assert!(
            errors.windows(2).all(|pair| pair[1] < 0.75 * pair[0]),
            "{errors:?}"
        );
        // Borders of shadows are a fixed number of voxels from where they should be, and
        // these become eight times narrower; maps and lights have a share of their own.
        assert!(6.0 * errors[3] < errors[0], "{errors:?}");
    }
}

#[test]
fn other_numbers_of_points_or_lights_are_refused() {
    let lights = lights();
    let volumes = voxels(&lights, &geometry(), 32);
    let (points, medium, cpu) = (floor(), fog(), Cpu::new());
    for (emitters, length) in [(&lights[1..], points.len()), (&lights[..], 3)] {
        let lit = ManyOnSurfaces {
            points: &points,
            emitters,
            medium: &medium,
            lookup: SurfaceLookup::Nearest,
        };
        let mut radiance = vec![[1.0; 4]; length];
        assert!(
            cpu.light_many_surfaces(&lit, &volumes, &mut radiance)
                .is_err()
        );
        assert!(radiance.iter().all(|pixel| *pixel == [1.0; 4]));
    }
}

/// Points of the floor that the eye sees, far from the edge of a shadow.
#[test]
fn surfaces_have_the_shadows_of_the_same_voxels() {
    let lights = panel().virtual_lights(Pattern::Lattice, 5).unwrap();
    let medium = fog();
    let cpu = Cpu::new();
    let casters = Casters::upload(&cpu, &geometry()).unwrap();
    let fine = Resolution::new(512, 512, 512).unwrap();
    let mut volumes = LightVolumes::new(&cpu, fine, lights.len()).unwrap();
    let maps = cpu.shadow_map_atlas(&casters, &lights, 512).unwrap();
    volumes.update(&cpu, &lights, &eye(&medium), &maps).unwrap();
    let triangles = geometry();
    let tracer = crate::scene::trace::Tracer::new(&triangles);
    let mut counts = [0; 2];
    for (index, light) in lights.iter().enumerate() {
        let Emitter::Point(point) = light else {
            panic!("a panel is points");
        };
        let voxels = volumes.on_surfaces(index, SurfaceLookup::default());
        for i in 0..400 {
            let at = Vec3::new(
                0.2 * (i % 20) as f32 - 2.0,
                1e-4,
                -4.0 - 0.2 * (i / 20) as f32,
            );
            let lit = |offset: Vec3| {
                let from = at + offset;
                let to = point.position() - from;
                let way = to.length();
                tracer.transmittance(from, to / way, 0.0, way) == Vec3::ONE
            };
            let around = [Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z].map(|side| lit(0.12 * side));
            if around.iter().any(|other| *other != lit(Vec3::ZERO)) {
                continue;
            }
            let expected = f32::from(u8::from(lit(Vec3::ZERO)));
            let found = voxels.visibility(at, Vec3::Y).x;
            counts[usize::from((found - expected).abs() > 0.1)] += 1;
        }
    }
    let [right, wrong] = counts;
    assert!(right > 800 && wrong * 100 < right, "{counts:?}");
    let nowhere = volumes.on_surfaces(99, SurfaceLookup::Nearest);
    assert_eq!(nowhere.visibility(Vec3::ZERO, Vec3::Y), Vec3::ONE);
}

/// Air so thin that it takes nothing away, everywhere and in a box that no surface is in.
#[cfg(feature = "methods")]
#[test]
fn shadows_on_surfaces_do_not_depend_on_where_the_fog_is() {
    use super::tests::{SIZE, camera};
    use crate::Ray;
    use crate::methods::{Frame, FrameInputs, Registry, RunOn, Selection, Store};
    use crate::scene::{Bounds, Medium, PhaseFunction};

    let thin = Medium::new(Vec3::splat(1e-7), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let far = Bounds::new(Vec3::new(90.0, 90.0, 90.0), Vec3::new(91.0, 91.0, 91.0)).unwrap();
    let cpu = Cpu::new();
    let (lights, geometry, points) = (lights(), geometry(), floor()[..256].to_vec());
    let eye = camera().eye();
    let to_point = |point: &SurfacePoint| {
        let way = point.position() - eye;
        Ray::new(eye, way, way.length()).unwrap()
    };
    let rays: Vec<Ray> = points.iter().map(to_point).collect();
    let hits = vec![None; rays.len()];
    let found = [thin, thin.within(far)].map(|medium| {
        let (host, store) = (Store::new(), Store::<Host>::new());
        let inputs = FrameInputs {
            emitters: &lights,
            areas: &[],
            medium: &medium,
            height_fog: None,
            geometry: &geometry,
            translucent: &[],
            camera: &camera(),
            size: SIZE,
            rays: &rays,
            hits: &hits,
            map: 64,
            host: &host,
            selection: Selection::default(),
            watch: &(),
        };
        let registry = Registry::standard();
        let method = registry.find("area-runs").unwrap();
        let surfaces = RunOn::<Cpu>::surfaces(&method).unwrap();
        let frame = Frame::new(&cpu, inputs, &store).unwrap();
        let mut radiance = vec![[0.0; 4]; points.len()];
        surfaces
            .add_surface_light(&frame, 16, &points, false, &mut radiance)
            .unwrap();
        radiance
    });
    let mut shaded = 0;
    for (open, boxed) in found[0].iter().zip(&found[1]) {
        assert!(
            (open[1] - boxed[1]).abs() <= 1e-4 * open[1],
            "{open:?} {boxed:?}"
        );
        shaded += usize::from(open[1] < 0.5 * found[0][0][1].max(found[0][255][1]));
    }
    assert!(shaded > 5, "{shaded}");
}
