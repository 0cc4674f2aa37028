//! Shaders without a device, and pictures against rays on the CPU with one.

use glam::camera::rh::proj::directx::{perspective, perspective_infinite_reverse};
use glam::camera::rh::view::look_to_mat4;
use glam::{Mat4, Quat, Vec3};
use gpu_backend::gpu::Queued;
use gpu_backend::testing::{Shader, gpu};
use gpu_backend::{Cpu, Download, assert_same_layout};
use wgpu::{TextureFormat, TextureUsages};

use super::gather::shader;
use super::*;
use crate::scene::{Bounds, Cone, Emission, Medium, PhaseFunction};
use crate::voxelized::VoxelShadow;
use crate::{Emitter, Gather, LitRays, Ray};

/// Rows of copies are multiples of 256 bytes.
const SIZE: [u32; 2] = [64, 24];
const TEXELS: u32 = 128;
const LAMP: Vec3 = Vec3::new(0.5, 1.0, -4.0);

/// The fog as it is read back.
type Pixels = Vec<[f32; 4]>;

#[test]
fn shaders_are_valid_and_see_scenes_as_they_are() {
    for samples in [1, 4] {
        let unshadowed = shader::<Unshadowed>(samples).unwrap().finish(1);
        let shadowed = shader::<VoxelShadow<VoxelVolume<GpuMemory>, GpuMemory>>(samples).unwrap();
        let storage = shadowed.bindings().iter().filter(|b| b.kind.is_storage());
        assert!(2 + storage.count() <= 8);
        for parts in [unshadowed, shadowed.finish(1)] {
            let shader = Shader::new(&parts).unwrap();
            assert_same_layout!(
                shader,
                "Scene",
                Scene {
                    medium,
                    eye,
                    depth,
                    right,
                    up,
                    forward,
                    size,
                    empty,
                    reach,
                    first,
                    lights,
                    cookies,
                    adds,
                }
            );
        }
    }
    Shader::new(&[DRAW]).unwrap();
}

/// A texture of depths, or one that is drawn into.
fn texture(
    gpu: &Gpu<Queued>,
    format: TextureFormat,
    [width, height, layers]: [u32; 3],
    sample_count: u32,
) -> wgpu::Texture {
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let read = TextureUsages::COPY_SRC;
    gpu.context()
        .device()
        .create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: if sample_count == 1 {
                usage | read
            } else {
                usage
            },
            view_formats: &[],
        })
}

fn layer(texture: &wgpu::Texture, layer: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..wgpu::TextureViewDescriptor::default()
    })
}

/// What a renderer draws: depths, those of all samples of a pixel side by side.
const DEPTHS: &str = "
@group(0) @binding(0) var<uniform> size: vec2<u32>;
@group(0) @binding(1) var<storage> depths: array<f32>;
@vertex
fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment
fn draw(@builtin(position) at: vec4<f32>, @builtin(sample_index) s: u32) -> @builtin(frag_depth) f32 {
    let pixel = vec2<u32>(at.xy);
    return depths[(pixel.y * size.x + pixel.x) * size.y + s];
}";

/// A depth texture with a layer for each list of depths.
fn drawn(gpu: &Gpu<Queued>, size: [u32; 2], samples: u32, layers: &[Vec<f32>]) -> wgpu::Texture {
    let [width, height] = size;
    let count = layers.len() as u32;
    let drawn = texture(
        gpu,
        TextureFormat::Depth32Float,
        [width, height, count],
        samples,
    );
    let device = gpu.context().device();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(DEPTHS.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: samples,
            ..wgpu::MultisampleState::default()
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    });
    for (i, depths) in (0..).zip(layers) {
        let depths = gpu.upload(depths).unwrap();
        let arguments = [Argument::uniform([width, samples]), Argument::read(&depths)];
        let layout = pipeline.get_bind_group_layout(0);
        let group = gpu
            .context()
            .bind_group("depths", &layout, &arguments)
            .unwrap();
        let view = layer(&drawn, i);
        gpu.with_encoder("depths", |encoder| {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        })
        .unwrap();
    }
    drawn
}

