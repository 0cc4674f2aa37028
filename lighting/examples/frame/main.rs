//! The fog of a renderer's frame by one object, used as `wgpu::util::TextureBlitter` is.
//!
//! The renderer draws its surfaces with four samples in each pixel and reversed depths, and
//! a shadow map for one of its two lamps. A [`FogPass`] takes the depths, the lights and the
//! camera's matrix, records into the renderer's command encoder, and leaves a texture that
//! the renderer puts over its picture.
//!
//! ```console
//! $ cargo run -p crepuscular-lighting --example frame \
//!       --features wgpu,voxel-shadow,gpu-backend/vulkan
//! ```
//!
//! Another path than the printed one is the first argument. Elsewhere take
//! `gpu-backend/metal` or `gpu-backend/dx12`.

#[path = "../screen/mod.rs"]
mod screen;

use glam::camera::rh::proj::directx::perspective_infinite_reverse;
use glam::camera::rh::view::look_at_mat4;
use glam::{Mat4, Vec3, Vec4};
use gpu_backend::gpu::Context;
use lighting::Emitter;
use lighting::fog_pass::{DepthLayers, DepthViews, FogEye, FogFrame, FogLight, FogPass};
use lighting::scene::{Emission, Medium, PhaseFunction};
use screen::Screen;
use wgpu::{BindingResource, BufferUsages, TextureFormat, TextureViewDimension};

/// The renderer's shaders.
const SCENE: &str = include_str!("scene.wgsl");
const PICTURE: &str = include_str!("picture.wgsl");

const WIDTH: u32 = 256;
/// Samples in each pixel.
const SAMPLES: u32 = 4;
/// Texels along the side of a face of the shadow map, and the near plane, m.
const TEXELS: u32 = 512;
const NEAR: f32 = 0.05;
const EYE: Vec3 = Vec3::new(0.0, 1.6, 5.0);
const TARGET: Vec3 = Vec3::new(0.0, 1.2, 0.0);
/// The tangent of half of the field of view.
const TAN: f32 = 0.7;
/// The lamp in the cage, and the one beside it that nothing is around.
const LAMPS: [Vec3; 2] = [Vec3::new(0.0, 1.5, 0.0), Vec3::new(2.2, 0.5, -1.0)];
/// W/sr.
const INTENSITIES: [Vec3; 2] = [Vec3::new(9.0, 7.0, 4.0), Vec3::new(0.3, 0.7, 1.6)];
/// Scattering and extinction of the fog, 1/m.
const SIGMA_S: f32 = 0.09;
const SIGMA_T: f32 = 0.1;

/// The lowest and the highest corner of each box: a floor, and a cage around the lamp.
fn boxes() -> [[Vec4; 2]; 16] {
    let mut boxes = [[Vec4::ZERO; 2]; 16];
    boxes[0] = [
        Vec4::new(-30.0, -1.0, -30.0, 0.0),
        Vec4::new(30.0, 0.0, 30.0, 0.0),
    ];
    for (i, bar) in boxes[1..].iter_mut().enumerate() {
        let (sine, cosine) = (std::f32::consts::TAU * i as f32 / 15.0).sin_cos();
        let [x, z] = [0.6 * cosine, 0.6 * sine];
        *bar = [
            Vec4::new(x - 0.05, 0.9, z - 0.05, 0.0),
            Vec4::new(x + 0.05, 2.1, z + 0.05, 0.0),
        ];
    }
    boxes
}

/// The uniforms `Lights` of `scene.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Lights {
    faces: [[[f32; 4]; 4]; 6],
    positions: [Vec4; 2],
    intensities: [Vec4; 2],
}

/// The renderer: what it draws boxes with, into depths alone and into a picture.
struct Renderer<'a> {
    screen: &'a Screen,
    boxes: wgpu::Buffer,
    depths: wgpu::RenderPipeline,
    surfaces: wgpu::RenderPipeline,
}

