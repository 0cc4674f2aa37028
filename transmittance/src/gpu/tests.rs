//! Shaders without a device. Results are compared in `tests/gpu.rs`.

use gpu_backend::assert_same_layout;
use gpu_backend::gpu::GpuMemory;
use gpu_backend::testing::Shader;

use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::build::{self, ListsRecord};
use super::candidates::{self, BinParameters, CandidatesSlot, MeetParameters};
use super::capture::{self, GATHER, GatherParameters, SCAN, SORT, SortParameters};
use super::{LARGEST_CAPACITY, WgslRule, WgslStored, build_parts, lookup_parts, query};
use crate::certificate::INCOMPLETE;
use crate::lookup::Rules;
use crate::{
    Area, Curve, Exponential, Linear, Lookup, Maximum, Packed, PackedHalf, Receiver, SegmentLists,
    Stream,
};

/// Stand for the bindings of a map.
const WORDS: &str = "
    var<private> avsm_memory: array<u32, 64>;
    fn avsm_word(index: u32) -> u32 { return avsm_memory[index % 64u]; }
    fn avsm_set_word(index: u32, word: u32) { avsm_memory[index % 64u] = word; }";

/// Both kinds of parts and both entry points of a rule and a stored form.
fn are_valid<A, P, const C: usize>()
where
    A: WgslRule<C>,
    A::Curve: Into<P>,
    P: WgslStored<C>,
{
    let lookup = Shader::new(&[&lookup_parts::<P, C>()[..], &[WORDS]].concat()).unwrap();
    lookup.require_part(&["avsm_"]).unwrap();
    assert_eq!(lookup.values("avsm_WORDS").unwrap(), [P::WORDS as f64]);
    assert_eq!(lookup.values("avsm_CHANNELS").unwrap(), [C as f64]);
    let build = Shader::new(&[&build_parts::<A, P, C>()[..], &[WORDS]].concat()).unwrap();
    build.require_part(&["avsm_"]).unwrap();
    assert_eq!(build.values("avsm_CAPACITY").unwrap(), [A::CAPACITY as f64]);
    assert!(build.values("avsm_CHOICE").unwrap()[0] <= A::CAPACITY as f64);
    assert_eq!(
        build.values("avsm_VALUES").unwrap(),
        [(C * A::CAPACITY) as f64]
    );

    let query = Shader::new(&query::parts::<P, C>()).unwrap();
    assert_same_layout!(
        query,
        "Parameters",
        query::Parameters {
            width,
            height,
            count,
            side
        }
    );
    assert_same_layout!(query, "Receiver", Receiver { position, depth });
    let build = build::shader::<A, SegmentLists<GpuMemory, C>, P, C>().unwrap();
    let build = Shader::new(&build.finish(1)).unwrap();
    assert_same_layout!(
        build,
        "Parameters",
        build::Parameters {
            width,
            texels,
            first_texel,
            first,
            end
        }
    );
    assert_same_layout!(
        build,
        "avsm_Lists",
        ListsRecord {
            width,
            height,
            segments
        }
    );
}

/// Candidates that are nowhere.
struct Nowhere;

