//! Pictures from the samples of lines on a GPU.

use gpu_backend::testing::{self, Shader};
use gpu_backend::{Backend, Cpu, Download, assert_same_layout};
use reference::random::Random;
use reference::tolerances::Allowed;

use super::choice::{Choice, Mixture, NONE};
use super::fill::FillFromLines;
use super::gpu::FILL;
use super::samples::Spacing;
use super::surfaces::Surfaces;
use super::tests::{lights, with_view};

#[test]
fn the_shader_is_valid_and_has_the_constants_of_rust() {
    let shader = Shader::new(&FILL).unwrap();
    assert_same_layout!(
        shader,
        "Mixture",
        Mixture {
            samples,
            along,
            across,
            padding
        }
    );
    assert_eq!(shader.values("NONE").unwrap()[0], f64::from(NONE));
}

/// Light without any likeness between neighbours.
#[test]
fn it_fills_pictures_as_the_cpu_does() {
    let Some(gpu) = testing::gpu() else { return };
    let cpu = Cpu::new();
    let spacing = Spacing {
        lines: 1.0,
        samples: 12.0,
    };
    for (name, light) in lights() {
        with_view([53, 38], &[light], |inputs| {
            let surfaces = Surfaces::new(&cpu, &inputs);
            let choice = Choice::new(&cpu, &surfaces, &inputs.emitters[0], spacing).unwrap();
            let mut random = Random::new(9);
            let gathered: Vec<[f32; 4]> = (0..choice.rays.len())
                .map(|_| {
                    let [r, g, b] = random.vector(1.0);
                    [r.abs(), g.abs(), b.abs(), 9.0]
                })
                .collect();
            let start = vec![[0.0, 0.0, 0.0, 3.0]; inputs.rays.len()];
            let mut expected = start.clone();
            cpu.fill_from_lines(&choice, &gathered, &mut expected)
                .unwrap();
            let on_gpu = gpu.upload(&gathered).unwrap();
            let mut found = gpu.upload(&start).unwrap();
            gpu.fill_from_lines(&choice, &on_gpu, &mut found).unwrap();
            let found = gpu.download(&found).unwrap();
            for (e, f) in expected.iter().zip(&found) {
                assert_eq!(f[3], 3.0);
                for c in 0..3 {
                    // Light is at most 1.
                    let off = f64::from((e[c] - f[c]).abs());
                    let allowed = Allowed::GpuLinesFilled.error();
                    assert!(off <= allowed, "{name} {e:?} {f:?}");
                }
            }
            for (gathered, pixels) in [(&gathered[1..], start.len()), (&gathered[..], 7)] {
                let gathered = gpu.upload(gathered).unwrap();
                let mut radiance = gpu.zeros(pixels).unwrap();
                let error = gpu.fill_from_lines(&choice, &gathered, &mut radiance);
                assert!(error.is_err());
            }
        });
    }
}