/// The directions through the pixels of a view, as long as the shader has them.
fn directions(view: &View, [width, height]: [u32; 2]) -> Vec<glam::Vec4> {
    (0..width * height)
        .map(|i| {
            let x = 2.0 * ((i % width) as f32 + 0.5) / width as f32 - 1.0;
            let y = 1.0 - 2.0 * ((i / width) as f32 + 0.5) / height as f32;
            view.forward + x * view.right + y * view.up
        })
        .collect()
}

/// The depth of what is at a distance.
fn depth(view: &View, direction: glam::Vec4, distance: f32, empty: f32) -> f32 {
    if distance == f32::INFINITY {
        return empty;
    }
    view.depth / (distance / direction.truncate().length()) + direction.w
}

/// How far a surface is from the eye, by pixel and sample; every seventh is the sky.
fn surface(pixel: usize, sample: usize) -> f32 {
    let i = 4 * pixel + sample;
    if i % 7 == 3 {
        f32::INFINITY
    } else {
        2.0 + 1.3 * ((i * 37) % 11) as f32
    }
}

/// A ball between the lamp and much of the view, as the lamp sees it.
fn blocker(direction: Vec3) -> f32 {
    let to_middle = Vec3::new(0.3, 0.4, -3.2) - LAMP;
    let along = to_middle.dot(direction);
    let inside = 0.5_f32.powi(2) - to_middle.cross(direction).length_squared();
    if along > 0.0 && inside > 0.0 {
        along - inside.sqrt()
    } else {
        f32::INFINITY
    }
}

/// The cube that a renderer draws around the lamp.
fn cube() -> (DepthViews, Vec<Vec<f32>>) {
    let views = DepthViews::cube(LAMP, 0.05).unwrap();
    let faces = (0..6).map(|face| {
        let view = View::new(&views.matrix(face)).unwrap();
        let directions = directions(&view, [TEXELS; 2]).into_iter();
        let depths = directions.map(|v| {
            let distance = blocker(v.truncate().normalize());
            depth(&view, v, distance, 0.0)
        });
        depths.collect()
    });
    let faces = faces.collect();
    (views, faces)
}

fn lamp() -> Emitter {
    Emitter::point(
        LAMP,
        Vec3::new(9.0, 7.0, 4.0),
        f32::INFINITY,
        Emission::Isotropic,
    )
    .unwrap()
}

/// Lights without a shadow map: a spot, and a sun.
fn unshadowed() -> [Emitter; 2] {
    let cone = Cone {
        inner: 0.3,
        outer: 0.6,
    };
    let spot = Emission::spot(Quat::from_rotation_x(-1.2), cone, None).unwrap();
    [
        Emitter::point(
            Vec3::new(-1.0, 2.5, -5.0),
            Vec3::new(1.0, 4.0, 9.0),
            20.0,
            spot,
        )
        .unwrap(),
        Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::splat(0.2)).unwrap(),
    ]
}

fn medium() -> Medium {
    let phase = PhaseFunction::HenyeyGreenstein { g: 0.4 };
    let fog = Medium::new(
        Vec3::new(0.05, 0.06, 0.07),
        Vec3::new(0.03, 0.02, 0.01),
        phase,
    );
    let room = Bounds::new(Vec3::new(-20.0, -3.0, -25.0), Vec3::new(20.0, 9.0, 5.0)).unwrap();
    fog.unwrap().within(room)
}

/// The matrices of a view: depths with an end, and reversed ones without.
fn matrices(eye: Vec3) -> [(Mat4, f32); 2] {
    let look = look_to_mat4(eye, Vec3::new(0.0, -0.05, -1.0).normalize(), Vec3::Y);
    [
        (perspective(1.0, 1.6, 0.2, 60.0) * look, 1.0),
        (perspective_infinite_reverse(1.0, 1.6, 0.2) * look, 0.0),
    ]
}

