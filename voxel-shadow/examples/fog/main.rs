//! Fog with shadows from a renderer's own shadow map: a cube of reversed depths.
//!
//! The renderer has a device, draws the depths around a lamp as it would anyway, records the
//! three steps of a shadow volume into its own command encoder, and reads the volume in its
//! own fragment shader.
//!
//! ```console
//! $ cargo run -p crepuscular-voxel-shadow --example fog --features wgpu,gpu-backend/vulkan
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
use gpu_backend::gpu::{Context, Gpu};
use screen::Screen;
use voxel_shadow::gpu::{DEPTH, DepthLayers, SHADOW, SamplingRecord};
use voxel_shadow::{BuildGrid, DepthViews, Grid, IndexMap, Rectify, Sampling};
use wgpu::BufferUsages;

/// The shader of the picture.
const SHADER: &[&str] = &[
    EPIPOLAR,
    PHI,
    SHADOW,
    DEPTH,
    SEGMENT,
    NUMERIC,
    SCALED,
    TABLE,
    include_str!("fog.wgsl"),
];

/// The shader of the shadow map.
const CUBE: &str = include_str!("cube.wgsl");

const WIDTH: u32 = 256;
const EYE: [f32; 3] = [0.0, 1.2, 5.0];
const LAMP: [f32; 3] = [0.0, 1.5, 0.0];
const INTENSITY: [f32; 3] = [9.0, 7.0, 4.0];
/// Scattering and extinction of the fog, 1/m.
const SIGMA_S: f32 = 0.09;
const SIGMA_T: f32 = 0.1;
/// Texels along the side of a face of the shadow map, and its near plane, m.
const TEXELS: u32 = 512;
const NEAR: f32 = 0.05;

/// The lowest and the highest corner of each box: a floor, and a cage around the lamp. The
/// fourth numbers are not used.
fn boxes() -> [[[f32; 4]; 2]; 16] {
    let mut boxes = [[[0.0; 4]; 2]; 16];
    boxes[0] = [[-30.0, -1.0, -30.0, 0.0], [30.0, 0.0, 30.0, 0.0]];
    for (i, bar) in boxes[1..].iter_mut().enumerate() {
        let (sine, cosine) = (std::f32::consts::TAU * i as f32 / 15.0).sin_cos();
        let [x, z] = [0.6 * cosine, 0.6 * sine];
        *bar = [
            [x - 0.05, 0.9, z - 0.05, 0.0],
            [x + 0.05, 2.1, z + 0.05, 0.0],
        ];
    }
    boxes
}

/// The uniforms of `fog.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Frame {
    eye: [f32; 3],
    sigma_t: f32,
    lamp: [f32; 3],
    sigma_s: f32,
    intensity: [f32; 3],
    near: f32,
}

