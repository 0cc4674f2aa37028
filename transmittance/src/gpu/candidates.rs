//! Maps of what the rays of texels meet, without a fragment in memory.
//!
//! Based on section 4.3 of M. Salvi, K. Vidimče, A. Lauritzen, A. Lefohn, "Adaptive Volumetric
//! Shadow Maps", Eurographics Symposium on Rendering 2010: lists of blockers by tile, and then
//! every texel goes through the list of its tile in order. Departures: a blocker is listed in
//! at most four squares, larger ones if it is large, so that lists are bounded before anything
//! is counted and nothing is read back; a texel goes through the lists of all sizes at once,
//! as one list in the order of the candidates' numbers.

use gpu_backend::Backend;
use gpu_backend::gpu::{
    Argument, Encode, Gpu, GpuBuffer, GpuMemory, INDEX_WGSL, InShader, Kernel, Workgroups,
};
use gpu_backend::shader::{Assembly, Slot};

use super::build::{BUDGET, UNFINISHED, band, insertion, unfinished_numbers};
use super::capture::grouped;
use super::{GROUP, WgslRule, WgslStored, build_parts};
use crate::{Error, TransmittanceMap};

/// *What does this candidate take from the ray of this texel?* A candidate is anything that
/// may be in the way: a piece of a strand, a particle, a box with a density. A part `x`
/// defines
///
/// ```wgsl
/// fn x_candidate_texels(candidate: u32) -> vec4<u32>
/// fn x_candidate_segment_count(candidate: u32) -> u32
/// fn x_candidate_segment(candidate: u32, texel: vec2<u32>, index: u32) -> avsm_Segment
/// ```
///
/// for candidates with numbers from 0. The first gives the texels that a candidate may touch:
/// first column, first row, and the column and row behind the last, in any way beyond the map;
/// none if there is no texel between them. The others are asked for these texels alone, with
/// each `index` below the count. `avsm_Segment` is that of
/// [`build_parts`](super::build_parts); one with an optical depth of 0 is passed over, and so
/// is what is no [`BlockerSegment`](crate::BlockerSegment).
///
/// Boxes of smoke seen along z, each cut into eight slabs whose density a function of the
/// renderer's tells:
///
/// ```no_run
/// use transmittance::gpu::{CandidatesSlot, Crowding, ShaderCandidates, build_from_candidates};
/// use transmittance::gpu_backend::gpu::{Argument, Gpu, GpuBuffer, InShader, Queued};
/// use transmittance::gpu_backend::shader::Part;
/// use transmittance::{Error, Packed, Stream, TransmittanceMap};
///
/// struct Boxes {
///     /// First texel, the one behind the last, and two depths, as six u32.
///     words: GpuBuffer<u32>,
///     count: u32,
///     crowding: Crowding,
/// }
///
/// impl InShader<CandidatesSlot> for Boxes {
///     fn part() -> Part {
///         Part::new("boxes").read("boxes_words", "array<u32>").source(
///             "
///             fn boxes_word(candidate: u32, index: u32) -> u32 {
///                 return boxes_words[6u * candidate + index];
///             }
///             fn boxes_candidate_texels(candidate: u32) -> vec4<u32> {
///                 return vec4(boxes_word(candidate, 0u), boxes_word(candidate, 1u),
///                     boxes_word(candidate, 2u), boxes_word(candidate, 3u));
///             }
///             fn boxes_candidate_segment_count(candidate: u32) -> u32 {
///                 return 8u;
///             }
///             fn boxes_density(position: vec3<f32>) -> f32 {
///                 return 0.5 + 0.5 * sin(position.x + position.y) * cos(position.z);
///             }
///             fn boxes_candidate_segment(
///                 candidate: u32, texel: vec2<u32>, index: u32
///             ) -> avsm_Segment {
///                 let near = bitcast<f32>(boxes_word(candidate, 4u));
///                 let far = bitcast<f32>(boxes_word(candidate, 5u));
///                 var segment: avsm_Segment;
///                 segment.entry = mix(near, far, f32(index) / 8.0);
///                 segment.exit = mix(near, far, f32(index + 1u) / 8.0);
///                 let middle = 0.5 * (segment.entry + segment.exit);
///                 let density = boxes_density(vec3(vec2<f32>(texel), middle));
///                 segment.optical_depth[0] = density * (segment.exit - segment.entry);
///                 return segment;
///             }",
///         )
///     }
///
///     fn arguments(&self) -> Vec<Argument<'_>> {
///         vec![Argument::read(&self.words)]
///     }
/// }
///
/// impl ShaderCandidates for Boxes {
///     const LOOPS: u32 = 0;
///     fn count(&self) -> u32 {
///         self.count
///     }
///     fn crowding(&self) -> Crowding {
///         self.crowding
///     }
/// }
///
/// fn smoke(gpu: &Gpu<Queued>, boxes: &Boxes) -> Result<(), Error> {
///     let mut map = TransmittanceMap::<_, Packed<8>>::new(gpu, [512, 512])?;
///     build_from_candidates(gpu, &Stream::<8>::new(), boxes, &mut map)
/// }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct CandidatesSlot;

