//! Filtered shadows of buildings from a file, in a renderer's own lighting pass.
//!
//! The file is baked here if it is not there yet, as `crepuscular bake` would do it; the
//! renderer reads it, uploads its words once, and asks a 9 × 9 window at each pixel.
//!
//! ```console
//! $ cargo run -p crepuscular-shadow-dag --example sunlight --features wgpu,gpu-backend/vulkan
//! ```
//!
//! Another path than the printed one is the first argument. Elsewhere take
//! `gpu-backend/metal` or `gpu-backend/dx12`.

#[path = "../screen/mod.rs"]
mod screen;

use std::path::Path;

use glam::DVec3;
use glam::dcamera::rh::view::look_to_mat4;
use gpu_backend::Cpu;
use gpu_backend::gpu::{Context, Gpu};
use screen::Screen;
use shadow_dag::gpu::{DagRecord, EXTENT, PACKED, POINT, SPACE, SpaceRecord};
use shadow_dag::{Builder, Form, LightSpace, Mesh, Resolution, ShadowSet};
use wgpu::BufferUsages;

/// The shader of the picture.
const SHADER: &[&str] = &[POINT, PACKED, EXTENT, SPACE, include_str!("sunlight.wgsl")];

const WIDTH: u32 = 256;
/// Towards the sun.
const SUN: DVec3 = DVec3::new(0.6, 0.7, 0.387_298_334_620_741_7);
/// Texels of the filter's window.
const FILTER: u32 = 9;

/// The lowest and the highest corner of each box: the ground, and houses. The fourth numbers
/// are not used.
fn boxes() -> [[[f32; 4]; 2]; 16] {
    let mut boxes = [[[0.0; 4]; 2]; 16];
    boxes[0] = [[-8.0, -0.5, -8.0, 0.0], [8.0, 0.0, 8.0, 0.0]];
    for (i, house) in (0..).zip(&mut boxes[1..]) {
        let [x, z] = [2.6 * (i % 4) as f32 - 4.0, 2.4 * (i / 4) as f32 - 4.0];
        let height = 0.6 + 0.35 * (i * 7 % 5) as f32;
        *house = [[x, -0.1, z, 0.0], [x + 1.0, height, z + 0.9, 0.0]];
    }
    boxes
}

/// Positions and triangles of the boxes, front faces counter-clockwise.
fn triangles() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    const SIDES: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for corners in boxes() {
        let first = positions.len() as u32;
        positions.extend((0..8_usize).map(|i| [0, 1, 2].map(|k| corners[i >> k & 1][k])));
        for side in SIDES {
            let [a, b, c, d] = side.map(|corner| first + corner);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

/// Where the sun's grid is: 24 m wide around the origin.
fn light_space() -> Result<LightSpace, shadow_dag::Error> {
    let view = look_to_mat4(20.0 * SUN, -SUN, DVec3::Y);
    LightSpace::orthographic(view, 24.0, 24.0, 0.0, 40.0)
}

/// The file, made if it is not there.
fn file(path: &Path) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    if !path.exists() {
        let (positions, indices) = triangles();
        let resolution = Resolution::new(4096)?;
        let mesh = Mesh::new(resolution, light_space()?, &positions, &indices)?;
        let shadows = Builder::new().bake(&Cpu::new(), &mesh)?;
        std::fs::write(path, shadows.to_form(Form::Packed)?.into_bytes())?;
    }
    Ok(std::fs::read(path)?)
}

/// The uniforms of `sunlight.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Sun {
    direction: [f32; 3],
    width: u32,
}

