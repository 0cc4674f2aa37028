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
#[derive(Debug, Default)]
pub(crate) struct Texels {
    hits: Vec<Hit>,
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
        let order = |kind: Kind| match kind {
            Kind::Front => 0,
            Kind::Open => 1,
            Kind::Back => 2,
        };
        self.hits.sort_unstable_by(|a, b| {
            (a.texel.cmp(&b.texel))
                .then(a.rank.total_cmp(&b.rank))
                .then(order(a.kind).cmp(&order(b.kind)))
        });
        tile.enter.fill(none);
        tile.exit.fill(none);
        for hits in self.hits.chunk_by(|a, b| a.texel == b.texel) {
            let texel = usize::from(hits[0].texel);
            let (enter, exit) = stretch(hits);
            tile.enter[texel] = slice(enter);
            tile.exit[texel] = slice(exit).max(tile.enter[texel]);
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
