//! A lamp with a surface in fog, as many points that share one atlas of shadow volumes.
//!
//! Blockers are the renderer's own: a part of a shader that traces rays against its boxes.
//! The atlas is made in two dispatches of the renderer's command encoder, however many points
//! there are.
//!
//! ```console
//! $ cargo run -p crepuscular-voxel-shadow --example area --features wgpu,gpu-backend/vulkan
//! ```
//!
//! Another path than the printed one is the first argument. Elsewhere take
//! `gpu-backend/metal` or `gpu-backend/dx12`.

#[path = "../screen/mod.rs"]
mod screen;

use airlight::gpu::{NUMERIC, SCALED, SEGMENT, TABLE};
use airlight::{PhaseFunction, Table};
use epipolar::gpu::{EPIPOLAR, LatticeRecord, PHI};
use epipolar::{Lattice, Light, Resolution, Space, Spacing, ViewVolume};
use gpu_backend::gpu::{Argument, Context, Gpu, InShader};
use gpu_backend::shader::Part;
use screen::Screen;
use voxel_shadow::gpu::{AtlasBlockerSlot, SHADOW, SamplingRecord};
use voxel_shadow::{AtlasGrid, AtlasMap, BuildAtlas, RectifyAtlas, Sampling};
use wgpu::BufferUsages;

/// The shader of the picture.
const SHADER: &[&str] = &[
    EPIPOLAR,
    PHI,
    SHADOW,
    SEGMENT,
    NUMERIC,
    SCALED,
    TABLE,
    include_str!("area.wgsl"),
];

const WIDTH: u32 = 256;
const EYE: [f32; 3] = [0.0, 1.2, 5.0];
/// Centre of the lamp, an upright square, and half of its side, m.
const LAMP: [f32; 3] = [0.0, 1.5, 0.0];
const HALF: f32 = 0.25;
/// Points of the lamp.
const POINTS: u32 = 32;
const INTENSITY: [f32; 3] = [20.0, 16.0, 9.0];
/// Scattering and extinction of the fog, 1/m.
const SIGMA_S: f32 = 0.09;
const SIGMA_T: f32 = 0.1;

/// The lowest and the highest corner of a box; the fourth numbers are not used.
type Corners = [[f32; 4]; 2];

/// A floor, and a cage around the lamp.
fn boxes() -> [Corners; 16] {
    let mut boxes = [[[0.0; 4]; 2]; 16];
    boxes[0] = [[-30.0, -1.0, -30.0, 0.0], [30.0, 0.0, 30.0, 0.0]];
    for (i, bar) in boxes[1..].iter_mut().enumerate() {
        let (sine, cosine) = (std::f32::consts::TAU * i as f32 / 15.0).sin_cos();
        let [x, z] = [0.9 * cosine, 0.9 * sine];
        *bar = [[x - 0.1, 0.7, z - 0.1, 0.0], [x + 0.1, 2.3, z + 0.1, 0.0]];
    }
    boxes
}

/// Points that fill the lamp evenly.
fn points(count: u32) -> impl Iterator<Item = [f32; 3]> {
    (0..count).map(move |i| {
        let across = (i as f32 + 0.5) / count as f32;
        let up = i.reverse_bits() as f32 / 4_294_967_296.0 + 0.5 / count as f32;
        let [x, y] = [across, up].map(|share| HALF * (2.0 * share - 1.0));
        [LAMP[0] + x, LAMP[1] + y, LAMP[2]]
    })
}

/// The renderer's casters, as a part of the shader that rectifies.
struct Boxes([Corners; 16]);

impl InShader<AtlasBlockerSlot> for Boxes {
    fn part() -> Part {
        Part::new("example_boxes")
            .source(include_str!("boxes.wgsl"))
            .uniform("example_boxes", "array<example_Box, 16>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![Argument::uniform(self.0)]
    }
}

/// The uniforms of `area.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Frame {
    eye: [f32; 3],
    sigma_t: f32,
    intensity: [f32; 3],
    sigma_s: f32,
    tiles: u32,
    words: u32,
    bounds: u32,
    padding: u32,
}

