#![doc = include_str!("../../docs/gpu.md")]

mod argument;
mod buffer;
mod cache;
mod context;
mod dispatch;
mod encode;
mod in_shader;
mod queued;
#[cfg(not(target_family = "wasm"))]
mod read_back;
#[cfg(not(target_family = "wasm"))]
mod request;
#[cfg(not(target_family = "wasm"))]
mod time;
mod uniform;

use std::sync::{Mutex, MutexGuard, PoisonError};

pub use argument::Argument;
pub use buffer::{GpuBuffer, GpuMemory};
pub use context::Context;
pub use dispatch::{INDEX_WGSL, Kernel, Workgroups};
pub use encode::{Encode, Queued, Recording};
pub use in_shader::InShader;
#[cfg(not(target_family = "wasm"))]
pub use request::ADAPTER_VARIABLE;
#[cfg(not(target_family = "wasm"))]
pub use time::{Clock, Timing};

use crate::{Backend, Buffer, BufferOf, Element, Error};

/// A handle on a GPU, generic over where its commands go.
///
/// * `Gpu<Queued>` owns a pending command encoder. Steps are recorded into it
///   and nothing is submitted until something is read, waited for, or
///   [`submit`](Gpu::submit)ted.
/// * `Gpu<Recording<'_>>` records into a command encoder of the caller's and
///   never submits; therefore it cannot read back.
///
/// A step is implemented once, `impl<E: Encode> Step for Gpu<E>`, and serves
/// both. Handles are `Send` and `Sync`; a handle of one's own per thread is
/// [`Gpu::new`] with a clone of the [`Context`]. What one handle has recorded
/// is not visible to another before it is submitted, and is dropped with the
/// handle.
#[derive(Debug)]
pub struct Gpu<E: Encode> {
    context: Context,
    encode: E,
    statistics: Mutex<Statistics>,
}

/// What a handle has done so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Dispatches recorded.
    pub dispatches: u64,
    /// Command buffers submitted.
    pub submits: u64,
    /// Times the host waited for data from the device.
    pub read_backs: u64,
}

impl<E: Encode> Gpu<E> {
    fn with_encode(context: Context, encode: E) -> Self {
        Self {
            context,
            encode,
            statistics: Mutex::default(),
        }
    }

    /// The device and what is shared on it.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// True if the processor plays the GPU. Its times represent nothing.
    pub fn is_software(&self) -> bool {
        self.context.is_software()
    }

    /// Counts since the handle was made.
    pub fn statistics(&self) -> Statistics {
        *lock(&self.statistics)
    }

    /// Records commands of any kind after those that are recorded already.
    ///
    /// Not to be nested: no other step may be called on the same handle from
    /// within `record`. In a queued handle, mistakes come back as an
    /// [`Error::Rejected`] when the work is submitted; in a recording one they
    /// surface where the caller finishes the encoder.
    ///
    /// # Errors
    /// [`Error::Rejected`], [`Error::OutOfMemory`] or [`Error::DeviceLost`] for
    /// objects that were created meanwhile.
    pub fn with_encoder<R>(
        &self,
        what: &str,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> R,
    ) -> Result<R, Error> {
        self.encode.with_encoder(&self.context, |encoder| {
            self.context.scoped(what, || record(encoder))
        })
    }

    /// Copies all of `source` over `target`.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if their lengths differ,
    /// [`Error::UnsuitableBuffer`] if a buffer of the caller's was made without
    /// the usage `COPY_SRC` or `COPY_DST`, [`Error::Aliased`] if both are the
    /// same memory, [`Error::DeviceLost`].
    pub fn copy<T: Element>(
        &self,
        source: &GpuBuffer<T>,
        target: &mut GpuBuffer<T>,
    ) -> Result<(), Error> {
        if source.len() != target.len() {
            return Err(Error::LengthMismatch {
                what: "the target of a copy",
                expected: source.len(),
                actual: target.len(),
            });
        }
        source.require(wgpu::BufferUsages::COPY_SRC)?;
        target.require(wgpu::BufferUsages::COPY_DST)?;
        let (from, to) = (source.as_wgpu(), target.as_wgpu());
        if from == to {
            return Err(Error::Aliased { what: "a copy" });
        }
        self.context.check_alive()?;
        if source.is_empty() {
            return Ok(());
        }
        self.with_encoder("a copy", |encoder| {
            encoder.copy_buffer_to_buffer(from, 0, to, 0, source.copy_size());
        })
    }

    /// Replaces the elements of `target`, after the steps that are recorded
    /// already and before those that follow.
    ///
    /// # Errors
    /// Those of [`Gpu::copy`] and of [`Backend::upload`].
    pub fn write<T: Element>(&self, target: &mut GpuBuffer<T>, data: &[T]) -> Result<(), Error> {
        self.copy(
            &GpuBuffer::new(&self.context, data.len(), Some(data))?,
            target,
        )
    }
}

impl<E: Encode> Backend for Gpu<E> {
    type Memory = GpuMemory;

    fn name(&self) -> &str {
        &self.context.adapter().name
    }

    fn upload<T: Element>(&self, data: &[T]) -> Result<BufferOf<Self, T>, Error> {
        GpuBuffer::new(&self.context, data.len(), Some(data))
    }

    fn zeros<T: Element>(&self, len: usize) -> Result<BufferOf<Self, T>, Error> {
        GpuBuffer::new(&self.context, len, None)
    }

    fn check_alive(&self) -> Result<(), Error> {
        self.context.check_alive()
    }
}

/// Nothing that is locked here is left half-changed by a panic.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
