//! What every user of a GPU handle may rely on.

mod steps;

use gpu_backend::gpu::{Argument, Context, Encode, Gpu, GpuBuffer, Kernel, Workgroups};
use gpu_backend::{Backend, Buffer, Download, Error, testing};
use steps::{Steps, scramble};

#[test]
fn any_length_works_on_any_backend() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = gpu_backend::Cpu::new();
    for len in [0, 1, 2, 63, 64, 65, 127, 1000, 65_537] {
        let data: Vec<u32> = (0..len).map(|i| i * 7).collect();
        let run = |mut steps: Vec<u32>| {
            let up = gpu.upload(&steps)?;
            let out = gpu.scramble(&up, 3)?;
            assert_eq!(out.len(), steps.len());
            steps = gpu.download(&out)?;
            Ok::<_, Error>(steps)
        };
        let host = cpu.scramble(&data, 3).unwrap();
        assert_eq!(run(data).unwrap(), host, "{len}");
    }
}

#[test]
fn more_workgroups_than_fit_in_one_dimension_are_folded() {
    let Some(gpu) = testing::gpu() else { return };
    let limit = gpu.context().limits().max_compute_workgroups_per_dimension as usize;
    let len = (limit + 2) * steps::GROUP as usize + 1;
    let zeros = gpu.zeros::<u32>(len).unwrap();
    let out = gpu.download(&gpu.scramble(&zeros, 5).unwrap()).unwrap();
    for (i, value) in (0..).zip(out) {
        assert_eq!(value, scramble(i, 0, 5));
    }
}

#[test]
fn elements_of_odd_sizes_come_back_as_they_went() {
    let Some(gpu) = testing::gpu() else { return };
    for len in [0, 1, 2, 3, 4, 5, 33] {
        let bytes: Vec<u8> = (0..len).collect();
        assert_eq!(gpu.download(&gpu.upload(&bytes).unwrap()).unwrap(), bytes);
        let triples: Vec<[u16; 3]> = (0..u16::from(len)).map(|i| [i, 2 * i, 3 * i]).collect();
        let buffer = gpu.upload(&triples).unwrap();
        assert_eq!(gpu.download(&buffer).unwrap(), triples);
        let mut copy = gpu.zeros::<[u16; 3]>(triples.len()).unwrap();
        assert!(gpu.download(&copy).unwrap().iter().all(|t| *t == [0; 3]));
        gpu.copy(&buffer, &mut copy).unwrap();
        assert_eq!(gpu.download(&copy).unwrap(), triples);
    }
}

#[test]
fn five_steps_are_one_submit_and_one_read_back() {
    let Some(gpu) = testing::gpu() else { return };
    let mut buffer = gpu.upload(&[1_u32, 2, 3]).unwrap();
    for key in 0..5 {
        buffer = gpu.scramble(&buffer, key).unwrap();
    }
    assert_eq!(gpu.statistics().submits, 0);
    gpu.download(&buffer).unwrap();
    let done = gpu.statistics();
    assert_eq!((done.dispatches, done.submits, done.read_backs), (5, 1, 1));
}

#[test]
fn results_do_not_depend_on_how_many_steps_share_a_submit() {
    let Some(gpu) = testing::gpu() else { return };
    let data: Vec<u32> = (0..777).collect();
    let run = |submit_every: u32| {
        let mut buffer = gpu.upload(&data).unwrap();
        for key in 0..12 {
            buffer = gpu.scramble(&buffer, key).unwrap();
            // In place as well: the order of the steps matters.
            gpu.add(&mut buffer, key).unwrap();
            if key % submit_every == 0 {
                gpu.submit().unwrap();
            }
        }
        gpu.download(&buffer).unwrap()
    };
    let one_by_one = run(1);
    for submit_every in [2, 5, 100] {
        assert_eq!(run(submit_every), one_by_one);
    }
}

