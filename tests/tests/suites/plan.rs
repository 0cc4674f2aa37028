//! What a plan leaves out of a frame does not change its picture.

use crepuscular_tests::frames::{image, inputs};
use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use lighting::methods::{Entry, FrameInputs, Method, Registry, Role, Store, Verdict};
use lighting::plan::{Pass, Plan, Reason, Subject};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{
    AreaEmitters, AreaLight, AreaShape, Camera, Cone, Emission, Medium, Pattern, PhaseFunction,
};
use lighting::visibility::{Exact, VisibilitySource};
use lighting::{Emitter, LightPath};
use reference::random::Random;
use reference::scenes::TestScene;
use reference::shapes;

/// A room with a few boxes, balls and shards of glass without a frame in it, some of them
/// outside of its walls.
fn room(random: &mut Random) -> TestScene {
    let mut triangles = shapes::cuboid(Vec3::new(-6.0, 0.0, -8.0), Vec3::new(6.0, 4.0, 8.0));
    let vector = |random: &mut Random, size: f32| Vec3::from_array(random.vector(size));
    for _ in 0..random.below(6) {
        let centre = Vec3::new(0.0, 1.0, 0.0) + vector(random, 12.0);
        let size = Vec3::splat(0.05) + vector(random, 1.0).abs();
        match random.below(3) {
            0 => triangles.extend(shapes::cuboid(centre - size, centre + size)),
            1 => triangles.extend(shapes::sphere(centre, size.x, 2)),
            _ => triangles.extend([[0; 3].map(|_| centre + vector(random, 1.5))]),
        }
    }
    let geometry = shapes::geometry(&triangles);
    let tracer = Tracer::new(&geometry);
    let eye = Vec3::new(
        random.between(-5.0, 5.0),
        random.between(0.5, 3.5),
        random.between(5.0, 7.5),
    );
    let target = eye - Vec3::Z + 0.5 * vector(random, 1.0);
    let camera = Camera::look_at(eye, target, random.between(0.3, 1.4)).unwrap();
    let size = [48, 27];
    let view = View::new(&Cpu::new(), &camera, &tracer, size[0], size[1]).unwrap();
    let medium = Medium::new(Vec3::splat(0.05), Vec3::ZERO, PhaseFunction::Isotropic).unwrap();
    TestScene {
        name: "room",
        emitters: (0..8).map(|kind| light(random, kind)).collect(),
        areas: Vec::new(),
        medium,
        camera,
        size,
        rays: view.rays().to_vec(),
        hits: view.hits().to_vec(),
        translucent: Vec::new(),
        height_fog: None,
        tracer,
        geometry,
    }
}

fn light(random: &mut Random, kind: u32) -> Emitter {
    let position = Vec3::new(
        random.between(-5.9, 5.9),
        random.between(0.1, 3.9),
        random.between(-7.9, 7.9),
    );
    let way = Vec3::from_array(random.vector(1.0)) + 1e-3 * Vec3::X;
    let range = match random.below(2) {
        0 => f32::INFINITY,
        _ => random.between(0.3, 5.0),
    };
    let emission = match kind % 4 {
        0 => return Emitter::directional(way, Vec3::ONE).unwrap(),
        1 => Emission::Isotropic,
        2 => Emission::Cosine {
            normal: way.normalize(),
        },
        _ => {
            let cone = Cone {
                inner: 0.0,
                outer: random.between(0.05, 1.4),
            };
            let turn = Quat::from_rotation_arc(Vec3::NEG_Z, way.normalize());
            Emission::spot(turn, cone, None).unwrap()
        }
    };
    Emitter::point(position, Vec3::ONE, range, emission).unwrap()
}

