//! Where commands go.

use std::sync::Mutex;

use super::{Context, Gpu, lock};

/// A place for commands: [`Queued`] or [`Recording`].
pub trait Encode: sealed::Sealed + Send + Sync + std::fmt::Debug {
    /// Calls `record` with the encoder, one caller at a time.
    #[doc(hidden)]
    fn with_encoder<R>(
        &self,
        context: &Context,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> R,
    ) -> R;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Queued {}
    impl Sealed for super::Recording<'_> {}
}

/// Commands wait in an encoder of the handle's own.
#[derive(Debug, Default)]
pub struct Queued {
    /// Taken, finished and submitted under this lock: two threads that share
    /// a handle would otherwise submit in the wrong order.
    pub(super) pending: Mutex<Option<wgpu::CommandEncoder>>,
}

impl Encode for Queued {
    fn with_encoder<R>(
        &self,
        context: &Context,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> R,
    ) -> R {
        record(lock(&self.pending).get_or_insert_with(|| new_encoder(context)))
    }
}

pub(super) fn new_encoder(context: &Context) -> wgpu::CommandEncoder {
    context
        .device()
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

/// Commands go to an encoder of the caller's.
#[derive(Debug)]
pub struct Recording<'a> {
    encoder: Mutex<&'a mut wgpu::CommandEncoder>,
}

impl Encode for Recording<'_> {
    fn with_encoder<R>(
        &self,
        _: &Context,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> R,
    ) -> R {
        record(&mut lock(&self.encoder))
    }
}

impl<'a> Gpu<Recording<'a>> {
    /// A handle whose steps are recorded into `encoder`, which must be of the
    /// same device. Nothing is submitted and nothing blocks.
    ///
    /// Parameters of steps and uploads travel with the queue's next submit, so
    /// the encoder must be submitted to the queue of the context.
    pub fn record(context: &Context, encoder: &'a mut wgpu::CommandEncoder) -> Self {
        let encoder = Mutex::new(encoder);
        Self::with_encode(context.clone(), Recording { encoder })
    }
}