impl Slot for CandidatesSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn avsm_candidate_texels(candidate: u32) -> vec4<u32> {{
    return {part}_candidate_texels(candidate);
}}
fn avsm_candidate_segment_count(candidate: u32) -> u32 {{
    return {part}_candidate_segment_count(candidate);
}}
fn avsm_candidate_segment(candidate: u32, texel: vec2<u32>, index: u32) -> avsm_Segment {{
    return {part}_candidate_segment(candidate, texel, index);
}}
"
        )
    }
}

/// Candidates that a shader knows.
pub trait ShaderCandidates: InShader<CandidatesSlot> {
    /// Iterations of all loops in the part's `x_candidate_segment`, at most 30,000: some drivers
    /// end loops of a shader that has had 65,535. The other functions of the part have no loops.
    const LOOPS: u32;

    /// How many there are.
    fn count(&self) -> u32;

    /// How many come together. A texel that has more is not gone through to the end: its curve
    /// lacks the rest and has an error bound of 1, which a map of [`Packed`](crate::Packed)
    /// curves does not keep.
    fn crowding(&self) -> Crowding;
}

/// How many candidates come together in a map. This decides how many dispatches the map takes,
/// about one for 1000 candidates around a texel, and one for 50 segments of it with 8 nodes. If
/// the candidates are known to the device alone, `around` is their number; `segments` needs a
/// bound that the renderer knows, such as the particles of an emitter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crowding {
    /// The largest number of candidates that are listed in the squares around any one texel. A
    /// candidate is listed in the smallest squares, of 16 texels a side or twice, four times …
    /// as many, of which it touches at most four.
    pub around: u32,
    /// The largest number of segments of the candidates that touch any one texel.
    pub segments: u32,
}

/// Texels along each side of the smallest squares.
pub(super) const TILE: u32 = 16;

/// The largest number of squares in which a candidate is listed.
pub(super) const MOST_BINS: u32 = 4;

/// Each is recorded, with its bindings.
const MOST_DISPATCHES: u64 = 65_536;

/// How many turns of loops count for one. Invocations that run together wait for each other: eight
/// of a software driver that never do the same at once take 8 × 32,768 / 4 turns together for
/// a [`BUDGET`] of 32,768, and 65,536 is where such a driver ends loops.
const WAITING: u32 = 4;