/// Whether exact visibility sees all that the light reaches of every ray.
fn is_wholly_lit(frame: &FrameInputs<'_>, tracer: &Tracer, emitter: &Emitter) -> bool {
    let mut lit = Vec::new();
    frame.rays.iter().all(|ray| {
        let Some(path) = LightPath::new(ray, emitter, frame.medium) else {
            return true;
        };
        lit.clear();
        Exact::new(tracer).lit_intervals(&path, &mut lit);
        matches!(lit[..], [part] if part.interval == path.span() && part.visibility == Vec3::ONE)
    })
}

#[test]
fn lights_that_a_plan_calls_unshadowed_light_all_that_they_reach() {
    let mut random = Random::new(21);
    let (mut found, mut missed, mut shadowed) = (0, 0, 0);
    for round in 0..200 {
        let scene = room(&mut random);
        let host = Store::new();
        let frame = inputs(&scene, 64, &host);
        let plan = Plan::of_frame(&frame).unwrap();
        for index in plan.emitters() {
            let truth = is_wholly_lit(&frame, &scene.tracer, &scene.emitters[*index]);
            match (plan.unshadowed().contains(index), truth) {
                (true, false) => panic!("round {round}, light {index} casts a shadow"),
                (true, true) => found += 1,
                (false, true) => missed += 1,
                (false, false) => shadowed += 1,
            }
        }
    }
    println!("found {found}, missed {missed}, shadowed {shadowed}");
    assert!(found > 100 && shadowed > 100, "{found}, {shadowed}");
    assert!(missed * 10 <= found, "{missed} missed, {found} found");
}

/// Unshadowed lights of many rooms, each with its room.
fn unshadowed(rounds: usize) -> impl Iterator<Item = TestScene> {
    let mut random = Random::new(7);
    let rooms = (0..rounds).filter_map(move |_| {
        let mut scene = room(&mut random);
        let host = Store::new();
        let plan = Plan::of_frame(&inputs(&scene, 64, &host)).unwrap();
        let lights = plan.unshadowed().iter();
        scene.emitters = lights.map(|index| scene.emitters[*index].clone()).collect();
        (!scene.emitters.is_empty()).then_some(scene)
    });
    rooms.collect::<Vec<_>>().into_iter()
}

fn picture(scene: &TestScene, entry: &Entry, quality: u32) -> Vec<[f32; 4]> {
    let host = Store::new();
    let frame = inputs(scene, 64, &host);
    image(&Cpu::new(), frame, entry, quality).unwrap().unwrap()
}

#[test]
fn exact_visibility_of_unshadowed_lights_is_none_bit_for_bit() {
    let methods = Registry::standard();
    for scene in unshadowed(20) {
        for [airlight, _] in methods.evaluators() {
            let Some(exact) = methods.pair("exact", airlight, None) else {
                continue;
            };
            let quality = exact.about().usual;
            let (closed, of_closed) = methods.unshadowed(&exact, quality).unwrap();
            assert!(closed.about().name.starts_with("none x "));
            let (forced, planned) = (
                picture(&scene, &exact, quality),
                picture(&scene, &closed, of_closed),
            );
            assert_eq!(forced, planned, "{airlight}");
        }
    }
}

#[test]
fn unshadowed_lights_are_right_to_the_bound_of_the_closed_form() {
    let methods = Registry::standard();
    let truth = methods.pair("exact", "quadrature", None).unwrap();
    for name in ["march x midpoint", "epipolar-sampling", "froxels"] {
        let method = methods.find(name).unwrap();
        for scene in unshadowed(20) {
            let quality = method.about().usual;
            let (closed, quality) = methods.unshadowed(&method, quality).unwrap();
            // Those of both quadratures.
            let allowed = 1e-4 + 1e-6;
            let (exact, planned) = (
                picture(&scene, &truth, 6),
                picture(&scene, &closed, quality),
            );
            for (exact, planned) in exact.iter().zip(&planned) {
                for (exact, planned) in exact.iter().zip(planned) {
                    let error = (exact - planned).abs();
                    assert!(error <= allowed * exact, "{name}: {planned} for {exact}");
                }
            }
        }
    }
}

