//! The reference image: identities that no rendering method enters into.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use glam::{DQuat, DVec3, Vec3};
use proptest::prelude::*;
use reference::generators::{bulb, direction, fog, point, ray, rotation, solids, sun};
use reference::oracle::airlight::{Airlight, NEAREST, Tolerance};
use reference::oracle::image::{Options, Reference, reference};
use reference::oracle::visibility::{Blockers, Search};
use reference::oracle::{Fog, Lamp, Line, PointLamp, Span, Sun, closed_form};
use reference::property::holds_for;
use reference::shapes;
use reference::tolerances::Allowed;
use scene::{Emission, Emitter, Geometry, Medium, PhaseFunction, Ray};

fn image(rays: &[Ray], emitters: &[Emitter], medium: &Medium, geometry: &Geometry) -> Reference {
    let options = Options {
        tolerance: 1e-10,
        ..Options::default()
    };
    reference(rays, emitters, medium, geometry, options)
}

fn many<S: Strategy>(strategy: S) -> impl Strategy<Value = Vec<S::Value>> {
    prop::collection::vec(strategy, 40)
}

fn grey_fog(sigma: f32) -> Medium {
    Medium::new(Vec3::splat(sigma), Vec3::ZERO, PhaseFunction::Isotropic).unwrap()
}

#[test]
fn without_blockers_every_pixel_is_the_closed_form() {
    let world = (many(ray(10.0)), bulb(10.0), 0.001_f32..3.0);
    holds_for(50, world, |(rays, emitter, sigma)| {
        let image = image(
            &rays,
            std::slice::from_ref(&emitter),
            &grey_fog(sigma),
            &shapes::nothing(),
        );
        let Lamp::Point(lamp) = Lamp::new(&emitter) else {
            return Ok(());
        };
        let sigma = f64::from(sigma);
        for ((ray, value), bound) in rays.iter().zip(&image.radiance).zip(&image.bound) {
            let line = Line::new(ray);
            let (foot, offset) = line.nearest(lamp.position);
            let mut h = offset.length();
            if (0.0..=line.length).contains(&foot) {
                h = h.max(NEAREST * foot.hypot(h));
            }
            if line.length == 0.0 || h < 1e-3 {
                // Nothing, or next to the axis, where the form cancels.
                continue;
            }
            let form = |start, end| closed_form::isotropic(sigma, sigma, foot, h, start, end);
            let (expected, terms) = (form(0.0, line.length), form(0.0, f64::INFINITY));
            // exp(−σ D) σ / (4π h D) bounds the terms before they cancel.
            let d = foot.hypot(h);
            let scale =
                terms + 1e-3 * (-sigma * d).exp() * sigma / (2.0 * h * (sigma * d).max(1.0));
            let error = (value[0] - expected).abs();
            prop_assert!(
                error <= Allowed::ClosedForm.error() * scale + bound,
                "{value:?} {expected}"
            );
            let allowed = 1e-10 * value[0].max(1e-3 * image.mean());
            prop_assert!(*bound <= 2.0 * allowed, "{bound} of {value:?}");
        }
        Ok(())
    });
}

/// Where a ray from outside enters the cube between −1 and 1; infinite if it
/// misses.
fn distance_to_unit_cube(origin: Vec3, direction: Vec3) -> f32 {
    let direction = direction.normalize();
    let (a, b) = ((-1.0 - origin) / direction, (1.0 - origin) / direction);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    if enter <= leave && leave > 0.0 {
        enter.max(0.0)
    } else {
        f32::INFINITY
    }
}