fn draw(screen: &Screen, path: &Path) -> Result<Vec<[f32; 4]>, Box<dyn std::error::Error>> {
    // Once: the words of the file go to the device. Files hold one light or many.
    let bytes = file(path)?;
    let set = ShadowSet::read(&bytes)?;
    let grid = &set.grids().next().ok_or("a file has a grid")?;
    let light = grid
        .light()
        .ok_or("a file made from a mesh knows its light")?;
    let space = SpaceRecord::new(light, grid.resolution());
    let context = Context::new(screen.device.clone(), screen.queue.clone());
    let shadows = grid.to_form(Form::Packed)?.upload(&Gpu::new(context))?;
    let module = screen
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SHADER.join("\n").into()),
        });
    let geometry = screen
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("find"),
            compilation_options: Default::default(),
            cache: None,
        });
    let pipeline = screen.pipeline(SHADER);
    let uniform = |bytes: &[u8]| screen.buffer(bytes, BufferUsages::UNIFORM);
    let record = uniform(bytemuck::bytes_of(&DagRecord::new(&shadows)));
    let space = uniform(bytemuck::bytes_of(&space));

    // Once per frame.
    let boxes = uniform(bytemuck::cast_slice(&boxes()));
    let sun = uniform(bytemuck::bytes_of(&Sun {
        direction: SUN.as_vec3().into(),
        width: FILTER,
    }));
    let surfaces = vec![0; 16 * (WIDTH * WIDTH) as usize];
    let surfaces = screen.buffer(&surfaces, BufferUsages::STORAGE);
    let mut encoder = screen.device.create_command_encoder(&Default::default());
    {
        let groups = [(0, [&surfaces, &sun]), (1, [&boxes, &space])].map(|(index, buffers)| {
            let layout = geometry.get_bind_group_layout(index);
            screen.group(&layout, &buffers.map(wgpu::Buffer::as_entire_binding))
        });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&geometry);
        pass.set_bind_group(0, &groups[0], &[]);
        pass.set_bind_group(1, &groups[1], &[]);
        pass.dispatch_workgroups(WIDTH / 8, WIDTH / 8, 1);
    }
    let buffers = [&surfaces, &sun, &record, shadows.words().as_wgpu()];
    let group = screen.group(
        &pipeline.get_bind_group_layout(0),
        &buffers.map(wgpu::Buffer::as_entire_binding),
    );
    screen.draw(&mut encoder, &pipeline, &group);
    Ok(screen.show(encoder))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::temp_dir().join("sunlight.cpvs");
    screen::run("sunlight", WIDTH, |screen| draw(screen, &path))
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn the_shader_is_valid() {
        Shader::new(SHADER).unwrap();
    }

    /// The distance to the nearest box along a ray, and the normal there, in f64.
    fn hit(origin: DVec3, direction: DVec3) -> (f64, DVec3) {
        let corner = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        let mut nearest = (f64::INFINITY, DVec3::ZERO);
        for [low, high] in boxes() {
            let a = (corner(low) - origin) / direction;
            let b = (corner(high) - origin) / direction;
            let (enter, leave) = (a.min(b), a.max(b));
            let distance = enter.max_element();
            if distance > 1e-9 && distance < leave.min_element() && distance < nearest.0 {
                let side = DVec3::AXES[enter.max_position()];
                nearest = (distance, -side * direction.signum());
            }
        }
        nearest
    }

    /// The share of light rays through a window around a point that no box stops before
    /// they have come as near to its surface as the filter is wide.
    fn expected(pixel: u32) -> Option<f64> {
        let at = |i: u32| 0.6 * ((2.0 * f64::from(i) + 1.0) / f64::from(WIDTH) - 1.0);
        let eye = DVec3::new(0.0, 5.0, 9.0);
        let direction = DVec3::new(at(pixel % WIDTH), -at(pixel / WIDTH) - 0.5, -1.0).normalize();
        let (distance, normal) = hit(eye, direction);
        if distance.is_infinite() || normal.dot(SUN) <= 0.0 {
            return None;
        }
        let texel = 24.0 / 4096.0;
        let half = f64::from(FILTER / 2);
        let point = eye + distance * direction + 0.5 * f64::from(FILTER) * texel * normal;
        let (right, up) = SUN.any_orthonormal_pair();
        let offsets = || (0..FILTER).map(|i| texel * (f64::from(i) - half));
        let lit = offsets()
            .flat_map(|x| offsets().map(move |y| x * right + y * up))
            .filter(|offset| hit(point + *offset, SUN).0.is_infinite());
        Some(lit.count() as f64 / f64::from(FILTER * FILTER))
    }

    #[test]
    fn the_shadows_are_those_of_the_oracle() {
        let Some(screen) = Screen::for_test(WIDTH, WIDTH) else {
            return;
        };
        let folder = tempfile::tempdir().unwrap();
        let picture = draw(&screen, &folder.path().join("test.cpvs")).unwrap();
        let (mut squares, mut count) = (0.0, 0.0);
        for pixel in (0..WIDTH * WIDTH).step_by(31) {
            if let Some(expected) = expected(pixel) {
                squares += (f64::from(picture[pixel as usize][3]) - expected).powi(2);
                count += 1.0;
            }
        }
        let error = f64::sqrt(squares / count);
        println!("root of the mean square error of the lit share: {error}");
        assert!(count > 500.0 && error < 0.03);
    }
}
