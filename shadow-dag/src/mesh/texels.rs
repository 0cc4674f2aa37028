//! Where the rays of single texels enter and leave solids.

use super::triangle::{Kind, Triangle};
use crate::rule::Tile;

/// A surface under a texel.
#[derive(Debug, Clone, Copy)]
struct Hit {
    texel: u8,
    kind: Kind,
    depth: f64,
    /// The depth by which hits are put in order.
    rank: f64,
}

/// Finds the ends of the first stretch inside of solids.
#[derive(Debug)]
pub(crate) struct Texels {
    hits: Vec<Hit>,
    /// The same texel by texel, and where each begins.
    grouped: Vec<Hit>,
    starts: [usize; 65],
}

impl Default for Texels {
    fn default() -> Self {
        Self {
            hits: Vec::new(),
            grouped: Vec::new(),
            starts: [0; 65],
        }
    }
}

impl Texels {
    /// Writes the slices of the 8×8 texels whose centres begin at `first`, one
    /// each `step`. `slice` turns a depth into a slice and must not fall; `none`
    /// stands for nothing.
    pub(crate) fn resolve<'a>(
        &mut self,
        triangles: impl Iterator<Item = &'a Triangle>,
        first: [i32; 2],
        step: i32,
        slice: impl Fn(f64) -> u32,
        none: u32,
        tile: &mut Tile,
    ) {
        self.hits.clear();
        for triangle in triangles {
            let mut covered = triangle.coverage(first, step);
            while covered != 0 {
                let texel = covered.trailing_zeros();
                covered &= covered - 1;
                let (x, y) = (texel as i32 % 8, texel as i32 / 8);
                let depth = triangle.depth([first[0] + x * step, first[1] + y * step]);
                let nearer = match triangle.kind {
                    Kind::Front => triangle.touch(depth),
                    Kind::Back | Kind::Open => 0.0,
                };
                self.hits.push(Hit {
                    texel: texel as u8,
                    kind: triangle.kind,
                    depth,
                    rank: depth - nearer,
                });
            }
        }
        self.group();
        tile.enter.fill(none);
        tile.exit.fill(none);
        for texel in 0..64 {
            let hits = &mut self.grouped[self.starts[texel]..self.starts[texel + 1]];
            if hits.is_empty() {
                continue;
            }
            sort(hits);
            let (enter, exit) = stretch(hits);
            tile.enter[texel] = slice(enter);
            tile.exit[texel] = slice(exit).max(tile.enter[texel]);
        }
    }

    /// Puts the hits of each texel side by side.
    fn group(&mut self) {
        self.starts = [0; 65];
        for hit in &self.hits {
            self.starts[usize::from(hit.texel) + 1] += 1;
        }
        for texel in 0..64 {
            self.starts[texel + 1] += self.starts[texel];
        }
        let mut next = self.starts;
        self.grouped.clear();
        self.grouped.extend_from_slice(&self.hits);
        for hit in &self.hits {
            let place = &mut next[usize::from(hit.texel)];
            self.grouped[*place] = *hit;
            *place += 1;
        }
    }
}

/// More hits than this are left to the standard library.
const FEW: usize = 32;

/// Puts hits in order; at the same depth fronts come first and backs last, so
/// that it is one order whatever it was before.
fn sort(hits: &mut [Hit]) {
    let compare = |a: &Hit, b: &Hit| a.rank.total_cmp(&b.rank).then(a.kind.cmp(&b.kind));
    if hits.len() > FEW {
        hits.sort_unstable_by(compare);
        return;
    }
    for i in 1..hits.len() {
        let mut at = i;
        while at > 0 && compare(&hits[at - 1], &hits[at]).is_gt() {
            hits.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// The depths between which nothing is defined, given all hits of a ray in
/// order.
///
/// Solids are left as often as they are entered. A ray that leaves more often
/// began inside, where something was cut off by the near plane. A surface
/// that encloses nothing ends the freedom: behind it all is shadowed.
fn stretch(hits: &[Hit]) -> (f64, f64) {
    let sign = |hit: &Hit| match hit.kind {
        Kind::Front => 1,
        Kind::Back => -1,
        Kind::Open => 0,
    };
    let mut inside: i32 = -hits.iter().map(sign).sum::<i32>();
    let enter = if inside > 0 {
        f64::NEG_INFINITY
    } else {
        hits.iter()
            .fold(f64::INFINITY, |least, hit| least.min(hit.depth))
    };
    for hit in hits {
        inside += sign(hit);
        if inside <= 0 || hit.kind == Kind::Open {
            return (enter, hit.depth);
        }
    }
    (enter, f64::INFINITY)
}
