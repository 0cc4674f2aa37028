//! One list of lights, media and rays at which methods for single scattering
//! are known to break.

mod casters;
mod frames;

pub use casters::{CasterCase, caster_cases};
pub use frames::{FrameCase, LargeCase, frame_cases, large_frame_cases};

use std::f32::consts::FRAC_PI_4;

use glam::{Quat, Vec3};
use scene::{Bounds, Cone, Emission, Emitter, Medium, PhaseFunction, Ray, Texture};

/// A ray, a light and a medium, unshadowed.
#[derive(Debug, Clone)]
pub struct HardCase {
    /// What is hard about it.
    pub name: &'static str,
    /// The light.
    pub emitter: Emitter,
    /// The medium.
    pub medium: Medium,
    /// The eye ray.
    pub ray: Ray,
}

/// All of them.
pub fn hard_cases() -> Vec<HardCase> {
    let mut list = List::default();
    points(&mut list);
    media(&mut list);
    beams(&mut list);
    suns(&mut list);
    list.0
}

#[derive(Default)]
struct List(Vec<HardCase>);

impl List {
    fn add(&mut self, name: &'static str, emitter: Emitter, medium: Medium, ray: Ray) {
        self.0.push(HardCase {
            name,
            emitter,
            medium,
            ray,
        });
    }
}

const SKY: f32 = f32::INFINITY;

fn along_x(length: f32) -> Ray {
    Ray::new(Vec3::ZERO, Vec3::X, length).expect("a sound ray")
}

fn point(x: f32, y: f32, z: f32) -> Emitter {
    emitting(Vec3::new(x, y, z), Emission::Isotropic)
}

fn emitting(position: Vec3, emission: Emission) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, emission).expect("a sound light")
}

fn fog(sigma: f32) -> Medium {
    scattering(
        Vec3::splat(0.9 * sigma),
        Vec3::splat(0.1 * sigma),
        PhaseFunction::Isotropic,
    )
}

fn peaked(sigma: f32, g: f32) -> Medium {
    scattering(
        Vec3::splat(sigma),
        Vec3::ZERO,
        PhaseFunction::HenyeyGreenstein { g },
    )
}

fn scattering(sigma_s: Vec3, sigma_a: Vec3, phase: PhaseFunction) -> Medium {
    Medium::new(sigma_s, sigma_a, phase).expect("a sound medium")
}

fn points(list: &mut List) {
    list.add("ordinary", point(3.0, 1.0, 0.5), fog(0.2), along_x(8.0));
    list.add(
        "through the light",
        point(3.0, 0.0, 0.0),
        fog(0.2),
        along_x(8.0),
    );
    list.add(
        "one ULP beside the light",
        point(3.0, f32::EPSILON, 0.0),
        fog(0.2),
        along_x(8.0),
    );
    list.add(
        "ends at the light",
        point(3.0, 0.0, 0.0),
        fog(0.2),
        along_x(3.0),
    );
    list.add(
        "ends just before the light",
        point(3.0, 0.0, 0.0),
        fog(0.2),
        along_x(2.999),
    );
    list.add(
        "starts just beyond the light",
        point(-1e-3, 0.0, 0.0),
        fog(0.2),
        along_x(8.0),
    );
    list.add(
        "gamma towards 0",
        point(3.0, 3e-5, 0.0),
        fog(0.2),
        along_x(8.0),
    );
    list.add(
        "gamma 1e-6, ends before the light",
        point(3.0, 3e-6, 0.0),
        fog(0.2),
        along_x(2.0),
    );
    list.add(
        "gamma towards pi",
        point(-3.0, 3e-6, 0.0),
        fog(0.2),
        along_x(8.0),
    );
    list.add("gamma is pi", point(-3.0, 0.0, 0.0), fog(0.2), along_x(8.0));
    list.add(
        "light 1e-6 m from the eye",
        point(6e-7, 8e-7, 0.0),
        fog(0.2),
        along_x(8.0),
    );
    list.add(
        "light 1e4 m away",
        point(6e3, 8e3, 0.0),
        fog(1e-4),
        along_x(30.0),
    );
    list.add(
        "light 1e4 m ahead, nearly on the ray",
        point(1e4, 1.0, 0.0),
        fog(1e-4),
        along_x(30.0),
    );
    list.add("zero length", point(3.0, 1.0, 0.5), fog(0.2), along_x(0.0));
    list.add(
        "a micrometre long",
        point(3.0, 1.0, 0.5),
        fog(0.2),
        along_x(1e-6),
    );
    list.add("sky", point(3.0, 1.0, 0.5), fog(0.2), along_x(SKY));
    list.add(
        "sky, thin fog",
        point(3.0, 1.0, 0.5),
        fog(1e-6),
        along_x(SKY),
    );
    list.add(
        "sky, away from the light",
        point(-3.0, 1.0, 0.5),
        fog(0.2),
        along_x(SKY),
    );
}

