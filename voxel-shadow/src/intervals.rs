//! Lit intervals of many rays at once.
//!
//! [`Runs`](crate::Runs) reads the runs of a ray one after the other, and the end of each is a
//! branch that is hard to foresee. Here a block of rays takes each step together, in loops
//! without such branches:
//!
//! 1. The first words of all rays are read, so that misses of the cache overlap.
//! 2. The borders between runs are read off the words into one list for all rays, four at a
//!    time: what is written beyond the last border of a word is overwritten by what comes next.
//! 3. The distances and the visibilities of all borders are computed, with the best vector
//!    instructions that there are.
//! 4. The lit runs are kept: all are written to the list of intervals, and those in shadow are
//!    overwritten.
//!
//! All steps round as those of a ray by itself do, so that the intervals have the same bits.
//! What binds is reading the borders, with a branch at the end of those of each word; misses of
//! the cache, of texels and of the places for intervals, take a fifth of the time.

use std::sync::LazyLock;

use epipolar::{Angle, Lattice, Phi, RAYS, RayBlock};
use gpu_backend::Host;
use pulp::{Arch, Simd, WithSimd};

use crate::runs::{Pair, blend};
use crate::shadow::Texels;
use crate::{LitInterval, ShadowVolume};

/// Borders that are read off a word without asking whether there are as many.
const STRIDE: usize = 4;

/// The best instructions that this processor has: asked once.
fn arch() -> Arch {
    static ARCH: LazyLock<Arch> = LazyLock::new(Arch::new);
    *ARCH
}

impl ShadowVolume<'_, Host> {
    /// [`RayShadow::lit_runs`](crate::RayShadow::lit_runs) of many rays, for less time: calls
    /// `each` with the number and the lit intervals of each ray, in order. Rays are a direction
    /// of any length and, as the fourth number, the distance of the surface in metres; any
    /// numbers are taken, as [`ShadowVolume::ray_shadow`] takes them.
    pub fn lit_intervals(&self, rays: &[[f32; 4]], each: impl FnMut(usize, &[LitInterval])) {
        self.lit_parts_on::<false>(arch(), rays, each);
    }

    /// [`RayShadow::lit_voxels`](crate::RayShadow::lit_voxels) of many rays, as
    /// [`ShadowVolume::lit_intervals`] has their runs. It takes less time than ray by ray if
    /// there is no bias along φ.
    pub fn lit_voxels(&self, rays: &[[f32; 4]], mut each: impl FnMut(usize, &[LitInterval])) {
        if self.sampling().phi_bias == 0.0 {
            return self.lit_parts_on::<true>(arch(), rays, each);
        }
        let mut voxels = Vec::new();
        self.ray_shadows(rays, |number, ray| {
            voxels.clear();
            voxels.extend(ray.lit_voxels());
            each(number, &voxels);
        });
    }

    /// The lit runs or, if `VOXELS`, the lit voxels, for which there must be no bias along φ.
    fn lit_parts_on<const VOXELS: bool>(
        &self,
        arch: Arch,
        rays: &[[f32; 4]],
        mut each: impl FnMut(usize, &[LitInterval]),
    ) {
        let mut block = RayBlock::default();
        let mut parts = Parts::new();
        let mut alone = Vec::new();
        let bias = self.sampling().phi_bias;
        let shifted: Vec<[f32; 2]>;
        let phi = if bias == 0.0 {
            self.lattice().bounds()
        } else {
            let bits = 0..self.lattice().resolution().bits();
            let phi = bits.map(|bit| self.lattice().phi_at(bit as f32 - bias).pair());
            shifted = phi.collect();
            &shifted
        };
        for (rays, first_ray) in rays.chunks(RAYS).zip((0..).step_by(RAYS)) {
            self.lattice().locate_rays(rays, &mut block);
            let texels: [Texels<'_>; RAYS] = std::array::from_fn(|i| {
                if i < rays.len() {
                    let positions = [block.alpha_position(i), block.theta_position(i)];
                    self.texels(positions, block.surface(i))
                } else {
                    Texels::Axis { lit: false }
                }
            });
            arch.dispatch(Search::<VOXELS> {
                lattice: self.lattice(),
                phi,
                bias,
                block: &block,
                texels: &texels[..rays.len()],
                parts: &mut parts,
            });
            let mut start = 0;
            for (i, texels) in texels[..rays.len()].iter().enumerate() {
                if pair_of(texels, block.end(i)).is_some() {
                    let end = parts.ends[i];
                    each(first_ray + i, &parts.lit[start..end]);
                    start = end;
                } else {
                    let ray = self.shadow_of(*texels, block.ray(i), block.surface(i), block.end(i));
                    alone.clear();
                    if VOXELS {
                        alone.extend(ray.lit_voxels());
                    } else {
                        alone.extend(ray.lit_runs());
                    }
                    each(first_ray + i, &alone);
                }
            }
        }
    }
}