/// The depths of all samples of a picture.
fn depths(view: &View, empty: f32, samples: usize, first: usize) -> Vec<f32> {
    let pixels = directions(view, SIZE).into_iter().enumerate();
    pixels
        .flat_map(|(pixel, v)| {
            (first..first + samples).map(move |s| depth(view, v, surface(pixel, s), empty))
        })
        .collect()
}

/// Draws a frame into the layers of a texture, one for each eye.
fn record(
    gpu: &Gpu<Queued>,
    pass: &mut FogPass,
    target: &wgpu::Texture,
    eyes: &[([[f32; 4]; 4], &wgpu::TextureView)],
    empty_depth: f32,
    lights: &[FogLight<'_>],
) {
    gpu.wait().unwrap();
    let targets: Vec<_> = (0..).zip(eyes).map(|(i, _)| layer(target, i)).collect();
    let eyes = eyes
        .iter()
        .zip(&targets)
        .map(|((matrix, depth), fog)| FogEye {
            view_projection: *matrix,
            depth,
            fog,
        });
    let frame = FogFrame {
        eyes: &eyes.collect::<Vec<_>>(),
        empty_depth,
        reach: f32::INFINITY,
        medium: &medium(),
        lights,
    };
    let mut encoder = encoder(gpu);
    pass.record(&mut encoder, &frame).unwrap();
    gpu.context().queue().submit([encoder.finish()]);
}

fn encoder(gpu: &Gpu<Queued>) -> wgpu::CommandEncoder {
    let device = gpu.context().device();
    device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

/// The texels of a texture, as many of type `T` as there are.
fn read<T: gpu_backend::Element>(gpu: &Gpu<Queued>, texture: &wgpu::Texture) -> Vec<T> {
    let size = texture.size();
    let row = size.width * size_of::<T>() as u32;
    let texels = size.width * size.height * size.depth_or_array_layers;
    let buffer = gpu.zeros::<T>(texels as usize).unwrap();
    gpu.with_encoder("a copy", |encoder| {
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: buffer.as_wgpu(),
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: Some(size.height),
                },
            },
            size,
        );
    })
    .unwrap();
    gpu.download(&buffer).unwrap()
}

/// The fog of each eye.
fn fog(
    gpu: &Gpu<Queued>,
    pass: &mut FogPass,
    eyes: &[([[f32; 4]; 4], &wgpu::TextureView)],
    empty_depth: f32,
    lights: &[FogLight<'_>],
) -> Vec<Pixels> {
    let [width, height] = SIZE;
    let size = [width, height, eyes.len() as u32];
    let target = texture(gpu, TextureFormat::Rgba32Float, size, 1);
    record(gpu, pass, &target, eyes, empty_depth, lights);
    let pixels: Pixels = read(gpu, &target);
    let of_eyes = pixels.chunks((width * height) as usize);
    of_eyes.map(<[_]>::to_vec).collect()
}

/// The same by rays on the CPU, for samples from `first` on.
fn expected(view: &View, samples: usize, first: usize, is_shadowed: bool) -> Pixels {
    let cpu = Cpu::new();
    let medium = medium();
    let rays: Vec<Ray> = directions(view, SIZE)
        .into_iter()
        .enumerate()
        .flat_map(|(pixel, v)| {
            let ray = move |s| Ray::new(view.eye, v.truncate(), surface(pixel, s)).unwrap();
            (first..first + samples).map(ray)
        })
        .collect();
    let airlight = Quadrature::with_tolerance(medium.phase(), 1e-5).unwrap();
    let mut light = vec![[0.0; 4]; rays.len()];
    for emitter in unshadowed() {
        let lit = LitRays::new(&rays, &emitter, &medium).joined();
        cpu.gather(&lit, &Unshadowed, &airlight, &mut light)
            .unwrap();
    }
    let lamp = lamp();
    let lit = LitRays::new(&rays, &lamp, &medium).joined();
    let mut volume = VoxelVolume::new(&cpu, Resolution::new(512, 512, 256).unwrap()).unwrap();
    if is_shadowed {
        let (views, faces) = cube();
        let blockers = |ray: &epipolar::LightRay| {
            views.first_blocker(ray, |face, at| {
                let [x, y] = at.map(|share| ((share * TEXELS as f32) as u32).min(TEXELS - 1));
                faces[face][(y * TEXELS + x) as usize]
            })
        };
        let space = view.volume(&medium, f32::INFINITY);
        volume.update_from(&cpu, &lamp, &space, &blockers).unwrap();
    }
    let shadow = volume.source(Detail::Runs);
    cpu.gather(&lit, &shadow, &airlight, &mut light).unwrap();
    for (ray, light) in rays.iter().zip(&mut light) {
        let inside = medium.length_inside(ray.origin(), ray.direction(), ray.length());
        light[3] = (-medium.sigma_t().x * inside).exp();
    }
    let mean = |of: &[[f32; 4]]| -> [f32; 4] {
        std::array::from_fn(|i| of.iter().map(|light| light[i]).sum::<f32>() / of.len() as f32)
    };
    light.chunks(samples).map(mean).collect()
}

/// The root of the mean square of the difference over the mean.
fn rmse(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    assert_eq!(a.len(), b.len());
    let squares: f32 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    let mean = b.iter().sum::<f32>() / b.len() as f32;
    (squares / b.len() as f32).sqrt() / mean
}

fn d2_array(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    })
}

