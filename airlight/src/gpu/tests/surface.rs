//! Light that fog sends to surfaces, against the CPU.

use gpu_backend::gpu::{Argument, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::testing::Shader;
use gpu_backend::{Backend, Download, testing};
use reference::tolerances::Allowed;

use crate::gpu::SURFACE;
use crate::surface::{GlossTable, LobeTable};

/// One question per invocation: T, cos θ, exponent (0 for a table of one).
const ENTRY: &str = "
    @group(0) @binding(0) var<uniform> count: u32;
    @group(0) @binding(1) var<storage> coefficients: array<f32>;
    @group(0) @binding(2) var<storage> questions: array<vec4<f32>>;
    @group(0) @binding(3) var<storage, read_write> answers: array<f32>;

    fn air_surface_coefficient(index: u32) -> f32 { return coefficients[index]; }

    @compute @workgroup_size(64)
    fn ask(
        @builtin(workgroup_id) workgroup: vec3<u32>,
        @builtin(num_workgroups) workgroups: vec3<u32>,
        @builtin(local_invocation_index) local: u32,
    ) {
        let i = gpu_index(workgroup, workgroups, local, 64u);
        if i >= count { return; }
        let q = questions[i];
        if q.z == 0.0 {
            answers[i] = air_lobe(q.x, q.y);
        } else {
            answers[i] = air_gloss(q.z, q.x, q.y);
        }
    }";

#[test]
fn the_part_is_fit_for_other_shaders_and_has_the_axes_of_the_tables() {
    let data = "fn air_surface_coefficient(index: u32) -> f32 { return f32(index); }";
    let shader = Shader::new(&[SURFACE, data]).unwrap();
    shader.require_part(&["air_"]).unwrap();
    let length = |name: &str| shader.values(name).unwrap()[0] as usize;
    let plane = LobeTable::lambertian().coefficients().len();
    assert_eq!(length("air_SURFACE_PLANE"), plane);
    assert_eq!(
        (length("air_SURFACE_EXPONENTS") + 2) * plane,
        GlossTable::new().coefficients().len()
    );
}

#[test]
fn lobes_are_those_of_the_cpu() {
    let Some(gpu) = testing::gpu() else { return };
    let (lobe, gloss) = (LobeTable::new(20.0).unwrap(), GlossTable::new());
    let mut questions = Vec::new();
    for t in [0.0, 1e-6, 1e-3, 0.1, 1.0, 7.0, 30.0, 50.0, 80.0] {
        for step in 0..=40 {
            let cos = (step as f32 / 40.0 * std::f32::consts::PI).cos();
            questions.push([t, cos, 0.0, 0.0]);
            for exponent in [1.0, 2.5, 20.0, 90.0, 200.0] {
                questions.push([t, cos, exponent, 0.0]);
            }
        }
    }
    let answers = |coefficients: &[f32], questions: &[[f32; 4]]| {
        let table = gpu.upload(coefficients).unwrap();
        let asked = gpu.upload(questions).unwrap();
        let mut answers = gpu.zeros::<f32>(questions.len()).unwrap();
        gpu.dispatch(
            &Kernel {
                label: "ask",
                parts: &[INDEX_WGSL, SURFACE, ENTRY],
                entry: "ask",
                constants: &[],
            },
            &[&[
                Argument::uniform(questions.len() as u32),
                Argument::read(&table),
                Argument::read(&asked),
                Argument::write(&mut answers),
            ]],
            Workgroups::covering(questions.len(), 64),
        )
        .unwrap();
        gpu.download(&answers).unwrap()
    };
    let (ones, all): (Vec<[f32; 4]>, Vec<[f32; 4]>) = questions.iter().partition(|q| q[2] == 0.0);
    for (coefficients, questions) in [(lobe.coefficients(), ones), (gloss.coefficients(), all)] {
        for (question, answer) in questions.iter().zip(answers(coefficients, &questions)) {
            let [t, cos, exponent, _] = *question;
            let expected = if exponent == 0.0 {
                lobe.value(t, cos)
            } else {
                gloss.value(exponent, t, cos)
            };
            if expected < f32::MIN_POSITIVE {
                assert!(answer < 2.0 * f32::MIN_POSITIVE, "{question:?}");
                continue;
            }
            let exponential = Allowed::GpuExponential.error() * f64::from(1.0 + t);
            let allowed = Allowed::GpuLobe.error() + exponential;
            let error = (f64::from(answer) / f64::from(expected) - 1.0).abs();
            assert!(
                error <= allowed,
                "{question:?}: {answer} {expected} {error:e}"
            );
        }
    }
}