fn draw(screen: &Screen) -> Result<Vec<[f32; 4]>, Box<dyn std::error::Error>> {
    // Once: pipelines are kept in the context, tables are for a phase function.
    let context = Context::new(screen.device.clone(), screen.queue.clone());
    let table = Table::new(&PhaseFunction::Isotropic, 64)?;
    let pipeline = screen.pipeline(SHADER);
    let uniform = |bytes: &[u8]| screen.buffer(bytes, BufferUsages::UNIFORM);
    let storage = |bytes: &[u8]| screen.buffer(bytes, BufferUsages::STORAGE);
    let table_uniforms = uniform(bytemuck::bytes_of(&table.gpu_uniforms()));
    let table_cells = storage(bytemuck::cast_slice(&table.gpu_cells()));

    // Once per frame: a lattice for each point, each turned against the others around the
    // axis, so that the errors of their voxels average.
    let view = ViewVolume::perspective([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.7, 0.7], 0.0, 30.0)?;
    let voxels = Resolution::new(256, 256, 128)?;
    let lattices = (points(POINTS).zip(0..))
        .map(|(point, i)| {
            let space = Space::new(Light::point(point)?, EYE)?.rotated(2.4 * i as f32);
            Lattice::new(space, &view, voxels, Spacing::Angle)
        })
        .collect::<Result<Vec<_>, _>>()?;

    // Their shadow volumes, in the renderer's own encoder: two dispatches.
    let mut encoder = screen.device.create_command_encoder(&Default::default());
    let gpu = Gpu::record(&context, &mut encoder);
    let mut map = AtlasMap::new(&gpu, voxels, lattices.len())?;
    let mut grid = AtlasGrid::new(&gpu, voxels, lattices.len())?;
    gpu.rectify_atlas(&lattices, &Boxes(boxes()), &mut map)?;
    gpu.build_atlas(&map, lattices.len(), &mut grid)?;
    drop(gpu);

    // The picture.
    let frame = uniform(bytemuck::bytes_of(&Frame {
        eye: EYE,
        sigma_t: SIGMA_T,
        intensity: INTENSITY.map(|all| all / POINTS as f32),
        sigma_s: SIGMA_S,
        tiles: POINTS,
        words: voxels.words() as u32,
        bounds: voxels.bits() + 1,
        padding: 0,
    }));
    let boxes = uniform(bytemuck::cast_slice(&boxes()));
    let records: Vec<_> = lattices.iter().map(LatticeRecord::new).collect();
    let records = storage(bytemuck::cast_slice(&records));
    let bounds: Vec<_> = lattices.iter().flat_map(Lattice::bounds).copied().collect();
    let bounds = storage(bytemuck::cast_slice(&bounds));
    let sampling = SamplingRecord::new(&Sampling::default());
    let sampling = uniform(bytemuck::bytes_of(&sampling));
    let buffers = [
        &frame,
        &boxes,
        &records,
        &bounds,
        &sampling,
        grid.words().as_wgpu(),
        &table_uniforms,
        &table_cells,
    ];
    let group = screen.group(
        &pipeline.get_bind_group_layout(0),
        &buffers.map(wgpu::Buffer::as_entire_binding),
    );
    screen.draw(&mut encoder, &pipeline, &group);
    Ok(screen.show(encoder))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    screen::run("area", WIDTH, draw)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use gpu_backend::testing::Shader;
    use reference::oracle::closed_form;

    use super::*;

    #[test]
    fn the_shader_is_valid() {
        Shader::new(SHADER).unwrap();
    }

    /// The distance to the nearest box along a ray, in f64.
    fn hit(origin: DVec3, direction: DVec3) -> f64 {
        let corner = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        let distances = boxes().map(|[low, high]| {
            let a = (corner(low) - origin) / direction;
            let b = (corner(high) - origin) / direction;
            let enter = a.min(b).max_element();
            let is_met = enter > 0.0 && enter < a.max(b).min_element();
            if is_met { enter } else { f64::INFINITY }
        });
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The airlight of a pixel by four times as many points: short parts of its ray, each lit
    /// if its middle is.
    fn expected(pixel: u32) -> f64 {
        let point = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let at = |i: u32| 0.7 * ((2.0 * f64::from(i) + 1.0) / f64::from(WIDTH) - 1.0);
        let (eye, x, y) = (point(EYE), at(pixel % WIDTH), -at(pixel / WIDTH));
        let direction = DVec3::new(x, y, -1.0).normalize();
        let end = hit(eye, direction).min(60.0);
        let of_point = |lamp: DVec3| -> f64 {
            let foot = direction.dot(lamp - eye);
            let h = direction.cross(lamp - eye).length();
            let [first, last] = [0.0, end].map(|x: f64| (x - foot).atan2(h));
            let borders: Vec<f64> = (0..=500)
                .map(|i| foot + h * (first + (last - first) * f64::from(i) / 500.0).tan())
                .collect();
            let lit = borders.windows(2).filter(|part| {
                let middle = eye + 0.5 * (part[0] + part[1]) * direction - lamp;
                hit(lamp, middle.normalize()) >= middle.length()
            });
            let sigma_t = f64::from(SIGMA_T);
            lit.map(|part| closed_form::isotropic(1.0, sigma_t, foot, h, part[0], part[1]))
                .sum()
        };
        let count = 4 * POINTS;
        points(count).map(point).map(of_point).sum::<f64>() / f64::from(count)
    }

    #[test]
    fn the_fog_is_that_of_the_oracle() {
        let Some(screen) = Screen::for_test(WIDTH, WIDTH) else {
            return;
        };
        let picture = draw(&screen).unwrap();
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for pixel in (0..WIDTH * WIDTH).step_by(503) {
            let expected = expected(pixel);
            let error = f64::from(picture[pixel as usize][3]) - expected;
            sum += expected;
            squares += error * error;
            count += 1.0;
        }
        let mean: f64 = sum / count;
        let error = f64::sqrt(squares / count) / mean;
        println!("root of the mean square error over the mean: {error}");
        assert!(error < 0.03);
    }
}