impl<'a> Renderer<'a> {
    fn new(screen: &'a Screen) -> Self {
        let device = &screen.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SCENE.into()),
        });
        let pipeline = |targets: &[Option<wgpu::ColorTargetState>], count| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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
                    format: TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: wgpu::MultisampleState {
                    count,
                    ..Default::default()
                },
                fragment: (!targets.is_empty()).then_some(wgpu::FragmentState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            screen,
            boxes: screen.buffer(bytemuck::cast_slice(&boxes()), BufferUsages::UNIFORM),
            depths: pipeline(&[], 1),
            surfaces: pipeline(&[Some(TextureFormat::Rgba16Float.into())], SAMPLES),
        }
    }

    fn texture(
        &self,
        format: TextureFormat,
        side: u32,
        layers: u32,
        samples: u32,
    ) -> wgpu::Texture {
        self.screen.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: side,
                height: side,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    }

    /// Draws the boxes as `matrix` sees them: depths, and colours if there are lights.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        matrix: &[[f32; 4]; 4],
        depth: &wgpu::TextureView,
        colours: Option<(
            &wgpu::TextureView,
            &wgpu::TextureView,
            &[BindingResource<'_>],
        )>,
    ) {
        let pipeline = match colours {
            None => &self.depths,
            Some(_) => &self.surfaces,
        };
        let matrix = self
            .screen
            .buffer(bytemuck::bytes_of(matrix), BufferUsages::UNIFORM);
        let buffers = [&self.boxes, &matrix].map(wgpu::Buffer::as_entire_binding);
        let group = self
            .screen
            .group(&pipeline.get_bind_group_layout(0), &buffers);
        let attachment = colours.map(|(view, resolved, _)| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: Some(resolved),
                ops: wgpu::Operations::default(),
            })
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: attachment.as_slice(),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        if let Some((_, _, lights)) = colours {
            let lights = self
                .screen
                .group(&pipeline.get_bind_group_layout(1), lights);
            pass.set_bind_group(1, &lights, &[]);
        }
        pass.draw(0..36, 0..16);
    }
}

