//! Whole views: what is asked for adds up, and panes are lit and seen through.

use glam::{Quat, Vec3};
use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::environment::Environment;
use lighting::indirect::{self, FogShadows, Indirect, IndirectLight, LightSurfaces, LitView};
use lighting::scene::procedural::Embedded;
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{
    AlphaMode, Camera, Emission, Geometry, Instance, Material, Mesh, PhaseFunction, Scene,
};

use super::{fog, lamp};

/// The embedded city as `render` shows it.
fn city<R>(use_view: impl FnOnce(LitView<'_>) -> R) -> R {
    let mut scene = Embedded::City.build(1);
    let geometry = Geometry::new(&scene).unwrap();
    scene.complete(geometry.bounds()).unwrap();
    scene.fill_with_fog(geometry.bounds()).unwrap();
    let tracer = Tracer::new(&geometry);
    let view = View::new(&Cpu::new(), &scene.camera.unwrap(), &tracer, 16, 9).unwrap();
    let emitters: Vec<Emitter> = (scene.lights.iter())
        .flat_map(|light| light.emitters(4).unwrap())
        .collect();
    use_view(LitView {
        view: &view,
        scene: &scene,
        geometry: &geometry,
        tracer: &tracer,
        emitters: &emitters,
        medium: scene.medium.as_ref(),
    })
}

fn a_view_is_lit_by_the_sum_of_what_is_asked_for<B: LightSurfaces>(backend: &B) {
    city(|lit| {
        let cpu = Cpu::new();
        let sky = Environment::even([0.1, 0.2, 0.3])
            .unwrap()
            .at_distance(100.0)
            .unwrap();
        let none = IndirectLight {
            scattering: None,
            nodes: 4,
            environment: None,
            ambient: None,
            openness_rays: 8,
        };
        let of = |light| indirect::radiance(backend, &cpu, lit, light).unwrap();
        let fog = IndirectLight {
            scattering: Some(FogShadows::None),
            ..none
        };
        let shadowed = IndirectLight {
            scattering: Some(FogShadows::Maps { resolution: 64 }),
            ..none
        };
        let environment = IndirectLight {
            environment: Some(&sky),
            ..none
        };
        let both = IndirectLight {
            scattering: Some(FogShadows::None),
            ..environment
        };
        let fogged = IndirectLight {
            ambient: Some([0.1, 0.2, 0.3]),
            ..none
        };
        let all = IndirectLight {
            ambient: Some([0.1, 0.2, 0.3]),
            ..both
        };
        let (fogged, all) = (of(fogged), of(all));
        assert!(of(none).radiance.iter().all(|light| *light == [0.0; 4]));
        let (fog, shadowed, environment, both) = (of(fog), of(shadowed), of(environment), of(both));
        assert_eq!((fog.in_closed_form, fog.by_quadrature), (1, 0));
        assert_eq!((shadowed.in_closed_form, shadowed.by_quadrature), (0, 1));
        let most = fog
            .radiance
            .iter()
            .map(|light| f64::from(light[1]))
            .fold(0.0, f64::max);
        for (pixel, hit) in lit.view.hits().iter().enumerate() {
            let at = |of: &Indirect| f64::from(of.radiance[pixel][1]);
            // Fog lights surfaces only, an environment all of the picture.
            assert_eq!(at(&fog) > 0.0, hit.is_some());
            assert!(at(&environment) > 0.0 || hit.is_some());
            let sum = at(&fog) + at(&environment);
            assert!((at(&both) / sum - 1.0).abs() < 1e-5 || sum == 0.0);
            // Fog is lit before everything, but for the sky that has its halo.
            assert!(at(&fogged) > 0.0);
            let before = if hit.is_some() { at(&fogged) } else { 0.0 };
            assert!((at(&all) / (at(&both) + before) - 1.0).abs() < 1e-5);
            // Shadows only take away, but for what four nodes miss.
            assert!(at(&shadowed) <= at(&fog) + 0.02 * most);
        }
        let endless = Environment::even([1.0; 3]).unwrap();
        let bare = IndirectLight {
            environment: Some(&endless),
            ..none
        };
        let error = indirect::radiance(backend, &cpu, lit, bare).unwrap_err();
        assert!(error.to_string().contains("distance"), "{error}");
    });
}

/// A pane before the sky, or before a wall if there is one, looked at from the front.
fn behind_a_pane<R>(pane: Material, wall: bool, use_view: impl FnOnce(LitView<'_>) -> R) -> R {
    let square = |half: f32, z: f32, material| Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(half * x, half * y, z))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(material),
        ..Mesh::default()
    };
    let mut scene = Scene::from(square(1.0, -2.0, 0));
    scene.materials = vec![pane, Material::default()];
    if wall {
        scene.meshes.push(square(9.0, -5.0, 1));
        scene.instances.push(Instance {
            mesh: 1,
            ..Instance::default()
        });
    }
    let geometry = Geometry::new(&scene).unwrap();
    let tracer = Tracer::new(&geometry);
    let camera = Camera::new(Vec3::ZERO, Quat::IDENTITY, 0.5).unwrap();
    let view = View::new(&Cpu::new(), &camera, &tracer, 8, 8).unwrap();
    use_view(LitView {
        view: &view,
        scene: &scene,
        geometry: &geometry,
        tracer: &tracer,
        emitters: &[lamp(Emission::Isotropic, f32::INFINITY)],
        medium: wall.then(|| fog(0.05, PhaseFunction::Isotropic)).as_ref(),
    })
}

