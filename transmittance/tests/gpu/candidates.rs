//! Maps of what texels meet of candidates, against maps of the same segments in lists.

use crate::support::streams::Random;
use gpu_backend::gpu::{Argument, Gpu, GpuBuffer, GpuMemory, InShader, Queued};
use gpu_backend::shader::Part;
use gpu_backend::{Backend, Cpu, Host, testing};
use transmittance::gpu::{
    CandidatesSlot, Crowding, ShaderCandidates, WgslRule, WgslStored, build_from_candidates,
};
use transmittance::{
    Accumulate, BlockerSegment, BuildMap, Curve, Error, Lists, Packed, Stream, Tile,
    TransmittanceMap,
};

/// Texels, and depths that differ from texel to texel.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Slab {
    texels: [u32; 4],
    entry: f32,
    length: f32,
    optical_depth: f32,
    segments: u32,
}

impl Slab {
    /// Numbers that f32 holds exactly, so that both backends have the same.
    fn segment(&self, [x, y]: [usize; 2], index: u32) -> BlockerSegment {
        let slope = 0.25 * (x % 32) as f32 + 0.5 * (y % 16) as f32;
        let entry = self.entry + slope + index as f32 * self.length;
        let tau = if (x + y) % 5 == 4 {
            0.0
        } else {
            self.optical_depth
        };
        BlockerSegment::from_optical_depth(entry, entry + self.length, tau).unwrap()
    }

    fn touches(&self, [x, y]: [usize; 2]) -> bool {
        let [first, row, end, end_row] = self.texels.map(|at| at as usize);
        (first..end).contains(&x) && (row..end_row).contains(&y)
    }
}

struct Slabs {
    count: u32,
    crowding: Crowding,
    buffer: GpuBuffer<Slab>,
}

impl Slabs {
    fn new(gpu: &Gpu<Queued>, extent: [usize; 2], slabs: &[Slab]) -> Self {
        let touched = slabs.iter().map(|slab| (slab.texels, slab.segments));
        Self {
            count: slabs.len() as u32,
            crowding: Crowding::of(extent, touched),
            buffer: gpu.upload(slabs).unwrap(),
        }
    }
}

impl InShader<CandidatesSlot> for Slabs {
    fn part() -> Part {
        Part::new("slabs")
            .source(
                "struct slabs_Slab {
                    texels: vec4<u32>,
                    entry: f32,
                    length: f32,
                    optical_depth: f32,
                    segments: u32,
                }
                fn slabs_candidate_texels(candidate: u32) -> vec4<u32> {
                    return slabs_all[candidate].texels;
                }
                fn slabs_candidate_segment_count(candidate: u32) -> u32 {
                    return slabs_all[candidate].segments;
                }
                fn slabs_candidate_segment(
                    candidate: u32, texel: vec2<u32>, index: u32
                ) -> avsm_Segment {
                    let slab = slabs_all[candidate];
                    let slope = 0.25 * f32(texel.x % 32u) + 0.5 * f32(texel.y % 16u);
                    var segment: avsm_Segment;
                    segment.entry = slab.entry + slope + f32(index) * slab.length;
                    segment.exit = segment.entry + slab.length;
                    segment.optical_depth[0] =
                        select(slab.optical_depth, 0.0, (texel.x + texel.y) % 5u == 4u);
                    return segment;
                }",
            )
            .read("slabs_all", "array<slabs_Slab>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![Argument::read(&self.buffer)]
    }
}

impl ShaderCandidates for Slabs {
    const LOOPS: u32 = 0;

    fn count(&self) -> u32 {
        self.count
    }

    fn crowding(&self) -> Crowding {
        self.crowding
    }
}

/// Slabs of every size in and around a map.
fn random(extent: [usize; 2], count: usize, seed: u64) -> Vec<Slab> {
    let mut random = Random::new(seed);
    let mut below = |end: u32| (random.unit() * end as f32) as u32;
    (0..count)
        .map(|_| {
            let size = 1 << below(9);
            let [x, y] = extent.map(|side| below(side as u32 + 20));
            let end = [x + below(size + 1), y + below(size + 1)];
            Slab {
                texels: [x, y, end[0], end[1]],
                entry: 0.25 * below(128) as f32,
                length: 0.25 * below(16) as f32,
                optical_depth: 2.0_f32.powi(-(below(8) as i32)),
                segments: below(4),
            }
        })
        .collect()
}