/// The texels of a ray that has borders; `None` for one on the axis, or without length, whose
/// single run is a case of its own.
#[inline(always)]
fn pair_of<'t, 'a>(texels: &'t Texels<'a>, end: f32) -> Option<&'t Pair<'a>> {
    match texels {
        Texels::Pair(pair) if end > 0.0 => Some(pair),
        _ => None,
    }
}

/// Where a run begins, or a ray ends: the number of a bit, the number of the ray in its block,
/// which of the texels are lit from there on, and whether it is the first or the last one of
/// the ray. Behind the last one nothing is lit.
type Border = u32;

const BIT: Border = (1 << RAY_SHIFT) - 1;
const RAY_SHIFT: u32 = 16;
const LIT_SHIFT: u32 = 24;
const BEGINS: Border = 1 << 26;
const ENDS: Border = 1 << 27;
const _: () = assert!(RAYS <= 1 << (LIT_SHIFT - RAY_SHIFT));

/// The number of the ray in its block.
#[inline(always)]
fn ray_of(border: Border) -> usize {
    (border >> RAY_SHIFT) as usize % RAYS
}

/// The part of a texel pair that a ray passes.
#[derive(Debug, Clone, Copy, Default)]
struct Passed {
    /// The first and the last bit.
    first: u32,
    last: u32,
    /// The word of the first bit in both texels.
    words: [Word; 2],
}

impl Passed {
    /// What [`Runs::new`](crate::Runs::new) begins with.
    #[inline(always)]
    fn new(pair: &Pair<'_>, bias: f32, end: f32) -> Self {
        let highest = (32 * pair.first.len() - 1) as f32;
        let bit_at = |position: f32| (position + bias).clamp(0.0, highest) as u32;
        let (first, mut last) = (bit_at(0.0), bit_at(end));
        // Nothing begins at the end of a ray, to which a border may be rounded.
        if first < last && last as f32 - bias >= end {
            last -= 1;
        }
        Self {
            first,
            last,
            words: words(pair, first / 64),
        }
    }
}

/// What is found along the rays of a block. All lists but `lit` have a place for each border;
/// beyond `count` they have what is left over.
#[derive(Debug)]
struct Parts {
    borders: Vec<Border>,
    count: usize,
    /// φ of the borders.
    pairs: Vec<[f32; 2]>,
    /// Of the ray of each border, the vector of α, the surface, and the share of the second
    /// texel.
    alpha: [Vec<f32>; 2],
    surfaces: Vec<f32>,
    shares: Vec<f32>,
    distances: Vec<f32>,
    visibilities: Vec<f32>,
    lit: Vec<LitInterval>,
    /// Where the lit parts of each ray end.
    ends: [usize; RAYS],
}

struct Search<'s, 'a, const VOXELS: bool> {
    lattice: &'a Lattice,
    /// φ at which each bit begins.
    phi: &'s [[f32; 2]],
    bias: f32,
    block: &'s RayBlock,
    texels: &'s [Texels<'a>],
    parts: &'s mut Parts,
}