#[test]
fn fog_is_that_of_rays_on_the_cpu_whichever_way_depths_run() {
    let Some(gpu) = gpu() else { return };
    let (views, faces) = cube();
    let map = d2_array(&drawn(&gpu, [TEXELS; 2], 1, &faces));
    let (lamp, others) = (lamp(), unshadowed());
    let lights = [
        FogLight::shadowed(&lamp, DepthLayers::new(&views, &map)),
        FogLight::unshadowed(&others[0]),
        FogLight::unshadowed(&others[1]),
    ];
    let mut pass = FogPass::new(gpu.context(), TextureFormat::Rgba32Float, 1).unwrap();
    for (matrix, empty) in matrices(Vec3::new(0.0, 0.6, 1.0)) {
        let matrix = matrix.to_cols_array_2d();
        let view = View::new(&matrix).unwrap();
        let depths = layer(&drawn(&gpu, SIZE, 1, &[depths(&view, empty, 1, 0)]), 0);
        let found = fog(&gpu, &mut pass, &[(matrix, &depths)], empty, &lights).remove(0);
        let expected_here = expected(&view, 1, 0, true);
        let error = rmse(&found, &expected_here);
        let shadow = rmse(&expected(&view, 1, 0, false), &expected_here);
        println!("error {error}, shadows {shadow}");
        assert!(shadow > 0.02, "shadows are worth {shadow}");
        assert!(error < 1e-3, "{error}");
    }
}

#[test]
fn a_pixel_has_the_mean_fog_of_its_samples() {
    let Some(gpu) = gpu() else { return };
    let (views, faces) = cube();
    let map = d2_array(&drawn(&gpu, [TEXELS; 2], 1, &faces));
    let (lamp, others) = (lamp(), unshadowed());
    let lights = [
        FogLight::unshadowed(&others[0]),
        FogLight::unshadowed(&others[1]),
        FogLight::shadowed(&lamp, DepthLayers::new(&views, &map)),
    ];
    let (matrix, empty) = matrices(Vec3::new(0.0, 0.6, 1.0))[1];
    let matrix = matrix.to_cols_array_2d();
    let view = View::new(&matrix).unwrap();
    let mut pass = FogPass::new(gpu.context(), TextureFormat::Rgba32Float, 4).unwrap();
    let all = layer(&drawn(&gpu, SIZE, 4, &[depths(&view, empty, 4, 0)]), 0);
    let found = fog(&gpu, &mut pass, &[(matrix, &all)], empty, &lights).remove(0);
    let error = rmse(&found, &expected(&view, 4, 0, true));
    assert!(error < 1e-3, "{error}");
    // The same device, sample by sample.
    let mut pass = FogPass::new(gpu.context(), TextureFormat::Rgba32Float, 1).unwrap();
    let mut mean = vec![[0.0; 4]; found.len()];
    for s in 0..4 {
        let one = layer(&drawn(&gpu, SIZE, 1, &[depths(&view, empty, 1, s)]), 0);
        let one = fog(&gpu, &mut pass, &[(matrix, &one)], empty, &lights).remove(0);
        for (mean, one) in mean.as_flattened_mut().iter_mut().zip(one.as_flattened()) {
            *mean += 0.25 * one;
        }
    }
    let error = rmse(&found, &mean);
    assert!(error < 5e-4, "{error}");
}