impl Crowding {
    /// That of candidates on a map of `extent` texels, each with the texels that it may touch,
    /// as [`CandidatesSlot`] says, and its number of segments. Takes work in proportion to the
    /// number of candidates and of texels, and 8 bytes of memory for each texel, which is less
    /// than a map of curves takes.
    ///
    /// ```
    /// use transmittance::gpu::Crowding;
    ///
    /// let leaf = ([0, 0, 3, 3], 1);
    /// let smoke = ([2, 1, 32, 32], 4);
    /// let crowding = Crowding::of([32, 32], [leaf, smoke, leaf]);
    /// assert_eq!(crowding, Crowding { around: 3, segments: 6 });
    /// ```
    #[must_use]
    pub fn of(extent: [usize; 2], candidates: impl IntoIterator<Item = ([u32; 4], u32)>) -> Self {
        let [width, height] = extent;
        let squares = levels(extent);
        if squares.is_empty() {
            return Self {
                around: 0,
                segments: 0,
            };
        }
        let mut listed = vec![0_u32; squares.iter().map(|[x, y]| x * y).sum()];
        // Sums over columns and rows of these are what each texel has.
        let mut steps = vec![0_i64; (width + 1) * (height + 1)];
        for ([x, y, end_x, end_y], segments) in candidates {
            let (x, y) = (x as usize, y as usize);
            let (end_x, end_y) = (width.min(end_x as usize), height.min(end_y as usize));
            if x >= end_x || y >= end_y {
                continue;
            }
            let segments = i64::from(segments);
            for (at, change) in [
                ([x, y], segments),
                ([end_x, y], -segments),
                ([x, end_y], -segments),
                ([end_x, end_y], segments),
            ] {
                steps[at[1] * (width + 1) + at[0]] += change;
            }
            let (mut side, mut first) = (TILE as usize, 0);
            for [columns, rows] in &squares {
                let (low, high) = (
                    [x / side, y / side],
                    [(end_x - 1) / side, (end_y - 1) / side],
                );
                if (high[0] + 1 - low[0]) * (high[1] + 1 - low[1]) <= MOST_BINS as usize {
                    for row in low[1]..=high[1] {
                        for column in low[0]..=high[0] {
                            listed[first + row * columns + column] += 1;
                        }
                    }
                    break;
                }
                first += columns * rows;
                side *= 2;
            }
        }
        let mut segments = 0;
        for row in 0..height {
            let mut before = 0;
            for column in 0..width {
                let i = row * (width + 1) + column;
                before += steps[i];
                let above = if row > 0 { steps[i - width - 1] } else { 0 };
                steps[i] = before + above;
                segments = segments.max(steps[i]);
            }
        }
        let around = |column: usize, row: usize| {
            let mut first = 0;
            let mut sum = 0_u64;
            for (level, [columns, rows]) in squares.iter().enumerate() {
                let (x, y) = (column >> level, row >> level);
                sum += u64::from(listed[first + y * columns + x]);
                first += columns * rows;
            }
            sum
        };
        let [columns, rows] = squares[0];
        let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let most = all.map(|(column, row)| around(column, row)).max();
        Self {
            around: u32::try_from(most.unwrap_or(0)).unwrap_or(u32::MAX),
            segments: u32::try_from(segments).unwrap_or(u32::MAX),
        }
    }
}

/// Columns and rows of the squares of each level, the smallest first; none of a map without
/// texels.
fn levels([width, height]: [usize; 2]) -> Vec<[usize; 2]> {
    if width == 0 || height == 0 {
        return Vec::new();
    }
    let sides = std::iter::successors(Some(TILE as usize), |side| {
        (*side < width.max(height)).then_some(2 * side)
    });
    sides
        .map(|side| [width.div_ceil(side), height.div_ceil(side)])
        .collect()
}

/// Uniforms of `find_bins.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct BinParameters {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) candidates: u32,
}

/// Uniforms of `meet.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct MeetParameters {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: u32,
    pub(super) first_square: u32,
    pub(super) levels: u32,
    pub(super) starts: u32,
    pub(super) budget: i32,
    pub(super) look: i32,
    pub(super) ask: i32,
    pub(super) insertion: i32,
}

