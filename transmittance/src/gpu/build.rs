//! Curves made on a GPU.

use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Part, Slot};
use gpu_backend::{Backend, Buffer};

use super::{GROUP, WgslRule, WgslStored, build_parts};
use crate::{BuildMap, Error, SegmentLists, TransmittanceMap};

/// *What is in the way of the rays of this texel?* The question that a
/// [`Source`](crate::Source) answers, in shaders. A part `x` defines, with the
/// structure `avsm_Segment` of `entry`, `exit` and `optical_depth`, an array of
/// `avsm_CHANNELS` numbers,
///
/// ```wgsl
/// fn x_segment_count(texel: vec2<u32>) -> u32
/// fn x_segment(texel: vec2<u32>, index: u32) -> avsm_Segment
/// ```
///
/// for column and row of a texel. What is no
/// [`BlockerSegment`](crate::BlockerSegment) is left out.
#[derive(Debug, Clone, Copy)]
pub struct SegmentsSlot;

impl Slot for SegmentsSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn avsm_segment_count(texel: vec2<u32>) -> u32 {{
    return {part}_segment_count(texel);
}}
fn avsm_segment(texel: vec2<u32>, index: u32) -> avsm_Segment {{
    return {part}_segment(texel, index);
}}
"
        )
    }
}

/// Segments that a shader knows.
///
/// A renderer that has its own lists of fragments, or makes segments from what
/// it has (particles, slices of a volume), gives them to [`BuildMap`] by this.
pub trait ShaderSegments: InShader<SegmentsSlot> {
    /// The largest number of segments that a texel has. More are not looked at;
    /// the curve's error bound is then 1.
    fn longest(&self) -> u32;
}

/// Uniforms of `lists.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct ListsRecord {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) segments: u32,
}

impl<const C: usize> InShader<SegmentsSlot> for SegmentLists<GpuMemory, C> {
    fn part() -> Part {
        Part::new("avsm_lists")
            .source(include_str!("lists.wgsl"))
            .uniform("avsm_lists", "avsm_Lists")
            .read("avsm_offsets", "array<u32>")
            .read("avsm_numbers", "array<f32>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let [width, height] = self.extent();
        vec![
            // There is an offset in memory for each texel, so neither overflows
            // but for maps without texels.
            Argument::uniform(ListsRecord {
                width: width.min(self.offsets().len()) as u32,
                height: height.min(self.offsets().len()) as u32,
                segments: (self.numbers().len() / (2 + C)) as u32,
            }),
            Argument::read(self.offsets()),
            Argument::read(self.numbers()),
        ]
    }
}

impl<const C: usize> ShaderSegments for SegmentLists<GpuMemory, C> {
    fn longest(&self) -> u32 {
        // The promise is only an upper bound, and each part of it costs a dispatch. No list has
        // more than all segments.
        let segments = self.numbers().len() / (2 + C);
        SegmentLists::longest(self).min(segments.try_into().unwrap_or(u32::MAX))
    }
}

/// Uniforms of `build.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Parameters {
    pub(super) width: u32,
    pub(super) texels: u32,
    pub(super) first_texel: u32,
    pub(super) first: u32,
    pub(super) end: u32,
}

/// WGSL of the curves that wait between dispatches.
pub(super) const UNFINISHED: &str = include_str!("unfinished.wgsl");

/// Texels of a dispatch.
const BAND: usize = 1 << 16;

/// The largest binding that every device of WebGPU allows, in bytes.
const LARGEST_BINDING: usize = 128 << 20;

/// Texels whose unfinished curves, of so many `numbers` each, are in memory at
/// once: [`BAND`], or what one binding holds.
pub(super) const fn band(numbers: usize) -> usize {
    let most = LARGEST_BINDING / (4 * numbers);
    if most > BAND {
        BAND
    } else if most == 0 {
        1
    } else {
        most
    }
}

/// Numbers of an unfinished curve, as `build.wgsl` keeps it.
pub(super) const fn unfinished_numbers(capacity: usize, channels: usize) -> usize {
    2 + capacity * (1 + 3 * channels)
}

/// Segments per texel and dispatch.
///
/// A software driver ends loops after 65,535 iterations of an invocation, summed
/// over all loops, and the driver of a real GPU takes the device away if a dispatch takes too
/// long. An insertion goes over the nodes of a curve a dozen times, and at each of them over the
/// channels.
pub(super) const fn batch(capacity: usize, channels: usize) -> u32 {
    let batch = BUDGET / insertion(capacity, channels);
    if batch == 0 { 1 } else { batch }
}

/// Iterations of loops that an invocation spends before it waits for another dispatch.
pub(super) const BUDGET: u32 = 32_768;

/// Iterations of an insertion, at most.
pub(super) const fn insertion(capacity: usize, channels: usize) -> u32 {
    (12 * capacity * (1 + channels)) as u32
}

/// The shader that makes curves.
pub(super) fn shader<A, S, P, const C: usize>() -> Result<Assembly, gpu_backend::Error>
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    S: InShader<SegmentsSlot>,
    P: WgslStored<C>,
{
    let entry = [INDEX_WGSL, include_str!("build.wgsl"), UNFINISHED];
    let mut shader = Assembly::new(&[&build_parts::<A, P, C>()[..], &entry].concat());
    shader.fill::<SegmentsSlot>(&S::part())?;
    Ok(shader)
}

impl<A, S, P, E, const C: usize> BuildMap<A, S, P, C> for Gpu<E>
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    S: ShaderSegments,
    P: WgslStored<C>,
    E: Encode,
{
    fn build_map(
        &self,
        _: &A,
        source: &S,
        map: &mut TransmittanceMap<GpuMemory, P, C>,
    ) -> Result<(), Error> {
        let [width, height] = map.extent();
        let texels = width * height;
        let batch = batch(A::CAPACITY, C);
        let longest = source.longest().max(1);
        let numbers = unfinished_numbers(A::CAPACITY, C);
        let is_at_once = longest <= batch && !A::FINISHES_APART;
        let most = if is_at_once { BAND } else { band(numbers) };
        let waiting = if is_at_once { 0 } else { most.min(texels) };
        let mut unfinished = self.zeros::<u32>(waiting * numbers)?;
        for first_texel in (0..texels).step_by(most) {
            let band = most.min(texels - first_texel);
            let mut run = |entry, first, end| -> Result<(), Error> {
                let parameters = Parameters {
                    // The words of a map are in memory: each fits.
                    width: width as u32,
                    texels: band as u32,
                    first_texel: first_texel as u32,
                    first,
                    end,
                };
                self.dispatch(
                    &Kernel {
                        label: "build a shadow map",
                        parts: &shader::<A, S, P, C>()?.finish(1),
                        entry,
                        constants: &source.constants(),
                    },
                    &[
                        &[
                            Argument::uniform(parameters),
                            Argument::write(map.words_mut()),
                            Argument::write(&mut unfinished),
                        ],
                        &source.arguments(),
                    ],
                    Workgroups::covering(band, GROUP),
                )?;
                Ok(())
            };
            for first in (0..longest).step_by(batch as usize) {
                let end = longest.min(first.saturating_add(batch));
                let is_last = end == longest && !A::FINISHES_APART;
                run(if is_last { "complete" } else { "insert" }, first, end)?;
            }
            if A::FINISHES_APART {
                run("finish", longest, longest)?;
            }
        }
        Ok(())
    }
}
