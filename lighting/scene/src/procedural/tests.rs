//! What must hold for every scene, and its figures.

use glam::Vec3;
use gpu_backend::Cpu;

use super::primitives::volume;
use super::{Embedded, ponytail, smoke_grid, smoke_particles, smoke_puffs};
use crate::statistics::{closed_components, figures};
use crate::{Emitter, Geometry, Light, Scene};

fn first_emitter(scene: &Scene) -> Emitter {
    scene.lights[0].emitters(16).unwrap()[0].clone()
}

#[test]
fn the_same_seed_gives_the_same_scene_and_another_seed_another() {
    for which in Embedded::listed() {
        let [scene, again, other] = [1, 1, 2].map(|seed| {
            let scene = which.build(seed);
            let triangles = Geometry::new(&scene).unwrap().triangles().to_vec();
            let rest = format!("{:?}", (scene.camera, scene.lights, scene.medium));
            (triangles, scene.translucent, rest)
        });
        assert!(scene == again, "{which:?}");
        assert!(scene != other, "{which:?}");
    }
    assert_eq!(smoke_puffs(5), smoke_puffs(5));
    assert_ne!(smoke_puffs(5), smoke_puffs(6));
}

#[test]
fn every_scene_is_sound_complete_and_closed_whatever_the_seed() {
    for which in Embedded::listed().chain(Embedded::LARGE) {
        for seed in [0, 1, 17, u64::MAX] {
            let scene = which.build(seed);
            assert_eq!(scene.name, which.name());
            let geometry = Geometry::new(&scene).unwrap();
            assert_eq!(geometry.dropped(), 0, "{which:?} {seed}");
            assert!(scene.camera.is_some() && scene.medium.is_some());
            assert!(!scene.lights.is_empty());
            for light in &scene.lights {
                assert!(!light.emitters(16).unwrap().is_empty());
            }
            for mesh in &scene.meshes {
                // All triangles belong to closed components.
                let components = closed_components(mesh);
                let mut reduced = mesh.clone();
                reduced.triangles.pop();
                assert!(components > 0, "{which:?} {seed}: {}", mesh.name);
                assert_eq!(closed_components(&reduced), components - 1);
                assert!(volume(mesh) > 0.0, "{which:?}: {} is inside out", mesh.name);
                let euler = mesh.positions.len() as i64 - mesh.triangles.len() as i64 / 2;
                let handles = i64::from(mesh.name == "knot");
                assert_eq!(euler, 2 * (components as i64 - handles), "{}", mesh.name);
            }
            for instance in &scene.instances {
                assert!(instance.transform.matrix3.determinant() > 0.0);
            }
        }
    }
}

#[test]
fn names_lead_back_to_their_scenes() {
    for which in Embedded::listed().chain(Embedded::LARGE) {
        assert_eq!(Embedded::from_name(which.name()), Some(which));
        assert!(which.description().len() < 80);
    }
    assert_eq!(Embedded::from_name("City"), None);
}

/// World-space box of an instance.
fn extent(scene: &Scene, instance: usize) -> (Vec3, Vec3) {
    let instance = &scene.instances[instance];
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let positions = scene.meshes[instance.mesh].positions.iter();
    positions.fold(start, |(min, max), &p| {
        let p = instance.transform.transform_point3(p);
        (min.min(p), max.max(p))
    })
}

