//! Devices that offer little and devices that go away: every step and every method gives its
//! result or an error that says why there is none.

mod steps;

use std::sync::atomic::{AtomicBool, Ordering};

use crepuscular_tests::frames::{image, inputs};
use crepuscular_tests::suite;
use gpu_backend::gpu::{ADAPTER_VARIABLE, Context, Gpu, GpuMemory, Queued};
use gpu_backend::{Backend, Download, Error, Host};
use lighting::Watch;
use lighting::methods::{Entry, Frame, FrameInputs, MethodError, Registry, Store, Verdict};
use lighting::scene::procedural::Embedded;
use lighting::shadow_map::{Casters, RenderShadowMap};
use reference::scenes::TestScene;
use steps::Steps;

/// Texels per side of shadow maps.
const MAP: u32 = 32;

/// A device of the test's own with what `change` leaves of WebGPU's default limits, or `None` if
/// there is no adapter.
fn device(change: impl FnOnce(&mut wgpu::Limits)) -> Option<Gpu<Queued>> {
    suite::gpu()?;
    let mut limits = wgpu::Limits::defaults();
    change(&mut limits);
    let name = std::env::var(ADAPTER_VARIABLE).unwrap_or_default();
    Some(Gpu::new(
        Context::request_named(&name, Some(limits)).unwrap(),
    ))
}

/// The methods of a comparison that apply, of those with one source only the first: what
/// evaluators need is the same for all sources.
fn methods<'r>(registry: &'r Registry, inputs: &FrameInputs<'_>) -> Vec<&'r Entry> {
    let mut sources = Vec::new();
    let mut is_new = |entry: &&Entry| {
        let Some([(source, _), _]) = entry.halves() else {
            return true;
        };
        let is_new = !sources.contains(&source);
        sources.push(source);
        is_new
    };
    let applies = |entry: &&Entry| {
        let runs = entry.on::<Gpu<Queued>>().is_some();
        runs && entry.method().applies(inputs) == Verdict::Applies
    };
    registry
        .compared()
        .filter(applies)
        .filter(|entry| is_new(entry))
        .collect()
}

/// The least quality of a comparison.
fn least(entry: &Entry) -> u32 {
    entry.about().quick[0]
}

/// Whether an error names a limit, and nothing was left to the checks of the driver.
fn names_a_limit(error: &MethodError) -> bool {
    let text = error.to_string();
    ["limit is", "fit", "are left"]
        .iter()
        .any(|words| text.contains(words))
}

/// The picture on a device with lower limits is that of one without them, bit for bit, or an
/// error names the limit. Returns how many pictures and how many errors there were.
fn pictures_or_limits(small: &Gpu<Queued>, scenes: &[Embedded]) -> [usize; 2] {
    let whole = device(|_| ()).unwrap();
    let registry = Registry::standard();
    let mut counts = [0; 2];
    for &embedded in scenes {
        let scene = TestScene::new(embedded, 16, 9);
        let host = Store::new();
        let inputs = inputs(&scene, MAP, &host);
        for entry in methods(&registry, &inputs) {
            let name = entry.about().name;
            match image(small, inputs, entry, least(entry)) {
                Ok(found) => {
                    let expected = image(&whole, inputs, entry, least(entry)).unwrap();
                    assert_eq!(found, expected, "{name} in {}", scene.name);
                    counts[0] += 1;
                }
                Err(error) => {
                    assert!(names_a_limit(&error), "{name} in {}: {error:?}", scene.name);
                    counts[1] += 1;
                }
            }
        }
    }
    counts
}

#[test]
fn small_bindings_give_pictures_or_errors_that_name_them() {
    let small = device(|limits| {
        limits.max_storage_buffer_binding_size = 1 << 16;
        limits.max_buffer_size = 1 << 16;
        limits.max_uniform_buffer_binding_size = 1 << 12;
    });
    let Some(small) = small else { return };
    let [pictures, errors] =
        pictures_or_limits(&small, &[Embedded::TexturedSpot, Embedded::Translucent]);
    assert!(pictures > 0 && errors > 0, "{pictures} {errors}");
}

#[test]
fn few_bindings_and_small_dispatches_give_pictures_or_errors_that_name_them() {
    let small = device(|limits| {
        limits.max_storage_buffers_per_shader_stage = 4;
        limits.max_compute_workgroups_per_dimension = 16;
        limits.max_texture_dimension_2d = 64;
    });
    let Some(small) = small else { return };
    let [pictures, errors] =
        pictures_or_limits(&small, &[Embedded::TexturedSpot, Embedded::Translucent]);
    assert!(pictures > 0 && errors > 0, "{pictures} {errors}");
}

#[test]
fn shadow_maps_beyond_the_limits_of_webgpu_are_refused_before_anything_is_allocated() {
    let Some(gpu) = device(|_| ()) else { return };
    let scene = TestScene::new(Embedded::TexturedSpot, 4, 3);
    let casters = Casters::upload(&gpu, &scene.geometry).unwrap();
    let map = |resolution| gpu.shadow_map(&casters, &scene.emitters[0], resolution);
    // Four bytes a texel: 128 MiB are 5792².
    for resolution in [8192, 16384, 65536] {
        let error = map(resolution).unwrap_err().to_string();
        assert!(
            error.contains("limit is") || error.contains("fit"),
            "{error}"
        );
    }
    assert!(map(64).is_ok());
}

