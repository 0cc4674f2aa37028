//! A device and what all handles on it share.

use std::fmt;
use std::sync::{Arc, Mutex, OnceLock};

use super::cache::Cache;
use super::lock;
use super::uniform::Uniforms;
use crate::Error;

/// A device with its queue and the pipelines that were built for it.
///
/// Cheap to clone; all clones share the pipelines. Make one per device and
/// hand it to everything that runs there: each [`Gpu`](super::Gpu) is a handle on a
/// context.
#[derive(Debug, Clone)]
pub struct Context {
    shared: Arc<Shared>,
}

struct Shared {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    limits: wgpu::Limits,
    cache: Cache,
    uniforms: Mutex<Uniforms>,
    loss: Loss,
}

/// Why the device was lost, once it was.
pub(super) type Loss = Arc<OnceLock<String>>;

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shared")
            .field("adapter", &self.info.name)
            .field("lost", &self.loss.get())
            .finish_non_exhaustive()
    }
}

impl Context {
    /// Uses a device of the caller's.
    ///
    /// Its error and loss handlers are left as they are. Nothing beyond
    /// WebGPU's default features and limits is needed; steps that need more
    /// than the limits of this device say so when they are called.
    pub fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self::with_loss(device, queue, Loss::default())
    }

    pub(super) fn with_loss(device: wgpu::Device, queue: wgpu::Queue, loss: Loss) -> Self {
        let limits = device.limits();
        Self {
            shared: Arc::new(Shared {
                info: device.adapter_info(),
                cache: Cache::default(),
                uniforms: Mutex::new(Uniforms::new(&limits)),
                limits,
                device,
                queue,
                loss,
            }),
        }
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.shared.device
    }

    /// Its queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.shared.queue
    }

    /// What the device can do at most.
    pub fn limits(&self) -> &wgpu::Limits {
        &self.shared.limits
    }

    /// Name, driver and kind of the adapter.
    pub fn adapter(&self) -> &wgpu::AdapterInfo {
        &self.shared.info
    }

    /// True if the processor plays the GPU. Its times represent nothing.
    pub fn is_software(&self) -> bool {
        self.shared.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Anything that is built once per device and then kept: a render pipeline, a
    /// table. The key tells values of one type apart; types of different
    /// crates never meet. Another thread that asks for the same value while
    /// it is being built waits; a failure is not kept.
    ///
    /// `build` must not ask for the value that it builds.
    ///
    /// # Errors
    /// What `build` returns; [`Error::Rejected`] or [`Error::OutOfMemory`] if
    /// the device complained while it ran, [`Error::DeviceLost`] if there is no
    /// device any more.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), gpu_backend::Error> {
    /// use gpu_backend::gpu::Context;
    ///
    /// struct Linear { sampler: wgpu::Sampler }
    ///
    /// # let context = Context::request()?;
    /// let filter = wgpu::FilterMode::Linear;
    /// let linear = context.cached("linear sampler", filter, |device| {
    ///     let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
    ///         mag_filter: filter,
    ///         ..Default::default()
    ///     });
    ///     Ok(Linear { sampler })
    /// })?;
    /// # Ok(()) }
    /// ```
    pub fn cached<K, V>(
        &self,
        what: &str,
        key: K,
        build: impl FnOnce(&wgpu::Device) -> Result<V, Error>,
    ) -> Result<Arc<V>, Error>
    where
        K: std::hash::Hash + Eq + Send + Sync + 'static,
        V: Send + Sync + 'static,
    {
        self.shared.cache.get(key, || {
            let built = self.scoped(what, || build(self.device()))??;
            // A lost device builds invalid objects in silence.
            self.check_alive()?;
            Ok(built)
        })
    }

    /// Runs `work` and turns what the device has to say about it into an
    /// error.
    ///
    /// For calls to wgpu outside of this crate: without it a mistake ends in the
    /// device's uncaptured-error handler, which panics unless it was replaced. In a browser
    /// it always ends there: what the device has to say is known only after the program has
    /// returned to the browser.
    ///
    /// # Errors
    /// [`Error::Rejected`], [`Error::OutOfMemory`] or [`Error::DeviceLost`].
    pub fn scoped<R>(&self, what: &str, work: impl FnOnce() -> R) -> Result<R, Error> {
        // Waiting for an answer would wait forever.
        if cfg!(target_family = "wasm") {
            return Ok(work());
        }
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let device = self.device();
        // Scopes are of this thread and must be popped in reverse.
        let scopes = [Internal, OutOfMemory, Validation].map(|f| device.push_error_scope(f));
        let result = work();
        let mut first = None;
        for scope in scopes.into_iter().rev() {
            first = pollster::block_on(scope.pop()).or(first);
        }
        match first {
            None => Ok(result),
            Some(error) => Err(self.translate(what, &error)),
        }
    }

    fn translate(&self, what: &str, error: &wgpu::Error) -> Error {
        if let Err(lost) = self.check_alive() {
            return lost;
        }
        match error {
            wgpu::Error::OutOfMemory { .. } => Error::OutOfMemory { what: what.into() },
            other => Error::Rejected {
                what: what.into(),
                reason: other.to_string(),
            },
        }
    }

    /// The error to return if the device has gone.
    ///
    /// wgpu keeps quiet about a lost device: objects are created and work is
    /// submitted as if nothing had happened. Memory cannot be mapped any more,
    /// though.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    pub fn check_alive(&self) -> Result<(), Error> {
        if self.shared.loss.get().is_none() {
            let probe = self.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("probe"),
                size: 4,
                usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            });
            if probe.get_mapped_range_mut(..).is_ok() {
                return Ok(());
            }
        }
        Err(self.lost())
    }

    /// The error of a device that is known to have gone.
    pub(super) fn lost(&self) -> Error {
        Error::DeviceLost {
            reason: match self.shared.loss.get() {
                Some(reason) => reason.clone(),
                None => format!("{} does not map memory any more", self.shared.info.name),
            },
        }
    }

    /// Stores bytes that a shader reads as a uniform; returns where.
    pub(super) fn uniform(&self, bytes: &[u8]) -> Result<(wgpu::Buffer, u64), Error> {
        lock(&self.shared.uniforms).store(self, bytes)
    }
}
