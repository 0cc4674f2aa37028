//! Submitting.

use super::{Context, Gpu, Queued, lock};
use crate::Error;

impl Gpu<Queued> {
    /// A handle with commands of its own on a device that is already in use.
    pub fn new(context: Context) -> Self {
        Self::with_encode(context, Queued::default())
    }

    /// Uses a device of the caller's; see [`Context::new`].
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self::new(Context::new(device, queue))
    }

    /// Starts the work that is recorded and does not wait for it. From then on
    /// other handles on the same device see its results.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], or [`Error::Rejected`] if commands from
    /// [`Gpu::with_encoder`] were not sound.
    pub fn submit(&self) -> Result<(), Error> {
        let mut pending = lock(&self.encode.pending);
        self.context.check_alive()?;
        match pending.take() {
            Some(encoder) => self.finish(encoder).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Called with the lock on the pending encoder held.
    pub(super) fn finish(
        &self,
        encoder: wgpu::CommandEncoder,
    ) -> Result<wgpu::SubmissionIndex, Error> {
        lock(&self.statistics).submits += 1;
        self.context.scoped("recorded work", || {
            self.context.queue().submit([encoder.finish()])
        })
    }
}