fn panes_are_lit_and_what_is_behind_is_seen_through_them<B: LightSurfaces>(backend: &B) {
    let film = |opacity| Material {
        base_color: Vec3::splat(0.5),
        opacity,
        alpha: AlphaMode::Blend,
        ..Material::default()
    };
    let cpu = Cpu::new();
    let none = IndirectLight {
        scattering: None,
        nodes: 4,
        environment: None,
        ambient: None,
        openness_rays: 16,
    };
    // Half of the light is reflected where the pane is, all of it comes from behind
    // where it is not.
    let sky = Environment::even([1.0, 2.0, 3.0]).unwrap();
    let environment = IndirectLight {
        environment: Some(&sky),
        ..none
    };
    let light = behind_a_pane(film(0.25), false, |lit| {
        indirect::radiance(backend, &cpu, lit, environment)
            .unwrap()
            .radiance
    });
    for pixel in &light {
        let share = 0.25 * 0.5 + 0.75;
        for (channel, sky) in [1.0, 2.0, 3.0].into_iter().enumerate() {
            // An environment is a sum over patches.
            let off = (pixel[channel] / (share * sky) - 1.0).abs();
            assert!(off < 5e-3, "{pixel:?}");
        }
    }
    // By way of the fog: as much as a solid card for its share.
    let scattering = IndirectLight {
        scattering: Some(FogShadows::None),
        ..none
    };
    let of = |opacity| {
        behind_a_pane(film(opacity), true, |lit| {
            indirect::radiance(backend, &cpu, lit, scattering)
                .unwrap()
                .radiance
        })
    };
    let (thin, solid, clear) = (of(0.25), of(1.0), of(0.0));
    for (pixel, thin) in thin.iter().enumerate() {
        let expected = 0.25 * solid[pixel][0] + 0.75 * clear[pixel][0];
        assert!(solid[pixel][0] > 0.0 && clear[pixel][0] > 0.0);
        assert!((thin[0] / expected - 1.0).abs() < 1e-5, "{pixel}: {thin:?}");
    }
}

crepuscular_tests::on_every_backend!(
    panes_are_lit_and_what_is_behind_is_seen_through_them,
    a_view_is_lit_by_the_sum_of_what_is_asked_for,
);