#[test]
fn the_city_has_intersecting_solids_and_poles_thinner_than_a_texel() {
    let scene = Embedded::City.build(1);
    let geometry = Geometry::new(&scene).unwrap();
    let named = |name: &str| {
        let of_name = |&i: &usize| scene.meshes[scene.instances[i].mesh].name == name;
        (0..scene.instances.len())
            .filter(of_name)
            .collect::<Vec<_>>()
    };

    // Every roof box starts below the roof of the building that was placed
    // last before it, and ends above.
    let buildings = named("building");
    let boxes = named("roof box");
    assert!(boxes.len() >= 2 * buildings.len());
    for &index in &boxes {
        let building = buildings[buildings.partition_point(|&b| b < index) - 1];
        let (roof, (min, max)) = (extent(&scene, building), extent(&scene, index));
        assert!(min.y < roof.1.y && roof.1.y < max.y);
        assert!(min.x > roof.0.x - 0.01 && max.x < roof.1.x + 0.01);
    }
    // Every trunk ends inside the crown that follows it.
    for &index in &named("trunk") {
        let (trunk, crown) = (extent(&scene, index), extent(&scene, index + 1));
        assert!(crown.0.y < trunk.1.y && trunk.1.y < crown.1.y);
    }
    // A light map of the sun at 2048 texels a side has larger texels than the
    // poles are thick, in both directions.
    let Emitter::Directional(sun) = first_emitter(&scene) else {
        panic!("the city is lit by a sun");
    };
    let bounds = geometry.bounds();
    let face = crate::raster::Face::orthographic(bounds, sun.direction());
    let crate::raster::Rays::Parallel {
        half_width,
        half_height,
    } = face.rays
    else {
        panic!("the map of a sun is orthographic");
    };
    let texel = 2.0 * half_width.min(half_height) / 2048.0;
    for &index in &named("pole") {
        let (min, max) = extent(&scene, index);
        assert!((max - min).x.max((max - min).z) < texel, "{texel}");
    }
    assert!(named("pole").len() > 1000);
}

#[test]
fn what_moves_in_the_traffic_is_not_part_of_the_city_that_stays() {
    let city = Geometry::new(&Embedded::City.build(1)).unwrap();
    assert!(city.dynamic_part().is_none());
    let traffic = Geometry::new(&Embedded::Traffic.build(1)).unwrap();
    let (fixed, dynamic) = (
        traffic.static_part().unwrap(),
        traffic.dynamic_part().unwrap(),
    );
    assert_eq!(fixed.triangles(), city.triangles());
    assert!(dynamic.triangles().len() > 4000);
    let [all, moving] = [city.bounds(), dynamic.bounds()].map(|b| (b.max() - b.min()).length());
    assert!(moving < 0.25 * all, "{moving} {all}");
}

#[test]
fn a_scene_uses_the_lights_and_media_that_it_is_there_for() {
    let light = |which: Embedded| which.build(1).lights[0].kind();
    assert_eq!(light(Embedded::City), "directional");
    assert_eq!(light(Embedded::TexturedSpot), "textured spot");
    for which in Embedded::LARGE.into_iter().chain([Embedded::AreaLight]) {
        assert_eq!(light(which), "area");
    }
    for which in Embedded::IN_SMOKE {
        assert!(!crate::Media::of(&which.build(1)).is_homogeneous());
    }
    assert!(Embedded::SmokeColumns.build(1).height_fog.is_some());
    let air = |which: Embedded| which.build(1).medium.unwrap();
    assert!(air(Embedded::Landscape).bounds().is_some());
    let haze = air(Embedded::Landscape).sigma_s();
    assert!(haze.x < haze.y && haze.y < haze.z);
}

#[test]
fn the_stiff_scene_is_as_stiff_as_it_says() {
    let scene = Embedded::Stiff.build(1);
    let medium = scene.medium.unwrap();
    let bounds = medium.bounds().unwrap();
    let across = (bounds.max() - bounds.min()).max_element();
    let depths = medium.sigma_t() * across;
    assert!(
        depths.min_element() >= 50.0 && depths.max_element() <= 100.0,
        "{depths}"
    );
    let eye = scene.camera.unwrap().eye();
    let distances: Vec<f32> = scene
        .lights
        .iter()
        .map(|light| match light {
            Light::Point(light) => light.position.distance(eye),
            _ => panic!("both lights are points"),
        })
        .collect();
    assert!((1e-3..1e-2).contains(&distances[0]), "{distances:?}");
    assert!((distances[1] / 1e4 - 1.0).abs() < 0.01, "{distances:?}");
    // The wall that the distant light grazes most closely, but not edge-on.
    let Light::Point(distant) = &scene.lights[1] else {
        panic!("both lights are points");
    };
    let towards = distant.position.as_dvec3().normalize();
    let geometry = Geometry::new(&scene).unwrap();
    let grazing = geometry.triangles().iter().map(|triangle| {
        let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
        (b - a).cross(c - a).normalize().dot(towards).abs()
    });
    let least = grazing.fold(1.0, f64::min);
    assert!(least > 1e-5 && least < 1e-4, "{least}");
}

