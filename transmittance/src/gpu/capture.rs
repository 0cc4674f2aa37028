//! Captured segments sorted on a GPU: by digits of 4 bits, the lowest first,
//! without atomics, so that equal segments stay in their order.

use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, Kernel, Workgroups,
};
use gpu_backend::{Backend, Buffer};

use super::GROUP;
use crate::capture::check;
use crate::{CaptureSegments, Error, Order, SegmentLists};

pub(super) const SCAN: &[&str] = &[INDEX_WGSL, include_str!("scan.wgsl")];
pub(super) const SORT: &[&str] = &[INDEX_WGSL, include_str!("sort.wgsl")];
pub(super) const GATHER: &[&str] = &[INDEX_WGSL, include_str!("gather.wgsl")];

/// Numbers per invocation.
pub(super) const CHUNK: usize = 256;

/// Values of a digit, and its bits.
pub(super) const DIGITS: usize = 16;
const BITS: u32 = 4;

/// Uniforms of `sort.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct SortParameters {
    pub(super) count: u32,
    pub(super) chunks: u32,
    pub(super) field: u32,
    pub(super) shift: u32,
    pub(super) texels: u32,
    pub(super) stride: u32,
}

/// Uniforms of `gather.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct GatherParameters {
    pub(super) count: u32,
    pub(super) texels: u32,
    pub(super) stride: u32,
}

impl<E: Encode, const C: usize> CaptureSegments<C> for Gpu<E> {
    fn capture_segments(
        &self,
        extent: [usize; 2],
        texels: &GpuBuffer<u32>,
        numbers: &GpuBuffer<f32>,
        longest: u32,
        order: Order,
    ) -> Result<SegmentLists<GpuMemory, C>, Error> {
        let map = check::<C>(extent, texels.len(), numbers.len())?;
        let count = texels.len();
        let mut sorting = Sorting::new(self, texels, numbers, map, 2 + C as u32)?;
        if order == Order::FrontToBack {
            for field in (1..=sorting.stride).rev() {
                sorting.by_field(field, u32::BITS)?;
            }
        }
        let offsets = sorting.by_texel()?;
        let mut lists = self.zeros(numbers.len())?;
        sorting.gather("gather", count, Argument::write(&mut lists))?;
        SegmentLists::from_buffers(extent, longest, offsets, lists)
    }
}

/// Everything that the passes of a sort share.
struct Sorting<'a, E: Encode> {
    gpu: &'a Gpu<E>,
    texels: &'a GpuBuffer<u32>,
    numbers: &'a GpuBuffer<f32>,
    map: u32,
    stride: u32,
    order: GpuBuffer<u32>,
    sorted: GpuBuffer<u32>,
    counts: GpuBuffer<u32>,
}

/// The indices of `keys` below `end` in the order of their keys, those of the same key in
/// rising order, and where those of each key begin. Larger keys come last, in any order.
pub(super) fn grouped<E: Encode>(
    gpu: &Gpu<E>,
    keys: &GpuBuffer<u32>,
    end: u32,
) -> Result<[GpuBuffer<u32>; 2], Error> {
    // Keys alone decide; there are no other numbers.
    let numbers = gpu.zeros(1)?;
    let mut sorting = Sorting::new(gpu, keys, &numbers, end, 1)?;
    let starts = sorting.by_texel()?;
    Ok([sorting.order, starts])
}

impl<'a, E: Encode> Sorting<'a, E> {
    fn new(
        gpu: &'a Gpu<E>,
        texels: &'a GpuBuffer<u32>,
        numbers: &'a GpuBuffer<f32>,
        map: u32,
        stride: u32,
    ) -> Result<Self, Error> {
        let count = texels.len();
        Ok(Self {
            gpu,
            texels,
            numbers,
            map,
            stride,
            order: gpu.upload(&(0..count as u32).collect::<Vec<_>>())?,
            sorted: gpu.zeros(count)?,
            counts: gpu.zeros(DIGITS * count.div_ceil(CHUNK))?,
        })
    }

    /// Sorts by texel, and returns where those of each texel begin.
    fn by_texel(&mut self) -> Result<GpuBuffer<u32>, Error> {
        // Texels that are not in the map count as the one behind the last.
        self.by_field(0, u32::BITS - self.map.leading_zeros())?;
        let mut offsets = self.gpu.zeros(self.map as usize + 1)?;
        let items = self.map as usize + 1;
        self.gather("find_offsets", items, Argument::write(&mut offsets))?;
        Ok(offsets)
    }

    /// Sorts by the lowest `bits` of a field.
    fn by_field(&mut self, field: u32, bits: u32) -> Result<(), Error> {
        for shift in (0..bits).step_by(BITS as usize) {
            self.pass("count_digits", field, shift)?;
            scan(self.gpu, &mut self.counts)?;
            self.pass("place", field, shift)?;
            std::mem::swap(&mut self.order, &mut self.sorted);
        }
        Ok(())
    }

    fn pass(&mut self, entry: &'static str, field: u32, shift: u32) -> Result<(), Error> {
        let chunks = self.texels.len().div_ceil(CHUNK);
        let parameters = SortParameters {
            // Buffers have fewer bytes than u32 has numbers.
            count: self.texels.len() as u32,
            chunks: chunks as u32,
            field,
            shift,
            texels: self.map,
            stride: self.stride,
        };
        self.gpu.dispatch(
            &Kernel {
                label: "sort captured segments",
                parts: SORT,
                entry,
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::read(self.texels),
                Argument::read(self.numbers),
                Argument::read(&self.order),
                Argument::write(&mut self.counts),
                Argument::write(&mut self.sorted),
            ]],
            Workgroups::covering(chunks, GROUP),
        )?;
        Ok(())
    }

    fn gather(
        &self,
        entry: &'static str,
        items: usize,
        results: Argument<'_>,
    ) -> Result<(), Error> {
        let parameters = GatherParameters {
            count: self.texels.len() as u32,
            texels: self.map,
            stride: self.stride,
        };
        self.gpu.dispatch(
            &Kernel {
                label: "gather captured segments",
                parts: GATHER,
                entry,
                constants: &[],
            },
            &[&[
                Argument::uniform(parameters),
                Argument::read(self.texels),
                Argument::read(self.numbers),
                Argument::read(&self.order),
                results,
            ]],
            Workgroups::covering(items, GROUP),
        )?;
        Ok(())
    }
}

/// Replaces each number by the sum of those before it.
pub(super) fn scan<E: Encode>(gpu: &Gpu<E>, numbers: &mut GpuBuffer<u32>) -> Result<(), Error> {
    let chunks = numbers.len().div_ceil(CHUNK);
    let mut sums = gpu.zeros(chunks)?;
    if chunks > 1 {
        scan_pass(gpu, "sum_chunks", numbers, &mut sums)?;
        scan(gpu, &mut sums)?;
    }
    scan_pass(gpu, "sum_before", numbers, &mut sums)
}

fn scan_pass<E: Encode>(
    gpu: &Gpu<E>,
    entry: &'static str,
    numbers: &mut GpuBuffer<u32>,
    sums: &mut GpuBuffer<u32>,
) -> Result<(), Error> {
    let count = numbers.len();
    gpu.dispatch(
        &Kernel {
            label: "sum before each",
            parts: SCAN,
            entry,
            constants: &[],
        },
        &[&[
            Argument::uniform(count as u32),
            Argument::write(numbers),
            Argument::write(sums),
        ]],
        Workgroups::covering(count.div_ceil(CHUNK), GROUP),
    )?;
    Ok(())
}
