//! Streams of blockers: some like smoke and hair, some that lean towards what
//! is hard.

use proptest::prelude::*;
pub(crate) use reference::random::Random;
use transmittance::BlockerSegment;

/// 141 puffs, 282 ends: three columns of smoke behind each other.
pub(crate) fn columns_of_smoke(seed: u64) -> Vec<BlockerSegment> {
    let mut random = Random::new(seed);
    let columns = [(20.0, 0.0008), (120.0, 0.004), (260.0, 0.002)];
    (0..141)
        .map(|puff| {
            let (centre, density) = columns[puff % 3];
            let centre = centre + (random.unit() + random.unit() - 1.0) * 25.0;
            let (radius, offset) = (2.0 + 8.0 * random.unit(), random.unit());
            let half = radius * (1.0 - offset).sqrt() + 1e-3;
            let density = density * (0.3 + 1.4 * random.unit());
            BlockerSegment::from_density(centre - half, centre + half, density)
                .expect("sound numbers")
        })
        .collect()
}

/// Up to 64 touching voxels of a smooth cloud; clear ones are left out.
pub(crate) fn voxels(seed: u64) -> Vec<BlockerSegment> {
    let mut random = Random::new(seed);
    let waves: Vec<[f32; 3]> = (1..6)
        .map(|k| [k as f32, 6.3 * random.unit(), random.unit() / k as f32])
        .collect();
    (0..64)
        .map(|voxel| {
            let x = (voxel as f32 + 0.5) / 64.0;
            let noise: f32 = waves
                .iter()
                .map(|[k, at, a]| a * (6.3 * k * x + at).sin())
                .sum();
            let density = (0.05 * (noise + 0.3) * (x * (1.0 - x) * 4.0)).max(0.0);
            BlockerSegment::from_density(voxel as f32, voxel as f32 + 1.0, density)
                .expect("sound numbers")
        })
        .filter(|voxel: &BlockerSegment| !voxel.is_clear())
        .collect()
}

/// 58 strands in a few wisps, thin against their distances.
pub(crate) fn hair(seed: u64) -> Vec<BlockerSegment> {
    let mut random = Random::new(seed);
    let wisps: Vec<f32> = (0..7).map(|_| 100.0 * random.unit()).collect();
    (0..58)
        .map(|strand| {
            let at = wisps[strand % wisps.len()] + 8.0 * random.unit() * random.unit();
            BlockerSegment::from_transmittance(at, at + 0.06, 0.84).expect("sound numbers")
        })
        .collect()
}

/// Hair in smoke, and for every other seed a wall behind it.
pub(crate) fn hair_in_smoke(seed: u64) -> Vec<BlockerSegment> {
    let mut random = Random::new(seed);
    let mut stream = Vec::new();
    for _ in 0..60 {
        let at = 40.0 + 10.0 * random.unit();
        let tau = 0.02 + 0.12 * random.unit();
        stream.push(BlockerSegment::from_optical_depth(at, at + 0.05, tau).expect("sound numbers"));
        let (centre, half) = (25.0 + 75.0 * random.unit(), 1.0 + 4.0 * random.unit());
        stream.push(
            BlockerSegment::from_density(centre - half, centre + half, 0.004)
                .expect("sound numbers"),
        );
    }
    if seed.is_multiple_of(2) {
        stream.push(BlockerSegment::opaque(105.0).expect("sound numbers"));
    }
    stream
}

/// Smoke in front of and behind one to three walls, in random order: what is
/// behind a wall is dark, whatever the order in which it came.
pub(crate) fn smoke_around_walls(seed: u64) -> Vec<BlockerSegment> {
    let mut random = Random::new(seed);
    let mut stream = columns_of_smoke(seed);
    for _ in 0..1 + seed % 3 {
        let depth = 100.0 + 180.0 * random.unit();
        stream.push(BlockerSegment::opaque(depth).expect("a finite depth"));
    }
    random.shuffle(&mut stream);
    stream
}

/// Depths where streams live: about 0, far out, at the limits of f32.
fn scales() -> impl Strategy<Value = (f32, f32)> {
    prop_oneof![
        6 => Just((0.0, 1.0)),
        1 => Just((1000.0, 1.0)),
        1 => Just((0.0, 1e-30)),
        1 => Just((0.0, 1e30)),
        1 => Just((-1e6, 1.0)),
        1 => Just((0.0, f32::MAX / 128.0)),
        1 => Just((0.0, f32::from_bits(1))),
    ]
}

fn optical_depth() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => (-12.0_f32..3.0).prop_map(|power| 10.0_f32.powf(power)),
        8 => 0.01_f32..1.0,
        1 => Just(0.0),
        1 => Just(f32::INFINITY),
        1 => Just(1e29),
    ]
}

/// Entry and length between -128 and 128: smoke, hair, touching voxels,
/// surfaces, coincident ones, needles in mountains.
fn extent() -> impl Strategy<Value = (f32, f32)> {
    prop_oneof![
        4 => (-64.0_f32..64.0, 0.0_f32..32.0),
        4 => (-64.0_f32..64.0, 1e-4_f32..1e-1),
        2 => (-16_i8..16, 0_u8..4).prop_map(|(at, len)| (f32::from(at), f32::from(len))),
        2 => (-64.0_f32..64.0, Just(0.0)),
        1 => Just((1.0, 0.0)),
        1 => (-64.0_f32..0.0, Just(64.0)),
        1 => (-64.0_f32..64.0, (-6.0_f32..1.5).prop_map(|power| 10.0_f32.powf(power))),
    ]
}

/// Hard streams of up to `most` segments in any order.
pub(crate) fn hard(most: usize) -> impl Strategy<Value = Vec<BlockerSegment>> {
    let segment = (extent(), optical_depth());
    (scales(), prop::collection::vec(segment, 0..most)).prop_map(|((at, scale), segments)| {
        segments
            .into_iter()
            .map(|((entry, length), tau)| {
                let place = |x: f32| x * scale + at;
                let (entry, exit) = (place(entry), place(entry + length));
                BlockerSegment::from_optical_depth(entry, exit.max(entry), tau)
                    .expect("sound numbers")
            })
            .collect()
    })
}

/// Streams in which much is opaque or nearly so, and where what is merged is dark.
pub(crate) fn dark(most: usize) -> impl Strategy<Value = Vec<BlockerSegment>> {
    let tau = prop_oneof![
        3 => 0.01_f32..1.0,
        2 => (0.0_f32..8.0).prop_map(|power| 10.0_f32.powf(power)),
        2 => Just(f32::INFINITY),
        1 => Just(1e29),
    ];
    let extent = prop_oneof![
        3 => (-64.0_f32..64.0, 0.0_f32..32.0),
        2 => (-16_i8..16, 0_u8..4).prop_map(|(at, len)| (f32::from(at), f32::from(len))),
        2 => (-64.0_f32..64.0, Just(0.0)),
    ];
    prop::collection::vec((extent, tau), 0..most).prop_map(|segments| {
        let segment = |((entry, length), tau): ((f32, f32), f32)| {
            BlockerSegment::from_optical_depth(entry, entry + length, tau).expect("sound numbers")
        };
        segments.into_iter().map(segment).collect()
    })
}