/// The renderer's own shadow map: records a pass for each face of a cube of depths.
fn draw_cube(
    screen: &Screen,
    boxes: &wgpu::Buffer,
    views: &DepthViews,
    encoder: &mut wgpu::CommandEncoder,
) -> wgpu::Texture {
    let device = &screen.device;
    let cube = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shadow map"),
        size: wgpu::Extent3d {
            width: TEXELS,
            height: TEXELS,
            depth_or_array_layers: 6,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(CUBE.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    });
    for face in 0..6 {
        let matrix = views.matrix(face as usize);
        let matrix = screen.buffer(bytemuck::bytes_of(&matrix), BufferUsages::UNIFORM);
        let buffers = [boxes, &matrix].map(wgpu::Buffer::as_entire_binding);
        let group = screen.group(&pipeline.get_bind_group_layout(0), &buffers);
        let layer = cube.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: face,
            array_layer_count: Some(1),
            ..Default::default()
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &layer,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..36, 0..16);
    }
    cube
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
    let boxes = uniform(bytemuck::cast_slice(&boxes()));

    // Once per frame: the shadow map, as the renderer draws it anyway.
    let mut encoder = screen.device.create_command_encoder(&Default::default());
    let views = DepthViews::cube(LAMP, NEAR)?;
    let cube = draw_cube(screen, &boxes, &views, &mut encoder);
    let layers = cube.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });

    // The shadow volume of it, in the same encoder: a few dispatches.
    let space = Space::new(Light::point(LAMP)?, EYE)?;
    let view = ViewVolume::perspective([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.7, 0.7], 0.0, 30.0)?;
    let voxels = Resolution::new(512, 512, 256)?;
    let lattice = Lattice::new(space, &view, voxels, Spacing::Angle)?;
    let gpu = Gpu::record(&context, &mut encoder);
    let mut map = IndexMap::new(&gpu, voxels)?;
    let mut grid = Grid::new(&gpu, voxels)?;
    gpu.rectify(&lattice, &DepthLayers::new(&views, &layers), &mut map)?;
    gpu.voxelise(&map, &mut grid)?;
    gpu.extrude(&mut grid)?;
    drop(gpu);

    // The picture.
    let frame = uniform(bytemuck::bytes_of(&Frame {
        eye: EYE,
        sigma_t: SIGMA_T,
        lamp: LAMP,
        sigma_s: SIGMA_S,
        intensity: INTENSITY,
        near: NEAR,
    }));
    let lattice_uniforms = uniform(bytemuck::bytes_of(&LatticeRecord::new(&lattice)));
    let bounds = storage(bytemuck::cast_slice(lattice.bounds()));
    let sampling = SamplingRecord::new(&Sampling::default());
    let sampling = uniform(bytemuck::bytes_of(&sampling));
    let words = grid.words().as_wgpu();
    let buffers = [
        &frame,
        &boxes,
        &lattice_uniforms,
        &bounds,
        &sampling,
        words,
        &table_uniforms,
        &table_cells,
    ];
    let mut resources = buffers.map(wgpu::Buffer::as_entire_binding).to_vec();
    resources.push(wgpu::BindingResource::TextureView(&layers));
    let group = screen.group(&pipeline.get_bind_group_layout(0), &resources);
    screen.draw(&mut encoder, &pipeline, &group);
    Ok(screen.show(encoder))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    screen::run("fog", WIDTH, draw)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use gpu_backend::testing::Shader;
    use reference::oracle::closed_form;

    use super::*;

    #[test]
    fn the_shaders_are_valid() {
        Shader::new(SHADER).unwrap();
        Shader::new(&[CUBE]).unwrap();
    }

    /// The distance to the nearest box along a ray, in f64.
    fn hit(origin: DVec3, direction: DVec3) -> f64 {
        let corner = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        let distances = boxes().map(|[low, high]| {
            let a = (corner(low) - origin) / direction;
            let b = (corner(high) - origin) / direction;
            let enter = a.min(b).max_element();
            let leave = a.max(b).min_element();
            if enter > 0.0 && enter < leave {
                enter
            } else {
                f64::INFINITY
            }
        });
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The airlight of a pixel: short parts of its ray, each lit if its middle is.
    fn expected(pixel: u32) -> f64 {
        let point = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (eye, lamp) = (point(EYE), point(LAMP));
        let at = |i: u32| 0.7 * ((2.0 * f64::from(i) + 1.0) / f64::from(WIDTH) - 1.0);
        let direction = DVec3::new(at(pixel % WIDTH), -at(pixel / WIDTH), -1.0).normalize();
        let end = hit(eye, direction).min(60.0);
        let foot = direction.dot(lamp - eye);
        let h = direction.cross(lamp - eye).length();
        // Equal angles at the lamp: finer where there is more light.
        let [first, last] = [0.0, end].map(|x: f64| (x - foot).atan2(h));
        let borders: Vec<f64> = (0..=2000)
            .map(|i| foot + h * (first + (last - first) * f64::from(i) / 2000.0).tan())
            .collect();
        let lit = borders.windows(2).filter(|part| {
            let middle = eye + 0.5 * (part[0] + part[1]) * direction - lamp;
            hit(lamp, middle.normalize()) >= middle.length()
        });
        let sigma_t = f64::from(SIGMA_T);
        lit.map(|part| closed_form::isotropic(1.0, sigma_t, foot, h, part[0], part[1]))
            .sum()
    }

    #[test]
    fn the_fog_is_that_of_the_oracle() {
        let Some(screen) = Screen::for_test(WIDTH, WIDTH) else {
            return;
        };
        let picture = draw(&screen).unwrap();
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for pixel in (0..WIDTH * WIDTH).step_by(61) {
            let expected = expected(pixel);
            let error = f64::from(picture[pixel as usize][3]) - expected;
            sum += expected;
            squares += error * error;
            count += 1.0;
        }
        let mean: f64 = sum / count;
        let error = f64::sqrt(squares / count) / mean;
        println!("root of the mean square error over the mean: {error}");
        assert!(error < 0.02);
    }
}