impl InShader<CandidatesSlot> for Nowhere {
    fn part() -> Part {
        Part::new("nowhere").source(
            "fn nowhere_candidate_texels(candidate: u32) -> vec4<u32> { return vec4(0u); }
            fn nowhere_candidate_segment_count(candidate: u32) -> u32 { return 1u; }
            fn nowhere_candidate_segment(
                candidate: u32, texel: vec2<u32>, index: u32
            ) -> avsm_Segment {
                return avsm_Segment();
            }",
        )
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

#[test]
fn the_shaders_of_candidates_are_valid_and_as_in_rust() {
    type Rule = Stream<8>;
    let bins = candidates::bins_shader::<Nowhere, Rule, 1>().unwrap();
    let bins = Shader::new(&bins.finish(1)).unwrap();
    assert_same_layout!(
        bins,
        "BinParameters",
        BinParameters {
            width,
            height,
            candidates
        }
    );
    let meet = candidates::meet_shader::<Rule, Nowhere, Packed<8>, 1>().unwrap();
    let meet = Shader::new(&meet.finish(1)).unwrap();
    assert_same_layout!(
        meet,
        "MeetParameters",
        MeetParameters {
            width,
            height,
            texels,
            first_square,
            levels,
            starts,
            budget,
            look,
            ask,
            insertion
        }
    );
    for shader in [bins, meet] {
        let value = |name| shader.values(name).unwrap();
        assert_eq!(value("avsm_TILE"), [f64::from(candidates::TILE)]);
        assert_eq!(value("avsm_MOST_BINS"), [f64::from(candidates::MOST_BINS)]);
    }
    let coloured = candidates::meet_shader::<
        Stream<5, Maximum, Linear, 2, 2>,
        Nowhere,
        Curve<5, Linear, 2>,
        2,
    >();
    Shader::new(&coloured.unwrap().finish(1)).unwrap();
}

fn all_stored<A, L: Lookup, const N: usize, const C: usize>()
where
    A: WgslRule<C, Curve = Curve<N, L, C>>,
{
    are_valid::<A, Curve<N, L, C>, C>();
    are_valid::<A, Packed<N, L, C>, C>();
    are_valid::<A, PackedHalf<N, L, C>, C>();
}

#[test]
fn all_parts_are_fit_for_other_shaders_and_all_structures_are_those_of_rust() {
    all_stored::<Curve<4, Linear>, Linear, 4, 1>();
    all_stored::<Curve<8>, Exponential, 8, 1>();
    all_stored::<Curve<64, Linear, 3>, Linear, 64, 3>();
    all_stored::<Stream<8>, Exponential, 8, 1>();
    all_stored::<Stream<12, Maximum>, Exponential, 12, 1>();
    all_stored::<Stream<16, Area, Linear, 3>, Linear, 16, 3>();
    all_stored::<Stream<5, Maximum, Linear, 2, 2>, Linear, 5, 2>();
    all_stored::<Stream<2, Area, Exponential, 16, 32>, Exponential, 2, 16>();
}

#[test]
fn constants_are_those_of_rust() {
    let shader = Shader::new(&query::parts::<PackedHalf<8>, 1>()).unwrap();
    assert_eq!(
        shader.values("avsm_LARGEST").unwrap(),
        [f64::from(f32::MAX)]
    );
    assert_eq!(
        shader.values("avsm_INCOMPLETE").unwrap(),
        [f64::from(INCOMPLETE)]
    );
    assert_eq!(
        shader.values("avsm_DARK").unwrap(),
        [f64::from(Exponential::DARK)]
    );
    assert_eq!(shader.values("avsm_LAST").unwrap(), [f64::from(u16::MAX)]);
    assert_eq!(shader.values("avsm_NODES").unwrap(), [8.0]);
}

#[test]
fn the_sort_is_valid_and_as_in_rust() {
    let shader = Shader::new(SORT).unwrap();
    assert_same_layout!(
        shader,
        "Parameters",
        SortParameters {
            count,
            chunks,
            field,
            shift,
            texels,
            stride
        }
    );
    assert_eq!(shader.values("DIGITS").unwrap(), [capture::DIGITS as f64]);
    for parts in [SORT, SCAN] {
        let chunk = Shader::new(parts).unwrap().values("CHUNK").unwrap();
        assert_eq!(chunk, [capture::CHUNK as f64]);
    }
    let shader = Shader::new(GATHER).unwrap();
    assert_same_layout!(
        shader,
        "Parameters",
        GatherParameters {
            count,
            texels,
            stride
        }
    );
}

#[test]
fn unfinished_curves_fit_into_a_binding_of_any_device() {
    let bytes = |numbers| 4 * numbers * build::band(numbers);
    for capacity in 2..=LARGEST_CAPACITY {
        for channels in 1..=16 {
            let numbers = build::unfinished_numbers(capacity, channels);
            let next = bytes(numbers) + 4 * numbers;
            assert!(bytes(numbers) <= 128 << 20, "{capacity} {channels}");
            // No smaller than it has to be.
            assert!(build::band(numbers) == 1 << 16 || next > 128 << 20);
        }
    }
    // Small curves wait 65,536 at once; 64 nodes of three channels would need
    // 168 MB for as many.
    assert_eq!(build::band(build::unfinished_numbers(10, 1)), 1 << 16);
    let capacity = <Stream<16, Area, Linear, 3> as WgslRule<3>>::CAPACITY;
    let coloured = build::unfinished_numbers(capacity, 3);
    assert!((4 * coloured) << 16 > 128 << 20);
    assert_eq!(build::band(coloured), (128 << 20) / (4 * coloured));
    assert_eq!(build::band(64 << 20), 1);
}

#[test]
fn pages_say_what_the_parts_define() {
    let page = include_str!("parts.rs");
    let (lookup, build) = page.split_once("pub const fn lookup_parts").unwrap();
    let parts = lookup_parts::<Curve<8>, 1>();
    let named = Shader::documented(&[&parts[..], &[WORDS]].concat(), lookup).unwrap();
    assert!(named.contains(&"avsm_error_bounds".to_owned()), "{named:?}");
    let parts = build_parts::<Stream<8>, Packed<8>, 1>();
    let named = Shader::documented(&[&parts[..], &[WORDS]].concat(), build).unwrap();
    assert!(named.contains(&"avsm_insert".to_owned()), "{named:?}");
}