#[test]
fn a_write_falls_between_the_steps_around_it() {
    let Some(gpu) = testing::gpu() else { return };
    let mut buffer = gpu.upload(&[1_u32, 2]).unwrap();
    let before = gpu.scramble(&buffer, 0).unwrap();
    gpu.write(&mut buffer, &[10, 20]).unwrap();
    let after = gpu.scramble(&buffer, 0).unwrap();
    let expect = |data: [u32; 2]| [scramble(0, data[0], 0), scramble(1, data[1], 0)];
    assert_eq!(gpu.download(&before).unwrap(), expect([1, 2]));
    assert_eq!(gpu.download(&after).unwrap(), expect([10, 20]));
}

#[test]
fn steps_recorded_by_the_caller_equal_queued_ones() {
    let Some(gpu) = testing::gpu() else { return };
    let context = gpu.context();
    let data: Vec<u32> = (100..300).collect();
    let queued = {
        let up = gpu.upload(&data).unwrap();
        let mut out = gpu.scramble(&gpu.scramble(&up, 1).unwrap(), 2).unwrap();
        gpu.add(&mut out, 9).unwrap();
        gpu.download(&out).unwrap()
    };
    // The caller's buffer is longer than what is used of it.
    let own = context.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 4 * 256,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    context
        .queue()
        .write_buffer(&own, 0, bytemuck::cast_slice(&data));
    let mut encoder = context
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let out = {
        let recording = Gpu::record(context, &mut encoder);
        let own = GpuBuffer::<u32>::from_wgpu(own, data.len()).unwrap();
        let once = recording.scramble(&own, 1).unwrap();
        let mut out = recording.scramble(&once, 2).unwrap();
        recording.add(&mut out, 9).unwrap();
        assert_eq!(recording.statistics().submits, 0);
        out
    };
    context.queue().submit([encoder.finish()]);
    assert_eq!(gpu.download(&out).unwrap(), queued);
}

#[test]
fn eight_threads_share_a_device_and_a_handle() {
    let Some(shared) = testing::gpu() else { return };
    for run in 0..60 {
        std::thread::scope(|scope| {
            for thread in 0..8_u32 {
                let shared = &shared;
                scope.spawn(move || {
                    let own = Gpu::new(shared.context().clone());
                    // Half of the threads record on one handle.
                    let gpu = if thread % 2 == 0 { shared } else { &own };
                    let len = 1 + (run * 13 + thread * 7) % 200;
                    let data: Vec<u32> = (0..len).collect();
                    let mut buffer = gpu.upload(&data).unwrap();
                    for key in 0..3 {
                        buffer = gpu.scramble(&buffer, key + thread).unwrap();
                    }
                    let expected = data
                        .iter()
                        .map(|&i| (0..3).fold(i, |value, key| scramble(i, value, key + thread)));
                    assert!(gpu.download(&buffer).unwrap().into_iter().eq(expected));
                });
            }
        });
    }
}

#[test]
fn two_devices_live_side_by_side() {
    let Some(first) = testing::gpu() else { return };
    let second = Gpu::request().unwrap();
    let data = [5_u32, 6, 7];
    let a = first.scramble(&first.upload(&data).unwrap(), 1).unwrap();
    let b = second.scramble(&second.upload(&data).unwrap(), 1).unwrap();
    assert_eq!(first.download(&a).unwrap(), second.download(&b).unwrap());
    drop(first);
    assert_eq!(second.download(&b).unwrap().len(), 3);
}

/// All calls after the loss of the device.
fn everything_fails<E: Encode>(gpu: &Gpu<E>, buffer: &GpuBuffer<u32>) {
    let lost = |result: Result<(), Error>| {
        assert!(
            matches!(result, Err(Error::DeviceLost { .. })),
            "{result:?}"
        );
    };
    lost(gpu.upload(&[1_u32]).map(drop));
    lost(gpu.upload::<u32>(&[]).map(drop));
    lost(gpu.zeros::<u32>(4).map(drop));
    lost(gpu.scramble(buffer, 1).map(drop));
    lost(gpu.dispatch(&steps::NOTHING, &[], Workgroups::Grid([1; 3])));
    lost(gpu.dispatch(&steps::NOTHING, &[], Workgroups::Grid([0; 3])));
}