#[test]
fn two_eyes_at_once_are_each_by_itself() {
    let Some(gpu) = gpu() else { return };
    let (views, faces) = cube();
    let map = d2_array(&drawn(&gpu, [TEXELS; 2], 1, &faces));
    let lamp = lamp();
    let lights = [FogLight::shadowed(&lamp, DepthLayers::new(&views, &map))];
    let eyes = [-0.032, 0.032].map(|x| {
        let (matrix, empty) = matrices(Vec3::new(x, 0.6, 1.0))[1];
        let matrix = matrix.to_cols_array_2d();
        let depths = depths(&View::new(&matrix).unwrap(), empty, 1, 0);
        (matrix, depths)
    });
    let both = drawn(&gpu, SIZE, 1, &eyes.clone().map(|(_, depths)| depths));
    let layers = [0, 1].map(|i| layer(&both, i));
    let both = [(eyes[0].0, &layers[0]), (eyes[1].0, &layers[1])];
    let mut pass = FogPass::new(gpu.context(), TextureFormat::Rgba32Float, 1).unwrap();
    let found = fog(&gpu, &mut pass, &both, 0.0, &lights);
    assert_ne!(found[0], found[1]);
    for (eye, found) in both.iter().zip(found) {
        let alone = fog(&gpu, &mut pass, &[*eye], 0.0, &lights).remove(0);
        assert_eq!(found, alone);
    }
}

#[test]
fn without_lights_there_is_the_transmittance_of_the_medium() {
    let Some(gpu) = gpu() else { return };
    let (matrix, empty) = matrices(Vec3::ZERO)[1];
    let matrix = matrix.to_cols_array_2d();
    let view = View::new(&matrix).unwrap();
    let depth = layer(&drawn(&gpu, SIZE, 1, &[depths(&view, empty, 1, 0)]), 0);
    let mut pass = FogPass::new(gpu.context(), TextureFormat::Rgba32Float, 1).unwrap();
    let found = fog(&gpu, &mut pass, &[(matrix, &depth)], empty, &[]).remove(0);
    for (pixel, found) in found.iter().enumerate() {
        let v = directions(&view, SIZE)[pixel].truncate().normalize();
        let inside = medium().length_inside(view.eye, v, surface(pixel, 0));
        let transmittance = (-medium().sigma_t().x * inside).exp();
        assert_eq!(found[..3], [0.0; 3]);
        assert!(
            (found[3] - transmittance).abs() < 1e-5,
            "{found:?} {transmittance}"
        );
    }
}

#[test]
fn fog_is_blended_over_the_colours_of_a_picture() {
    let Some(gpu) = gpu() else { return };
    let (matrix, empty) = matrices(Vec3::new(0.0, 0.6, 1.0))[1];
    let matrix = matrix.to_cols_array_2d();
    let view = View::new(&matrix).unwrap();
    let depth = layer(&drawn(&gpu, SIZE, 1, &[depths(&view, empty, 1, 0)]), 0);
    let dim = Emitter::point(LAMP, Vec3::ONE, f32::INFINITY, Emission::Isotropic).unwrap();
    let lights = [FogLight::unshadowed(&dim)];
    let format = TextureFormat::Rgba8Unorm;
    let mut pass = FogPass::new(gpu.context(), TextureFormat::Rgba32Float, 1).unwrap();
    let fog = fog(&gpu, &mut pass, &[(matrix, &depth)], empty, &lights).remove(0);
    // A picture of one colour.
    let colour = [0.5, 0.25, 1.0, 0.75];
    let [width, height] = SIZE;
    let picture = texture(&gpu, format, [width, height, 1], 1);
    let view = layer(&picture, 0);
    gpu.with_encoder("a colour", |encoder| {
        let [r, g, b, a] = colour;
        let load = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a });
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load,
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
    })
    .unwrap();
    let mut pass = FogPass::new(gpu.context(), format, 1)
        .unwrap()
        .with_blend(FogPass::OVER);
    record(
        &gpu,
        &mut pass,
        &picture,
        &[(matrix, &depth)],
        empty,
        &lights,
    );
    for (found, fog) in read::<[u8; 4]>(&gpu, &picture).iter().zip(fog) {
        for i in 0..3 {
            let expected = (colour[i] as f32 * fog[3] + fog[i]).min(1.0);
            let found = f32::from(found[i]) / 255.0;
            assert!((found - expected).abs() < 0.01, "{found} {expected}");
        }
        assert_eq!(found[3], 191);
    }
}

