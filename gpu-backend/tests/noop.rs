//! What can be checked without an adapter: everything the host does. The
//! device checks all commands and runs none of them.

mod steps;

use gpu_backend::gpu::{Argument, Clock, Context, Gpu, Kernel, Queued, Workgroups};
use gpu_backend::{Backend, Download, Error, testing::Shader};
use steps::Steps;

fn noop(limits: wgpu::Limits) -> Gpu<Queued> {
    let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor {
        required_limits: limits,
        ..wgpu::DeviceDescriptor::default()
    });
    Gpu::from_device(device, queue)
}

#[test]
fn steps_record_and_submit_without_a_complaint() {
    let gpu = noop(wgpu::Limits::defaults());
    for len in [0, 1, 65, 10_000] {
        let data = gpu.upload(&vec![1_u32; len]).unwrap();
        let mut out = gpu.scramble(&data, 1).unwrap();
        gpu.add(&mut out, 2).unwrap();
        gpu.write(&mut out, &vec![3; len]).unwrap();
        assert_eq!(gpu.download(&out).unwrap().len(), len);
    }
    let mut encoder = gpu
        .context()
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recording = Gpu::record(gpu.context(), &mut encoder);
    let data = recording.upload(&[1_u32, 2]).unwrap();
    recording.scramble(&data, 1).unwrap();
    gpu.context()
        .scoped("the caller's submit", || {
            gpu.context().queue().submit([encoder.finish()])
        })
        .unwrap();
}

#[test]
fn the_smallest_limits_that_can_compute_are_enough() {
    let gpu = noop(wgpu::Limits {
        max_storage_buffers_per_shader_stage: 2,
        max_uniform_buffers_per_shader_stage: 1,
        max_bind_groups: 1,
        ..wgpu::Limits::downlevel_defaults()
    });
    let data = gpu.upload(&[1_u32; 100]).unwrap();
    gpu.scramble(&data, 1).unwrap();
    gpu.wait().unwrap();
    let error = gpu
        .dispatch(&steps::NOTHING, &[&[], &[]], Workgroups::Grid([1; 3]))
        .unwrap_err();
    assert!(matches!(error, Error::Limit { limit: 1, .. }), "{error}");
}

#[test]
fn a_device_without_compute_is_refused_step_by_step() {
    let gpu = noop(wgpu::Limits::downlevel_webgl2_defaults());
    let error = gpu.upload(&[1_u32]).unwrap_err();
    assert!(matches!(error, Error::TooLarge { limit: 0, .. }), "{error}");
    let error = gpu
        .dispatch(&steps::NOTHING, &[], Workgroups::covering(1, 1))
        .unwrap_err();
    assert!(matches!(error, Error::Limit { limit: 0, .. }), "{error}");
}

#[test]
fn many_parameters_outlive_the_buffer_they_share() {
    let gpu = noop(wgpu::Limits::defaults());
    let mut data = gpu.upload(&[1_u32]).unwrap();
    // 64 KiB hold 256 of them.
    for key in 0..1000 {
        gpu.add(&mut data, key).unwrap();
    }
    gpu.wait().unwrap();
    let large = Argument::uniform([[0_u32; 4]; 4096]);
    let kernel = Kernel {
        label: "large parameters",
        parts: &[
            "@group(0) @binding(0) var<uniform> a: array<vec4<u32>, 4096>;
            @compute @workgroup_size(1) fn main() { _ = a[0]; }",
        ],
        entry: "main",
        constants: &[],
    };
    gpu.dispatch(&kernel, &[&[large]], Workgroups::Grid([1; 3]))
        .unwrap();
    gpu.wait().unwrap();
    let error = gpu
        .dispatch(
            &kernel,
            &[&[Argument::uniform([[0_u32; 4]; 4097])]],
            Workgroups::Grid([1; 3]),
        )
        .unwrap_err();
    assert!(
        matches!(
            error,
            Error::TooLarge {
                limit: 65536,
                requested: 65552,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn without_time_stamps_the_hosts_clock_is_used() {
    let gpu = noop(wgpu::Limits::defaults());
    let mut runs = 0;
    let timing = gpu
        .time(3, || {
            runs += 1;
            Ok(())
        })
        .unwrap();
    assert_eq!((runs, timing.clock), (3, Clock::Host));
    let failing = gpu.time(0, || Err(Error::Aliased { what: "a test" }));
    assert_eq!(failing, Err(Error::Aliased { what: "a test" }));
}

#[test]
fn pipelines_are_built_once_per_device_and_shared_by_its_handles() {
    let gpu = noop(wgpu::Limits::defaults());
    let other = Gpu::new(gpu.context().clone());
    let built = |gpu: &Gpu<Queued>| {
        gpu.context()
            .cached("a value", "key", |_| Ok(std::thread::current().id()))
            .unwrap()
    };
    let first = built(&gpu);
    let again = std::thread::scope(|scope| scope.spawn(|| built(&other)).join().unwrap());
    assert_eq!(first, again);
}

#[test]
fn mistakes_of_whoever_builds_a_pipeline_come_back_to_him() {
    let context = noop(wgpu::Limits::defaults()).context().clone();
    let build = |context: &Context, size| {
        context.cached("a buffer too many", size, |device| {
            Ok(device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage: wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            }))
        })
    };
    let error = build(&context, 1 << 40).unwrap_err();
    assert!(error.to_string().contains("a buffer too many"), "{error}");
    build(&context, 4).unwrap();
}

#[test]
fn the_shaders_of_these_tests_compile() {
    for kernel in [steps::SCRAMBLE, steps::ADD, steps::NOTHING] {
        Shader::new(kernel.parts).unwrap();
    }
    Shader::new(&[gpu_backend::gpu::INDEX_WGSL])
        .and_then(|shader| shader.require_part(&["gpu_"]))
        .unwrap();
}
