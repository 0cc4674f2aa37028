use std::f64::consts::PI;

use glam::{Affine3A, Quat, Vec3};
use scene::{
    Bounds, DensityGrid, Instance, Interpolation, Mesh, Particle, Particles, PhaseFunction,
    Profile, Scene,
};

use super::*;
use crate::oracle::image::{self, Options};

const TOLERANCE: f64 = 1e-7;

fn geometry(triangles: &[[Vec3; 3]]) -> Geometry {
    let mut scene = Scene::default();
    for (index, corners) in triangles.iter().enumerate() {
        scene.meshes.push(Mesh {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        });
        scene.instances.push(Instance {
            mesh: index,
            ..Instance::default()
        });
    }
    Geometry::new(&scene).expect("triangles")
}

/// Nothing that casts a shadow here.
fn far_away() -> Geometry {
    let corner = Vec3::new(0.0, -1e4, 0.0);
    geometry(&[[corner, corner + Vec3::X, corner + Vec3::Z]])
}

/// A plate above the origin, between the lights and a part of each ray.
fn plate() -> Geometry {
    geometry(&[[
        Vec3::new(-0.6, 1.5, -1.0),
        Vec3::new(0.8, 1.5, -1.0),
        Vec3::new(0.1, 1.5, 2.0),
    ]])
}

fn lights() -> [Emitter; 3] {
    let even = scene::Emission::Isotropic;
    let cone = scene::Cone {
        inner: 0.2,
        outer: 0.6,
    };
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let spot = scene::Emission::spot(down, cone, None).expect("a cone");
    let colour = Vec3::new(3.0, 2.0, 1.0);
    [
        Emitter::point(Vec3::new(0.2, 3.0, 0.3), colour, f32::INFINITY, even).expect("a lamp"),
        Emitter::point(Vec3::new(-0.1, 2.5, 0.0), colour, 9.0, spot).expect("a spot"),
        Emitter::directional(Vec3::new(0.2, -1.0, 0.1), colour).expect("a sun"),
    ]
}

fn rays() -> Vec<Ray> {
    let ray = |origin: Vec3, target: Vec3, length| {
        Ray::new(origin, target - origin, length).expect("a sound ray")
    };
    vec![
        ray(Vec3::new(-4.0, 0.3, 0.1), Vec3::new(0.0, 0.2, 0.0), 9.0),
        ray(Vec3::new(0.1, 0.4, 0.2), Vec3::new(3.0, 1.0, 0.5), 4.0),
        ray(
            Vec3::new(0.5, -3.0, 4.0),
            Vec3::new(0.1, 0.0, 0.0),
            f32::INFINITY,
        ),
    ]
}

fn fog(sigma_s: f32, g: f32) -> Medium {
    let phase = PhaseFunction::HenyeyGreenstein { g };
    Medium::new(Vec3::new(1.0, 0.8, 0.5) * sigma_s, Vec3::splat(0.02), phase).expect("fog")
}

fn smoke(interpolation: Interpolation, scale: f32) -> DensityGrid {
    let bounds = Bounds::new(Vec3::new(-1.0, -0.7, -0.8), Vec3::new(1.2, 0.9, 0.7));
    let density = (0..60).map(|i| (i * 7 % 11) as f32).collect();
    DensityGrid::new(
        bounds.expect("a box"),
        [5, 4, 3],
        density,
        scale,
        interpolation,
    )
    .expect("smoke")
}

fn of(air: Air<'_>, emitters: &[Emitter], geometry: &Geometry, ray: &Ray) -> Estimate {
    let world = MediaWorld::new(air, emitters, geometry);
    world.radiance(ray, Tolerance::relative(TOLERANCE))
}

fn assert_same(one: Estimate, other: Estimate, relative: f64) {
    let error = (one.value - other.value).abs().max_element();
    let allowed = one.bound + other.bound + relative * other.value.max_element();
    assert!(error <= allowed, "{one:?} {other:?}");
}

#[test]
fn homogeneous_media_are_those_of_the_reference_image() {
    let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -2.0), Vec3::new(2.5, 4.0, 2.0));
    let whole = fog(0.2, 0.5);
    let boxed = whole.within(bounds.expect("a box"));
    let mut lit = 0;
    for medium in [whole, boxed] {
        for geometry in [far_away(), plate()] {
            for emitter in lights() {
                let emitters = [emitter];
                let rays = rays();
                let options = Options {
                    tolerance: 1e-8,
                    ..Options::default()
                };
                let truth = image::reference(&rays, &emitters, &medium, &geometry, options);
                let air = Air {
                    medium: Some(&medium),
                    ..Air::default()
                };
                for (index, ray) in rays.iter().enumerate() {
                    let expected = Estimate {
                        value: DVec3::from_array(truth.radiance[index]),
                        bound: truth.bound[index],
                    };
                    lit += u32::from(expected.value.min_element() > 0.0);
                    assert_same(of(air, &emitters, &geometry, ray), expected, 1e-12);
                }
            }
        }
    }
    assert!(lit > 24, "{lit} of 36");
}