impl<const VOXELS: bool> WithSimd for Search<'_, '_, VOXELS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            lattice,
            phi,
            bias,
            block,
            texels,
            parts,
        } = self;
        parts.count = 0;
        // All first words are asked for before any is needed, so that misses of the cache
        // overlap.
        let mut passed = [Passed::default(); RAYS];
        for (i, texels) in texels.iter().enumerate() {
            if let Some(pair) = pair_of(texels, block.end(i)) {
                passed[i] = Passed::new(pair, bias, block.end(i));
            }
        }
        for (i, texels) in texels.iter().enumerate() {
            if let Some(pair) = pair_of(texels, block.end(i)) {
                parts.read_borders::<VOXELS>(i, pair, &passed[i], block);
            }
        }
        parts.measure(lattice, phi);
        parts.keep_lit();
    }
}

impl Parts {
    fn new() -> Self {
        Self {
            borders: Vec::new(),
            count: 0,
            pairs: Vec::new(),
            alpha: [Vec::new(), Vec::new()],
            surfaces: Vec::new(),
            shares: Vec::new(),
            distances: Vec::new(),
            visibilities: Vec::new(),
            lit: Vec::new(),
            ends: [0; RAYS],
        }
    }

    /// Makes all lists at least so long.
    fn reserve(&mut self, len: usize) {
        if self.borders.len() >= len {
            return;
        }
        let len = len.next_power_of_two();
        self.borders.resize(len, 0);
        self.pairs.resize(len, [0.0; 2]);
        let [cos, sin] = &mut self.alpha;
        for list in [
            cos,
            sin,
            &mut self.surfaces,
            &mut self.shares,
            &mut self.distances,
            &mut self.visibilities,
        ] {
            list.resize(len, 0.0);
        }
        self.lit.resize(len, LitInterval::default());
    }

    /// Reads the borders of a ray off its texels.
    #[inline(always)]
    fn read_borders<const VOXELS: bool>(
        &mut self,
        number: usize,
        pair: &Pair<'_>,
        passed: &Passed,
        block: &RayBlock,
    ) {
        let Passed {
            first,
            last,
            words: mut both,
        } = *passed;
        let begin = self.count;
        self.reserve(begin + 32 * pair.first.len() + 2 * STRIDE);
        // There are 64 rays.
        let ray = (number as Border) << RAY_SHIFT;
        let mut count = begin;
        let mut number_of_word = first / 64;
        loop {
            let border_at = |bit: u32| {
                let lit = |word: &Word| ((!word.bits >> (bit % 64)) & 1) as Border;
                let lit = lit(&both[0]) | lit(&both[1]) << 1;
                ray | (64 * number_of_word + bit) | lit << LIT_SHIFT
            };
            let mut borders = if VOXELS {
                u64::MAX
            } else {
                both[0].changes() | both[1].changes()
            };
            if number_of_word == first / 64 {
                self.borders[count] = BEGINS | border_at(first % 64);
                count += 1;
                borders &= !1 << (first % 64);
            }
            if number_of_word == last / 64 {
                borders &= u64::MAX >> (63 - last % 64);
            }
            loop {
                let places = &mut self.borders[count..count + STRIDE];
                count += (borders.count_ones() as usize).min(STRIDE);
                for place in places {
                    *place = border_at(borders.trailing_zeros());
                    borders &= borders.wrapping_sub(1);
                }
                if borders == 0 {
                    break;
                }
            }
            if number_of_word >= last / 64 {
                break;
            }
            number_of_word += 1;
            both = words(pair, number_of_word);
        }
        self.borders[count] = ENDS | ray | last;
        self.count = count + 1;

        let [cos, sin] = block.ray(number).alpha.vector();
        let [cosines, sines] = &mut self.alpha;
        for (list, value) in [
            (cosines, cos),
            (sines, sin),
            (&mut self.surfaces, block.surface(number)),
            (&mut self.shares, pair.share),
        ] {
            let mut start = begin;
            while start <= count {
                list[start..start + STRIDE].fill(value);
                start += STRIDE;
            }
        }
    }

