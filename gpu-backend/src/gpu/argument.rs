//! What a kernel is given.

use super::{Context, GpuBuffer};
use crate::{Element, Error};

/// One binding of a [`Kernel`](super::Kernel), or of a pass of the caller's own
/// ([`Context::bind_group`]).
#[derive(Debug)]
pub struct Argument<'a>(Value<'a>);

#[derive(Debug)]
enum Value<'a> {
    Uniform(Vec<u8>),
    Table(Vec<u8>),
    Read(&'a wgpu::Buffer),
    Write(&'a wgpu::Buffer),
    Texture(&'a wgpu::TextureView, TextureKind),
    Sampler(&'a wgpu::Sampler, wgpu::SamplerBindingType),
}

/// What a texture is declared as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct TextureKind {
    texels: wgpu::TextureSampleType,
    dimension: wgpu::TextureViewDimension,
    multisampled: bool,
}

/// How a binding is declared in the shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Uniform,
    Read,
    Write,
    Texture(TextureKind),
    Sampler(wgpu::SamplerBindingType),
}

impl<'a> Argument<'a> {
    /// Parameters: `var<uniform>`. Copied here; each dispatch sees its own.
    /// Laid out as WGSL lays out uniforms (members of nested structs and
    /// arrays at multiples of 16 bytes), padded at the end to 16.
    pub fn uniform<T: Element>(value: T) -> Self {
        let mut bytes = bytemuck::bytes_of(&value).to_vec();
        bytes.resize(bytes.len().max(1).next_multiple_of(16), 0);
        Self(Value::Uniform(bytes))
    }

    /// A few values that are read, `var<storage>`, and uploaded for this
    /// dispatch alone. May be empty.
    pub fn table<T: Element>(values: &[T]) -> Self {
        let mut bytes = bytemuck::cast_slice(values).to_vec();
        // A binding holds at least one element.
        bytes.resize(bytes.len().max(size_of::<T>()), 0);
        Self(Value::Table(bytes))
    }

    /// A buffer that is read: `var<storage>`.
    pub fn read<T: Element>(buffer: &'a GpuBuffer<T>) -> Self {
        Self(Value::Read(buffer.as_wgpu()))
    }

    /// A buffer that is written, and perhaps read: `var<storage, read_write>`.
    pub fn write<T: Element>(buffer: &'a mut GpuBuffer<T>) -> Self {
        Self(Value::Write(buffer.as_wgpu()))
    }

    /// A two-dimensional texture that is read texel by texel:
    /// `var texture: texture_2d<f32>`.
    pub fn texture(view: &'a wgpu::TextureView) -> Self {
        let texels = wgpu::TextureSampleType::Float { filterable: false };
        Self::texture_of(view, texels, wgpu::TextureViewDimension::D2)
    }

    /// A texture of any kind that is not multisampled, such as `var depth:
    /// texture_depth_2d_array` for
    /// [`Depth`](wgpu::TextureSampleType::Depth) and
    /// [`D2Array`](wgpu::TextureViewDimension::D2Array). The layers of a cube can be seen as
    /// an array, and so read texel by texel, without a copy.
    pub fn texture_of(
        view: &'a wgpu::TextureView,
        texels: wgpu::TextureSampleType,
        dimension: wgpu::TextureViewDimension,
    ) -> Self {
        let kind = TextureKind {
            texels,
            dimension,
            multisampled: false,
        };
        Self(Value::Texture(view, kind))
    }

    /// A two-dimensional texture with several samples in each texel, such as `var depth:
    /// texture_depth_multisampled_2d` for [`Depth`](wgpu::TextureSampleType::Depth).
    pub fn multisampled(view: &'a wgpu::TextureView, texels: wgpu::TextureSampleType) -> Self {
        let kind = TextureKind {
            texels,
            dimension: wgpu::TextureViewDimension::D2,
            multisampled: true,
        };
        Self(Value::Texture(view, kind))
    }

    /// A sampler: `var nearest: sampler`, or `sampler_comparison` for
    /// [`Comparison`](wgpu::SamplerBindingType::Comparison). Depths take one that is
    /// [`NonFiltering`](wgpu::SamplerBindingType::NonFiltering).
    pub fn sampler(sampler: &'a wgpu::Sampler, kind: wgpu::SamplerBindingType) -> Self {
        Self(Value::Sampler(sampler, kind))
    }

    pub(super) fn kind(&self) -> Kind {
        match self.0 {
            Value::Uniform(_) => Kind::Uniform,
            Value::Table(_) | Value::Read(_) => Kind::Read,
            Value::Write(_) => Kind::Write,
            Value::Texture(_, kind) => Kind::Texture(kind),
            Value::Sampler(_, kind) => Kind::Sampler(kind),
        }
    }

    /// The buffer and the place in it to bind, or the texture.
    fn resource(&self, context: &Context) -> Result<Resource, Error> {
        Ok(match &self.0 {
            Value::Uniform(bytes) => {
                let (buffer, offset) = context.uniform(bytes)?;
                Resource::Buffer(buffer, offset, wgpu::BufferSize::new(bytes.len() as u64))
            }
            Value::Table(bytes) => {
                let buffer = GpuBuffer::new(context, bytes.len(), Some(bytes))?;
                Resource::Buffer(buffer.into_wgpu(), 0, None)
            }
            Value::Read(buffer) | Value::Write(buffer) => {
                Resource::Buffer((*buffer).clone(), 0, None)
            }
            Value::Texture(view, _) => Resource::Texture((*view).clone()),
            Value::Sampler(sampler, _) => Resource::Sampler((*sampler).clone()),
        })
    }
}

impl Kind {
    fn layout(self) -> wgpu::BindingType {
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        match self {
            Self::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Self::Read => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Self::Write => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
            Self::Texture(kind) => wgpu::BindingType::Texture {
                sample_type: kind.texels,
                view_dimension: kind.dimension,
                multisampled: kind.multisampled,
            },
            Self::Sampler(kind) => wgpu::BindingType::Sampler(kind),
        }
    }
}

/// A resolved binding.
enum Resource {
    Buffer(wgpu::Buffer, u64, Option<wgpu::BufferSize>),
    Texture(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Context {
    /// The layout of a group of such arguments: the `i`-th is `@binding(i)`.
    ///
    /// To be called from within [`Context::cached`] or [`Context::scoped`].
    pub fn bind_group_layout(
        &self,
        label: &str,
        stages: wgpu::ShaderStages,
        arguments: &[Argument<'_>],
    ) -> wgpu::BindGroupLayout {
        let entries: Vec<_> = (0..)
            .zip(arguments)
            .map(|(binding, argument)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: stages,
                ty: argument.kind().layout(),
                count: None,
            })
            .collect();
        self.device()
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
    }

    /// The arguments as a bind group, for passes of the caller's own. Uniforms and
    /// tables are uploaded; limits are checked as for a dispatch.
    ///
    /// # Errors
    /// Those of [`Gpu::dispatch`](super::Gpu::dispatch) but for its workgroups.
    pub fn bind_group(
        &self,
        label: &'static str,
        layout: &wgpu::BindGroupLayout,
        arguments: &[Argument<'_>],
    ) -> Result<wgpu::BindGroup, Error> {
        check(self, label, &[arguments])?;
        self.bind_checked(label, layout, arguments)
    }

    /// The same for arguments that have been checked.
    pub(super) fn bind_checked(
        &self,
        label: &'static str,
        layout: &wgpu::BindGroupLayout,
        arguments: &[Argument<'_>],
    ) -> Result<wgpu::BindGroup, Error> {
        let resources = arguments
            .iter()
            .map(|argument| argument.resource(self))
            .collect::<Result<Vec<_>, Error>>()?;
        // Storing a uniform has shown already that the device is there.
        if !arguments.iter().any(|a| a.kind() == Kind::Uniform) {
            self.check_alive()?;
        }
        let entries: Vec<_> = (0..)
            .zip(&resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: match resource {
                    Resource::Buffer(buffer, offset, size) => {
                        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer,
                            offset: *offset,
                            size: *size,
                        })
                    }
                    Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
                    Resource::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
                },
            })
            .collect();
        self.scoped(label, || {
            self.device().create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries: &entries,
            })
        })
    }
}