fn media(list: &mut List) {
    let near = || point(3.0, 1.0, 0.5);
    list.add("tau 30", near(), fog(10.0), along_x(8.0));
    list.add(
        "tau 100 past a light 1 m away",
        point(0.8, 0.6, 0.0),
        fog(30.0),
        along_x(3.0),
    );
    list.add(
        "tau 600 over the ray, light at the eye",
        point(0.0, 0.02, 0.0),
        fog(60.0),
        along_x(10.0),
    );
    list.add(
        "light exactly at the eye",
        point(0.0, 0.0, 0.0),
        fog(0.3),
        along_x(8.0),
    );
    list.add("thin fog", near(), fog(1e-8), along_x(8.0));
    let extremes = scattering(
        Vec3::new(1e-8, 1.0, 1e3),
        Vec3::new(0.0, 0.1, 0.0),
        PhaseFunction::Isotropic,
    );
    list.add(
        "RGB extinction from 1e-8 to 1e3",
        point(0.01, 0.02, 0.0),
        extremes,
        along_x(8.0),
    );
    list.add(
        "forward peak, towards the light",
        point(3.0, 0.1, 0.0),
        peaked(0.2, 0.95),
        along_x(8.0),
    );
    list.add(
        "forward peak, away from the light",
        point(-3.0, 0.1, 0.0),
        peaked(0.2, 0.95),
        along_x(8.0),
    );
    list.add(
        "backward peak, towards the light",
        point(3.0, 0.1, 0.0),
        peaked(0.2, -0.95),
        along_x(8.0),
    );
    list.add(
        "g 0.99, gamma 1e-3",
        point(3.0, 3e-3, 0.0),
        peaked(0.2, 0.99),
        along_x(8.0),
    );
    let rayleigh = scattering(
        Vec3::new(0.1, 0.2, 0.4),
        Vec3::ZERO,
        PhaseFunction::Rayleigh,
    );
    list.add("Rayleigh", near(), rayleigh, along_x(8.0));

    let room = |min: Vec3, max: Vec3| Bounds::new(min, max).expect("a box");
    let ahead = room(Vec3::new(2.0, -1.0, -1.0), Vec3::new(4.0, 1.0, 1.0));
    list.add(
        "box, light and eye outside",
        point(3.0, 3.0, 2.5),
        fog(0.8).within(ahead),
        along_x(SKY),
    );
    // More optical depths of vacuum than any exponential holds.
    list.add(
        "box, light 1e4 m outside",
        point(6e3, 7e3, 3e3),
        fog(0.8).within(ahead),
        along_x(SKY),
    );
    let deep = room(Vec3::splat(-50.0), Vec3::splat(50.0));
    for (name, travel) in [
        ("deep box, towards the sun", Vec3::new(-1.0, -0.02, 0.01)),
        ("deep box, away from the sun", Vec3::new(1.0, -0.02, 0.01)),
    ] {
        let sun = Emitter::directional(travel, Vec3::ONE).expect("a sun");
        list.add(name, sun, fog(10.0).within(deep), along_x(SKY));
    }
    list.add(
        "box, light inside",
        point(3.0, 0.5, 0.5),
        fog(0.8).within(ahead),
        along_x(SKY),
    );
    list.add(
        "box, light on its face",
        point(3.0, 1.0, 0.5),
        fog(0.8).within(ahead),
        along_x(SKY),
    );
    list.add(
        "box, light behind the eye",
        point(-2.0, 0.3, 0.2),
        fog(0.8).within(ahead),
        along_x(3.5),
    );
    let beside = room(Vec3::new(2.0, 1.0, -1.0), Vec3::new(4.0, 2.0, 1.0));
    list.add("box missed", near(), fog(0.8).within(beside), along_x(SKY));
    let touching = room(Vec3::new(2.0, 0.0, -1.0), Vec3::new(4.0, 2.0, 1.0));
    list.add(
        "along a face of the box",
        near(),
        fog(0.8).within(touching),
        along_x(SKY),
    );
}

