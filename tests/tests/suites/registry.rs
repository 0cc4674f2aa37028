//! What every method of the registry must do, on every backend. A method that is
//! added is tested here without a word.

use crepuscular_tests::frames::{image, inputs};
use crepuscular_tests::suite::{self, Subject};
use std::sync::Arc;

use gpu_backend::gpu::{Context, Gpu, Queued};
use gpu_backend::{Backend, BufferOf, Cpu, Download};
use lighting::Emitter;
use lighting::methods::{
    About, Entry, Frame, FrameInputs, Method, MethodError, OfLight, Registry, Role, RunOn, Store,
    Verdict,
};
use lighting::scene::Emission;
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, RenderShadowMap};
use reference::metrics::image_error;
use reference::scenes::TestScene;
use reference::tolerances::Allowed;

crepuscular_tests::on_every_backend!(
    images_are_finite_and_added_to_what_is_there,
    no_quality_panics,
);
crepuscular_tests::on_every_backend!(heavy:
    the_best_quality_is_no_worse_than_the_worst_one,
);

/// Texels per side of shadow maps.
const MAP: u32 = 128;

/// The same light from everywhere: a method that only this test knows.
#[derive(Debug)]
struct Constant;

impl Method for Constant {
    fn about(&self) -> About {
        About {
            name: "constant".into(),
            title: "constant light",
            purpose: "an example",
            paper: "none",
            quality: "units",
            qualities: &[1, 2],
            quick: &[1],
            pictured: 1,
            usual: 1,
            role: Role::Variant,
            uses_shadow_map: false,
        }
    }

    fn applies(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }
}

impl<B: Backend> RunOn<B> for Constant {
    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let light = quality as f32;
        let all = vec![[light, light, light, 0.0]; frame.inputs.rays.len()];
        *radiance = frame.backend.upload(&all)?;
        Ok(())
    }
}

fn registry() -> Registry {
    Registry::standard().with(Constant)
}

/// A sun, a spotlight with a cookie, a lamp, hair and smoke, an area light.
const SCENES: [Embedded; 5] = [
    Embedded::Fence,
    Embedded::TexturedSpot,
    Embedded::Coil,
    Embedded::Translucent,
    Embedded::Pergola,
];

