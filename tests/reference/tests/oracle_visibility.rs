//! The oracle's lit intervals against analytic shadows, against single shadow
//! rays, and against themselves.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on may panic")]

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use reference::generators::{bulb, log_uniform, neighbour, ray, ray_near, solids, soup, sun};
use reference::oracle::visibility::{Blockers, Search};
use reference::oracle::{Lamp, Line, PointLamp, Span};
use reference::property::holds_for;
use reference::shapes;
use reference::tolerances::Allowed;
use scene::{Emitter, Ray};

fn lamp_at(x: f64, y: f64, z: f64) -> Lamp {
    Lamp::Point(PointLamp::even(DVec3::new(x, y, z), DVec3::ONE))
}

fn sun_from(toward: DVec3) -> Lamp {
    Lamp::Sun(reference::oracle::Sun {
        toward: toward.normalize(),
        irradiance: DVec3::ONE,
    })
}

fn lit(triangles: &[[Vec3; 3]], lamp: &Lamp, ray: Ray) -> Vec<Span> {
    Blockers::new(&shapes::geometry(triangles)).lit_parts(&ray, lamp, Search::Tree)
}

fn along_x(length: f32) -> Ray {
    Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X, length).unwrap()
}

#[track_caller]
fn assert_ends(found: &[Span], expected: &[[f64; 2]]) {
    let near = |a: f64, b: f64| a == b || (a - b).abs() <= Allowed::AnalyticEnds.error();
    assert!(
        found.len() == expected.len()
            && found
                .iter()
                .zip(expected)
                .all(|(f, e)| near(f.start, e[0]) && near(f.end, e[1])),
        "{found:?} instead of {expected:?}"
    );
}

/// The square of half side `half` at height `y` over the origin.
fn plate(y: f32, half: f32) -> Vec<[Vec3; 3]> {
    let side = 2.0 * half;
    shapes::parallelogram(Vec3::new(-half, y, -half), side * Vec3::X, side * Vec3::Z)
}

#[test]
fn a_plane_occluder_casts_the_shadow_of_similar_triangles() {
    let ray = along_x(10.0);
    let lit = |height: f32, lamp: &Lamp| lit(&plate(height, 1.0), lamp, ray);
    // Light 4 m over the plate's middle: at height y the shadow is 4/(4 − y) wide.
    assert_ends(
        &lit(2.0, &lamp_at(0.0, 4.0, 0.1)),
        &[[0.0, 3.0], [7.0, 10.0]],
    );
    assert_ends(
        &lit(1.0, &lamp_at(0.0, 4.0, 0.1)),
        &[[0.0, 5.0 - 4.0 / 3.0], [5.0 + 4.0 / 3.0, 10.0]],
    );
    // Above the light or below the ray it is in nobody's way.
    for height in [-1.0, 5.0] {
        assert_ends(&lit(height, &lamp_at(0.0, 4.0, 0.1)), &[[0.0, 10.0]]);
    }
    let slanted = sun_from(DVec3::new(-1.0, 1.0, 0.0));
    assert_ends(&lit(2.0, &slanted), &[[0.0, 6.0], [8.0, 10.0]]);
    let flat = sun_from(DVec3::new(-1.0, 0.125, 0.0));
    assert_ends(&lit(1.0, &flat), &[[0.0, 10.0]]);
}

#[test]
fn a_wall_higher_than_the_light_shadows_all_that_follows() {
    // At x = 1, from y = ½ upwards; the light is at height 2 over x = 0.
    let wall = shapes::parallelogram(Vec3::new(1.0, 0.5, -50.0), 99.0 * Vec3::Y, 100.0 * Vec3::Z);
    let end = 5.0 + 4.0 / 3.0;
    for length in [50.0, f32::INFINITY] {
        assert_ends(
            &lit(&wall, &lamp_at(0.0, 2.0, 0.0), along_x(length)),
            &[[0.0, end]],
        );
    }
    // From the other side of the wall the near part is dark.
    assert_ends(
        &lit(&wall, &lamp_at(2.0, 2.0, 0.0), along_x(f32::INFINITY)),
        &[[6.0 - 1.0 / 3.0, f64::INFINITY]],
    );
}

#[test]
fn with_the_light_on_the_line_of_the_ray_the_hits_decide() {
    let plate = plate(1.0, 1.0);
    let down = Ray::new(Vec3::new(0.1, 3.0, 0.2), Vec3::NEG_Y, 8.0).unwrap();
    let at = |y: f64| lamp_at(f64::from(0.1_f32), y, f64::from(0.2_f32));
    assert_ends(&lit(&plate, &at(4.0), down), &[[0.0, 2.0]]);
    assert_ends(&lit(&plate, &at(2.5), down), &[[0.0, 2.0]]);
    assert_ends(&lit(&plate, &at(0.0), down), &[[2.0, 8.0]]);
    assert_ends(&lit(&plate, &at(-9.0), down), &[[2.0, 8.0]]);
    assert_ends(&lit(&plate, &sun_from(DVec3::Y), down), &[[0.0, 2.0]]);
    assert_ends(&lit(&plate, &sun_from(DVec3::NEG_Y), down), &[[2.0, 8.0]]);
    // The plate is behind the eye and between it and the sun.
    let below = Ray::new(Vec3::new(0.1, 0.5, 0.2), Vec3::NEG_Y, 8.0).unwrap();
    assert_ends(&lit(&plate, &sun_from(DVec3::Y), below), &[]);
    // Through the edge that the plate's two triangles share.
    let through = Ray::new(Vec3::new(0.25, 3.0, 0.25), Vec3::NEG_Y, 8.0).unwrap();
    assert_ends(
        &lit(&plate, &lamp_at(0.25, 4.0, 0.25), through),
        &[[0.0, 2.0]],
    );
}