    /// Computes the distances and the visibilities of all borders.
    #[inline(always)]
    fn measure(&mut self, lattice: &Lattice, phi: &[[f32; 2]]) {
        let count = self.count;
        let borders = &self.borders[..count];
        let pairs = &mut self.pairs[..count];
        for (border, pair) in borders.iter().zip(&mut *pairs) {
            *pair = phi[(border & BIT) as usize];
        }
        let [cos, sin] = &self.alpha;
        let (cos, sin) = (&cos[..count], &sin[..count]);
        let (surfaces, shares) = (&self.surfaces[..count], &self.shares[..count]);
        let distances = &mut self.distances[..count];
        let visibilities = &mut self.visibilities[..count];
        for i in 0..count {
            let alpha = Angle::of([cos[i], sin[i]]);
            let along = lattice.space().distance_at(alpha, Phi::of(pairs[i]));
            let inside = borders[i] & ENDS == 0;
            distances[i] = if inside {
                along.min(surfaces[i])
            } else {
                surfaces[i]
            };
            let [first, second] = [0, 1].map(|texel| (borders[i] >> (LIT_SHIFT + texel)) & 1);
            visibilities[i] = blend(first, second, shares[i]);
        }
    }

    /// Keeps the runs that are lit.
    #[inline(always)]
    fn keep_lit(&mut self) {
        let lit = &mut self.lit[..self.count];
        let mut kept = 0;
        // Where the run before a border begins, and its visibility.
        let (mut start, mut visibility) = (0.0_f32, 0.0_f32);
        let values = self.distances.iter().zip(&self.visibilities);
        for (border, (distance, next)) in self.borders[..lit.len()].iter().zip(values) {
            // Borders that all but coincide may be rounded past each other; one between two
            // dark runs is none of a lit one.
            let bounds_light = visibility.max(*next) > 0.0;
            let reached = if bounds_light {
                distance.max(start)
            } else {
                start
            };
            let end = if border & BEGINS == 0 { reached } else { 0.0 };
            lit[kept] = LitInterval {
                start,
                end,
                visibility,
            };
            // A ray on the axis of a sun never comes to its second voxel; `f32::MAX` may stand
            // for the distance of the sky.
            kept += usize::from((visibility > 0.0) & (start < f32::MAX));
            self.ends[ray_of(*border)] = kept;
            (start, visibility) = (end, *next);
        }
    }
}

/// The words of this number of both texels.
#[inline(always)]
fn words(pair: &Pair<'_>, number: u32) -> [Word; 2] {
    [pair.first, pair.second].map(|texel| Word::new(texel, number as usize))
}

/// 64 bits of a texel, fewer at its end.
#[derive(Debug, Clone, Copy, Default)]
struct Word {
    bits: u64,
    /// The bit before them, or the first one of the texel again.
    before: u64,
}

impl Word {
    #[inline(always)]
    fn new(texel: &[u32], number: usize) -> Self {
        let at = |word: usize| texel.get(word).map_or(0, |word| u64::from(*word));
        let bits = at(2 * number) | at(2 * number + 1) << 32;
        Self {
            bits,
            before: match number {
                0 => bits & 1,
                _ => at(2 * number - 1) >> 31,
            },
        }
    }

    /// The bits that differ from the bit before them.
    #[inline(always)]
    fn changes(&self) -> u64 {
        self.bits ^ (self.bits << 1 | self.before)
    }
}

#[cfg(test)]
mod tests {
    use epipolar::{Light, Resolution, Space, Spacing, ViewVolume};
    use glam::Vec3;
    use reference::random::Random;

    use super::*;
    use crate::{Grid, Sampling};

