//! The oracle's airlight against closed forms and against itself.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use airlight::Segment;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use reference::generators::{fog, log_uniform, medium, neighbour, ray_near};
use reference::oracle::airlight::{Airlight, Estimate, Tolerance, reach};
use reference::oracle::{Fog, Lamp, Line, Span, closed_form, segment};
use reference::property::holds_for;
use reference::tolerances::Allowed;
use scene::{Emission, Emitter, Medium, PhaseFunction, Ray};

fn bulb(position: Vec3) -> Emitter {
    Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap()
}

fn light(line: &Line, emitter: &Emitter, fog: &Fog, part: Span, tolerance: f64) -> Estimate {
    let mut airlight = Airlight::new(line, fog);
    airlight.add(&Lamp::new(emitter), &[part]);
    airlight.total(Tolerance::relative(tolerance))
}

#[test]
fn isotropic_airlight_equals_its_closed_form() {
    let sizes = (
        log_uniform(1e-3, 1e2),
        log_uniform(1e-3, 1e2),
        log_uniform(1e-3, 1e3),
        log_uniform(1e-4, 30.0),
        any::<bool>(),
        any::<bool>(),
    );
    holds_for(2000, sizes, |(h, along, length, sigma, behind, sky)| {
        let foot = if behind { -along } else { along };
        let emitter = bulb(Vec3::new(foot, h, 0.0));
        let length = if sky { f32::INFINITY } else { length };
        let ray = Ray::new(Vec3::ZERO, Vec3::X, length).unwrap();
        let grey = Vec3::splat(sigma);
        let fog = Fog::new(&Medium::new(grey, Vec3::ZERO, PhaseFunction::Isotropic).unwrap());
        let whole = Span::new(0.0, f64::from(length));
        let found = light(&Line::new(&ray), &emitter, &fog, whole, 1e-11);

        let [sigma, foot, h] = [sigma, foot, h].map(f64::from);
        let from = |start| closed_form::isotropic(sigma, sigma, foot, h, start, f64::INFINITY);
        let expected = closed_form::isotropic(sigma, sigma, foot, h, 0.0, whole.end);
        // What the difference is made of sets its accuracy.
        let terms = from(0.0) + from(whole.end);
        let modulus = |x: f64| {
            let s = x - foot;
            let d = s.hypot(h);
            (-sigma * (x + d)).exp() / (2.0 * std::f64::consts::PI * h * d.max(1.0 / sigma))
        };
        let allowed = Allowed::ClosedForm.error() * (terms + 1e-3 * modulus(0.0));
        let error = (found.value.x - expected).abs();
        prop_assert!(
            error <= allowed + found.bound + 1e-300,
            "{found:?} {expected}"
        );
        prop_assert!(found.bound <= 2e-11 * found.value.x + 1e-300, "{found:?}");
        Ok(())
    });
}

