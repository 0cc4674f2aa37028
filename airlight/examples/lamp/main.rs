//! A lamp in fog over a floor, in a renderer's own fragment shader: analytic, without
//! marching.
//!
//! The renderer makes a table for its phase function once, binds its two buffers where it
//! likes, and puts the parts of `airlight::gpu` in front of its shader.
//!
//! ```console
//! $ cargo run -p crepuscular-airlight --example lamp --features wgsl,gpu-backend/vulkan
//! ```
//!
//! Another path than the printed one is the first argument. Elsewhere take
//! `gpu-backend/metal` or `gpu-backend/dx12`.

#[path = "../screen/mod.rs"]
mod screen;

use airlight::gpu::{NUMERIC, PHASE, SCALED, SEGMENT, TABLE};
use airlight::{PhaseFunction, Table};
use screen::Screen;
use wgpu::BufferUsages;

/// The shader of the picture.
const SHADER: &[&str] = &[
    PHASE,
    SEGMENT,
    NUMERIC,
    SCALED,
    TABLE,
    include_str!("lamp.wgsl"),
];

const WIDTH: u32 = 256;
const EYE: [f32; 3] = [0.0, 1.0, 4.0];
const LAMP: [f32; 3] = [0.6, 1.4, 0.0];
const INTENSITY: [f32; 3] = [6.0, 4.5, 2.5];
/// Scattering and extinction of the fog, 1/m.
const SIGMA_S: f32 = 0.09;
const SIGMA_T: f32 = 0.1;
const PHASE_FUNCTION: PhaseFunction = PhaseFunction::HenyeyGreenstein { g: 0.6 };

/// The uniforms of `lamp.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Frame {
    eye: [f32; 3],
    sigma_t: f32,
    lamp: [f32; 3],
    sigma_s: f32,
    intensity: [f32; 3],
    padding: f32,
}

fn draw(screen: &Screen) -> Result<Vec<[f32; 4]>, airlight::Error> {
    // Once per phase function: 64 KiB.
    let table = Table::new(&PHASE_FUNCTION, 64)?;
    let uniforms = screen.buffer(
        bytemuck::bytes_of(&table.gpu_uniforms()),
        BufferUsages::UNIFORM,
    );
    let cells = screen.buffer(
        bytemuck::cast_slice(&table.gpu_cells()),
        BufferUsages::STORAGE,
    );
    let pipeline = screen.pipeline(SHADER);

    // Once per frame.
    let frame = Frame {
        eye: EYE,
        sigma_t: SIGMA_T,
        lamp: LAMP,
        sigma_s: SIGMA_S,
        intensity: INTENSITY,
        padding: 0.0,
    };
    let frame = screen.buffer(bytemuck::bytes_of(&frame), BufferUsages::UNIFORM);
    let buffers = [&frame, &uniforms, &cells].map(wgpu::Buffer::as_entire_binding);
    let group = screen.group(&pipeline.get_bind_group_layout(0), &buffers);
    let mut encoder = screen.device.create_command_encoder(&Default::default());
    screen.draw(&mut encoder, &pipeline, &group);
    Ok(screen.show(encoder))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    screen::run("lamp", WIDTH, draw)
}

#[cfg(test)]
mod tests {
    use airlight::Segment;
    use gpu_backend::testing::Shader;
    use reference::oracle::Phase;
    use reference::oracle::segment::{self, Part};

    use super::*;

    #[test]
    fn the_shader_is_valid() {
        Shader::new(SHADER).unwrap();
    }

    /// The picture by adaptive quadrature in f64.
    fn expected(pixel: u32) -> [f64; 3] {
        let at = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(WIDTH) - 1.0;
        let (x, y) = (0.7 * at(pixel % WIDTH), -0.7 * at(pixel / WIDTH));
        let length = (x * x + y * y + 1.0).sqrt();
        let direction = [x / length, y / length, -1.0 / length];
        let wide = |v: [f32; 3]| v.map(f64::from);
        let (eye, lamp, sigma_t) = (wide(EYE), wide(LAMP), f64::from(SIGMA_T));
        let mut floor = 0.0;
        let mut distance = f64::INFINITY;
        if direction[1] < 0.0 {
            distance = -eye[1] / direction[1];
            let to_lamp: Vec<f64> = (0..3)
                .map(|k| lamp[k] - eye[k] - distance * direction[k])
                .collect();
            let d = to_lamp.iter().map(|v| v * v).sum::<f64>().sqrt();
            let irradiance = to_lamp[1] / d / (d * d);
            floor = 0.5 / std::f64::consts::PI * irradiance * (-sigma_t * (d + distance)).exp();
        }
        let ray = Segment::from_ray(EYE, direction.map(|v| v as f32), LAMP, distance as f32);
        let part = Part {
            x: ray.x,
            s: ray.s,
            h: ray.h,
            length: ray.length,
        };
        let phase = Phase::HenyeyGreenstein {
            g: f64::from(0.6_f32),
        };
        let airlight = segment::airlight(phase, sigma_t, part, 1e-9).value;
        wide(INTENSITY).map(|i| i * (floor + f64::from(SIGMA_S) * airlight))
    }

    #[test]
    fn the_picture_is_that_of_the_oracle() {
        let Some(screen) = Screen::for_test(WIDTH, WIDTH) else {
            return;
        };
        let picture = draw(&screen).unwrap();
        for pixel in (0..WIDTH * WIDTH).step_by(97) {
            let [expected, ..] = expected(pixel);
            let found = f64::from(picture[pixel as usize][0]);
            // The table's own error, the device's, and that of the rounded direction.
            assert!(
                (found - expected).abs() < 5e-4 * expected,
                "{found} instead of {expected} at {pixel}"
            );
        }
    }
}
