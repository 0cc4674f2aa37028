//! Where the rays of single texels enter and leave solids.

use super::Mesh;
use super::triangle::Kind;
use crate::rule::Tile;

/// A surface under a texel.
#[derive(Debug, Clone, Copy)]
struct Hit {
    kind: Kind,
    depth: f64,
    /// The depth by which hits are put in order.
    rank: f64,
}

/// The centres of 8×8 texels: the first, and the way from one to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Centres {
    pub(crate) first: [i32; 2],
    pub(crate) step: i32,
}

/// Finds the ends of the first stretch inside of solids.
#[derive(Debug, Default)]
pub(crate) struct Texels {
    /// Which of the triangles cover anything, and what.
    covers: Vec<(u64, usize)>,
    /// The surfaces under one texel.
    hits: Vec<Hit>,
}

impl Texels {
    /// Writes the slices of 8×8 texels under the triangles of `list` of a mesh. `slice`
    /// turns a depth into a slice and must not fall; `none` stands for nothing.
    pub(crate) fn resolve(
        &mut self,
        mesh: &Mesh,
        list: &[u32],
        Centres { first, step }: Centres,
        slice: impl Fn(f64) -> u32,
        none: u32,
        tile: &mut Tile,
    ) {
        let (triangles, masks) = (&mesh.triangles, mesh.masks.as_ref());
        self.covers.clear();
        let numbers = list.iter().map(|&number| number as usize);
        self.covers.extend(
            numbers
                .map(|number| (triangles[number].coverage(first, step), number))
                .filter(|(covered, _)| *covered != 0),
        );
        for texel in 0..64 {
            let at = [
                first[0] + (texel & 7) * step,
                first[1] + (texel >> 3) * step,
            ];
            self.hits.clear();
            for &(covered, number) in &self.covers {
                if covered >> texel & 1 == 1 {
                    let triangle = &triangles[number];
                    if let Some(mask) = triangle.mask()
                        && masks.is_some_and(|masks| masks.is_hole(mask, at))
                    {
                        continue;
                    }
                    let depth = triangle.depth(at);
                    let nearer = match triangle.kind {
                        Kind::Front => triangle.touch(depth),
                        Kind::Back | Kind::Open => 0.0,
                    };
                    self.hits.push(Hit {
                        kind: triangle.kind,
                        depth,
                        rank: depth - nearer,
                    });
                }
            }
            let texel = texel as usize;
            (tile.enter[texel], tile.exit[texel]) = (none, none);
            if !self.hits.is_empty() {
                sort(&mut self.hits);
                let (enter, exit) = stretch(&self.hits);
                tile.enter[texel] = slice(enter);
                tile.exit[texel] = slice(exit).max(tile.enter[texel]);
            }
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