#[test]
fn what_does_not_fit_is_refused_before_anything_is_recorded() {
    let Some(gpu) = gpu() else { return };
    let context = gpu.context();
    let half = TextureFormat::Rgba16Float;
    let refused = FogPass::new(context, half, 2);
    assert!(matches!(refused, Err(FogError::Samples { samples: 2 })));
    let mut pass = FogPass::new(context, half, 1).unwrap();
    let [width, height] = SIZE;
    let size = [width, height, 1];
    let view = |format, size, samples| layer(&texture(&gpu, format, size, samples), 0);
    let depth = view(TextureFormat::Depth32Float, size, 1);
    let fog = view(half, size, 1);
    let (matrix, _) = matrices(Vec3::ZERO)[1];
    let eye = FogEye {
        view_projection: matrix.to_cols_array_2d(),
        depth: &depth,
        fog: &fog,
    };
    let medium = medium();
    let frame = FogFrame {
        eyes: &[eye],
        empty_depth: 0.0,
        reach: f32::INFINITY,
        medium: &medium,
        lights: &[],
    };
    let mut error = |frame: &FogFrame<'_>| pass.record(&mut encoder(&gpu), frame).unwrap_err();
    let mut with_eye = |eye| {
        error(&FogFrame {
            eyes: &[eye],
            ..frame
        })
    };
    let samples = view(TextureFormat::Depth32Float, size, 4);
    let found = with_eye(FogEye {
        depth: &samples,
        ..eye
    });
    let expected = "the depth texture of an eye has 4 samples in each pixel, expected 1";
    assert_eq!(found.to_string(), expected);
    let found = with_eye(FogEye { depth: &fog, ..eye });
    assert!(matches!(found, FogError::Format { .. }), "{found}");
    let full = view(TextureFormat::Rgba32Float, size, 1);
    let found = with_eye(FogEye { fog: &full, ..eye });
    let expected = "the fog texture of an eye has the format Rgba32Float, expected Rgba16Float";
    assert_eq!(found.to_string(), expected);
    let small = view(half, [width, 7, 1], 1);
    let found = with_eye(FogEye { fog: &small, ..eye });
    let expected = "the depths of an eye have 64 × 24 pixels, and its fog has 64 × 7";
    assert_eq!(found.to_string(), expected);
    let parallel = Mat4::IDENTITY.to_cols_array_2d();
    let found = with_eye(FogEye {
        view_projection: parallel,
        ..eye
    });
    assert!(matches!(found, FogError::NoEye { .. }), "{found}");
    for reach in [0.0, -1.0, f32::NAN] {
        let found = error(&FogFrame { reach, ..frame });
        assert!(matches!(found, FogError::BadValue { .. }), "{found}");
    }
    let found = error(&FogFrame {
        empty_depth: 2.0,
        ..frame
    });
    assert!(matches!(found, FogError::BadValue { .. }), "{found}");
    let coloured = Medium::new([0.1, 0.1, 0.2], [0.0; 3], PhaseFunction::Isotropic).unwrap();
    let found = error(&FogFrame {
        medium: &coloured,
        ..frame
    });
    assert!(
        matches!(found, FogError::ColouredExtinction { .. }),
        "{found}"
    );
}