/// The shader that lists candidates.
pub(super) fn bins_shader<S, A, const C: usize>() -> Result<Assembly, gpu_backend::Error>
where
    S: InShader<CandidatesSlot>,
    A: WgslRule<C>,
{
    // The part may speak of segments, which those parts define that make curves.
    let mut shader = Assembly::new(&[
        A::SIZES,
        super::parts::SEGMENT,
        INDEX_WGSL,
        include_str!("bins.wgsl"),
        include_str!("find_bins.wgsl"),
    ]);
    shader.fill::<CandidatesSlot>(&S::part())?;
    Ok(shader)
}

/// The shader that makes curves.
pub(super) fn meet_shader<A, S, P, const C: usize>() -> Result<Assembly, gpu_backend::Error>
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    S: InShader<CandidatesSlot>,
    P: WgslStored<C>,
{
    let entry = [
        INDEX_WGSL,
        include_str!("bins.wgsl"),
        include_str!("meet.wgsl"),
        UNFINISHED,
    ];
    let mut shader = Assembly::new(&[&build_parts::<A, P, C>()[..], &entry].concat());
    shader.fill::<CandidatesSlot>(&S::part())?;
    Ok(shader)
}

/// Gives every texel of a map the curve of what its ray meets of the candidates, in the order
/// of their numbers, by the rule of `A`.
///
/// Memory beside the candidates and the map does not depend on how many segments there are:
/// 48 bytes per candidate and 4 per square of 16 × 16 texels and of the larger ones, and the
/// curves of at most 65,536 texels that are in the making, in one buffer of at most 128 MiB.
/// Nothing is read back, so that all of it can be recorded into an encoder of yours. The
/// result depends neither on chance nor on the device's number of threads; on the order of
/// candidates it depends as far as a curve does on that of its segments.
///
/// On a software driver, 64 × 64 curves of a [`Stream<8>`](crate::Stream), listing included, take
/// 1.03 times as long as capture and compression of the same segments where these are in memory
/// already, for 400 puffs (488,000 segments, for which capture alone needs 36 bytes each, 18 MB,
/// and the lists here 19 kB); 1.6 times for 12,000 pieces of hair on 18 texels each, and 2.7
/// times for 30,000 on 4 texels each, because a texel looks at all that is in its squares.
///
/// Of no candidates, or of those that touch no texel, a clear map is made. A map without texels
/// is legal.
///
/// All dispatches are recorded without a pause. A driver may take the device away if what is
/// submitted at once takes seconds: 2400 segments over one texel of a map of 512 × 512 are
/// about 200 dispatches.
///
/// # Errors
/// [`BadValue`](Error::BadValue) if the [`Crowding`] asks for more than 65,536 dispatches. Errors
/// of the backend, [`TooLarge`](gpu_backend::Error::TooLarge) among them: lists of candidates
/// take 16 bytes for each in one buffer, so that the default limits of WebGPU allow 8,388,608.
pub fn build_from_candidates<A, S, P, E, const C: usize>(
    gpu: &Gpu<E>,
    _: &A,
    candidates: &S,
    map: &mut TransmittanceMap<GpuMemory, P, C>,
) -> Result<(), Error>
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    S: ShaderCandidates,
    P: WgslStored<C>,
    E: Encode,
{
    const { assert!(S::LOOPS <= 30_000) };
    let extent = map.extent();
    let squares = levels(extent);
    if squares.is_empty() {
        return Ok(());
    }
    // The words of a map are in memory, so that each of its numbers fits.
    let [width, height] = extent.map(|side| side as u32);
    let [listed, starts] = lists::<A, S, E, C>(gpu, [width, height], candidates, &squares)?;

    let numbers = unfinished_numbers(A::CAPACITY, C) + 2;
    let most = (band(numbers) / 64).max(1);
    let all = extent[0].div_ceil(8) * extent[1].div_ceil(8);
    let mut unfinished = gpu.zeros::<u32>(64 * most.min(all) * numbers)?;
    let costs = Costs::new(A::CAPACITY, C, S::LOOPS, squares.len());
    let Crowding { around, segments } = candidates.crowding();
    let dispatches = costs.dispatches(Crowding {
        around: around.min(candidates.count()),
        segments,
    });
    let bands = all.div_ceil(most) as u64;
    if bands.saturating_mul(dispatches) > MOST_DISPATCHES {
        return Err(Error::BadValue {
            what: "the number of dispatches for the crowding of candidates",
            value: bands as f64 * dispatches as f64,
            expected: "at most 65536",
        });
    }
    let shader = meet_shader::<A, S, P, C>()?.finish(1);
    for first in (0..all).step_by(most) {
        let texels = 64 * most.min(all - first);
        let mut run = |entry, starts_curves: bool| -> Result<(), Error> {
            let parameters = MeetParameters {
                width,
                height,
                texels: texels as u32,
                first_square: first as u32,
                levels: squares.len() as u32,
                starts: u32::from(starts_curves),
                budget: BUDGET as i32,
                look: costs.look as i32,
                ask: costs.ask as i32,
                insertion: costs.insertion as i32,
            };
            gpu.dispatch(
                &Kernel {
                    label: "meet candidates",
                    parts: &shader,
                    entry,
                    constants: &candidates.constants(),
                },
                &[
                    &[
                        Argument::uniform(parameters),
                        Argument::write(map.words_mut()),
                        Argument::write(&mut unfinished),
                        Argument::read(&listed),
                        Argument::read(&starts),
                    ],
                    &candidates.arguments(),
                ],
                Workgroups::covering(texels, GROUP),
            )?;
            Ok(())
        };
        for index in 0..dispatches {
            run("meet", index == 0)?;
        }
        run("finish", false)?;
    }
    Ok(())
}