#[test]
fn a_constant_grid_is_a_homogeneous_medium_and_an_empty_one_is_nothing() {
    let bounds = Bounds::new(Vec3::new(-2.0, -1.0, -2.0), Vec3::new(2.5, 4.0, 2.0));
    let bounds = bounds.expect("a box");
    let medium = fog(0.2, 0.5).within(bounds);
    let sigma_t = medium.sigma_t();
    let grid = DensityGrid::new(bounds, [3, 2, 4], vec![1.0; 24], 1.0, Interpolation::Linear)
        .and_then(|grid| grid.with_tint(sigma_t))
        .and_then(|grid| grid.with_albedo(medium.sigma_s() / sigma_t))
        .and_then(|grid| grid.with_phase(medium.phase()))
        .expect("a grid");
    let empty = smoke(Interpolation::Constant, 0.0);
    let casters: [Translucent; 2] = [grid.into(), empty.into()];
    let (as_grid, as_medium) = (
        Air {
            translucent: &casters,
            ..Air::default()
        },
        Air {
            medium: Some(&medium),
            ..Air::default()
        },
    );
    let geometry = plate();
    for emitter in lights() {
        for ray in rays() {
            let emitters = [emitter.clone()];
            let found = of(as_grid, &emitters, &geometry, &ray);
            let expected = of(as_medium, &emitters, &geometry, &ray);
            // The products of tint and albedo are rounded to f32.
            assert_same(found, expected, 3e-7);
        }
    }
}

#[test]
fn split_rays_add_up_and_lights_do() {
    let medium = fog(0.05, 0.0);
    let height = HeightFog::new(
        Vec3::splat(0.1),
        Vec3::splat(0.05),
        0.0,
        1.5,
        PhaseFunction::Rayleigh,
    )
    .expect("fog");
    let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::Y);
    let grid = smoke(Interpolation::Constant, 0.05).with_transform(turned);
    let puff = Particle {
        centre: Vec3::new(0.3, 0.2, 0.0),
        radius: 0.7,
        sigma_t: 1.0,
    };
    let puffs = Particles::new(vec![puff], Profile::Soft).expect("a puff");
    let glowing = smoke(Interpolation::Linear, 0.1)
        .with_emission((0..60).map(|i| Vec3::splat(i as f32)).collect());
    let casters: [Translucent; 3] = [
        grid.expect("a grid").into(),
        puffs.into(),
        glowing.expect("a grid").into(),
    ];
    let air = Air {
        medium: Some(&medium),
        height_fog: Some(&height),
        translucent: &casters,
    };
    let geometry = plate();
    let emitters = lights();
    let world = MediaWorld::new(air, &emitters, &geometry);
    let light = |ray: &Ray| world.radiance(ray, Tolerance::relative(1e-6));
    for ray in rays() {
        let whole = light(&ray);
        let cut = 4.2_f32.min(0.5 * ray.length());
        let line = Line::new(&ray);
        let near = light(&ray.with_length(cut));
        let point = line.at(cut.into()).as_vec3();
        let rest = Ray::new(point, ray.direction(), ray.length() - cut).expect("a ray");
        let passed = (-world.optical_depth(line.origin, line.direction, cut.into())).exp();
        let far = light(&rest);
        let sum = Estimate {
            value: near.value + passed * far.value,
            bound: near.bound + far.bound,
        };
        // The second part begins at a point that was rounded to f32.
        assert_same(sum, whole, 3e-6);
        let unlit = MediaWorld::new(air, &[], &geometry);
        let mut each = unlit.radiance(&ray, Tolerance::relative(1e-6));
        assert!(each.value.x > 0.0, "it glows");
        for emitter in &emitters {
            // What glows would be counted again with each light.
            let with = of(air, std::slice::from_ref(emitter), &geometry, &ray);
            each.value += with.value - unlit.radiance(&ray, Tolerance::relative(1e-7)).value;
            each.bound += with.bound;
        }
        assert_same(each, whole, 1e-5);
    }
}

