//! Waiting for the device, and reading back. Not in a browser, where a program must return
//! before anything is done.

use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use super::encode::new_encoder;
use super::{Context, Gpu, GpuBuffer, Queued, lock};
use crate::{Buffer, Download, Element, Error};

/// How long a mapping may lag behind the work it waits for before the device
/// is asked whether it is still there.
const PATIENCE: Duration = Duration::from_millis(200);

impl Gpu<Queued> {
    /// Opens a device for people who have none; see [`Context::request`].
    ///
    /// # Errors
    /// [`Error::NoAdapter`].
    pub fn request() -> Result<Self, Error> {
        Context::request().map(Self::new)
    }

    /// Submits what is recorded with `last` at its end.
    fn submit_with(
        &self,
        last: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<wgpu::SubmissionIndex, Error> {
        let mut pending = lock(&self.encode.pending);
        self.context.check_alive()?;
        let mut encoder = pending.take().unwrap_or_else(|| new_encoder(&self.context));
        last(&mut encoder);
        self.finish(encoder)
    }

    /// Copies the first `size` bytes of a buffer to the host and hands them to
    /// `read`.
    pub(super) fn read_back<R>(
        &self,
        buffer: &wgpu::Buffer,
        size: u64,
        read: impl FnOnce(&[u8]) -> R,
    ) -> Result<R, Error> {
        let device = self.context.device();
        let staging = self.context.scoped("a buffer to read from", || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read back"),
                size,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        let submission = self.submit_with(|encoder| {
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
        })?;
        lock(&self.statistics).read_backs += 1;
        let (sender, receiver) = sync_channel(1);
        self.context.scoped("reading back", || {
            staging.map_async(wgpu::MapMode::Read, .., move |result| {
                // The receiver is gone only if reading was given up.
                sender.send(result).ok();
            });
        })?;
        self.poll(submission)?;
        // The callback may run on another thread that happens to poll.
        let mapped = loop {
            match receiver.recv_timeout(PATIENCE) {
                Ok(result) => break result.is_ok(),
                Err(RecvTimeoutError::Disconnected) => break false,
                Err(RecvTimeoutError::Timeout) => {
                    self.context.check_alive()?;
                    self.poll_all()?;
                }
            }
        };
        let view = mapped
            .then(|| staging.get_mapped_range(..).ok())
            .flatten()
            .ok_or_else(|| self.context.lost())?;
        Ok(read(&view))
    }

    fn poll(&self, submission: wgpu::SubmissionIndex) -> Result<(), Error> {
        self.poll_type(wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: None,
        })
    }

    fn poll_all(&self) -> Result<(), Error> {
        self.poll_type(wgpu::PollType::wait_indefinitely())
    }

    fn poll_type(&self, poll_type: wgpu::PollType) -> Result<(), Error> {
        let polled = self
            .context
            .scoped("waiting", || self.context.device().poll(poll_type))?;
        polled.map(|_| ()).map_err(|error| {
            self.context.check_alive().err().unwrap_or(Error::Rejected {
                what: "waiting".into(),
                reason: error.to_string(),
            })
        })
    }
}

impl Download for Gpu<Queued> {
    fn download<T: Element>(&self, buffer: &GpuBuffer<T>) -> Result<Vec<T>, Error> {
        if buffer.is_empty() {
            self.wait()?;
            return Ok(Vec::new());
        }
        buffer.require(wgpu::BufferUsages::COPY_SRC)?;
        self.read_back(buffer.as_wgpu(), buffer.copy_size(), |bytes| {
            // The mapping need not be aligned for T.
            bytemuck::pod_collect_to_vec(&bytes[..buffer.len() * size_of::<T>()])
        })
    }

    fn wait(&self) -> Result<(), Error> {
        self.submit()?;
        self.poll_all()?;
        self.context.check_alive()
    }
}
