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

impl Centres {
    /// Of texel `8 y + x`.
    fn at(self, texel: u32) -> [i32; 2] {
        [
            self.first[0] + (texel & 7) as i32 * self.step,
            self.first[1] + (texel >> 3) as i32 * self.step,
        ]
    }
}

/// A number for each texel of a tile.
type Rows = [f64; 64];

/// The triangles that cover any of the texels, and which.
#[derive(Debug, Clone, Copy)]
struct Cover {
    texels: u64,
    number: usize,
}

/// A surface over a group of texels. Texels outside of the group have the numbers of its first
/// texel, so that comparisons over all 64 hold.
#[derive(Debug, Clone, Copy)]
struct Sheet {
    kind: Kind,
    depths: Rows,
    ranks: Rows,
}

/// Texels under the same triangles.
#[derive(Debug, Clone, Copy)]
struct Group {
    texels: u64,
    /// All bits are set for its texels, and none for others.
    lanes: [u64; 64],
}

impl Group {
    fn new(texels: u64) -> Self {
        Self {
            texels,
            lanes: std::array::from_fn(|texel| (texels >> texel & 1).wrapping_neg()),
        }
    }

    /// Rows with the numbers of `other` beside the group.
    fn choose(&self, own: &Rows, other: &Rows) -> Rows {
        std::array::from_fn(|i| {
            let lane = self.lanes[i];
            f64::from_bits(own[i].to_bits() & lane | other[i].to_bits() & !lane)
        })
    }

    /// The number of its first texel.
    fn first(&self) -> usize {
        self.texels.trailing_zeros() as usize
    }
}

/// Groups of fewer texels, and tiles with more triangles, are resolved texel by texel, because
/// computing all 64 texels together would cost more.
const FEWEST_TEXELS: u32 = 12;
const MOST_COVERS: usize = 16;

/// The numbers of the bits that are set.
fn bits(mut set: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lowest = set.trailing_zeros();
        set &= set.wrapping_sub(1);
        (lowest < u64::BITS).then_some(lowest)
    })
}

/// Finds the ends of the first stretch inside of solids.
#[derive(Debug, Default)]
pub(crate) struct Texels {
    covers: Vec<Cover>,
    groups: Vec<u64>,
    /// The surfaces over one group, and their order along its first ray.
    sheets: Vec<Sheet>,
    order: Vec<usize>,
    /// The surfaces under one texel.
    hits: Vec<Hit>,
}

impl Texels {
    /// Writes the slices of 8×8 texels under the triangles of `list` of a mesh. `slice`
    /// turns a depth into a slice and must not fall.
    pub(crate) fn resolve(
        &mut self,
        mesh: &Mesh,
        list: &[u32],
        centres: Centres,
        slice: impl Fn(f64) -> u32,
        tile: &mut Tile,
    ) {
        self.covers.clear();
        let mut covered = 0;
        for &number in list {
            let number = number as usize;
            let texels = mesh.triangles[number].coverage(centres.first, centres.step);
            if texels != 0 {
                self.covers.push(Cover { texels, number });
                covered |= texels;
            }
        }
        let mut ends = [[f64::INFINITY; 64]; 2];
        if self.covers.len() > MOST_COVERS {
            self.one_by_one(mesh, covered, centres, &mut ends);
        } else {
            self.group(covered);
            for i in 0..self.groups.len() {
                let texels = self.groups[i];
                let found = texels.count_ones() >= FEWEST_TEXELS
                    && self.together(mesh, &Group::new(texels), centres, &mut ends);
                if !found {
                    self.one_by_one(mesh, texels, centres, &mut ends);
                }
            }
        }
        let side = mesh.resolution.side();
        (tile.enter, tile.exit) = ([side; 64], [side; 64]);
        for texel in bits(covered).map(|texel| texel as usize) {
            tile.enter[texel] = slice(ends[0][texel]);
            tile.exit[texel] = slice(ends[1][texel]).max(tile.enter[texel]);
        }
    }