#[test]
fn thin_smoke_scatters_in_proportion_to_what_there_is_of_it() {
    let geometry = far_away();
    let emitters = &lights()[2..];
    let ray = rays()[0];
    let light = |scale: f32| {
        let casters = [smoke(Interpolation::Linear, scale).into()];
        let air = Air {
            translucent: &casters,
            ..Air::default()
        };
        let world = MediaWorld::new(air, emitters, &geometry);
        let line = Line::new(&ray);
        let depth = world
            .optical_depth(line.origin, line.direction, line.length)
            .x;
        (of(air, emitters, &geometry, &ray), depth)
    };
    // An albedo of 1, evenly spread: E τ / 4π, less what is lost on the way.
    let (found, depth) = light(1e-6);
    let irradiance = DVec3::new(3.0, 2.0, 1.0);
    let expected = irradiance * (depth / (4.0 * PI));
    assert!(depth > 1e-6 && (found.value / expected - 1.0).abs().max_element() < 1e-4);
    assert!((found.value.cmple(expected)).all());
    let (half, _) = light(5e-7);
    assert!((2.0 * half.value / found.value - 1.0).abs().max_element() < 1e-4);
}

#[test]
fn no_more_light_comes_out_than_went_in() {
    // Parallel light through smoke of any thickness: what is scattered towards one
    // side, summed over a plane across it, is less than what was taken from the light.
    let geometry = far_away();
    let sun = [Emitter::directional(Vec3::NEG_Y, Vec3::ONE).expect("a sun")];
    for scale in [1e-3, 0.1, 10.0, 1e6] {
        let casters = [smoke(Interpolation::Constant, scale).into()];
        let air = Air {
            translucent: &casters,
            ..Air::default()
        };
        let world = MediaWorld::new(air, &sun, &geometry);
        let (mut scattered, mut taken) = (0.0, 0.0);
        let count = 12;
        for i in 0..count {
            for j in 0..count {
                let at = |index: i32| (f64::from(index) + 0.5) / f64::from(count);
                let origin = Vec3::new(-5.0, -0.7 + 1.6 * at(i) as f32, -0.8 + 1.5 * at(j) as f32);
                let ray = Ray::new(origin, Vec3::X, f32::INFINITY).expect("a ray");
                let light = world.radiance(&ray, Tolerance::relative(1e-4));
                assert!(light.value.is_finite() && light.bound <= 2e-4 * light.value.x + 1e-30);
                scattered += light.value.x * 4.0 * PI * 1.6 * 1.5;
                let above = DVec3::new(-1.0 + 2.2 * at(i), 5.0, -0.8 + 1.5 * at(j));
                let depth = world.optical_depth(above, DVec3::NEG_Y, 9.0).x;
                taken += -(-depth).exp_m1() * 2.2 * 1.5;
            }
        }
        assert!(
            (scattered > 0.0 || scale > 10.0) && scattered < 1.02 * taken,
            "{scale}: {scattered} {taken}"
        );
        // In the densest smoke only a skin is lit, which these lines pass below.
        if scale < 0.01 {
            // Nothing is lost in thin smoke; two sums over 144 lines.
            assert!(scattered > 0.85 * taken, "{scattered} {taken}");
        }
    }
}

#[test]
fn fog_that_thins_out_has_its_closed_form_and_its_limits() {
    let geometry = far_away();
    let up = Ray::new(Vec3::ZERO, Vec3::Y, f32::INFINITY).expect("a ray");
    let sun = [Emitter::directional(Vec3::NEG_Y, Vec3::ONE).expect("a sun")];
    let fog = |height| {
        let phase = PhaseFunction::Isotropic;
        HeightFog::new(Vec3::splat(0.1), Vec3::splat(0.1), 0.0, height, phase).expect("fog")
    };
    let thins = fog(3.0);
    let air = Air {
        height_fog: Some(&thins),
        ..Air::default()
    };
    // The way to the eye and that to the sun make up the whole of the fog.
    let found = of(air, &sun, &geometry, &up).value.x;
    let (sigma_s, sigma_t) = (f64::from(0.1_f32), 2.0 * f64::from(0.1_f32));
    let expected = sigma_s * 3.0 * (-sigma_t * 3.0).exp() / (4.0 * PI);
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    // Hardly thinner over the length of the ray: as if it were even.
    let (deep, even) = (fog(1e7), {
        let phase = PhaseFunction::Isotropic;
        Medium::new(Vec3::splat(0.1), Vec3::splat(0.1), phase).expect("fog")
    });
    let lamp = &lights()[..1];
    let slanted = rays()[0];
    let deep = Air {
        height_fog: Some(&deep),
        ..Air::default()
    };
    let even = Air {
        medium: Some(&even),
        ..Air::default()
    };
    let (found, expected) = (
        of(deep, lamp, &geometry, &slanted),
        of(even, lamp, &geometry, &slanted),
    );
    assert_same(found, expected, 2e-6);
}
