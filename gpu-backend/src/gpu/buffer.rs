//! Typed buffers on a device.

use std::marker::PhantomData;

use super::Context;
use crate::{Buffer, Element, Error, Memory};

/// Memory of a GPU; buffers are [`GpuBuffer`]s. All handles on one device share
/// it, whether they submit or record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GpuMemory;

impl Memory for GpuMemory {
    type Buffer<T: Element> = GpuBuffer<T>;
}

/// `len` elements of type `T` in a storage buffer.
///
/// A shader sees an `array<T>` that may be longer than `len`, because a binding
/// cannot be empty and sizes are multiples of four bytes: pass lengths as
/// parameters and do not use `arrayLength`.
///
/// Like a `Vec`, a buffer has one owner: what a step writes is passed as `&mut`,
/// so that reading and writing the same memory is a compile error.
#[derive(Debug)]
pub struct GpuBuffer<T> {
    buffer: wgpu::Buffer,
    len: usize,
    elements: PhantomData<T>,
}

impl<T: Element> Buffer<T> for GpuBuffer<T> {
    fn len(&self) -> usize {
        self.len
    }
}

/// What a buffer that is made here may be used for.
const USAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);

impl<T: Element> GpuBuffer<T> {
    /// Treats the first `len` elements of a buffer of the caller's as a typed
    /// buffer. `wgpu::Buffer` is a handle: keep a clone to go on using it.
    ///
    /// Two typed buffers of the same memory can be made this way; a step that
    /// is given both and writes to one fails with [`Error::Aliased`].
    ///
    /// # Errors
    /// [`Error::UnsuitableBuffer`] if the buffer is not a storage buffer, or
    /// smaller than the elements (rounded up to four bytes), or empty.
    pub fn from_wgpu(buffer: wgpu::Buffer, len: usize) -> Result<Self, Error> {
        let needed = bytes_of::<T>(len).and_then(|bytes| bytes.checked_next_multiple_of(4));
        let large_enough = needed.is_some_and(|needed| buffer.size() >= needed.max(4));
        if !large_enough || !buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
            let bytes = needed.map_or("more".into(), |n| n.max(4).to_string());
            return Err(unsuitable(
                &buffer,
                format!("usage STORAGE and at least {bytes} bytes for {len} elements"),
            ));
        }
        Ok(Self {
            buffer,
            len,
            elements: PhantomData,
        })
    }

    /// The untyped buffer, for commands of the caller's own.
    pub fn as_wgpu(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    pub(super) fn into_wgpu(self) -> wgpu::Buffer {
        self.buffer
    }

    /// Bytes of the elements, rounded up to what copies need.
    pub(super) fn copy_size(&self) -> u64 {
        (self.len as u64 * size_of::<T>() as u64).next_multiple_of(4)
    }

    pub(super) fn require(&self, usage: wgpu::BufferUsages) -> Result<(), Error> {
        if self.buffer.usage().contains(usage) {
            return Ok(());
        }
        Err(unsuitable(&self.buffer, format!("usage {usage:?}")))
    }

    /// A new buffer, filled by `data` or zeros.
    pub(super) fn new(context: &Context, len: usize, data: Option<&[T]>) -> Result<Self, Error> {
        let requested = bytes_of::<T>(len).unwrap_or(u64::MAX);
        let limits = context.limits();
        // Steps bind whole buffers.
        let limit = limits
            .max_buffer_size
            .min(limits.max_storage_buffer_binding_size);
        // At least one element of any WGSL type that is used in arrays here.
        let least = (size_of::<T>() as u64).max(16);
        let size = requested.max(least).checked_next_multiple_of(4);
        let Some(size) = size.filter(|size| *size <= limit) else {
            return Err(Error::TooLarge {
                what: "a buffer",
                requested,
                limit,
            });
        };
        // What a lost device makes is found out by mapping it.
        let buffer = match data {
            Some(data) => context.scoped("a buffer", || {
                let buffer = create(context, size, true);
                match buffer.get_mapped_range_mut(..) {
                    Ok(mut view) => {
                        let bytes = bytemuck::cast_slice(data);
                        view.slice(..bytes.len()).copy_from_slice(bytes);
                    }
                    Err(_) => return None,
                }
                buffer.unmap();
                Some(buffer)
            })?,
            None => {
                context.check_alive()?;
                Some(context.scoped("a buffer", || create(context, size, false))?)
            }
        };
        Ok(Self {
            buffer: buffer.ok_or_else(|| context.lost())?,
            len,
            elements: PhantomData,
        })
    }
}

fn create(context: &Context, size: u64, mapped_at_creation: bool) -> wgpu::Buffer {
    context.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: USAGE,
        mapped_at_creation,
    })
}

fn bytes_of<T>(len: usize) -> Option<u64> {
    (len as u64).checked_mul(size_of::<T>() as u64)
}

fn unsuitable(buffer: &wgpu::Buffer, expected: String) -> Error {
    Error::UnsuitableBuffer {
        bytes: buffer.size(),
        usage: format!("{:?}", buffer.usage()),
        expected,
    }
}