fn beams(list: &mut List) {
    let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let spot = |inner: f32, outer: f32, cookie: Option<Texture>| {
        Emission::spot(down, Cone { inner, outer }, cookie).expect("a cone")
    };
    // 2 m over the ray the cone meets it over ± 2 tan(outer).
    let over = Vec3::new(4.0, 2.0, 0.0);
    list.add(
        "across a cone",
        emitting(over, spot(0.2, 0.5, None)),
        fog(0.2),
        along_x(8.0),
    );
    list.add(
        "hard cone",
        emitting(over, spot(0.4999, 0.5, None)),
        fog(0.2),
        along_x(8.0),
    );
    let grazing = Vec3::new(4.0, 2.0, 2.0 * 0.4999_f32.tan());
    list.add(
        "grazing the edge of a cone",
        emitting(grazing, spot(0.2, 0.5, None)),
        fog(0.2),
        along_x(8.0),
    );
    let missed = Vec3::new(4.0, 2.0, 2.0 * 0.51_f32.tan());
    list.add(
        "past a cone",
        emitting(missed, spot(0.2, 0.5, None)),
        fog(0.2),
        along_x(8.0),
    );
    // The ray runs along the edge of this cone itself.
    let aslant = Quat::from_rotation_z(FRAC_PI_4) * down;
    let edge = Emission::spot(
        aslant,
        Cone {
            inner: 0.3,
            outer: FRAC_PI_4 + 0.01,
        },
        None,
    )
    .expect("a cone");
    list.add(
        "inside a cone, along its edge",
        emitting(Vec3::new(-1.0, 0.01, 0.0), edge),
        fog(0.2),
        along_x(8.0),
    );
    let ahead = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let torch = Emission::spot(
        ahead,
        Cone {
            inner: 0.1,
            outer: 0.3,
        },
        None,
    )
    .expect("a cone");
    list.add(
        "torch beside the eye",
        emitting(Vec3::new(0.0, 0.05, 0.0), torch),
        fog(0.2),
        along_x(SKY),
    );
    list.add(
        "wide cone",
        emitting(over, spot(0.0, std::f32::consts::FRAC_PI_2, None)),
        fog(0.2),
        along_x(8.0),
    );
    let texels = (0..64)
        .map(|i| Vec3::new((i % 2) as f32, (i / 8 % 2) as f32, 0.5))
        .collect();
    let cookie = Texture::new(8, 8, texels).expect("64 texels");
    list.add(
        "cookie",
        emitting(over, spot(0.2, 0.5, Some(cookie))),
        fog(0.2),
        along_x(8.0),
    );

    let cosine = |normal: Vec3| Emission::Cosine { normal };
    list.add(
        "cosine emission",
        emitting(over, cosine(Vec3::NEG_Y)),
        fog(0.2),
        along_x(8.0),
    );
    let oblique = Vec3::new(1.0, -0.2, 0.0).normalize();
    list.add(
        "cosine emission, half of the ray behind it",
        emitting(over, cosine(oblique)),
        fog(0.2),
        along_x(8.0),
    );
    let short = Emitter::point(over, Vec3::ONE, 2.5, Emission::Isotropic).expect("a light");
    list.add("range", short, fog(0.2), along_x(8.0));
    let grazing =
        Emitter::point(over, Vec3::ONE, 2.0 + 1e-5, Emission::Isotropic).expect("a light");
    list.add(
        "range just reaches the ray",
        grazing,
        fog(0.2),
        along_x(8.0),
    );
}

fn suns(list: &mut List) {
    let sun = |x: f32, y: f32, z: f32| {
        Emitter::directional(Vec3::new(x, y, z), Vec3::ONE).expect("a sound light")
    };
    list.add("sun", sun(1.0, -2.0, 0.5), fog(0.2), along_x(8.0));
    list.add("sun, sky", sun(1.0, -2.0, 0.5), fog(0.2), along_x(SKY));
    list.add(
        "sun, thin fog",
        sun(1.0, -2.0, 0.5),
        fog(1e-8),
        along_x(8.0),
    );
    list.add(
        "sun, tau 800",
        sun(1.0, -2.0, 0.5),
        fog(100.0),
        along_x(8.0),
    );
    list.add(
        "into the sun",
        sun(-1.0, 0.0, 0.0),
        peaked(0.2, 0.95),
        along_x(8.0),
    );
    list.add(
        "away from the sun",
        sun(1.0, 0.0, 0.0),
        peaked(0.2, -0.95),
        along_x(8.0),
    );
    let room = Bounds::new(Vec3::new(2.0, -1.0, -1.0), Vec3::new(4.0, 1.0, 1.0)).expect("a box");
    let boxed = fog(0.8).within(room);
    list.add("sun, box", sun(1.0, -2.0, 0.5), boxed, along_x(SKY));
    list.add(
        "sun through an edge of the box",
        sun(-1.0, -1.0, 0.25),
        boxed,
        along_x(SKY),
    );
    list.add(
        "sun against the ray, box",
        sun(-1.0, -1e-4, 0.0),
        boxed,
        along_x(SKY),
    );
    list.add(
        "sun along the ray, box",
        sun(1.0, 0.0, 0.0),
        boxed,
        along_x(SKY),
    );
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn names_are_unique() {
        let cases = hard_cases();
        let names: HashSet<_> = cases.iter().map(|case| case.name).collect();
        assert_eq!(names.len(), cases.len());
    }
}