#[test]
fn thin_fog_leaves_the_angle_that_the_part_subtends() {
    let thin = Medium::new(Vec3::splat(1e-12), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let fog = Fog::new(&thin);
    let line = Line::new(&Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap());
    let (emitter, part) = (bulb(Vec3::new(2.0, 0.5, 0.0)), Span::new(1.0, 4.0));
    let found = light(&line, &emitter, &fog, part, 1e-12).value.x;
    let expected = closed_form::isotropic(f64::from(1e-12_f32), 0.0, 2.0, 0.5, 1.0, 4.0);
    assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
}

#[test]
fn bounds_hold() {
    let world = (
        ray_near(Vec3::ZERO, 10.0),
        medium(10.0),
        log_uniform(1e-7, 1e-1),
    );
    holds_for(3000, world, |(ray, medium, tolerance)| {
        let (line, fog) = (Line::new(&ray), Fog::new(&medium));
        let emitter = bulb(Vec3::ZERO);
        let Some(part) = reach(&line, &Lamp::new(&emitter), &fog) else {
            return Ok(());
        };
        let tolerance = f64::from(tolerance);
        let rough = light(&line, &emitter, &fog, part, tolerance);
        let fine = light(&line, &emitter, &fog, part, 1e-12);
        let error = (rough.value - fine.value).abs().max_element();
        if rough.value.is_finite() {
            prop_assert!(error <= rough.bound + fine.bound, "{rough:?} {fine:?}");
            prop_assert!(
                rough.bound <= 1.001 * tolerance * rough.value.max_element() + 1e-300,
                "{rough:?}"
            );
        } else {
            prop_assert!(!fine.value.is_finite());
        }
        Ok(())
    });
}

#[test]
fn parts_add_up_to_the_whole() {
    use reference::generators::emitter;
    let cut = prop_oneof![0.01_f32..1.0, neighbour(0.5), neighbour(1.0)];
    let world = (ray_near(Vec3::ZERO, 5.0), emitter(5.0), medium(5.0), cut);
    holds_for(1000, world, |(ray, emitter, medium, cut)| {
        let (line, fog) = (Line::new(&ray), Fog::new(&medium));
        let Some(part) = reach(&line, &Lamp::new(&emitter), &fog) else {
            return Ok(());
        };
        let length = (part.end - part.start).min(20.0);
        let middle = part.start + f64::from(cut.min(1.0 - 1e-6)) * length;
        let tolerance = 1e-10;
        let of = |a, b| light(&line, &emitter, &fog, Span::new(a, b), tolerance).value;
        let whole = of(part.start, part.end);
        if whole.is_finite() {
            let sum = of(part.start, middle) + of(middle, part.end);
            let error = (sum - whole).abs().max_element();
            prop_assert!(
                error <= Allowed::Additivity.error() * whole.max_element(),
                "{sum} {whole}"
            );
        }
        Ok(())
    });
}

#[test]
fn sunlight_in_unbounded_fog_is_what_the_fog_does_not_transmit() {
    let world = (
        fog(10.0),
        log_uniform(1e-3, 1e3),
        reference::generators::direction(),
    );
    holds_for(500, world, |(medium, length, direction)| {
        let emitter = Emitter::directional(direction, Vec3::new(1.0, 2.0, 3.0)).unwrap();
        let ray = Ray::new(Vec3::ZERO, Vec3::Z, length).unwrap();
        let (line, fog) = (Line::new(&ray), Fog::new(&medium));
        let found = light(&line, &emitter, &fog, Span::new(0.0, line.length), 1e-9);
        let Lamp::Sun(sun) = Lamp::new(&emitter) else {
            return Err(TestCaseError::fail("a sun was asked for"));
        };
        // Sunlight travels away from the sun, then along −Z to the eye.
        let cos = sun.toward.z;
        let phase = fog.phase(0.5 * (1.0 - cos), 0.5 * (1.0 + cos));
        let albedo = fog.sigma_s / fog.sigma_t;
        let opacity = (-fog.sigma_t * line.length).map(|tau| -tau.exp_m1());
        let expected = DVec3::new(1.0, 2.0, 3.0) * albedo * phase * opacity;
        let error = ((found.value - expected) / expected).abs().max_element();
        prop_assert!(error < 1e-12, "{found:?} {expected}");
        Ok(())
    });
}

#[test]
fn a_sun_in_a_box_equals_the_integral_by_brute_force() {
    let world = (
        ray_near(Vec3::ZERO, 5.0),
        reference::generators::sun(),
        medium(5.0),
    );
    holds_for(100, world, |(ray, emitter, medium)| {
        let (line, fog) = (Line::new(&ray), Fog::new(&medium));
        let lamp = Lamp::new(&emitter);
        let Some(part) = reach(&line, &lamp, &fog) else {
            return Ok(());
        };
        let (Lamp::Sun(sun), true) = (&lamp, part.end.is_finite()) else {
            return Ok(());
        };
        let found = light(&line, &emitter, &fog, part, 1e-9).value;
        let cos = sun.toward.dot(line.direction);
        let phase = fog.phase(0.5 * (1.0 - cos), 0.5 * (1.0 + cos));
        let steps = 20_000;
        let step = (part.end - part.start) / f64::from(steps);
        let mut sum = DVec3::ZERO;
        for i in 0..steps {
            let x = part.start + step * (f64::from(i) + 0.5);
            let way = x - part.start + fog.sunlight_inside(sun.toward, line.at(x));
            sum += step * phase * fog.sigma_s * (-fog.sigma_t * way).exp();
        }
        // The logarithm of the integrand changes by at most `rate` per metre.
        // Midpoint rule: step²/24 of the second derivative, rate², and step²/8
        // of each of three jumps of the slope, all where the integrand is
        // largest, which is up to 1 + rate × length above its mean.
        let steepest = (line.direction / sun.toward).abs().max_element();
        let rate = fog.sigma_t.max_element() * (1.0 + steepest);
        let length = part.end - part.start;
        if !(rate * step < 0.01) {
            return Ok(());
        }
        let local = rate * rate / 24.0 + 0.75 * rate / length;
        let allowed = 1e-12 + step * step * local * (1.0 + rate * length);
        let error = (found - sum).abs().max_element();
        prop_assert!(
            error <= allowed * found.max_element() + 1e-300,
            "{found} {sum}"
        );
        Ok(())
    });
}

#[test]
fn a_ray_through_a_light_is_infinite_and_counts_as_a_near_miss_in_an_image() {
    let medium = Medium::new(Vec3::ONE, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let fog = Fog::new(&medium);
    let emitter = bulb(Vec3::X * 3.0);
    let line = Line::new(&Ray::new(Vec3::ZERO, Vec3::X, 5.0).unwrap());
    let part = Span::new(0.0, 5.0);
    let through = light(&line, &emitter, &fog, part, 1e-9);
    assert_eq!(through.value, DVec3::INFINITY);
    let mut image = Airlight::new(&line, &fog);
    image.add_off_the_light(&Lamp::new(&emitter), part, &[part]);
    let total = image.total(Tolerance::relative(1e-11));
    let expected = closed_form::isotropic(1.0, 1.0, 3.0, 3e-4, 0.0, 5.0);
    assert!(
        (total.value.x / expected - 1.0).abs() < 1e-9,
        "{total:?} {expected}"
    );
    // In front of the light, and behind it, the line is harmless.
    for part in [Span::new(0.0, 2.0), Span::new(4.0, 5.0)] {
        let value = light(&line, &emitter, &fog, part, 1e-9).value.x;
        let near = closed_form::isotropic(1.0, 1.0, 3.0, 1e-4, part.start, part.end);
        assert!((value / near - 1.0).abs() < 1e-3, "{value} {near}");
    }
}

#[test]
fn a_segment_by_itself_equals_its_part_of_a_line() {
    let sizes = (
        log_uniform(1e-3, 1e2),
        log_uniform(1e-3, 1e2),
        log_uniform(1e-3, 1e3),
        log_uniform(1e-4, 30.0),
        any::<bool>(),
        0.0_f32..0.99,
    );
    let phases = [
        PhaseFunction::Isotropic,
        PhaseFunction::Rayleigh,
        PhaseFunction::HenyeyGreenstein { g: 0.9 },
        PhaseFunction::HenyeyGreenstein { g: -0.7 },
    ];
    holds_for(500, sizes, |(h, along, length, sigma, behind, from)| {
        let foot = if behind { -along } else { along };
        let start = from * length;
        for phase in phases {
            let medium = Medium::new(Vec3::splat(sigma), Vec3::ZERO, phase).unwrap();
            let fog = Fog::new(&medium);
            let ray = Ray::new(Vec3::ZERO, Vec3::X, length).unwrap();
            let part = Span::new(f64::from(start), f64::from(length));
            let bulb = bulb(Vec3::new(foot, h, 0.0));
            let expected = light(&Line::new(&ray), &bulb, &fog, part, 1e-9).value.x;
            let segment = Segment {
                x: start,
                s: start - foot,
                h,
                length: length - start,
            };
            let own = segment::airlight(phase, f64::from(sigma), segment, 1e-9);
            let value = own.value * f64::from(sigma);
            // The four lengths are rounded to f32, and so are their differences.
            let scale = f64::from(foot.abs() + length + h);
            let shortest = f64::from(length - start).min(f64::from(h));
            let rounding = 1e-7 * scale * (1.0 / shortest + f64::from(sigma));
            prop_assert!(
                (value - expected).abs() <= (1e-8 + 4.0 * rounding) * expected + 1e-300,
                "{phase:?} {segment:?} {sigma}: {value:e} {expected:e}"
            );
        }
        Ok(())
    });
}