fn met<A, P>(
    gpu: &Gpu<Queued>,
    extent: [usize; 2],
    slabs: &Slabs,
    rule: &A,
) -> TransmittanceMap<Host, P>
where
    A: WgslRule,
    A::Curve: Into<P>,
    P: WgslStored,
{
    let mut map = TransmittanceMap::<GpuMemory, P>::new(gpu, extent).unwrap();
    build_from_candidates(gpu, rule, slabs, &mut map).unwrap();
    map.download(gpu).unwrap()
}

/// The same segments from lists, on both backends.
fn listed<A, P>(
    gpu: &Gpu<Queued>,
    extent: [usize; 2],
    slabs: &[Slab],
    rule: &A,
) -> [TransmittanceMap<Host, P>; 2]
where
    A: WgslRule + Accumulate + Clone + Sync,
    A::Curve: Into<P>,
    P: WgslStored,
{
    let (mut offsets, mut segments) = (vec![0], Vec::new());
    for y in 0..extent[1] {
        for x in 0..extent[0] {
            for slab in slabs.iter().filter(|slab| slab.touches([x, y])) {
                segments.extend((0..slab.segments).map(|index| slab.segment([x, y], index)));
            }
            offsets.push(segments.len() as u32);
        }
    }
    let lists = Lists::new(extent, &offsets, &segments).unwrap();
    let mut there = TransmittanceMap::<GpuMemory, P>::new(gpu, extent).unwrap();
    gpu.build_map(rule, &lists.upload(gpu).unwrap(), &mut there)
        .unwrap();
    let cpu = Cpu::new();
    let mut here = TransmittanceMap::<Host, P>::new(&cpu, extent).unwrap();
    cpu.build_map(rule, &lists, &mut here).unwrap();
    [here, there.download(gpu).unwrap()]
}

fn alike(extent: [usize; 2], slabs: &[Slab]) {
    let Some(gpu) = testing::gpu() else { return };
    let rule = Stream::<8>::new();
    let found: TransmittanceMap<_, Curve<8>> =
        met(&gpu, extent, &Slabs::new(&gpu, extent, slabs), &rule);
    let [here, there]: [TransmittanceMap<_, Curve<8>>; 2] = listed(&gpu, extent, slabs, &rule);
    for y in 0..extent[1] {
        for x in 0..extent[0] {
            // Bit by bit the same as from lists there, and within both bounds of the CPU's.
            let curve = found.texel(x, y);
            assert_eq!(curve, there.texel(x, y), "{x} {y}");
            let expected = here.texel(x, y);
            for depth in (0..80).map(|i| 0.75 * i as f32) {
                let off = (curve.transmittance(depth) - expected.transmittance(depth)).abs();
                let bound = curve.error_bound(depth) + expected.error_bound(depth);
                assert!(off <= bound, "{x} {y} at {depth}: {off}, {bound}");
            }
        }
    }
}

#[test]
fn what_texels_meet_makes_the_curves_of_the_same_segments_in_lists() {
    alike([70, 45], &random([70, 45], 300, 1));
    alike([1, 1], &random([1, 1], 200, 2));
    alike([8, 130], &random([8, 130], 500, 3));
}

#[test]
fn what_is_wider_than_the_map_or_beside_it_is_met_where_it_is() {
    let slab = |texels| Slab {
        texels,
        entry: 2.0,
        length: 1.0,
        optical_depth: 0.5,
        segments: 2,
    };
    let all = [
        [0, 0, u32::MAX, u32::MAX],
        [100, 0, 101, 9],
        [5, 5, 5, 9],
        [9, 9, 3, 3],
        [0, 16, u32::MAX, 17],
        [39, 0, u32::MAX, u32::MAX],
    ];
    alike([40, 20], &all.map(slab));
}

#[test]
fn no_candidates_make_a_clear_map_and_no_texels_none() {
    let Some(gpu) = testing::gpu() else { return };
    alike([20, 3], &[]);
    for extent in [[0, 7], [7, 0], [0, 0]] {
        let slabs = random([7, 7], 20, 5);
        let slabs = Slabs::new(&gpu, extent, &slabs);
        assert_eq!(
            slabs.crowding,
            Crowding {
                around: 0,
                segments: 0
            }
        );
        let map: TransmittanceMap<_, Packed<8>> = met(&gpu, extent, &slabs, &Curve::<8>::new());
        assert_eq!(map.extent(), extent);
    }
}