    /// Puts those texels together that are under the same triangles.
    fn group(&mut self, covered: u64) {
        self.groups.clear();
        self.groups.push(covered);
        for cover in &self.covers {
            for i in 0..self.groups.len() {
                let group = self.groups[i];
                let [under, beside] = [group & cover.texels, group & !cover.texels];
                if under != 0 && beside != 0 {
                    self.groups[i] = under;
                    self.groups.push(beside);
                }
            }
        }
    }

    /// Writes the ends of a group, if all of its rays leave solids through the
    /// same triangle, after the same others; says whether that is so.
    fn together(
        &mut self,
        mesh: &Mesh,
        group: &Group,
        Centres { first, step }: Centres,
        ends: &mut [Rows; 2],
    ) -> bool {
        let one = group.first();
        self.sheets.clear();
        let mut inside = 0;
        for cover in &self.covers {
            if cover.texels & group.texels == 0 {
                continue;
            }
            let triangle = &mesh.triangles[cover.number];
            if triangle.mask().is_some() {
                return false;
            }
            let depths = triangle.depth_rows(first, step);
            let depths = group.choose(&depths, &[depths[one]; 64]);
            let ranks = match triangle.kind {
                Kind::Front => depths.map(|depth| depth - triangle.touch(depth)),
                Kind::Back | Kind::Open => depths,
            };
            let kind = triangle.kind;
            inside -= sign(kind);
            self.sheets.push(Sheet {
                kind,
                depths,
                ranks,
            });
        }
        // The rays enter more often than they leave: the surface of some solid has a gap.
        if inside < 0 {
            return false;
        }
        let mut enter = [f64::NEG_INFINITY; 64];
        if inside == 0 {
            enter = [f64::INFINITY; 64];
            for sheet in &self.sheets {
                for (enter, &depth) in enter.iter_mut().zip(&sheet.depths) {
                    *enter = if depth < *enter { depth } else { *enter };
                }
            }
        }
        let sheets = &self.sheets;
        let before = |a: &Sheet, b: &Sheet| {
            a.ranks[one]
                .total_cmp(&b.ranks[one])
                .then(a.kind.cmp(&b.kind))
        };
        self.order.clear();
        self.order.extend(0..sheets.len());
        self.order
            .sort_unstable_by(|&a, &b| before(&sheets[a], &sheets[b]));
        let mut exit = &[f64::INFINITY; 64];
        for (at, &number) in self.order.iter().enumerate() {
            let sheet = &sheets[number];
            inside += sign(sheet.kind);
            if sheet.kind == Kind::Front {
                continue;
            }
            // The same surfaces are in front of it, and behind it, everywhere.
            let in_front = self.order[..at]
                .iter()
                .all(|&other| below(&sheets[other].ranks, &sheet.ranks));
            let behind = self.order[at + 1..]
                .iter()
                .all(|&other| below(&sheet.ranks, &sheets[other].ranks));
            if !in_front || !behind {
                return false;
            }
            if inside <= 0 || sheet.kind == Kind::Open {
                exit = &sheet.depths;
                break;
            }
        }
        *ends = [group.choose(&enter, &ends[0]), group.choose(exit, &ends[1])];
        true
    }