#[test]
fn what_has_no_shadows_is_not_replaced() {
    let methods = Registry::standard();
    for entry in methods.all() {
        let closed = methods.unshadowed(entry, entry.about().usual);
        if entry.about().role == Role::Unshadowed {
            assert!(closed.is_none(), "{:?}", entry.about().name);
        }
        if let Some((closed, _)) = closed {
            let again = methods.unshadowed(&closed, closed.about().usual);
            assert!(again.is_none());
        }
    }
}

#[test]
fn methods_and_the_plan_leave_out_the_same_by_the_same_conditions() {
    for embedded in Embedded::ALL {
        let scene = TestScene::new(embedded, 8, 8);
        let host = Store::new();
        let frame = inputs(&scene, 64, &host);
        let plan = Plan::of_frame(&frame).unwrap();
        let leaves_out = |reason| plan.left_out().iter().any(|part| part.reason == reason);
        let methods = Registry::standard();
        let is_pointless = |name: &str| {
            let entry = methods.find(name).unwrap();
            entry.applies(&frame) != Verdict::Applies
        };
        if leaves_out(Reason::NothingTranslucent) {
            assert!(is_pointless("translucent x midpoint"), "{}", scene.name);
        }
        let few = !lighting::culling::is_worthwhile(&scene.emitters);
        assert!(!few || plan.emitters().is_empty() || leaves_out(Reason::FewBoundedLights));
        assert_eq!(
            leaves_out(Reason::NoCookie),
            !plan.emitters().is_empty() && !frame.has_cookies()
        );
    }
}

#[test]
fn what_is_dynamic_and_casts_no_shadow_changes_no_bit_of_the_picture() {
    let methods = Registry::standard();
    let exact = methods.pair("exact", "quadrature", None).unwrap();
    let quality = exact.about().usual;
    let mut scene = TestScene::new(Embedded::Traffic, 48, 27);
    let mut random = Random::new(33);
    // Lamps before the surfaces in view, some of them among what moves.
    let surfaces: Vec<Vec3> = (scene.rays.iter().zip(&scene.hits))
        .filter(|(_, hit)| hit.is_some())
        .map(|(ray, _)| ray.at(ray.length() - 0.3))
        .collect();
    scene.emitters = (0..60)
        .map(|_| {
            let position = surfaces[random.below(surfaces.len() as u32) as usize];
            let range = random.between(0.5, 8.0);
            Emitter::point(position, Vec3::ONE, range, Emission::Isotropic).unwrap()
        })
        .collect();
    let host = Store::new();
    let plan = Plan::of_frame(&inputs(&scene, 64, &host)).unwrap();
    let left_out = plan.left_out().iter().find_map(|part| match &part.subject {
        Subject::DynamicMaps(emitters) => Some((emitters.clone(), part.reason, part.saving)),
        _ => None,
    });
    let (still, reason, saving) = left_out.unwrap();
    assert_eq!(reason, Reason::ReachesNothingDynamic);
    assert_eq!(saving.texels, 64 * 64 * 6 * still.len() as u64);
    let moving = plan.passes().iter().find_map(|pass| match pass {
        Pass::DynamicMaps { emitters } => Some(emitters.len()),
        _ => None,
    });
    let moving = moving.unwrap();
    assert!(still.len() > 5 && moving > 5, "{} {moving}", still.len());
    scene.emitters = still
        .iter()
        .map(|index| scene.emitters[*index].clone())
        .collect();
    let whole = picture(&scene, &exact, quality);
    scene.geometry = scene.geometry.static_part().unwrap().clone();
    scene.tracer = Tracer::new(&scene.geometry);
    assert_eq!(picture(&scene, &exact, quality), whole);
    let plan = Plan::of_frame(&inputs(&scene, 64, &host)).unwrap();
    let reasons = plan.left_out().iter().map(|part| part.reason);
    assert!(reasons.clone().any(|reason| reason == Reason::NothingMoves));
}