#[test]
fn a_lost_device_is_an_error_on_the_next_call_and_nothing_hangs() {
    if testing::gpu().is_none() {
        return;
    }
    // A device of ours and one whose handlers belong to somebody else.
    let ours = Gpu::request().unwrap();
    let theirs = {
        let gpu = Gpu::request().unwrap();
        let context = gpu.context();
        Gpu::from_device(context.device().clone(), context.queue().clone())
    };
    for gpu in [ours, theirs] {
        let buffer = gpu.upload(&[1_u32, 2, 3]).unwrap();
        let mut pending = gpu.scramble(&buffer, 1).unwrap();
        gpu.context().device().destroy();
        let lost = |result: Result<(), Error>| {
            assert!(
                matches!(result, Err(Error::DeviceLost { .. })),
                "{result:?}"
            );
        };
        lost(gpu.download(&pending).map(drop));
        lost(gpu.wait());
        lost(gpu.submit());
        lost(gpu.time(2, || Ok(())).map(drop));
        lost(gpu.copy(&buffer, &mut pending));
        everything_fails(&gpu, &buffer);
        let context = gpu.context();
        let mut encoder = context
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        everything_fails(&Gpu::record(context, &mut encoder), &buffer);
    }
}

#[test]
fn too_large_is_an_error_before_anything_is_allocated() {
    let Some(gpu) = testing::gpu() else { return };
    let limits = gpu.context().limits();
    let largest = limits
        .max_buffer_size
        .min(limits.max_storage_buffer_binding_size);
    for len in [largest as usize / 4 + 1, usize::MAX / 2, usize::MAX] {
        match gpu.zeros::<u32>(len).unwrap_err() {
            Error::TooLarge {
                requested, limit, ..
            } => {
                assert_eq!(limit, largest);
                assert_eq!(requested, (len as u64).saturating_mul(4));
            }
            error => panic!("{error}"),
        }
    }
}

#[test]
fn small_limits_suffice_and_are_kept() {
    if testing::gpu().is_none() {
        return;
    }
    let small = wgpu::Limits {
        max_storage_buffers_per_shader_stage: 2,
        max_uniform_buffers_per_shader_stage: 1,
        max_storage_buffer_binding_size: 1 << 16,
        max_buffer_size: 1 << 16,
        max_compute_workgroups_per_dimension: 16,
        max_uniform_buffer_binding_size: 1 << 10,
        ..wgpu::Limits::downlevel_defaults()
    };
    let gpu = Gpu::new(Context::request_named("", Some(small)).unwrap());
    // 129 workgroups, folded into rows of at most 16.
    let data: Vec<u32> = (0..8193).collect();
    let out = gpu.scramble(&gpu.upload(&data).unwrap(), 1).unwrap();
    let out = gpu.download(&out).unwrap();
    assert!((0..).zip(out).all(|(i, value)| value == scramble(i, i, 1)));

    let too_large = gpu.zeros::<u32>((1 << 14) + 1).unwrap_err();
    assert!(matches!(too_large, Error::TooLarge { limit: 65536, .. }));
    let too_many = gpu
        .dispatch(&steps::NOTHING, &[], Workgroups::covering(257, 1))
        .unwrap_err();
    assert!(
        matches!(too_many, Error::Limit { limit: 16, .. }),
        "{too_many}"
    );
    let (a, b) = (gpu.zeros::<u32>(4).unwrap(), gpu.zeros::<u32>(4).unwrap());
    let arguments = [&a, &b, &a].map(Argument::read);
    let error = gpu
        .dispatch(&steps::NOTHING, &[&arguments], Workgroups::Grid([1; 3]))
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "do nothing needs 3 storage bindings, but the device's limit is 2"
    );
}

