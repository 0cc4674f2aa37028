//! Shadows of smoke on surfaces below it and within it: an adaptive volumetric shadow map of a
//! renderer's own fragments.
//!
//! The renderer draws its puffs from the light, in any order; each fragment appends a segment
//! to two buffers. In the same command encoder they become a map, which the renderer's own
//! fragment shader looks up.
//!
//! ```console
//! $ cargo run -p crepuscular-transmittance --example smoke --features wgpu,gpu-backend/vulkan
//! ```
//!
//! Another path than the printed one is the first argument. Elsewhere take
//! `gpu-backend/metal` or `gpu-backend/dx12`.

#[path = "../screen/mod.rs"]
mod screen;

use gpu_backend::gpu::{Context, Gpu, GpuBuffer};
use screen::Screen;
use transmittance::gpu::lookup_parts;
use transmittance::{
    BuildMap, CaptureSegments, Curve, Order, Packed, SegmentLists, TransmittanceMap,
};
use wgpu::BufferUsages;

/// The shader of the picture, without its parts.
const SHADER: &str = include_str!("smoke.wgsl");

/// The shader of the pass from the light.
const FRAGMENTS: &str = include_str!("fragments.wgsl");

const WIDTH: u32 = 256;
const TEXELS: u32 = 128;
/// Fragments for which there is room.
const ROOM: u32 = 1 << 17;
const PUFFS: usize = 150;

/// The uniforms of both shaders.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Light {
    low: [f32; 2],
    size: f32,
    top: f32,
    texels: u32,
    room: u32,
    sigma_t: f32,
    padding: f32,
}

const LIGHT: Light = Light {
    low: [-2.5, -2.5],
    size: 5.0,
    top: 4.0,
    texels: TEXELS,
    room: ROOM,
    sigma_t: 1.5,
    padding: 0.0,
};

/// Centre and radius of each puff.
fn puffs() -> Vec<[f32; 4]> {
    (0..PUFFS)
        .map(|i| {
            // Shares that fill the unit cube evenly.
            let [a, b, c] = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|g| (g * i as f32).fract());
            [
                3.4 * a - 1.7,
                0.5 + 2.2 * b,
                1.6 * c - 1.0,
                0.12 + 0.2 * (a * b),
            ]
        })
        .collect()
}

/// Records the renderer's own pass over its smoke.
fn draw_fragments(
    screen: &Screen,
    encoder: &mut wgpu::CommandEncoder,
    buffers: [&wgpu::Buffer; 5],
) {
    let device = &screen.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(FRAGMENTS.into()),
    });
    let format = wgpu::TextureFormat::R8Unorm;
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            ..Default::default()
        },
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    // A pass has a target, even if nobody looks at it.
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: TEXELS,
            height: TEXELS,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let group = screen.group(
        &pipeline.get_bind_group_layout(0),
        &buffers.map(wgpu::Buffer::as_entire_binding),
    );
    let view = target.create_view(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        })],
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..4, 0..PUFFS as u32);
}

fn draw(screen: &Screen) -> Result<Vec<[f32; 4]>, Box<dyn std::error::Error>> {
    // Once: pipelines are kept in the context.
    let context = Context::new(screen.device.clone(), screen.queue.clone());
    let parts = [&lookup_parts::<Packed<8>, 1>()[..], &[SHADER]].concat();
    let pipeline = screen.pipeline(&parts);
    let light = screen.buffer(bytemuck::bytes_of(&LIGHT), BufferUsages::UNIFORM);
    let puffs = screen.buffer(bytemuck::cast_slice(&puffs()), BufferUsages::STORAGE);

    // Once per frame: fragments, in whatever order they come. Places that none has written
    // stay marked as those of no texel.
    let mut encoder = screen.device.create_command_encoder(&Default::default());
    let count = screen.buffer(&[0; 4], BufferUsages::STORAGE);
    let texels = screen.buffer(&vec![0xff; 4 * ROOM as usize], BufferUsages::STORAGE);
    let numbers = screen.buffer(&vec![0; 12 * ROOM as usize], BufferUsages::STORAGE);
    let buffers = [&light, &puffs, &count, &texels, &numbers];
    draw_fragments(screen, &mut encoder, buffers);

    // The map of them, in the same encoder.
    let extent = [TEXELS as usize; 2];
    let texels: GpuBuffer<u32> = GpuBuffer::from_wgpu(texels, ROOM as usize)?;
    let numbers: GpuBuffer<f32> = GpuBuffer::from_wgpu(numbers, 3 * ROOM as usize)?;
    let gpu = Gpu::record(&context, &mut encoder);
    let order = Order::FrontToBack;
    let lists: SegmentLists<_> =
        gpu.capture_segments(extent, &texels, &numbers, PUFFS as u32, order)?;
    let mut map = TransmittanceMap::<_, Packed<8>>::new(&gpu, extent)?;
    gpu.build_map(&Curve::<8>::new(), &lists, &mut map)?;
    drop(gpu);

    // The picture.
    let buffers = [&light, map.words().as_wgpu()].map(wgpu::Buffer::as_entire_binding);
    let group = screen.group(&pipeline.get_bind_group_layout(0), &buffers);
    screen.draw(&mut encoder, &pipeline, &group);
    Ok(screen.show(encoder))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    screen::run("smoke", WIDTH, draw)
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn the_shaders_are_valid() {
        Shader::new(&[&lookup_parts::<Packed<8>, 1>()[..], &[SHADER]].concat()).unwrap();
        Shader::new(&[FRAGMENTS]).unwrap();
    }

    /// What gets to a point: each puff takes what its stretch of the light's ray takes.
    fn expected(pixel: u32) -> f64 {
        let at = |i: u32| 0.5 * ((2.0 * f64::from(i) + 1.0) / f64::from(WIDTH) - 1.0);
        let (x, y) = (at(pixel % WIDTH), -at(pixel / WIDTH));
        let mut point = [4.2 * x, 1.5 + 4.2 * y, -0.2];
        if point[1] < 0.0 {
            point = [1.5 / -y * x, 0.0, 4.0 - 1.5 / -y];
        }
        let depth: f64 = puffs()
            .iter()
            .map(|puff| {
                let [a, b, c, radius] = puff.map(f64::from);
                let aside = (point[0] - a).powi(2) + (point[2] - c).powi(2);
                let half = (radius * radius - aside).max(0.0).sqrt();
                // What of the puff is above the point.
                f64::from(LIGHT.sigma_t)
                    * (b + half - point[1].max(b - half)).clamp(0.0, 2.0 * half)
            })
            .sum();
        (-depth).exp()
    }

    #[test]
    fn the_light_is_that_of_the_oracle() {
        let Some(screen) = Screen::for_test(WIDTH, WIDTH) else {
            return;
        };
        let picture = draw(&screen).unwrap();
        let pixels = (0..WIDTH * WIDTH).step_by(31);
        let errors: Vec<f64> = pixels
            .map(|pixel| f64::from(picture[pixel as usize][3]) - expected(pixel))
            .collect();
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let error = (squares / errors.len() as f64).sqrt();
        println!("root of the mean square error of the transmittance: {error}");
        assert!(error < 0.025);
    }
}