fn draw(screen: &Screen) -> Result<Vec<[f32; 4]>, Box<dyn std::error::Error>> {
    // Once.
    let renderer = Renderer::new(screen);
    let context = Context::new(screen.device.clone(), screen.queue.clone());
    let mut fog_pass = FogPass::new(&context, TextureFormat::Rgba16Float, SAMPLES)?;

    // Once per frame: the shadow map of the first lamp.
    let mut encoder = screen.device.create_command_encoder(&Default::default());
    let views = DepthViews::cube(LAMPS[0], NEAR)?;
    let cube = renderer.texture(TextureFormat::Depth32Float, TEXELS, 6, 1);
    for face in 0..6 {
        let layer = cube.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2),
            base_array_layer: face,
            array_layer_count: Some(1),
            ..Default::default()
        });
        renderer.draw(&mut encoder, &views.matrix(face as usize), &layer, None);
    }
    let cube = cube.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2Array),
        ..Default::default()
    });

    // The surfaces.
    let projection = perspective_infinite_reverse(2.0 * TAN.atan(), 1.0, NEAR);
    let camera: Mat4 = projection * look_at_mat4(EYE, TARGET, Vec3::Y);
    let camera = camera.to_cols_array_2d();
    let view = |format, samples| {
        let texture = renderer.texture(format, WIDTH, 1, samples);
        texture.create_view(&Default::default())
    };
    let depth = view(TextureFormat::Depth32Float, SAMPLES);
    let colours = view(TextureFormat::Rgba16Float, SAMPLES);
    let surfaces = view(TextureFormat::Rgba16Float, 1);
    let lights = Lights {
        faces: std::array::from_fn(|face| views.matrix(face)),
        positions: LAMPS.map(|lamp| lamp.extend(0.0)),
        intensities: INTENSITIES.map(|intensity| intensity.extend(SIGMA_T)),
    };
    let lights = screen.buffer(bytemuck::bytes_of(&lights), BufferUsages::UNIFORM);
    let resources = [
        lights.as_entire_binding(),
        BindingResource::TextureView(&cube),
    ];
    renderer.draw(
        &mut encoder,
        &camera,
        &depth,
        Some((&colours, &surfaces, &resources)),
    );

    // The fog before them.
    let fog = view(TextureFormat::Rgba16Float, 1);
    let lamp =
        |i: usize| Emitter::point(LAMPS[i], INTENSITIES[i], f32::INFINITY, Emission::Isotropic);
    let [caged, free] = [lamp(0)?, lamp(1)?];
    let sigma_a = Vec3::splat(SIGMA_T - SIGMA_S);
    fog_pass.record(
        &mut encoder,
        &FogFrame {
            eyes: &[FogEye {
                view_projection: camera,
                depth: &depth,
                fog: &fog,
            }],
            empty_depth: 0.0,
            reach: 60.0,
            medium: &Medium::new(Vec3::splat(SIGMA_S), sigma_a, PhaseFunction::Isotropic)?,
            lights: &[
                FogLight::shadowed(&caged, DepthLayers::new(&views, &cube)),
                FogLight::unshadowed(&free),
            ],
        },
    )?;

    // The picture.
    let pipeline = screen.pipeline(&[PICTURE]);
    let textures = [&surfaces, &fog].map(BindingResource::TextureView);
    let group = screen.group(&pipeline.get_bind_group_layout(0), &textures);
    screen.draw(&mut encoder, &pipeline, &group);
    Ok(screen.show(encoder))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    screen::run("frame", WIDTH, draw)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use gpu_backend::testing::Shader;
    use reference::oracle::closed_form;

    use super::*;

    #[test]
    fn the_shaders_are_valid() {
        Shader::new(&[SCENE]).unwrap();
        Shader::new(&[PICTURE]).unwrap();
    }

    /// The distance to the nearest box along a ray, in f64.
    fn hit(origin: DVec3, direction: DVec3) -> f64 {
        let distances = boxes().map(|corners| {
            let [a, b] = corners.map(|v| (v.truncate().as_dvec3() - origin) / direction);
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

    /// The airlight along a ray due to a lamp: all of it, or with a shadow map
    /// short parts, each lit if its middle is.
    fn airlight(direction: DVec3, end: f64, lamp: usize) -> f64 {
        let eye = EYE.as_dvec3();
        let to_lamp = LAMPS[lamp].as_dvec3() - eye;
        let (foot, h) = (direction.dot(to_lamp), direction.cross(to_lamp).length());
        let (sigma_s, sigma_t) = (f64::from(SIGMA_S), f64::from(SIGMA_T));
        let between = |a, b| closed_form::isotropic(sigma_s, sigma_t, foot, h, a, b);
        if lamp > 0 {
            return between(0.0, end);
        }
        // Equal angles at the lamp: finer where there is more light.
        let [first, last] = [0.0, end].map(|x: f64| (x - foot).atan2(h));
        let borders: Vec<f64> = (0..=2000)
            .map(|i| foot + h * (first + (last - first) * f64::from(i) / 2000.0).tan())
            .collect();
        let lit = borders.windows(2).filter(|part| {
            let middle = 0.5 * (part[0] + part[1]) * direction - to_lamp;
            hit(LAMPS[lamp].as_dvec3(), middle.normalize()) >= middle.length()
        });
        lit.map(|part| between(part[0], part[1])).sum()
    }

    /// The green of the fog in a pixel: along the ray through its centre, the mean of the
    /// parts before the surfaces in its samples, which are where WebGPU puts them.
    fn expected(pixel: u32) -> f64 {
        let forward = (TARGET - EYE).as_dvec3().normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        // A direction whose part along `forward` is 1.
        let direction = |x: f64, y: f64| {
            let at = |i: u32, share: f64| {
                f64::from(TAN) * (2.0 * (f64::from(i) + share) / f64::from(WIDTH) - 1.0)
            };
            forward + at(pixel % WIDTH, x) * right - at(pixel / WIDTH, y) * up
        };
        let centre = direction(0.5, 0.5);
        let samples = [
            (0.375, 0.125),
            (0.875, 0.375),
            (0.125, 0.625),
            (0.625, 0.875),
        ];
        let light = samples.map(|(x, y)| {
            let sample = direction(x, y);
            let depth = hit(EYE.as_dvec3(), sample.normalize()) / sample.length();
            let end = (depth * centre.length()).min(60.0);
            let of_lamp =
                |i: usize| f64::from(INTENSITIES[i].y) * airlight(centre.normalize(), end, i);
            of_lamp(0) + of_lamp(1)
        });
        light.iter().sum::<f64>() / 4.0
    }

    #[test]
    fn the_fog_is_that_of_the_oracle() {
        let Some(screen) = Screen::for_test(WIDTH, WIDTH) else {
            return;
        };
        let picture = draw(&screen).unwrap();
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for pixel in (0..WIDTH * WIDTH).step_by(127) {
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