#[test]
fn degenerate_rays_have_no_lit_part_and_no_trouble() {
    let plate = plate(1.0, 1.0);
    let here = Ray::new(Vec3::ZERO, Vec3::X, 0.0).unwrap();
    assert_ends(&lit(&plate, &lamp_at(0.0, 4.0, 0.0), here), &[]);
    // The eye at the light.
    assert_ends(
        &lit(&plate, &lamp_at(-5.0, 0.0, 0.0), along_x(9.0)),
        &[[0.0, 9.0]],
    );
    // All of the ray in the plane of the plate, the light too.
    let within = Ray::new(Vec3::new(-5.0, 1.0, 0.1), Vec3::X, 10.0).unwrap();
    assert_ends(
        &lit(&plate, &lamp_at(0.0, 1.0, 5.0), within),
        &[[0.0, 10.0]],
    );
}

#[test]
fn a_spheres_shadow_on_a_ray_has_analytic_ends() {
    let centre = Vec3::new(0.0, 2.0, 0.0);
    let mesh = shapes::sphere(centre, 1.0, 6);
    let inner = shapes::inner_radius(&mesh, centre);
    assert!(inner > 0.9997);
    let found = lit(&mesh, &lamp_at(0.0, 4.0, 0.0), along_x(10.0));
    // The tangents from the light, 2 m above the centre: sin α = r / 2, and
    // 4 m below the light the shadow is 4 tan α wide on either side.
    let half = |r: f64| 4.0 * (0.5 * r).asin().tan();
    assert_eq!(found.len(), 2);
    for width in [5.0 - found[0].end, found[1].start - 5.0] {
        assert!(half(inner) <= width && width <= half(1.0) + 1e-6, "{width}");
    }
    // And in parallel light, at 45°: r √2 wide on either side of x = 5 + 2.
    let found = lit(&mesh, &sun_from(DVec3::new(-1.0, 1.0, 0.0)), along_x(10.0));
    for width in [7.0 - found[0].end, found[1].start - 7.0] {
        let root2 = std::f64::consts::SQRT_2;
        assert!(inner * root2 <= width && width <= root2 + 1e-6, "{width}");
    }
}

/// How far the segment from `a` to `b` stays from `centre`.
fn clearance(a: DVec3, b: DVec3, centre: DVec3) -> f64 {
    let t = (centre - a).dot(b - a) / (b - a).length_squared().max(1e-300);
    (a + t.clamp(0.0, 1.0) * (b - a)).distance(centre)
}

#[test]
fn a_sphere_hides_the_light_exactly_where_the_segment_to_it_meets_the_ball() {
    let radius = 1.5_f32;
    let mesh = shapes::sphere(Vec3::ZERO, radius, 4);
    let inner = shapes::inner_radius(&mesh, Vec3::ZERO);
    let blockers = Blockers::new(&shapes::geometry(&mesh));
    // Rays towards the sphere's rim and its neighbourhood.
    let world = (ray_near(Vec3::ZERO, 6.0), bulb(6.0), neighbour(radius));
    holds_for(1000, world, |(ray, emitter, radius)| {
        let lamp = Lamp::new(&emitter);
        let Lamp::Point(point) = &lamp else {
            return Ok(());
        };
        let found = blockers.lit_parts(&ray, &lamp, Search::Tree);
        let line = Line::new(&ray);
        if line.length == 0.0 {
            return Ok(());
        }
        for k in 0..64 {
            let x = (f64::from(k) + 0.5) / 64.0 * line.length.min(20.0);
            let lit = found.iter().any(|part| part.start <= x && x <= part.end);
            let (at, near) = (
                line.at(x),
                clearance(line.at(x), point.position, DVec3::ZERO),
            );
            // Both ends within the mesh: between its inner surfaces nothing blocks.
            let inside =
                at.length() < f64::from(radius) && point.position.length() < f64::from(radius);
            if near > f64::from(radius) {
                prop_assert!(lit, "dark at {x}, {near} from the centre");
            } else if near < inner && !inside {
                prop_assert!(!lit, "lit at {x}, {near} from the centre");
            }
        }
        Ok(())
    });
}