#[test]
fn smoke_and_hair_have_the_size_and_the_density_that_are_told() {
    let grid = smoke_grid(3, 2.5).unwrap();
    assert!(grid.max_density() <= 1.0 && grid.max_density() > 0.9);
    let [x, y, z] = grid.resolution().map(|count| count as usize);
    for (index, &density) in grid.density().iter().enumerate() {
        let place = [index % x, index / x % y, index / (x * y)];
        let outside = [(0, x), (1, y), (2, z)]
            .iter()
            .any(|&(axis, count)| place[axis] == 0 || place[axis] == count - 1);
        assert!(density == 0.0 || !outside);
    }
    let filled = grid
        .density()
        .iter()
        .filter(|&&density| density > 0.1)
        .count();
    assert!(filled > grid.density().len() / 20, "{filled}");
    let hair = ponytail(3, 50, 0.01, 0.5).unwrap();
    assert_eq!((hair.len(), hair.piece_count()), (50, 750));
    let bounds = hair.bounds().unwrap();
    let size = bounds.max() - bounds.min();
    // About 1 m long; wisps part by up to 0.12 m to either side.
    assert!(
        size.min_element() > 0.2 && size.max_element() < 1.5,
        "{size}"
    );
    assert_eq!(smoke_particles(3).all().len(), smoke_puffs(3).len());
}

#[test]
fn smoke_and_hair_of_impossible_numbers_are_refused() {
    for (hair, cause) in [
        (ponytail(1, 10, f32::NAN, 0.5), "NaN"),
        (ponytail(1, 10, -0.1, 0.5), "thickness is -0.1"),
        (ponytail(1, 10, 0.1, 1.5), "opacity is 1.5"),
        (ponytail(1, 5_000_000, 0.1, 0.5), "5000000"),
        (ponytail(1, u32::MAX, 0.1, 0.5), "4294967295"),
    ] {
        let error = hair.unwrap_err().to_string();
        assert!(error.contains(cause), "{error}");
    }
    for sigma_t in [-1.0, f32::NAN, f32::INFINITY] {
        let error = smoke_grid(1, sigma_t).unwrap_err().to_string();
        assert!(error.contains("scale"), "{error}");
    }
    assert!(ponytail(1, 0, 0.0, 0.0).unwrap().is_empty());
}

#[test]
fn figures_are_those_on_record() {
    use Embedded::*;
    // Solids and triangles are exact. The rest is counted on texels, of which
    // a few may differ where the last bit of a coordinate does.
    let record = [
        (City, 10_985, 327_316, 0.416_321, 57_083.0, 3.132_678),
        (Landscape, 1, 134_144, 0.546_623, 5_737.0, 1.177_642),
        (Hairball, 1_501, 147_012, 0.999_996, 45_950.0, 8.824_462),
        (Smoke, 601, 192_012, 0.597_679, 7_851.0, 1.179_374),
        (TexturedSpot, 2, 20_492, 0.413_116, 834.0, 1.003_352),
        (AreaLight, 3, 103_704, 1.0, 4_249.0, 1.366_425),
        (Pergola, 11, 132, 1.0, 4_477.0, 1.688_068),
        (Coil, 2, 20_208, 1.0, 6_180.0, 1.577_061),
        (Fence, 137, 2_300, 0.673_492, 16_619.0, 1.238_292),
        (Stiff, 32, 384, 0.826_984, 4_443.0, 1.211_076),
        (Translucent, 2, 1_292, 0.462_849, 750.0, 1.000_626),
    ];
    assert_eq!(record.map(|entry| entry.0), Embedded::ALL);
    for (which, solids, triangles, covered_share, silhouette_length, depth_complexity) in record {
        let scene = which.build(1);
        let geometry = Geometry::new(&scene).unwrap();
        let found = figures(&scene, &geometry, &first_emitter(&scene), 512, &Cpu::new()).unwrap();
        let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < 2e-3;
        assert!(
            found.solids == solids
                && found.triangles == triangles
                && near(found.covered_share, covered_share)
                && near(found.silhouette_length as f64, silhouette_length)
                && near(found.depth_complexity, depth_complexity),
            "{}: {found:?}",
            which.name()
        );
    }
}
