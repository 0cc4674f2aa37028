//! Filled holes against what must hold of them.

use gpu_backend::{Cpu, Host};

use super::atlas::Layout;
use super::holes::sides;
use super::{EMPTY, FillHoles, ShadowMapAtlas};

/// Pictures without lights: depths are all that filling looks at.
fn maps(resolution: u32, depth: Vec<f32>) -> ShadowMapAtlas<Host> {
    ShadowMapAtlas::from_depth(Layout::default(), resolution, depth)
}

fn filled(resolution: u32, depth: &[f32], levels: u32) -> Vec<f32> {
    let mut maps = maps(resolution, depth.to_vec());
    let cpu = Cpu::new();
    cpu.fill_holes(&mut maps, levels).unwrap();
    maps.depth().clone()
}

/// Numbers in [0, 1) without a pattern.
pub(crate) fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed.wrapping_mul(0x9E37_79B9) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 8) as f32 / (1_u32 << 24) as f32
    }
}

/// Two layers of surfaces at several distances, of which that share is empty.
pub(crate) fn holey(resolution: u32, pictures: u32, share: f32, seed: u32) -> Vec<f32> {
    let mut next = noise(seed);
    let texels = pictures * resolution * resolution;
    let texel = |i: u32| {
        let near = (i / resolution / 5 + i % resolution / 7).is_multiple_of(2);
        let depth = if near { 1.5 } else { 4.0 } + next();
        if next() < share { EMPTY } else { depth }
    };
    (0..texels).map(texel).collect()
}

#[test]
fn texels_that_have_a_depth_keep_it_and_without_holes_nothing_changes() {
    for resolution in [1, 2, 3, 5, 37, 64] {
        for levels in [0, 1, 3, 20, u32::MAX] {
            let depth = holey(resolution, 2, 0.4, resolution);
            let after = filled(resolution, &depth, levels);
            for (before, after) in depth.iter().zip(&after) {
                assert!(*before == EMPTY || before.to_bits() == after.to_bits());
            }
            let whole = holey(resolution, 2, 0.0, 7);
            assert_eq!(filled(resolution, &whole, levels), whole);
            let empty = vec![EMPTY; depth.len()];
            assert_eq!(filled(resolution, &empty, levels), empty);
        }
    }
    assert!(filled(8, &[], 3).is_empty());
}

#[test]
fn no_picture_sees_another() {
    let resolution = 21;
    let texels = (resolution * resolution) as usize;
    let depth = holey(resolution, 3, 0.6, 3);
    let together = filled(resolution, &depth, 4);
    for (picture, found) in depth.chunks(texels).zip(together.chunks(texels)) {
        assert_eq!(filled(resolution, picture, 4), found);
    }
    // Between two full pictures an empty one stays so.
    let mut depth = vec![2.0; 3 * texels];
    depth[texels..2 * texels].fill(EMPTY);
    assert_eq!(filled(resolution, &depth, 9), depth);
}

/// Texels of 2 × 2 with one hole at most are filled by the first level.
#[test]
fn a_plane_is_continued_into_its_holes() {
    let resolution = 64;
    let plane = |column: u32, row: u32| 3.0 + 0.01 * column as f32 + 0.02 * row as f32;
    let mut depth: Vec<f32> = (0..resolution * resolution)
        .map(|i| plane(i % resolution, i / resolution))
        .collect();
    let mut next = noise(5);
    let mut holes = Vec::new();
    for row in 0..resolution / 2 {
        for column in 0..resolution / 2 {
            let pick = (8.0 * next()) as u32;
            if pick < 4 {
                let at = (2 * column + pick % 2, 2 * row + pick / 2);
                depth[(at.1 * resolution + at.0) as usize] = EMPTY;
                holes.push(at);
            }
        }
    }
    let after = filled(resolution, &depth, 1);
    // A mean of three texels is off by half a texel's slope, and so may all be that
    // are interpolated; at a border there is nothing to interpolate with.
    for (column, row) in holes {
        let found = after[(row * resolution + column) as usize];
        let off = (found - plane(column, row)).abs();
        assert!(off <= 0.03, "({column}, {row}): off by {off}");
    }
}

#[test]
fn what_is_filled_has_the_depth_of_one_of_two_surfaces_and_not_one_between() {
    for share in [0.1, 0.5, 0.9] {
        let depth = holey(64, 1, share, 11);
        // The surfaces are farther apart than what is averaged: 1.6 times.
        for depth in filled(64, &depth, 3) {
            let near = (1.5..=2.5).contains(&depth);
            let far = (4.0..=5.0).contains(&depth);
            assert!(near || far || depth == EMPTY, "{depth}");
        }
    }
}

/// A square hole of 2^(k + 1) texels in the middle, where four squares of 2^k of every level
/// up to k meet: each is empty, and one in four of a square of the next level.
#[test]
fn levels_bound_the_size_of_holes_that_are_filled() {
    let resolution = 64;
    for k in 0..4 {
        let half = 1 << k;
        let inside = |at: i32| (32 - half..32 + half).contains(&at);
        let depth: Vec<f32> = (0..resolution * resolution)
            .map(|i| match inside(i % resolution) && inside(i / resolution) {
                true => EMPTY,
                false => 2.0,
            })
            .collect();
        assert_eq!(filled(resolution as u32, &depth, k as u32), depth, "{k}");
        let after = filled(resolution as u32, &depth, k as u32 + 1);
        assert!(after.iter().all(|depth| *depth == 2.0), "{k}");
    }
}

#[test]
fn a_pyramid_ends_with_one_texel() {
    assert_eq!(sides(128, 3), [128, 64, 32, 16]);
    assert_eq!(sides(5, 99), [5, 3, 2, 1]);
    assert_eq!(sides(1, 9), [1]);
    assert_eq!(sides(64, 0), [64]);
}
