//! What a kernel is given.

use super::{Context, GpuBuffer};
use crate::{Element, Error};

/// One binding of a [`Kernel`](super::Kernel).
#[derive(Debug)]
pub struct Argument<'a>(Value<'a>);

#[derive(Debug)]
enum Value<'a> {
    Uniform(Vec<u8>),
    Table(Vec<u8>),
    Read(&'a wgpu::Buffer),
    Write(&'a wgpu::Buffer),
}

/// How a binding is declared in the shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Uniform,
    Read,
    Write,
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

    pub(super) fn kind(&self) -> Kind {
        match self.0 {
            Value::Uniform(_) => Kind::Uniform,
            Value::Table(_) | Value::Read(_) => Kind::Read,
            Value::Write(_) => Kind::Write,
        }
    }

    pub(super) fn is_uniform(&self) -> bool {
        self.kind() == Kind::Uniform
    }

    /// The buffer and the place in it to bind.
    pub(super) fn place(&self, context: &Context) -> Result<Place, Error> {
        match &self.0 {
            Value::Uniform(bytes) => {
                let (buffer, offset) = context.uniform(bytes)?;
                Ok(Place {
                    buffer,
                    offset,
                    size: wgpu::BufferSize::new(bytes.len() as u64),
                })
            }
            Value::Table(bytes) => Ok(Place {
                buffer: GpuBuffer::new(context, bytes.len(), Some(bytes))?.into_wgpu(),
                offset: 0,
                size: None,
            }),
            Value::Read(buffer) | Value::Write(buffer) => Ok(Place {
                buffer: (*buffer).clone(),
                offset: 0,
                size: None,
            }),
        }
    }
}

/// A resolved binding.
pub(super) struct Place {
    pub(super) buffer: wgpu::Buffer,
    pub(super) offset: u64,
    pub(super) size: Option<wgpu::BufferSize>,
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
        count(|kind| kind != Kind::Uniform),
        limits.max_storage_buffers_per_shader_stage,
    )?;
    for argument in all() {
        let (requested, limit) = match &argument.0 {
            Value::Uniform(bytes) => (bytes.len() as u64, limits.max_uniform_buffer_binding_size),
            Value::Table(bytes) => (bytes.len() as u64, limits.max_storage_buffer_binding_size),
            Value::Read(buffer) | Value::Write(buffer) => {
                (buffer.size(), limits.max_storage_buffer_binding_size)
            }
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
            Value::Uniform(_) | Value::Table(_) => false,
        });
        if twice {
            return Err(Error::Aliased { what });
        }
    }
    Ok(())
}