/// Whether a failure says that the device was lost.
fn says_lost<T>(result: Result<T, MethodError>) -> bool {
    result.is_err_and(|error| error.to_string().contains("the device was lost"))
}

#[test]
fn a_lost_device_is_an_error_of_every_method_whether_all_is_prepared_or_nothing() {
    let Some(gpu) = device(|_| ()) else { return };
    let registry = Registry::standard();
    let scenes = [
        Embedded::TexturedSpot,
        Embedded::Translucent,
        Embedded::Pergola,
    ]
    .map(|embedded| (TestScene::new(embedded, 4, 3), Store::<Host>::new()));
    let store = || Store::<GpuMemory>::new();
    let mut prepared = Vec::new();
    let mut shown = Vec::new();
    for (scene, host) in &scenes {
        let inputs = inputs(scene, 8, host);
        for entry in methods(&registry, &inputs) {
            let name = entry.about().name;
            // An area light is for the methods that no other scene shows.
            if inputs.areas.is_empty() || !shown.contains(&name) {
                prepared.push((inputs, entry, [store(), store()]));
                shown.push(name);
            }
        }
    }
    let frames: Vec<_> = prepared
        .iter()
        .map(|(inputs, entry, [full, empty])| {
            let frame = |store| Frame::new(&gpu, *inputs, store).unwrap();
            let mut radiance = gpu.zeros::<[f32; 4]>(inputs.rays.len()).unwrap();
            let method = entry.on::<Gpu<Queued>>().unwrap();
            let frames = [frame(full), frame(empty)];
            method
                .add_radiance(&frames[0], least(entry), &mut radiance)
                .unwrap();
            (frames, radiance)
        })
        .collect();
    gpu.wait().unwrap();
    assert_eq!(gpu.check_alive(), Ok(()));
    gpu.context().device().destroy();
    assert!(matches!(gpu.check_alive(), Err(Error::DeviceLost { .. })));
    for ((inputs, entry, _), (frames, mut radiance)) in prepared.iter().zip(frames) {
        let name = entry.about().name;
        let method = entry.on::<Gpu<Queued>>().unwrap();
        for (frame, what) in frames.iter().zip(["prepared", "not prepared"]) {
            let result = method.add_radiance(frame, least(entry), &mut radiance);
            assert!(says_lost(result), "{name}, {what}");
        }
        let store = store();
        assert!(says_lost(Frame::new(&gpu, *inputs, &store)), "{name}");
        assert!(
            says_lost(image(&gpu, *inputs, entry, least(entry))),
            "{name}"
        );
    }
}

/// Destroys a device once a light has been gathered.
struct Destroys<'a> {
    device: &'a wgpu::Device,
    done: AtomicBool,
}

impl Watch for Destroys<'_> {
    fn goes_on(&self, done: usize, _: usize) -> bool {
        if done > 0 {
            self.device.destroy();
            self.done.store(true, Ordering::Relaxed);
        }
        true
    }
}

#[test]
fn a_device_that_is_lost_between_two_lights_ends_the_method() {
    let registry = Registry::standard();
    let scene = TestScene::new(Embedded::TexturedSpot, 4, 3);
    let emitters = [scene.emitters[0].clone(), scene.emitters[0].clone()];
    let host = Store::new();
    for (visibility, airlight) in [
        ("none", "gauss"),
        ("march", "midpoint"),
        ("voxel-runs", "gauss"),
    ] {
        let Some(gpu) = device(|_| ()) else { return };
        let watch = Destroys {
            device: gpu.context().device(),
            done: AtomicBool::new(false),
        };
        let inputs = FrameInputs {
            emitters: &emitters,
            watch: &watch,
            ..inputs(&scene, 8, &host)
        };
        let entry = registry.pair(visibility, airlight, None).unwrap();
        let store = Store::new();
        let frame = Frame::new(&gpu, inputs, &store).unwrap();
        let mut radiance = gpu.zeros::<[f32; 4]>(inputs.rays.len()).unwrap();
        let method = entry.on::<Gpu<Queued>>().unwrap();
        let quality = least(&entry);
        let result = method
            .prepare(&frame, quality)
            .and_then(|()| method.add_radiance(&frame, quality, &mut radiance));
        assert!(says_lost(result), "{visibility}");
        assert!(watch.done.into_inner(), "{visibility}");
    }
}

#[test]
fn a_lost_device_is_an_error_of_every_step() {
    let Some(gpu) = device(|_| ()) else { return };
    let mut steps = Steps::new(&gpu);
    for (name, result) in steps.run(&gpu) {
        result.unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    gpu.wait().unwrap();
    let device = gpu.context().device();
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    device.destroy();
    let recording = Gpu::record(gpu.context(), &mut encoder);
    for (name, result) in steps.run(&gpu).into_iter().chain(steps.run(&recording)) {
        let error = result.expect_err(name).to_string();
        assert!(error.contains("the device was lost"), "{name}: {error}");
    }
}
