//! Random rays, lights, media and solids.

use glam::Vec3;
use proptest::prelude::*;
use scene::{Bounds, Cone, Emission, Emitter, Medium, PhaseFunction, Ray, Texture};

use super::{direction, length, log_uniform, point, rotation};
use crate::shapes;

/// A ray that starts within the cube ±`size`.
pub fn ray(size: f32) -> impl Strategy<Value = Ray> {
    (point(size), direction(), length(size)).prop_map(|(origin, direction, length)| {
        Ray::new(origin, direction, length).expect("a unit direction")
    })
}

/// A ray that starts within the cube ±`size` and passes `target` at a planted
/// distance: of any magnitude, mostly small, sometimes as near as f32 gets.
pub fn ray_near(target: Vec3, size: f32) -> impl Strategy<Value = Ray> {
    let miss = prop_oneof![3 => log_uniform(1e-6 * size, size), 1 => Just(0.0)];
    (point(size), miss, direction(), any::<bool>(), length(size)).prop_filter_map(
        "the ray starts at its target",
        move |(origin, miss, aside, away, length)| {
            let towards = target + miss * aside - origin;
            Ray::new(origin, if away { -towards } else { towards }, length)
        },
    )
}

/// A point light that shines the same everywhere, without a range.
pub fn bulb(size: f32) -> impl Strategy<Value = Emitter> {
    point(size).prop_map(|position| {
        Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic)
            .expect("a finite position")
    })
}

/// A sun.
pub fn sun() -> impl Strategy<Value = Emitter> {
    direction()
        .prop_map(|direction| Emitter::directional(direction, Vec3::ONE).expect("a unit direction"))
}

/// A spotlight, some with a cookie, or a surface that emits by the cosine law.
pub fn beam(size: f32) -> impl Strategy<Value = Emitter> {
    let cookie = prop::collection::vec(0.0_f32..1.0, 12).prop_map(|values| {
        let texels = values.iter().map(|v| Vec3::new(*v, 1.0 - v, 0.5)).collect();
        Texture::new(4, 3, texels).expect("twelve texels")
    });
    let spot = (
        rotation(),
        0.0_f32..0.95,
        log_uniform(0.02, 1.5),
        prop::option::of(cookie),
    )
        .prop_map(|(rotation, share, outer, cookie)| {
            let cone = Cone {
                inner: share * outer,
                outer,
            };
            Emission::spot(rotation, cone, cookie).expect("a cone")
        });
    let emission = prop_oneof![
        3 => spot,
        1 => direction().prop_map(|normal| Emission::Cosine { normal }),
    ];
    let range = prop_oneof![Just(f32::INFINITY), log_uniform(0.1 * size, 3.0 * size)];
    (point(size), range, emission).prop_map(|(position, range, emission)| {
        Emitter::point(position, Vec3::ONE, range, emission).expect("a finite position")
    })
}

/// Any light.
pub fn emitter(size: f32) -> impl Strategy<Value = Emitter> {
    prop_oneof![2 => bulb(size).boxed(), 2 => beam(size).boxed(), 1 => sun().boxed()]
}

/// A phase function; `peak` bounds |g|.
pub fn phase(peak: f32) -> impl Strategy<Value = PhaseFunction> {
    prop_oneof![
        2 => Just(PhaseFunction::Isotropic),
        1 => Just(PhaseFunction::Rayleigh),
        2 => (-peak..=peak).prop_map(|g| PhaseFunction::HenyeyGreenstein { g }),
        1 => (-peak..=peak).prop_map(|g| PhaseFunction::CornetteShanks { g }),
        1 => (-peak..=peak).prop_map(|k| PhaseFunction::Schlick { k }),
        1 => (-peak..=peak, -peak..=peak, 0.0_f32..=1.0)
            .prop_map(|(a, b, weight)| PhaseFunction::DoubleHenyeyGreenstein { g: [a, b], weight }),
        1 => (-peak..=peak, -peak..=peak, 0.0_f32..=50.0, 0.0_f32..=1.0).prop_map(
            |(g, draine_g, alpha, weight)| PhaseFunction::HenyeyGreensteinDraine {
                g,
                draine_g,
                alpha,
                weight,
            }
        ),
    ]
}

/// An unbounded medium of optical depth 1e-3 to 30 over `size`, per channel.
pub fn fog(size: f32) -> impl Strategy<Value = Medium> {
    let channel = || log_uniform(1e-3 / size, 30.0 / size);
    let albedo = prop_oneof![Just(1.0_f32), 0.05_f32..1.0];
    ([channel(), channel(), channel()], albedo, phase(0.9)).prop_map(|(sigma_t, albedo, phase)| {
        let sigma_t = Vec3::from_array(sigma_t);
        Medium::new(albedo * sigma_t, (1.0 - albedo) * sigma_t, phase)
            .expect("coefficients above 0")
    })
}

/// Fog everywhere or in a box within the cube ±`size`.
pub fn medium(size: f32) -> impl Strategy<Value = Medium> {
    let bounds = (point(size), point(size))
        .prop_filter_map("a flat box", |(a, b)| Bounds::new(a.min(b), a.max(b)).ok());
    (fog(size), prop::option::of(bounds)).prop_map(|(fog, bounds)| match bounds {
        Some(bounds) => fog.within(bounds),
        None => fog,
    })
}

/// 1 to `most` loose triangles within about ±`size`, some of them slivers.
pub fn soup(size: f32, most: usize) -> impl Strategy<Value = Vec<[Vec3; 3]>> {
    let edge = || (direction(), log_uniform(1e-3 * size, size)).prop_map(|(d, l)| d * l);
    let triangle = (point(size), edge(), edge()).prop_filter_map(
        "a triangle without area",
        |(corner, u, v)| {
            let area = u.as_dvec3().cross(v.as_dvec3()).length();
            (area > 0.0).then_some([corner, corner + u, corner + v])
        },
    );
    prop::collection::vec(triangle, 1..=most)
}

/// 1 to `most` closed boxes and spheres within about ±`size`, which may
/// intersect, as one list of triangles.
pub fn solids(size: f32, most: usize) -> impl Strategy<Value = Vec<[Vec3; 3]>> {
    let cuboid = (point(size), point(0.4 * size)).prop_filter_map("a flat box", |(at, extent)| {
        let extent = extent.abs();
        (extent.min_element() > 1e-4).then(|| shapes::cuboid(at - extent, at + extent))
    });
    let sphere = (point(size), log_uniform(0.02 * size, 0.5 * size))
        .prop_map(|(centre, radius)| shapes::sphere(centre, radius, 2));
    let solid = prop_oneof![cuboid.boxed(), sphere.boxed()];
    prop::collection::vec(solid, 1..=most).prop_map(|solids| solids.concat())
}