#[test]
fn a_light_in_a_closed_box_leaves_the_outside_black() {
    let walls = shapes::geometry(&shapes::cuboid(-Vec3::ONE, Vec3::ONE));
    let world = (many((point(9.0), direction())), point(0.99));
    holds_for(50, world, |(rays, position)| {
        let rays: Vec<Ray> = rays
            .iter()
            .filter(|(origin, _)| origin.abs().max_element() > 1.01)
            // Past the box, or up to just in front of it.
            .filter_map(|(origin, direction)| {
                let end = 0.999 * distance_to_unit_cube(*origin, *direction);
                Ray::new(*origin, *direction, end)
            })
            .collect();
        let lamp = Emitter::point(position, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
        let image = image(&rays, &[lamp], &grey_fog(0.1), &walls);
        prop_assert!(
            image.radiance.iter().all(|pixel| *pixel == [0.0; 3]),
            "{image:?}"
        );
        prop_assert_eq!(image.max_bound(), 0.0);
        Ok(())
    });
}

#[test]
fn the_image_is_the_same_with_and_without_the_tree_and_with_any_number_of_threads() {
    let lights = (bulb(8.0), sun());
    let world = (many(ray(8.0)), solids(6.0, 5), lights, fog(8.0));
    holds_for(30, world, |(rays, triangles, (bulb, sun), medium)| {
        let geometry = shapes::geometry(&triangles);
        let emitters = [bulb, sun];
        let of = |search| {
            let options = Options {
                search,
                ..Options::default()
            };
            reference(&rays, &emitters, &medium, &geometry, options)
        };
        let pool = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
        };
        let alone = pool(1).install(|| of(Search::Tree));
        prop_assert_eq!(&alone, &pool(3).install(|| of(Search::Tree)));
        prop_assert_eq!(&alone, &of(Search::BruteForce));
        Ok(())
    });
}

#[test]
fn progress_counts_every_ray_once() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let rays = vec![Ray::new(Vec3::ZERO, Vec3::X, 5.0).unwrap(); 333];
    let done = AtomicUsize::new(0);
    let options = Options {
        progress: &|rays| {
            done.fetch_add(rays, Ordering::Relaxed);
        },
        ..Options::default()
    };
    let sun = Emitter::directional(Vec3::Y, Vec3::ONE).unwrap();
    reference(&rays, &[sun], &grey_fog(1.0), &shapes::nothing(), options);
    assert_eq!(done.into_inner(), 333);
}

#[test]
fn vacuum_and_no_light_are_black() {
    let rays = [Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).unwrap()];
    let sun = [Emitter::directional(Vec3::Y, Vec3::ONE).unwrap()];
    let vacuum = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    let black = [[0.0; 3]];
    assert_eq!(
        image(&rays, &sun, &vacuum, &shapes::nothing()).radiance,
        black
    );
    assert_eq!(
        image(&rays, &[], &grey_fog(1.0), &shapes::nothing()).radiance,
        black
    );
    assert_eq!(
        image(&[], &sun, &grey_fog(1.0), &shapes::nothing()).mean(),
        0.0
    );
}

/// A scene in f64 that can be moved without rounding its coordinates to f32.
#[derive(Debug, Clone)]
struct World {
    triangles: Vec<[DVec3; 3]>,
    line: Line,
    lamp: Lamp,
    fog: Fog,
}

impl World {
    /// The airlight of the line with and without shadows.
    fn airlight(&self) -> [DVec3; 2] {
        let whole = Span::new(0.0, self.line.length);
        if self.line.length == 0.0 {
            return [DVec3::ZERO; 2];
        }
        let mut lit = Vec::new();
        Blockers::from_triangles(self.triangles.clone()).lit(
            &self.line,
            &self.lamp,
            whole,
            Search::Tree,
            &mut lit,
        );
        [lit, vec![whole]].map(|parts| {
            let mut airlight = Airlight::new(&self.line, &self.fog);
            airlight.add_off_the_light(&self.lamp, whole, &parts);
            airlight.total(Tolerance::relative(1e-10)).value
        })
    }