    /// All levels of instructions that this processor has.
    fn every_arch() -> Vec<Arch> {
        let mut all = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(Arch::V3));
            all.extend(pulp::x86::V4::try_new().map(Arch::V4));
        }
        all
    }

    /// Words without a change, with one, and with as many as there can be.
    fn word(random: &mut Random) -> u32 {
        let bits = random.bits() as u32;
        match random.bits() >> 61 {
            0 | 1 => 0,
            2 => u32::MAX,
            3 => 1 << (bits % 32),
            4 => u32::MAX << (bits % 32),
            5 => 0x5555_5555,
            _ => bits,
        }
    }

    /// Those of a picture, towards and away from the light, with and without a length.
    fn rays(lattice: &Lattice) -> Vec<[f32; 4]> {
        let mut rays = Vec::new();
        for i in 0..500_u16 {
            let [x, y] = [i % 25, i / 25].map(|k| 0.06 * f32::from(k) - 0.6);
            rays.push([x, y, -1.0, 0.002 * f32::from(i) * f32::from(i % 100)]);
        }
        let [axis, ..] = lattice.space().frame().map(Vec3::from);
        for direction in [axis, -axis, axis + 1e-3 * Vec3::X, Vec3::ZERO, Vec3::NAN] {
            for surface in [
                0.0,
                -0.0,
                1e-30,
                4.0,
                1e18,
                f32::MAX,
                f32::INFINITY,
                f32::NAN,
            ] {
                rays.push(direction.extend(surface).to_array());
            }
        }
        rays
    }

    #[test]
    fn parts_of_many_rays_have_the_bits_of_each_by_itself_with_all_instructions() {
        let lights = [
            Light::point([1.0, 2.0, -5.0]),
            Light::point([0.3, 1.6, 6.0]),
            Light::point([0.2001, 1.7, 0.4]),
            Light::directional([0.1, -1.0, 0.3]),
            Light::directional([0.0, 0.0, 1.0]),
        ];
        let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.6], 0.0, 30.0).unwrap();
        let mut random = Random::new(3);
        let mut most = 0;
        for light in lights {
            for bits in [32, 64, 96, 224, 1024] {
                let space = Space::new(light.as_ref().copied().unwrap(), [0.2, 1.7, 0.4]).unwrap();
                let voxels = Resolution::new(24, 20, bits).unwrap();
                let lattice = Lattice::new(space, &view, voxels, Spacing::Angle).unwrap();
                let words = (0..voxels.words()).map(|_| word(&mut random)).collect();
                let grid = Grid::from_words(voxels, words).unwrap();
                let rays = rays(&lattice);
                for (phi_bias, interpolate) in [
                    (0.0, true),
                    (0.0, false),
                    (-1.0, true),
                    (0.3, true),
                    (-40.7, false),
                ] {
                    let sampling = Sampling {
                        phi_bias,
                        interpolate,
                        ..Sampling::UNBIASED
                    };
                    let volume = ShadowVolume::new(&lattice, &grid, sampling).unwrap();
                    let alone =
                        |ray: &[f32; 4]| volume.ray_shadow([ray[0], ray[1], ray[2]], ray[3]);
                    let same = |found: &[LitInterval], expected: Vec<LitInterval>| {
                        let bits = |parts: &[LitInterval]| -> Vec<[u32; 3]> {
                            let of = |part: &LitInterval| {
                                [part.start, part.end, part.visibility].map(f32::to_bits)
                            };
                            parts.iter().map(of).collect()
                        };
                        assert_eq!(bits(found), bits(&expected));
                    };
                    for arch in every_arch() {
                        let mut number = 0;
                        volume.lit_parts_on::<false>(arch, &rays, |i, lit| {
                            assert_eq!(i, number);
                            number += 1;
                            most = most.max(lit.len());
                            same(lit, alone(&rays[i]).lit_runs().collect());
                        });
                        assert_eq!(number, rays.len());
                        if phi_bias == 0.0 {
                            volume.lit_parts_on::<true>(arch, &rays, |i, lit| {
                                same(lit, alone(&rays[i]).lit_voxels().collect());
                            });
                        }
                    }
                    volume.lit_voxels(&rays, |i, lit| {
                        same(lit, alone(&rays[i]).lit_voxels().collect());
                    });
                }
            }
        }
        assert!(most > 64, "{most}");
        let mut no_ray = 0;
        let voxels = Resolution::new(1, 1, 32).unwrap();
        let space = Space::new(Light::point([1.0, 2.0, -5.0]).unwrap(), [0.0; 3]).unwrap();
        let lattice = Lattice::new(space, &view, voxels, Spacing::Angle).unwrap();
        let grid = Grid::from_words(voxels, vec![0]).unwrap();
        let volume = ShadowVolume::new(&lattice, &grid, Sampling::UNBIASED).unwrap();
        volume.lit_intervals(&[], |_, _| no_ray += 1);
        assert_eq!(no_ray, 0);
    }
}