#[test]
fn mistakes_in_shaders_and_bindings_are_errors_and_not_panics() {
    let Some(gpu) = testing::gpu() else { return };
    let buffer = gpu.upload(&[1_u32]).unwrap();
    let rejected = |kernel: &Kernel<'_>, arguments: &[Argument<'_>]| {
        let error = gpu
            .dispatch(kernel, &[arguments], Workgroups::Grid([1; 3]))
            .unwrap_err();
        assert!(matches!(error, Error::Rejected { .. }), "{error}");
        error.to_string()
    };
    let broken = Kernel {
        parts: &["fn main( {"],
        ..steps::NOTHING
    };
    assert!(rejected(&broken, &[]).starts_with("do nothing was rejected"));
    let no_entry = Kernel {
        entry: "missing",
        ..steps::NOTHING
    };
    rejected(&no_entry, &[]);
    let no_override = Kernel {
        constants: &[("MISSING", 1.0)],
        ..steps::NOTHING
    };
    rejected(&no_override, &[]);
    // The kernel needs bindings that it is not given.
    rejected(&steps::SCRAMBLE, &[Argument::read(&buffer)]);
    // The handle still works, and the failure was not kept.
    let out = gpu.scramble(&buffer, 2).unwrap();
    assert_eq!(gpu.download(&out).unwrap(), [scramble(0, 1, 2)]);
}

#[test]
fn mistakes_in_the_callers_commands_come_back_when_they_are_submitted() {
    let Some(gpu) = testing::gpu() else { return };
    let buffer = gpu.upload(&[1_u32]).unwrap();
    let beyond_its_end = |encoder: &mut wgpu::CommandEncoder| {
        encoder.clear_buffer(buffer.as_wgpu(), 0, Some(1 << 20));
    };
    gpu.with_encoder("a clear", beyond_its_end).unwrap();
    let error = gpu.download(&buffer).unwrap_err();
    assert!(matches!(error, Error::Rejected { .. }), "{error}");
    assert_eq!(gpu.download(&buffer).unwrap(), [1]);
}

#[test]
fn buffers_of_the_caller_are_checked() {
    let Some(gpu) = testing::gpu() else { return };
    let make = |size, usage| {
        gpu.context()
            .device()
            .create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
    };
    let (storage, copy) = (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::COPY_SRC);
    for (size, usage, len) in [
        (16, copy, 1),
        (16, storage, 5),
        (0, storage, 0),
        (7, storage, 2),
        (16, storage, usize::MAX),
    ] {
        let error = GpuBuffer::<u32>::from_wgpu(make(size, usage), len).unwrap_err();
        assert!(matches!(error, Error::UnsuitableBuffer { .. }), "{error}");
    }
    let unreadable = GpuBuffer::<u32>::from_wgpu(make(16, storage), 4).unwrap();
    let error = gpu.download(&unreadable).unwrap_err();
    assert!(error.to_string().contains("COPY_SRC"), "{error}");

    let both = make(16, storage | copy);
    let read = GpuBuffer::<u32>::from_wgpu(both.clone(), 4).unwrap();
    let mut write = GpuBuffer::<u32>::from_wgpu(both, 4).unwrap();
    let error = gpu
        .dispatch(
            &steps::NOTHING,
            &[&[Argument::read(&read)], &[Argument::write(&mut write)]],
            Workgroups::Grid([1; 3]),
        )
        .unwrap_err();
    assert!(matches!(error, Error::Aliased { .. }), "{error}");
}

#[test]
fn groups_without_bindings_leave_the_numbers_of_the_others_alone() {
    let Some(gpu) = testing::gpu() else { return };
    let mut out = gpu.zeros::<u32>(1).unwrap();
    let kernel = Kernel {
        label: "three groups",
        parts: &[
            "@group(2) @binding(0) var<storage, read_write> out: array<u32>;
            override VALUE: u32;
            @compute @workgroup_size(1) fn main() { out[0] = VALUE; } // end",
        ],
        entry: "main",
        constants: &[("VALUE", 77.0)],
    };
    gpu.dispatch(
        &kernel,
        &[&[], &[], &[Argument::write(&mut out)]],
        Workgroups::Grid([1; 3]),
    )
    .unwrap();
    let other = Kernel {
        constants: &[("VALUE", 78.0)],
        ..kernel
    };
    assert_eq!(gpu.download(&out).unwrap(), [77]);
    gpu.dispatch(
        &other,
        &[&[], &[], &[Argument::write(&mut out)]],
        Workgroups::Grid([1; 3]),
    )
    .unwrap();
    assert_eq!(
        gpu.download(&out).unwrap(),
        [78],
        "constants tell kernels apart"
    );
}