    /// Enlarged, turned, moved; extinction is made thinner by as much.
    fn moved(&self, scale: f64, rotation: DQuat, translation: DVec3) -> Self {
        let place = |p: DVec3| rotation * (scale * p) + translation;
        let mut fog = self.fog;
        fog.sigma_s /= scale;
        fog.sigma_t /= scale;
        Self {
            triangles: self.triangles.iter().map(|t| t.map(place)).collect(),
            line: Line {
                origin: place(self.line.origin),
                direction: (rotation * self.line.direction).normalize(),
                length: scale * self.line.length,
            },
            lamp: match &self.lamp {
                Lamp::Point(lamp) => {
                    Lamp::Point(PointLamp::even(place(lamp.position), lamp.intensity))
                }
                Lamp::Sun(sun) => Lamp::Sun(Sun {
                    toward: (rotation * sun.toward).normalize(),
                    ..*sun
                }),
            },
            fog,
        }
    }
}

fn world() -> impl Strategy<Value = World> {
    let lamp = prop_oneof![bulb(9.0).boxed(), sun().boxed()];
    (solids(6.0, 5), ray(9.0), lamp, fog(9.0)).prop_map(|(triangles, ray, emitter, medium)| World {
        triangles: triangles.iter().map(|t| t.map(|p| p.as_dvec3())).collect(),
        line: Line::new(&ray),
        lamp: Lamp::new(&emitter),
        fog: Fog::new(&medium),
    })
}

#[test]
fn moving_and_turning_the_world_changes_nothing() {
    holds_for(
        1000,
        (world(), rotation(), point(20.0)),
        |(world, rotation, translation)| {
            let rotation = rotation.as_dquat().normalize();
            let [before, unshadowed] = world.airlight();
            let [after, _] = world
                .moved(1.0, rotation, translation.as_dvec3())
                .airlight();
            let error = (before - after).abs().max_element();
            prop_assert!(
                error <= Allowed::Symmetry.error() * unshadowed.max_element(),
                "{before} {after} {unshadowed}"
            );
            Ok(())
        },
    );
}

#[test]
fn in_a_larger_world_of_thinner_fog_point_lights_fade_with_the_square_and_suns_do_not() {
    // τ and every angle stay, so L = ∫ σ_s p I e^{−τ} / d² dx goes with
    // k⁻¹ k⁻² k = k⁻², and the sun's ∫ σ_s p E e^{−τ} dx with k⁻¹ k = 1.
    holds_for(1000, (world(), 0.01_f64..100.0), |(world, scale)| {
        let [before, unshadowed] = world.airlight();
        let [after, _] = world.moved(scale, DQuat::IDENTITY, DVec3::ZERO).airlight();
        let fade = match world.lamp {
            Lamp::Point(_) => scale.powi(-2),
            Lamp::Sun(_) => 1.0,
        };
        let error = (fade * before - after).abs().max_element();
        prop_assert!(
            error <= Allowed::Symmetry.error() * fade * unshadowed.max_element(),
            "{before} {after} {unshadowed}"
        );
        Ok(())
    });
}

#[test]
fn a_ray_in_two_parts_brings_the_light_of_both() {
    holds_for(1000, (world(), 0.05_f64..0.95), |(world, share)| {
        let cut = share * world.line.length.min(20.0);
        if cut == 0.0 {
            return Ok(());
        }
        let blockers = Blockers::from_triangles(world.triangles.clone());
        let of = |span: Span| {
            let mut lit = Vec::new();
            blockers.lit(&world.line, &world.lamp, span, Search::Tree, &mut lit);
            let mut airlight = Airlight::new(&world.line, &world.fog);
            airlight.add_off_the_light(&world.lamp, Span::new(0.0, world.line.length), &lit);
            airlight.total(Tolerance::relative(1e-10)).value
        };
        let whole = of(Span::new(0.0, world.line.length));
        let parts = of(Span::new(0.0, cut)) + of(Span::new(cut, world.line.length));
        let error = (whole - parts).abs().max_element();
        prop_assert!(
            error <= Allowed::Additivity.error() * whole.max_element(),
            "{whole} {parts}"
        );
        Ok(())
    });
}