/// The checks that the device would make later, where its error would reach
/// somebody else.
pub(super) fn check(
    context: &Context,
    what: &'static str,
    groups: &[&[Argument<'_>]],
) -> Result<(), Error> {
    let limits = context.limits();
    let all = || groups.iter().copied().flatten();
    let count = |kind: fn(Kind) -> bool| all().filter(|a| kind(a.kind())).count() as u64;
    let within = |unit, requested: u64, limit: u32| {
        let limit = u64::from(limit);
        (requested <= limit).then_some(()).ok_or(Error::Limit {
            what,
            unit,
            requested,
            limit,
        })
    };
    within("bind groups", groups.len() as u64, limits.max_bind_groups)?;
    within(
        "uniform bindings",
        count(|kind| kind == Kind::Uniform),
        limits.max_uniform_buffers_per_shader_stage,
    )?;
    within(
        "storage bindings",
        count(|kind| matches!(kind, Kind::Read | Kind::Write)),
        limits.max_storage_buffers_per_shader_stage,
    )?;
    for argument in all() {
        let (requested, limit) = match &argument.0 {
            Value::Uniform(bytes) => (bytes.len() as u64, limits.max_uniform_buffer_binding_size),
            Value::Table(bytes) => (bytes.len() as u64, limits.max_storage_buffer_binding_size),
            Value::Read(buffer) | Value::Write(buffer) => {
                (buffer.size(), limits.max_storage_buffer_binding_size)
            }
            Value::Texture(..) | Value::Sampler(..) => continue,
        };
        if requested > limit {
            return Err(Error::TooLarge {
                what,
                requested,
                limit,
            });
        }
    }
    for (i, argument) in all().enumerate() {
        let Value::Write(written) = argument.0 else {
            continue;
        };
        let twice = all().enumerate().any(|(j, other)| match other.0 {
            Value::Read(buffer) | Value::Write(buffer) => i != j && buffer == written,
            _ => false,
        });
        if twice {
            return Err(Error::Aliased { what });
        }
    }
    Ok(())
}