/// The signed volume test: does the open segment from `a` to `b` cross the
/// triangle? `None` if it comes too close to its border to tell.
fn crosses(a: DVec3, b: DVec3, [p, q, r]: &[DVec3; 3]) -> Option<bool> {
    let volume = |u: DVec3, v: DVec3, w: DVec3| (u - a).dot((v - a).cross(w - a));
    let normal = (*q - *p).cross(*r - *p);
    let (sa, sb) = (normal.dot(a - *p), normal.dot(b - *p));
    let sides = [volume(b, *p, *q), volume(b, *q, *r), volume(b, *r, *p)];
    let small = 1e-6 * normal.length() * (b - a).length();
    let same = sides.iter().all(|s| *s > small) || sides.iter().all(|s| *s < -small);
    let unsure =
        sides.iter().any(|s| s.abs() <= small) || sa.abs().min(sb.abs()) <= 1e-9 * normal.length();
    if unsure {
        let apart = sides.iter().any(|s| *s > small) && sides.iter().any(|s| *s < -small);
        return (apart || (sa * sb > 0.0 && sa.abs().min(sb.abs()) > 1e-9 * normal.length()))
            .then_some(false);
    }
    Some(same && sa * sb < 0.0)
}

#[test]
fn lit_points_are_those_from_which_no_triangle_hides_the_light() {
    let world = (
        solids(5.0, 6),
        ray(8.0),
        prop_oneof![bulb(8.0).boxed(), sun().boxed()],
    );
    holds_for(300, world, |(triangles, ray, emitter)| {
        let blockers = Blockers::new(&shapes::geometry(&triangles));
        let lamp = Lamp::new(&emitter);
        let line = Line::new(&ray);
        if line.length == 0.0 {
            return Ok(());
        }
        let found = blockers.lit_parts(&ray, &lamp, Search::Tree);
        for k in 0..40 {
            let x = (f64::from(k) + 0.5) / 40.0 * line.length.min(25.0);
            let to = match &lamp {
                Lamp::Point(point) => point.position,
                Lamp::Sun(sun) => line.at(x) + 1e3 * sun.toward,
            };
            let tests: Option<Vec<bool>> = blockers
                .triangles()
                .iter()
                .map(|triangle| crosses(line.at(x), to, triangle))
                .collect();
            let near_end = found
                .iter()
                .any(|part| (x - part.start).abs() < 1e-6 || (x - part.end).abs() < 1e-6);
            if let (Some(tests), false) = (tests, near_end) {
                let hidden = tests.contains(&true);
                let lit = found.iter().any(|part| part.start <= x && x <= part.end);
                prop_assert_eq!(lit, !hidden, "at {}: {:?}", x, &found);
            }
        }
        Ok(())
    });
}

#[test]
fn brute_force_over_all_triangles_finds_the_same_bits() {
    let triangles = prop_oneof![soup(10.0, 60).boxed(), solids(10.0, 6).boxed()];
    let emitter = || prop_oneof![2 => bulb(10.0).boxed(), 1 => sun().boxed()];
    let rays = prop::collection::vec((ray(10.0), emitter()), 20);
    holds_for(300, (triangles, rays), |(triangles, rays)| {
        let blockers = Blockers::new(&shapes::geometry(&triangles));
        for (ray, emitter) in rays {
            let mut aimed = vec![(ray, emitter.clone())];
            if let Emitter::Point(point) = &emitter {
                // The line of the light, too.
                let towards = point.position() - ray.origin();
                aimed.extend(
                    Ray::new(ray.origin(), towards, ray.length()).map(|ray| (ray, emitter)),
                );
            }
            for (ray, emitter) in aimed {
                let lamp = Lamp::new(&emitter);
                let tree = blockers.lit_parts(&ray, &lamp, Search::Tree);
                let all = blockers.lit_parts(&ray, &lamp, Search::BruteForce);
                prop_assert_eq!(tree, all, "{:?} {:?}", ray, lamp);
            }
        }
        Ok(())
    });
}

#[test]
fn no_light_leaks_through_the_edges_of_a_closed_mesh() {
    // The light inside, the ray outside, aimed so that planes meet vertices.
    let mesh = shapes::sphere(Vec3::ZERO, 1.0, 3);
    let blockers = Blockers::new(&shapes::geometry(&mesh));
    let vertices: Vec<Vec3> = mesh.iter().flatten().copied().collect();
    let world = (0..vertices.len(), ray(3.0), log_uniform(1.01, 10.0));
    holds_for(2000, world, |(vertex, ray, distance)| {
        let target = distance * vertices[vertex];
        let Some(ray) = Ray::new(target, ray.direction(), 5.0) else {
            return Ok(());
        };
        let line = Line::new(&ray);
        for lamp in [lamp_at(0.0, 0.0, 0.0), lamp_at(0.1, 0.2, -0.3)] {
            for part in blockers.lit_parts(&ray, &lamp, Search::Tree) {
                // Only inside of the sphere.
                let middle = line.at(0.5 * (part.start + part.end));
                prop_assert!(middle.length() < 1.0, "{part:?}");
            }
        }
        Ok(())
    });
}
