//! How long steps take on the device.

use std::time::{Duration, Instant};

use super::{Gpu, Queued};
use crate::{Download, Error};

/// A measured time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Mean over the runs.
    pub per_run: Duration,
    /// What it was measured with.
    pub clock: Clock,
}

/// Whose clock a time was measured with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Time stamps of the device: the work alone.
    Device,
    /// The host's, from the first recording to the end of the work: recording,
    /// submitting and one wait, shared by all runs.
    Host,
}

impl Gpu<Queued> {
    /// The mean time of `runs` runs (0 counts as 1) of `work`, which records steps
    /// on this handle. The runs are submitted together.
    ///
    /// Uses time stamps if the device was opened with
    /// `wgpu::Features::TIMESTAMP_QUERY`, as [`Gpu::request`] does where it can;
    /// otherwise the host's clock, for which more runs give a better mean.
    /// First runs build pipelines; call `work` once before to leave that out.
    ///
    /// # Errors
    /// Those of `work`, and of waiting for it.
    pub fn time(
        &self,
        runs: u32,
        mut work: impl FnMut() -> Result<(), Error>,
    ) -> Result<Timing, Error> {
        let runs = runs.max(1);
        self.wait()?;
        let device = self.context.device();
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            let start = Instant::now();
            for _ in 0..runs {
                work()?;
            }
            self.wait()?;
            return Ok(Timing {
                per_run: start.elapsed() / runs,
                clock: Clock::Host,
            });
        }
        let (stamps, resolved) = self.context.scoped("time stamps", || {
            let stamps = device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("time stamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            let resolved = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("time stamps"),
                size: 16,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            (stamps, resolved)
        })?;
        self.stamp(&stamps, 0)?;
        for _ in 0..runs {
            work()?;
        }
        self.stamp(&stamps, 1)?;
        self.with_encoder("time stamps", |encoder| {
            encoder.resolve_query_set(&stamps, 0..2, &resolved, 0);
        })?;
        let ticks = self.read_back(&resolved, 16, |bytes| {
            let [first, last]: [u64; 2] = bytemuck::pod_read_unaligned(bytes);
            last.saturating_sub(first)
        })?;
        let nanoseconds = ticks as f64 * f64::from(self.context.queue().get_timestamp_period());
        Ok(Timing {
            per_run: Duration::from_nanos(nanoseconds as u64) / runs,
            clock: Clock::Device,
        })
    }

    /// Time stamps belong to passes; this pass does nothing else.
    fn stamp(&self, stamps: &wgpu::QuerySet, index: u32) -> Result<(), Error> {
        self.with_encoder("time stamps", |encoder| {
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("time stamp"),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: stamps,
                    beginning_of_pass_write_index: None,
                    end_of_pass_write_index: Some(index),
                }),
            });
        })
    }
}
