//! What it costs to open a device, to build a pipeline, and to record a step.

use std::time::Instant;

use gpu_backend::gpu::{Argument, Context, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Download, Error};

const STEP: &str = "
    @group(0) @binding(0) var<uniform> count: u32;
    @group(0) @binding(1) var<storage> input: array<u32>;
    @group(0) @binding(2) var<storage, read_write> output: array<u32>;
    override SALT: u32;
    @compute @workgroup_size(64)
    fn main(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64);
        if i < count { output[i] = input[i] + SALT; }
    }";

fn step<E: Encode>(
    gpu: &Gpu<E>,
    salt: u32,
    input: &GpuBuffer<u32>,
    output: &mut GpuBuffer<u32>,
) -> Result<(), Error> {
    gpu.dispatch(
        &Kernel {
            label: "a small step",
            parts: &[STEP, INDEX_WGSL],
            entry: "main",
            constants: &[("SALT", f64::from(salt))],
        },
        &[&[
            Argument::uniform(64_u32),
            Argument::read(input),
            Argument::write(output),
        ]],
        Workgroups::covering(64, 64),
    )
}

/// Microseconds per call, the best of several batches: other programs only ever
/// add to a time.
fn best(mut call: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    const CALLS: u32 = 50;
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        for _ in 0..CALLS {
            call()?;
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e6 / f64::from(CALLS));
    }
    Ok(best)
}

fn report(what: &str, microseconds: f64) {
    println!("{what:24} {microseconds:9.2} us");
}

fn main() -> Result<(), Error> {
    let milliseconds = |start: Instant| start.elapsed().as_secs_f64() * 1e3;

    let start = Instant::now();
    let context = Context::request()?;
    println!("open a device            {:9.2} ms", milliseconds(start));
    let gpu = Gpu::new(context.clone());
    println!("  {} (software: {})", gpu.name(), gpu.is_software());

    let input = gpu.upload(&[1_u32; 64])?;
    let mut output = gpu.zeros(64)?;
    for salt in 0..2 {
        let start = Instant::now();
        step(&gpu, salt, &input, &mut output)?;
        println!("first use of a pipeline  {:9.2} ms", milliseconds(start));
    }
    let start = Instant::now();
    gpu.wait()?;
    println!("first submit and wait    {:9.2} ms", milliseconds(start));

    report(
        "record a queued step",
        best(|| step(&gpu, 0, &input, &mut output))?,
    );
    gpu.wait()?;
    let mut encoder = context
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recording = Gpu::record(&context, &mut encoder);
    report(
        "record into an encoder",
        best(|| step(&recording, 0, &input, &mut output))?,
    );
    context.queue().submit([encoder.finish()]);
    gpu.wait()?;
    report("look for the device", best(|| context.check_alive())?);
    report("a small buffer", best(|| gpu.zeros::<u32>(64).map(drop))?);
    report(
        "a small upload",
        best(|| gpu.upload(&[1_u32; 64]).map(drop))?,
    );
    report(
        "step, submit, read back",
        best(|| {
            step(&gpu, 0, &input, &mut output)?;
            gpu.download(&output).map(drop)
        })?,
    );
    let timing = gpu.time(100, || step(&gpu, 0, &input, &mut output))?;
    println!(
        "a step by the clock      {:9.2} us ({:?})",
        timing.per_run.as_secs_f64() * 1e6,
        timing.clock
    );
    Ok(())
}
