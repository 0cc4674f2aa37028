//! What a renderer has anyway: a device of its own, and a picture to draw into.
//! Nothing in this file knows of this crate.

use std::path::PathBuf;

/// A device and a picture of four `f32` per pixel.
pub(crate) struct Screen {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    picture: wgpu::Texture,
}

/// The format of the picture.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

impl Screen {
    /// The best adapter's device with WebGPU's default limits; without an adapter, the
    /// reason why there is none.
    pub(crate) fn open(width: u32, height: u32) -> Result<Self, String> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))
            .map_err(|error| error.to_string())?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))
            .map_err(|error| error.to_string())?;
        let picture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Ok(Self {
            device,
            queue,
            picture,
        })
    }

    /// The same for a test, which says if it is skipped, and fails if it must not be.
    #[cfg(test)]
    pub(crate) fn for_test(width: u32, height: u32) -> Option<Self> {
        match Self::open(width, height) {
            Ok(screen) => Some(screen),
            Err(reason) => {
                let required = std::env::var("REQUIRE_GPU").is_ok_and(|value| value == "1");
                assert!(!required, "REQUIRE_GPU is 1, but {reason}");
                eprintln!("SKIPPED: {reason}");
                None
            }
        }
    }

    /// A pipeline that draws one triangle over all of the picture with the entry points
    /// `vertex` and `fragment`.
    pub(crate) fn pipeline(&self, parts: &[&str]) -> wgpu::RenderPipeline {
        let module = self
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(parts.join("\n").into()),
            });
        self.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: None,
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fragment"),
                    compilation_options: Default::default(),
                    targets: &[Some(FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    /// A buffer with these contents, for a uniform or a storage binding.
    pub(crate) fn buffer(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: contents.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// A bind group, numbered as the resources come.
    pub(crate) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: resource.clone(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }

    /// Records a pass that draws the picture.
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        group: &wgpu::BindGroup,
    ) {
        let view = self.picture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Submits the commands and reads the picture, row by row.
    pub(crate) fn show(&self, mut encoder: wgpu::CommandEncoder) -> Vec<[f32; 4]> {
        let size = self.picture.size();
        let row = 16 * size.width;
        assert_eq!(row % wgpu::COPY_BYTES_PER_ROW_ALIGNMENT, 0, "whole rows");
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * size.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            self.picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            size,
        );
        self.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |mapped| {
            mapped.expect("the picture can be read");
        });
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("the device is there");
        let bytes = buffer
            .get_mapped_range(..)
            .expect("the picture was mapped above");
        bytemuck::pod_collect_to_vec(&bytes)
    }
}

/// Draws and saves a square picture, or says why there is none.
pub(crate) fn run<E: Into<Box<dyn std::error::Error>>>(
    name: &str,
    width: u32,
    draw: impl Fn(&Screen) -> Result<Vec<[f32; 4]>, E>,
) -> Result<(), Box<dyn std::error::Error>> {
    match Screen::open(width, width) {
        Ok(screen) => save(&draw(&screen).map_err(Into::into)?, width, name)?,
        Err(reason) => eprintln!("SKIPPED: {reason}"),
    }
    Ok(())
}

/// Writes a picture of so many pixels per row to the path that was given, or to the folder
/// for temporary files, and says where. Radiance 1 is white.
fn save(pixels: &[[f32; 4]], width: u32, name: &str) -> Result<(), image::ImageError> {
    let path = std::env::args_os().nth(1).map_or_else(
        || std::env::temp_dir().join(name).with_extension("png"),
        PathBuf::from,
    );
    let srgb = |linear: f32| (255.0 * linear.clamp(0.0, 1.0).powf(1.0 / 2.2)).round() as u8;
    let bytes: Vec<u8> = pixels
        .iter()
        .flat_map(|[r, g, b, _]| [srgb(*r), srgb(*g), srgb(*b)])
        .collect();
    let height = pixels.len() as u32 / width;
    image::save_buffer(&path, &bytes, width, height, image::ColorType::Rgb8)?;
    println!("{}", path.display());
    Ok(())
}