/// A room whose lights are rectangles and disks.
fn room_with_areas(random: &mut Random) -> TestScene {
    let mut scene = room(random);
    scene.emitters.clear();
    for number in 0..4 {
        let vector = |random: &mut Random| Vec3::from_array(random.vector(1.0));
        let normal = (vector(random) + 1e-3 * Vec3::X).normalize();
        let (u, v) = normal.any_orthonormal_pair();
        let centre = Vec3::new(
            random.between(-5.5, 5.5),
            random.between(0.3, 3.7),
            random.between(-7.5, 7.5),
        );
        let [a, b] = [0; 2].map(|_| random.between(0.02, 0.6));
        let light = AreaLight {
            shape: match number % 2 {
                0 => AreaShape::Rectangle,
                _ => AreaShape::Disk,
            },
            corner: centre - 0.5 * (a * u + b * v),
            edges: [a * u, b * v],
            radiance: Vec3::ONE,
            ..AreaLight::default()
        };
        let points = light.virtual_lights(Pattern::Lattice, 8).unwrap();
        let first = scene.emitters.len();
        scene.emitters.extend(points);
        scene.areas.push(AreaEmitters {
            light,
            emitters: first..scene.emitters.len(),
        });
    }
    scene
}

#[test]
fn area_lights_that_a_plan_calls_unshadowed_light_all_that_any_point_of_them_reaches() {
    let mut random = Random::new(77);
    let (mut found, mut missed, mut shadowed) = (0, 0, 0);
    for round in 0..150 {
        let scene = room_with_areas(&mut random);
        let host = Store::new();
        let frame = inputs(&scene, 64, &host);
        let plan = Plan::of_frame(&frame).unwrap();
        for area in &scene.areas {
            let own = plan.emitters().iter();
            let own: Vec<&usize> = own.filter(|index| area.emitters.contains(index)).collect();
            if own.is_empty() {
                continue;
            }
            let is_named = |index: &&usize| plan.unshadowed().contains(index);
            let named = own.iter().filter(|index| is_named(index)).count();
            assert!(named == 0 || named == own.len(), "an area is one light");
            // Other points than those that the plan looks at.
            let points = area.light.virtual_lights(Pattern::Halton, 40).unwrap();
            let mut points = points.iter();
            let truth = points.all(|point| is_wholly_lit(&frame, &scene.tracer, point));
            match (named > 0, truth) {
                (true, false) => panic!("round {round}: {:?} casts a shadow", area.light),
                (true, true) => found += 1,
                (false, true) => missed += 1,
                (false, false) => shadowed += 1,
            }
        }
    }
    println!("found {found}, missed {missed}, shadowed {shadowed}");
    assert!(found > 30 && shadowed > 30, "{found}, {shadowed}");
    assert!(missed <= found, "{missed} missed, {found} found");
}

#[test]
fn exact_visibility_of_unshadowed_area_lights_is_none_bit_for_bit() {
    let methods = Registry::standard();
    let exact = methods.pair("exact", "quadrature", None).unwrap();
    let quality = exact.about().usual;
    let (closed, of_closed) = methods.unshadowed(&exact, quality).unwrap();
    let mut random = Random::new(8);
    let mut compared = 0;
    for _ in 0..30 {
        let mut scene = room_with_areas(&mut random);
        let host = Store::new();
        let plan = Plan::of_frame(&inputs(&scene, 64, &host)).unwrap();
        let lights = plan.unshadowed().iter();
        scene.emitters = lights.map(|index| scene.emitters[*index].clone()).collect();
        scene.areas.clear();
        if !scene.emitters.is_empty() {
            let forced = picture(&scene, &exact, quality);
            assert_eq!(forced, picture(&scene, &closed, of_closed));
            compared += 1;
        }
    }
    assert!(compared > 3, "{compared}");
}
