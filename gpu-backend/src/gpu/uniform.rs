//! Small parameters of dispatches, side by side in larger buffers.

use super::Context;
use crate::Error;

/// Bytes of one buffer; parameters are at most a few hundred.
const CHUNK: u64 = 64 << 10;

/// Hands out consecutive places of a buffer, and a new buffer when it is full.
///
/// No place is ever used twice. The queue's writes overtake work that is
/// recorded and not yet submitted, so overwriting would change the parameters
/// of earlier dispatches.
pub(super) struct Uniforms {
    alignment: u64,
    chunk: Option<wgpu::Buffer>,
    used: u64,
}

impl Uniforms {
    pub(super) fn new(limits: &wgpu::Limits) -> Self {
        Self {
            alignment: u64::from(limits.min_uniform_buffer_offset_alignment).max(16),
            chunk: None,
            used: 0,
        }
    }

    /// `bytes` is not empty and its length is a multiple of 16.
    pub(super) fn store(
        &mut self,
        context: &Context,
        bytes: &[u8],
    ) -> Result<(wgpu::Buffer, u64), Error> {
        let size = bytes.len() as u64;
        let room = |chunk: &wgpu::Buffer| self.used + size <= chunk.size();
        let chunk = match self.chunk.take().filter(room) {
            Some(chunk) => chunk,
            None => {
                self.used = 0;
                context.scoped("parameters", || {
                    context.device().create_buffer(&wgpu::BufferDescriptor {
                        label: Some("parameters"),
                        size: CHUNK.max(size).min(context.limits().max_buffer_size),
                        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                        mapped_at_creation: false,
                    })
                })?
            }
        };
        let offset = self.used;
        let Some(size) = wgpu::BufferSize::new(size) else {
            return Ok((chunk, offset));
        };
        context.scoped("parameters", || {
            let mut view = context
                .queue()
                .write_buffer_with(&chunk, offset, size)
                // Refused without an error: the device has gone.
                .ok_or_else(|| context.lost())?;
            view.copy_from_slice(bytes);
            Ok(())
        })??;
        self.used = (offset + size.get()).next_multiple_of(self.alignment);
        self.chunk = Some(chunk.clone());
        Ok((chunk, offset))
    }
}