    /// Writes the ends of each of these texels.
    fn one_by_one(&mut self, mesh: &Mesh, texels: u64, centres: Centres, ends: &mut [Rows; 2]) {
        let (triangles, masks) = (&mesh.triangles, mesh.masks.as_ref());
        for texel in bits(texels) {
            let at = centres.at(texel);
            self.hits.clear();
            for cover in &self.covers {
                if cover.texels >> texel & 1 == 1 {
                    let triangle = &triangles[cover.number];
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
            if !self.hits.is_empty() {
                sort(&mut self.hits);
                let texel = texel as usize;
                (ends[0][texel], ends[1][texel]) = stretch(&self.hits);
            }
        }
    }
}

/// True if all of the first are less than those of the second.
fn below(a: &Rows, b: &Rows) -> bool {
    a.iter().zip(b).fold(true, |all, (a, b)| all & (a < b))
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

/// By how much a surface changes the number of solids that a ray is in.
fn sign(kind: Kind) -> i32 {
    match kind {
        Kind::Front => 1,
        Kind::Back => -1,
        Kind::Open => 0,
    }
}

/// The depths between which nothing is defined, given all hits of a ray in
/// order.
///
/// Solids are left as often as they are entered. A ray that leaves more often
/// began inside, where something was cut off by the near plane. A surface
/// that encloses nothing ends the freedom: behind it all is shadowed.
fn stretch(hits: &[Hit]) -> (f64, f64) {
    let mut inside: i32 = -hits.iter().map(|hit| sign(hit.kind)).sum::<i32>();
    let enter = if inside > 0 {
        f64::NEG_INFINITY
    } else {
        hits.iter()
            .fold(f64::INFINITY, |least, hit| least.min(hit.depth))
    };
    for hit in hits {
        inside += sign(hit.kind);
        if inside <= 0 || hit.kind == Kind::Open {
            return (enter, hit.depth);
        }
    }
    (enter, f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::ONE;
    use crate::mesh::footprint::slice;
    use crate::tests::mesh::{Soup, lights, solid};
    use crate::{DepthSource, TileRect};

    proptest! {
        #![proptest_config(reference::property::cases(128))]

        #[test]
        fn texels_together_are_what_they_are_one_by_one(
            solids in proptest::collection::vec(solid(), 1..8),
            light in proptest::sample::select(lights().to_vec()),
        ) {
            let mesh = Soup::of(&solids).mesh(64, light);
            let list: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
            let step = ONE / 64;
            let mut texels = Texels::default();
            for tile in 0..64 {
                let first = [tile % 8, tile / 8].map(|at| 8 * at * step + step / 2);
                let centres = Centres { first, step };
                let slice = |depth: f64| (1e6 * depth.clamp(-1.0, 1.0) + 1e6) as u32;
                let mut together = Tile::default();
                texels.resolve(&mesh, &list, centres, slice, &mut together);
                let covered = texels.covers.iter().fold(0, |all, cover| all | cover.texels);
                let mut ends = [[f64::INFINITY; 64]; 2];
                texels.one_by_one(&mesh, covered, centres, &mut ends);
                for texel in bits(covered).map(|texel| texel as usize) {
                    let [enter, exit] = ends.map(|ends| slice(ends[texel]));
                    let found = (together.enter[texel], together.exit[texel]);
                    prop_assert_eq!(found, (enter, exit.max(enter)), "{}, {}", tile, texel);
                }
            }
        }

        #[test]
        fn what_footprints_leave_out_is_nowhere_in_front(
            solids in proptest::collection::vec(solid(), 1..12),
            removed in proptest::collection::vec(any::<prop::sample::Index>(), 0..60),
            light in proptest::sample::select(lights().to_vec()),
        ) {
            let mut soup = Soup::of(&solids);
            for triangle in removed {
                if soup.indices.len() > 1 {
                    soup.indices.swap_remove(triangle.index(soup.indices.len()));
                }
            }
            let mesh = soup.mesh(64, light);
            let mut dag = [vec![0; 64 * 64], vec![0; 64 * 64]];
            let [enter, exit] = &mut dag;
            let whole = TileRect { x: 0, y: 0, side: 64 };
            mesh.read(whole, enter, exit).unwrap();
            let list: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
            let step = ONE / 64;
            let mut texels = Texels::default();
            for tile in 0..64 {
                let place = [tile % 8, tile / 8].map(|at| 8 * at);
                let first = place.map(|at| at * step + step / 2);
                let mut all = Tile::default();
                let slice = |depth: f64| slice(&mesh.light, mesh.resolution, depth);
                texels.resolve(&mesh, &list, Centres { first, step }, slice, &mut all);
                for texel in 0..64 {
                    let [x, y] = [place[0] as usize + texel % 8, place[1] as usize + texel / 8];
                    let found = dag.each_ref().map(|map| map[64 * y + x]);
                    prop_assert_eq!(found, [all.enter[texel], all.exit[texel]], "{}, {}", x, y);
                }
            }
        }
    }
}