/// Four times the number of each candidate and more, sorted by square, and where those of each
/// square begin.
fn lists<A, S, E, const C: usize>(
    gpu: &Gpu<E>,
    [width, height]: [u32; 2],
    candidates: &S,
    squares: &[[usize; 2]],
) -> Result<[GpuBuffer<u32>; 2], Error>
where
    A: WgslRule<C>,
    S: ShaderCandidates,
    E: Encode,
{
    let count = candidates.count() as usize;
    let mut bins = gpu.zeros::<u32>(count.saturating_mul(MOST_BINS as usize))?;
    gpu.dispatch(
        &Kernel {
            label: "list candidates",
            parts: &bins_shader::<S, A, C>()?.finish(1),
            entry: "find_bins",
            constants: &candidates.constants(),
        },
        &[
            &[
                Argument::uniform(BinParameters {
                    width,
                    height,
                    candidates: candidates.count(),
                }),
                Argument::write(&mut bins),
            ],
            &candidates.arguments(),
        ],
        Workgroups::covering(count, GROUP),
    )?;
    let all: usize = squares.iter().map(|[columns, rows]| columns * rows).sum();
    grouped(gpu, &bins, all as u32)
}

/// Iterations of loops, at most, as far as a dispatch is concerned.
#[derive(Debug, Clone, Copy)]
struct Costs {
    look: u32,
    ask: u32,
    insertion: u32,
}

impl Costs {
    fn new(capacity: usize, channels: usize, loops: u32, levels: usize) -> Self {
        let ask = loops.saturating_add(channels as u32 + 2);
        Self {
            look: WAITING * (levels as u32 + 2),
            // No more than a dispatch has in any case.
            ask: ask.saturating_mul(WAITING).min(BUDGET),
            insertion: insertion(capacity, channels),
        }
    }

    /// Dispatches that are enough.
    fn dispatches(self, crowding: Crowding) -> u64 {
        let [around, segments] = [crowding.around, crowding.segments].map(u64::from);
        // The end of the lists is looked at too.
        let looks = (around + 1) * u64::from(self.look);
        let segments = segments * u64::from(self.ask + self.insertion);
        // Each dispatch looks once more at the candidate that it goes on with.
        (looks + segments)
            .div_ceil(u64::from(BUDGET - self.look))
            .max(1)
    }
}