#[test]
fn thirty_thousand_candidates_take_many_dispatches_and_none_is_left_out() {
    let Some(gpu) = testing::gpu() else { return };
    let extent = [24, 24];
    let mut slabs = random(extent, 30_000, 8);
    for slab in &mut slabs {
        slab.optical_depth /= 1024.0;
        slab.segments = slab.segments.min(1);
        let [x, y, ..] = slab.texels;
        slab.texels = [x, y, x + 2, y + 2];
    }
    let uploaded = Slabs::new(&gpu, extent, &slabs);
    // More than a dispatch looks at.
    assert!(uploaded.crowding.around > 3000);
    let map: TransmittanceMap<_, Curve<8>> = met(&gpu, extent, &uploaded, &Curve::<8>::new());
    for [x, y] in [[0, 0], [23, 23], [7, 11], [16, 15]] {
        let touching = slabs.iter().filter(|slab| slab.touches([x, y]));
        let taus = touching.flat_map(|slab| (0..slab.segments).map(|i| slab.segment([x, y], i)));
        let tau: f64 = taus
            .map(|segment| f64::from(segment.optical_depth()[0]))
            .sum();
        let curve = map.texel(x, y);
        let off = (f64::from(curve.transmittance(1e6)) - (-tau).exp()).abs();
        assert!(off <= f64::from(curve.error_bound(1e6)), "{off}");
        assert!(curve.max_error_bound() < 1.0 && tau > 0.0);
    }
}

#[test]
fn curves_that_lack_candidates_have_a_bound_of_1() {
    let Some(gpu) = testing::gpu() else { return };
    let extent = [3, 3];
    let mut slabs = random(extent, 9000, 9);
    for slab in &mut slabs {
        slab.texels = [0, 0, 3, 3];
        slab.segments = 1;
    }
    let mut promised = Slabs::new(&gpu, extent, &slabs);
    assert_eq!(
        promised.crowding,
        Crowding {
            around: 9000,
            segments: 9000
        }
    );
    promised.crowding = Crowding {
        around: 1,
        segments: 1,
    };
    let map: TransmittanceMap<_, Curve<8>> = met(&gpu, extent, &promised, &Curve::<8>::new());
    assert_eq!(map.texel(1, 2).max_error_bound(), 1.0);
}

#[test]
fn crowding_is_that_of_every_texel_by_itself() {
    let extent = [70, 45];
    let slabs = random(extent, 300, 1);
    let crowding = Crowding::of(
        extent,
        slabs.iter().map(|slab| (slab.texels, slab.segments)),
    );
    let mut most = 0;
    let tile = Tile { x: 0..70, y: 0..45 };
    for y in tile.y.clone() {
        for x in tile.x.clone() {
            let touching = slabs.iter().filter(|slab| slab.touches([x, y]));
            most = most.max(touching.map(|slab| slab.segments).sum());
        }
    }
    assert_eq!(crowding.segments, most);

    // A slab is around all texels that share one of its squares with it.
    let side_of = |slab: &&Slab| {
        let [x, y, end_x, end_y] = slab.texels;
        let (end_x, end_y) = (end_x.min(70), end_y.min(45));
        let squares =
            |side: u32| ((end_x - 1) / side + 1 - x / side) * ((end_y - 1) / side + 1 - y / side);
        let sides = [16, 32, 64, 128];
        (x < end_x && y < end_y).then(|| sides.into_iter().find(|side| squares(*side) <= 4))?
    };
    let is_around = |slab: &&Slab, [x, y]: [u32; 2]| {
        side_of(slab).is_some_and(|side| {
            let [first, row, end, end_row] = slab.texels;
            let columns = first / side..=(end.min(70) - 1) / side;
            let rows = row / side..=(end_row.min(45) - 1) / side;
            columns.contains(&(x / side)) && rows.contains(&(y / side))
        })
    };
    let texels = (0..45).flat_map(|y| (0..70).map(move |x| [x, y]));
    let around = texels.map(|texel| slabs.iter().filter(|slab| is_around(slab, texel)).count());
    assert_eq!(Some(crowding.around as usize), around.max());
}

#[test]
fn a_map_of_several_bands_is_that_of_its_texels() {
    // More squares of 8 × 8 texels than are made at once, the last of them beyond the map.
    let extent = [300, 263];
    alike(extent, &random(extent, 40, 12));
}

#[test]
fn promises_that_cost_too_many_dispatches_are_turned_away() {
    let Some(gpu) = testing::gpu() else { return };
    let mut slabs = Slabs::new(&gpu, [9, 9], &random([9, 9], 20, 13));
    let mut map = TransmittanceMap::<GpuMemory, Packed<8>>::new(&gpu, [9, 9]).unwrap();
    let mut build = |around, segments| {
        slabs.crowding = Crowding { around, segments };
        build_from_candidates(&gpu, &Stream::<8>::new(), &slabs, &mut map)
    };
    // No more are around a texel than there are.
    assert!(build(u32::MAX, 60).is_ok());
    let error = build(20, u32::MAX).unwrap_err();
    assert!(matches!(error, Error::BadValue { .. }), "{error}");
}