/// Calls `test` for each method that applies to each scene. The area light is for the
/// methods that no other scene shows: to others it is some lamps, each with six maps.
fn for_each(size: [u32; 2], mut test: impl FnMut(&TestScene, FrameInputs<'_>, &Entry)) {
    let mut shown = Vec::new();
    for_each_of(&SCENES, size, |scene, inputs, entry| {
        let name = entry.about().name;
        if inputs.areas.is_empty() || !shown.contains(&name) {
            test(scene, inputs, entry);
            shown.push(name);
        }
    });
}

/// The least quality that a comparison takes; of an area light a quarter of the points,
/// each of which has maps of its own.
fn least(about: &About) -> u32 {
    match about.quality {
        "points per area light" => about.quick[0] / 4,
        _ => about.quick[0],
    }
}

/// The same with some of the scenes.
fn for_each_of(
    scenes: &[Embedded],
    [width, height]: [u32; 2],
    mut test: impl FnMut(&TestScene, FrameInputs<'_>, &Entry),
) {
    let registry = registry();
    for &embedded in scenes {
        let scene = TestScene::new(embedded, width, height);
        let host = Store::new();
        let inputs = inputs(&scene, MAP, &host);
        for entry in registry.compared() {
            if entry.method().applies(&inputs) == Verdict::Applies {
                test(&scene, inputs, entry);
            }
        }
    }
}

fn images_are_finite_and_added_to_what_is_there<B: Subject>(backend: &B) {
    for_each([16, 9], |scene, inputs, entry| {
        let Some(method) = entry.on::<B>() else {
            return;
        };
        let about = entry.about();
        if about.name == "constant" {
            return;
        }
        let quality = least(&about);
        let store = Store::new();
        let frame = Frame::new(backend, inputs, &store).unwrap();
        let before = vec![[1.0, 2.0, 3.0, 4.0]; scene.rays.len()];
        let mut radiance = backend.upload(&before).unwrap();
        method.prepare(&frame, quality).unwrap();
        method.add_radiance(&frame, quality, &mut radiance).unwrap();
        let after = backend.download(&radiance).unwrap();
        for pixel in after {
            let [r, g, b, a] = pixel;
            let name = &about.name;
            assert!(pixel.iter().all(|c| c.is_finite()), "{name}: {pixel:?}");
            assert!(r >= 1.0 && g >= 2.0 && b >= 3.0, "{name}: {pixel:?}");
            assert_eq!(a, 4.0, "{name}");
        }
    });
}

/// Every number is a quality or an error that says what is expected. The quality of a
/// pair is that of its source if that has one: then one evaluator is enough, one whose
/// shader other tests need as well.
fn no_quality_panics<B: Subject>(backend: &B) {
    let registry = Registry::standard();
    let scene = TestScene::new(Embedded::TexturedSpot, 2, 2);
    let host = Store::new();
    let inputs = inputs(&scene, 16, &host);
    let mut sources = Vec::new();
    for entry in registry.compared().chain(registry.all()) {
        if let Some([(source, Some(_)), _]) = entry.halves() {
            if sources.contains(&source) {
                continue;
            }
            sources.push(source);
        }
        for quality in [0, 1, 7, 5000] {
            match image(backend, inputs, entry, quality) {
                Ok(_) => {}
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
}

fn the_best_quality_is_no_worse_than_the_worst_one<B: Subject>(backend: &B) {
    let registry = registry();
    for embedded in [Embedded::Fence, Embedded::Coil] {
        let scene = TestScene::new(embedded, 24, 14);
        let truth = scene.truth();
        let host = Store::new();
        let inputs = inputs(&scene, 512, &host);
        for entry in registry.compared() {
            let about = entry.about();
            let (qualities, _) = entry.method().distinct(&inputs, about.quick);
            let is_left_out = entry.method().applies(&inputs) != Verdict::Applies;
            if is_left_out || about.name == "constant" || qualities.len() < 2 {
                continue;
            }
            let ends = [qualities[0], qualities[qualities.len() - 1]];
            let errors = ends.map(|quality| {
                let image = image(backend, inputs, entry, quality).unwrap();
                image.map(|image| image_error(&image, &truth).rmse)
            });
            let [Some(worst), Some(best)] = errors else {
                continue;
            };
            println!("{} {}: {worst:.5} {best:.5}", scene.name, about.name);
            // Errors at a floor scatter by as much; see `Allowed::Order`.
            assert!(best <= 1.1 * worst, "{}: {worst} {best}", about.name);
        }
    }
}

#[test]
fn names_are_distinct_and_qualities_rise() {
    let registry = registry();
    for (index, entry) in registry.all().iter().enumerate() {
        let about = entry.about();
        let before = || registry.all()[..index].iter().map(Entry::about);
        assert!(before().all(|other| other.name != about.name), "{about:?}");
        assert!(about.qualities.is_sorted());
        if about.qualities.is_empty() {
            continue;
        }
        let others = || before().filter(|other| !other.qualities.is_empty());
        assert!(
            others().all(|other| other.title != about.title),
            "{about:?}"
        );
        for quality in about.quick.iter().chain([&about.pictured]) {
            assert!(about.qualities.contains(quality), "{about:?}");
        }
        assert!(!about.purpose.is_empty() && !about.paper.is_empty());
        assert_eq!(registry.find(&about.name).unwrap().about().name, about.name);
    }
}

#[test]
fn methods_are_found_by_any_of_their_names() {
    let registry = registry();
    let found = |filter: &str| registry.compared().filter(|e| e.matches(filter)).count();
    assert_eq!(found("march x midpoint"), 1);
    assert_eq!(found("march × midpoint"), 1);
    assert_eq!(found("exact"), 7);
    assert_eq!(found("Equi-Angular sampling"), 3);
    assert_eq!(found("constant"), 1);
    assert_eq!((found("no such thing"), found("")), (0, 0));
    assert!(registry.find("ray marching").is_some());
    assert!(
        registry.find("equi-angular").is_none(),
        "several are called so"
    );
    assert!(registry.pair("march", "table", None).is_some());
    let own = registry.pair("march", "gauss", Some(3)).unwrap();
    assert_eq!(own.about().name, "march x gauss-3");
    assert!(registry.pair("march", "no such thing", None).is_none());
    let reduced = |name: &str| Some(registry.find(name)?.about().name.into_owned());
    for name in [
        "hybrid x gauss-8 quarter",
        "march x midpoint 2x2 sixteenth gaussian",
    ] {
        assert_eq!(reduced(name).as_deref(), Some(name));
    }
    assert_eq!(reduced("constant 1/9").as_deref(), Some("constant 1/9"));
    for name in [
        "no such thing quarter",
        "gaussian",
        "2x2 quarter",
        "march quarter sixteenth",
        "area-runs 3x3 quarter sixteenth",
    ] {
        assert!(reduced(name).is_none(), "{name}");
    }
}

/// Threads change nothing, and neither does which methods ran before.
#[test]
fn images_do_not_depend_on_threads_or_on_what_is_in_the_store() {
    let (one, three) = (Cpu::single_threaded(), Cpu::with_threads(3).unwrap());
    for_each([16, 9], |_, inputs, entry| {
        let quality = least(&entry.about());
        let expected = image(&one, inputs, entry, quality).unwrap().unwrap();
        let actual = image(&three, inputs, entry, quality).unwrap().unwrap();
        assert_eq!(expected, actual, "{}", entry.about().name);
        // The same frame twice, from what the first has left in the store.
        let fresh = Store::new();
        for store in [&fresh, &fresh] {
            let frame = Frame::new(&one, inputs, store).unwrap();
            let mut radiance = vec![[0.0; 4]; inputs.rays.len()];
            let method = entry.on::<Cpu>().unwrap();
            method.add_radiance(&frame, quality, &mut radiance).unwrap();
            assert_eq!(radiance, expected, "{}", entry.about().name);
        }
    });
}

/// The relative error that the GPU may have along a ray past the lights of a scene.
fn allowed(scene: &TestScene, ray: usize) -> f64 {
    let ray = &scene.rays[ray];
    let of_light = |emitter: &Emitter| {
        let Emitter::Point(point) = emitter else {
            return Allowed::GpuRadiance.error();
        };
        let to_light = (point.position() - ray.origin()).as_dvec3();
        let h = to_light.cross(ray.direction().as_dvec3()).length();
        // Images put a light no closer to a ray than this.
        let ratio = (to_light.length() / h).min(1e4);
        Allowed::GpuRadiance.error() + ratio * Allowed::GpuRadianceNearTheAxis.error()
    };
    scene.emitters.iter().map(of_light).fold(0.0, f64::max)
}

/// What a light that shines everywhere would give: the measure of errors at the
/// borders of cones and of texels of a cookie.
fn without_borders(emitter: &Emitter) -> Emitter {
    match emitter {
        Emitter::Point(point) => Emitter::point(
            point.position(),
            point.intensity(),
            f32::INFINITY,
            Emission::Isotropic,
        )
        .unwrap(),
        other => other.clone(),
    }
}

/// Puts the shadow maps of the CPU into the store of a frame on the GPU.
fn share_maps(cpu: &Cpu, frame: &Frame<'_, Gpu<Queued>>) {
    let inputs = frame.inputs;
    let casters = Casters::upload(cpu, inputs.geometry).unwrap();
    for (light, emitter) in inputs.emitters.iter().enumerate() {
        let map = cpu.shadow_map(&casters, emitter, inputs.map).unwrap();
        let map = map.upload(frame.backend).unwrap();
        let resolution = inputs.map;
        let key = OfLight { light, resolution };
        frame.store.insert("shadow map", key, Arc::new(map), 0);
    }
}

/// Through the same shadow maps, which rasterisers render differently at edges.
/// Errors are relative to the light without shadows, cones and cookies. Methods that
/// make many lights of an area light, with maps of their own, read a thousand bits for
/// a ray, of which one may differ; their folder has a test that allows for that.
#[test]
fn both_backends_agree_on_every_method_but_for_rays_at_an_edge() {
    let Some(gpu) = suite::gpu() else { return };
    let cpu = Cpu::new();
    let unshadowed = Registry::standard().pair("none", "gauss", None).unwrap();
    for_each_of(&SCENES[..4], [48, 27], |scene, inputs, entry| {
        let about = entry.about();
        let quality = least(&about);
        let Some(method) = entry.on::<Gpu<Queued>>() else {
            return;
        };
        let store = Store::new();
        let frame = Frame::new(&gpu, inputs, &store).unwrap();
        if about.uses_shadow_map {
            share_maps(&cpu, &frame);
        }
        let mut radiance = gpu.zeros::<[f32; 4]>(scene.rays.len()).unwrap();
        method.add_radiance(&frame, quality, &mut radiance).unwrap();
        let actual = gpu.download(&radiance).unwrap();
        let expected = image(&cpu, inputs, entry, quality).unwrap().unwrap();
        let bare: Vec<Emitter> = scene.emitters.iter().map(without_borders).collect();
        let everywhere = FrameInputs {
            emitters: &bare,
            ..inputs
        };
        let scale = image(&cpu, everywhere, &unshadowed, 8).unwrap().unwrap();
        let differs = |i: &usize| {
            (0..3).any(|c| {
                let (e, g) = (f64::from(expected[*i][c]), f64::from(actual[*i][c]));
                let scale = f64::from(scale[*i][c].max(f32::MIN_POSITIVE)).max(e);
                (e - g).abs() > scale * allowed(scene, *i)
            })
        };
        let different = (0..expected.len()).filter(differs).count();
        let share = different as f64 / expected.len() as f64;
        println!("{} {}: {different} rays differ", scene.name, about.name);
        assert!(
            share <= Allowed::GpuRays.error() * scene.emitters.len() as f64,
            "{} {}: {different} of {} rays differ",
            scene.name,
            about.name,
            expected.len()
        );
    });
}

#[test]
fn every_method_records_into_an_encoder_of_the_users() {
    let Some(queued) = suite::gpu() else { return };
    let context: &Context = queued.context();
    let mut recorded = Vec::new();
    for_each([16, 9], |_, inputs, entry| {
        let about = entry.about();
        // Once is enough: the commands are the same in every scene.
        if recorded.contains(&about.name) {
            return;
        }
        recorded.push(about.name.clone());
        let quality = least(&about);
        let Some(expected) = image(&queued, inputs, entry, quality).unwrap() else {
            return;
        };
        let device = context.device();
        let mut encoder = device.create_command_encoder(&Default::default());
        let store = Store::new();
        let radiance = {
            let recording = Gpu::record(context, &mut encoder);
            let frame = Frame::new(&recording, inputs, &store).unwrap();
            let mut radiance = recording.zeros::<[f32; 4]>(inputs.rays.len()).unwrap();
            let method = entry.on::<Gpu<gpu_backend::gpu::Recording<'_>>>().unwrap();
            method.prepare(&frame, quality).unwrap();
            method.add_radiance(&frame, quality, &mut radiance).unwrap();
            radiance
        };
        context.queue().submit([encoder.finish()]);
        let actual = queued.download(&radiance).unwrap();
        assert_eq!(actual, expected, "{}", about.name);
    });
}