#[test]
fn depths_of_arrays_and_cubes_are_read_where_they_are() {
    const READ: &str = "
        @group(0) @binding(0) var layers: texture_depth_2d_array;
        @group(0) @binding(1) var cube: texture_depth_cube;
        @group(0) @binding(2) var nearest: sampler;
        @group(0) @binding(3) var<storage, read_write> results: array<vec2<f32>>;
        @compute @workgroup_size(6)
        fn read(@builtin(local_invocation_index) i: u32) {
            var way = vec3(0.0);
            way[i / 2u] = 1.0 - 2.0 * f32(i % 2u);
            results[i] = vec2(
                textureLoad(layers, vec2(0u), i, 0),
                textureSampleLevel(cube, nearest, way, 0),
            );
        }";
    let Some(gpu) = testing::gpu() else { return };
    let device = gpu.context().device();
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 2,
            height: 2,
            depth_or_array_layers: 6,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = |dimension, first, count| {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            base_array_layer: first,
            array_layer_count: Some(count),
            ..Default::default()
        })
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    for face in 0..6 {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view(wgpu::TextureViewDimension::D2, face, 1),
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(face as f32 / 8.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
    }
    gpu.context().queue().submit([encoder.finish()]);
    let nearest = device.create_sampler(&wgpu::SamplerDescriptor::default());
    let [layers, cube] = [
        wgpu::TextureViewDimension::D2Array,
        wgpu::TextureViewDimension::Cube,
    ];
    let views = [view(layers, 0, 6), view(cube, 0, 6)];
    let depth = wgpu::TextureSampleType::Depth;
    let mut results = gpu.zeros::<[f32; 2]>(6).unwrap();
    gpu.dispatch(
        &Kernel {
            label: "read depths",
            parts: &[READ],
            entry: "read",
            constants: &[],
        },
        &[&[
            Argument::texture_of(&views[0], depth, layers),
            Argument::texture_of(&views[1], depth, cube),
            Argument::sampler(&nearest, wgpu::SamplerBindingType::NonFiltering),
            Argument::write(&mut results),
        ]],
        Workgroups::covering(6, 6),
    )
    .unwrap();
    let expected = [0, 1, 2, 3, 4, 5].map(|face| [face as f32 / 8.0; 2]);
    assert_eq!(gpu.download(&results).unwrap(), expected);
}

#[test]
fn time_is_measured_with_and_without_time_stamps() {
    use gpu_backend::gpu::Clock;
    let Some(gpu) = testing::gpu() else { return };
    let features = gpu.context().device().features();
    let work = |gpu: &Gpu<_>| {
        let buffer = gpu.zeros::<u32>(1 << 18).unwrap();
        let step = || gpu.scramble(&buffer, 1).map(drop);
        step().unwrap();
        gpu.time(4, step).unwrap()
    };
    let timing = work(&gpu);
    if features.contains(wgpu::Features::TIMESTAMP_QUERY) {
        assert_eq!(timing.clock, Clock::Device);
    }
    assert!(!timing.per_run.is_zero());
    assert!(timing.per_run < std::time::Duration::from_secs(10));
}

#[test]
fn an_adapter_that_is_not_there_is_named_with_those_that_are() {
    let Some(gpu) = testing::gpu() else { return };
    let error = Context::request_named("no such adapter", None).unwrap_err();
    let text = error.to_string();
    assert!(matches!(error, Error::NoAdapter { .. }));
    assert!(
        text.contains("no such adapter") && text.contains(gpu.name()),
        "{text}"
    );
    let part = gpu.name()[..4].to_uppercase();
    Context::request_named(&part, None).unwrap();
}
