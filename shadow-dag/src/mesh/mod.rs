//! Triangles as shadow casters.
//!
//! Vertices are snapped to a grid that does not depend on the resolution, so
//! that the side of an edge on which a texel lies is decided exactly, the same
//! way for all triangles that share it, and at every resolution.

mod clip;
mod closed;
mod cull;
mod footprint;
mod holes;
mod sorted;
mod surfaces;
mod texels;
mod triangle;
mod twins;
mod weld;

use gpu_backend::Cpu;

use crate::depths::{DepthSource, Exits, TileRect};
use crate::footprint::{Content, Footprints};
use crate::identity::Identity;
use crate::rule::Tile;
use crate::tiles::Plan;
use crate::{Error, LightSpace, Resolution};
use footprint::Part;
pub(crate) use footprint::Scratch;
pub use holes::Holes;
use holes::Masks;
use sorted::{PARTS, Parts, runs};
pub use surfaces::Surfaces;
#[cfg(all(feature = "wgpu", not(target_family = "wasm")))]
pub(crate) use triangle::Kind;
pub(crate) use triangle::ONE;
pub(crate) use triangle::Triangle;

/// Bins along each side of the map.
pub(crate) const BINS: u32 = 64;

/// Triangles as a light sees them.
#[derive(Debug, Clone)]
pub struct Mesh {
    resolution: Resolution,
    pub(crate) light: LightSpace,
    pub(crate) triangles: Vec<Triangle>,
    /// Numbers of the triangles over each bin, row by row.
    pub(crate) bins: Vec<Vec<u32>>,
    /// Of triangles with holes, if there are any.
    masks: Option<Masks>,
    watertightness: Watertightness,
    /// Of what it was made of.
    identity: Identity,
}

/// How much of a mesh encloses something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Watertightness {
    /// Parts that hang together by the positions of their vertices.
    pub parts: usize,
    /// Parts with holes: what is behind their surface is shadowed at once,
    /// and compresses less.
    pub open_parts: usize,
    /// Parts that are turned inside out as a whole, or cavities of others;
    /// treated like those with holes.
    pub inverted_parts: usize,
    /// Edges that do not have as many triangles on one side as on the other.
    pub open_edges: usize,
}

impl Watertightness {
    /// True if every part encloses something.
    pub fn is_closed(&self) -> bool {
        self.open_parts == 0 && self.inverted_parts == 0
    }
}

impl Mesh {
    /// [`Surfaces::new`], [seen from](Surfaces::seen_from) `light`.
    ///
    /// # Errors
    /// Those of [`Surfaces::new`].
    pub fn new(
        resolution: Resolution,
        light: LightSpace,
        positions: &[[f32; 3]],
        indices: &[[u32; 3]],
    ) -> Result<Self, Error> {
        Surfaces::new(positions, indices).map(|surfaces| surfaces.seen_from(light, resolution))
    }

    pub(crate) fn of(
        cpu: &Cpu,
        surfaces: &Surfaces<'_>,
        light: LightSpace,
        resolution: Resolution,
    ) -> Self {
        let corners = surfaces.corners(&light);
        let seen = surfaces.extents.seen(cpu, &light, &corners);
        Self::of_these(cpu, surfaces, &seen, light, resolution)
    }

    /// Of the triangles with these numbers, in order.
    pub(crate) fn of_these(
        cpu: &Cpu,
        surfaces: &Surfaces<'_>,
        seen: &[u32],
        light: LightSpace,
        resolution: Resolution,
    ) -> Self {
        let corners = surfaces.corners(&light);
        let holed: Vec<u32> = match &surfaces.holes {
            Some((has_holes, _)) => (seen.iter().copied())
                .filter(|&triangle| has_holes[triangle as usize])
                .collect(),
            None => Vec::new(),
        };
        let setup = triangle::Setup::new(&light);
        let cover = |number: u32, triangle: Triangle| match holed.binary_search(&number) {
            Ok(mask) => triangle.covered(mask as u32),
            Err(_) => triangle,
        };
        let closed = |number: u32| surfaces.closed[number as usize];
        let whole = cpu.map(seen.len(), |at| {
            let number = seen[at];
            let triangle = setup.whole(corners(number as usize), closed(number));
            triangle.map(|triangle| cover(number, triangle))
        });
        // The others come last. Their order makes no difference to anything.
        let mut others = Vec::new();
        let mut triangles: Vec<Triangle> = (whole.into_iter().zip(seen))
            .filter_map(|(triangle, &number)| {
                if triangle.is_none() {
                    others.push(number);
                }
                triangle
            })
            .collect();
        let parts = runs(cpu, others.len(), |run| {
            let mut parts = Vec::new();
            for &number in &others[run] {
                let clipped = setup.clipped(corners(number as usize), closed(number));
                parts.extend(clipped.map(|triangle| cover(number, triangle)));
            }
            parts
        });
        triangles.extend(parts.into_iter().flatten());
        twins::leave_out(cpu, &mut triangles);
        let masks = surfaces.holes.as_ref().map(|(_, holes)| {
            Masks::new(cpu, holes.clone(), &holed, |triangle| {
                corners(triangle as usize)
            })
        });
        Self {
            resolution,
            light,
            bins: bins(cpu, &triangles),
            triangles,
            masks,
            watertightness: surfaces.watertightness(),
            identity: Identity::of_light(&light).with(surfaces.identity().value()),
        }
    }

    /// True if light passes through holes of some triangles.
    pub fn has_holes(&self) -> bool {
        self.masks.is_some()
    }

    /// The same mesh and light for a grid of another resolution.
    #[must_use]
    pub fn with_resolution(self, resolution: Resolution) -> Self {
        Self { resolution, ..self }
    }

    /// How much of the mesh encloses something.
    pub fn watertightness(&self) -> Watertightness {
        self.watertightness
    }

    /// What tells it from other meshes, at any resolution.
    pub(crate) fn identity(&self) -> Identity {
        self.identity
    }

    /// The identity of the triangles over each tile of a plan. Two meshes have the same one only
    /// if they have the same columns there. If triangles have holes it is that of the whole
    /// scene.
    pub(crate) fn over_tiles(&self, plan: &Plan) -> Vec<Identity> {
        let light = Identity::of_light(&self.light);
        let mut list = Vec::new();
        let mut identity = |tile: usize| {
            let (x, y) = (tile as u32 % plan.width(), tile as u32 / plan.width());
            self.over(plan.tile(x, y), &mut list);
            // Sums do not depend on the order.
            let sum = list.iter().fold(0_u64, |sum, &number| {
                let triangle = &self.triangles[number as usize];
                let of_holes = triangle.mask().map_or(0, |_| self.identity.value());
                sum.wrapping_add(triangle.identity().with(of_holes).value())
            });
            light.with(list.len() as u64).with(sum)
        };
        (0..plan.tiles()).map(&mut identity).collect()
    }

    /// The triangles over a square of the map, each once.
    fn over(&self, tile: TileRect, list: &mut Vec<u32>) {
        // Of small maps a texel has several bins.
        let (bins, side) = (u64::from(BINS), u64::from(self.resolution.side()));
        let first = [tile.x, tile.y].map(|texel| (u64::from(texel) * bins / side) as u32);
        let last = [tile.x, tile.y]
            .map(|texel| (u64::from(texel + tile.side) * bins).div_ceil(side) as u32 - 1);
        list.clear();
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                list.extend(&self.bins[(y * BINS + x) as usize]);
            }
        }
        if first != last {
            list.sort_unstable();
            list.dedup();
        }
    }
}

/// Numbers of the triangles over each bin, row by row.
fn bins(cpu: &Cpu, triangles: &[Triangle]) -> Vec<Vec<u32>> {
    // One part for each row of bins.
    const { assert!(BINS as usize <= PARTS) };
    let size = ONE / BINS as i32;
    let rows = Parts::new(
        cpu,
        triangles.len(),
        |number, rows: &mut [Vec<[u32; 2]>]| {
            let triangle = &triangles[number];
            let cell = |at: i32| (at.clamp(0, ONE - 1) / size) as u32;
            let [low, high] = triangle.bounds();
            if high[0] < 0 || high[1] < 0 || low[0] >= ONE || low[1] >= ONE {
                return;
            }
            let [first, last] = [low, high].map(|corner| corner.map(cell));
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let [left, top] = [x, y].map(|at| at as i32 * size);
                    // One that is within a bin meets it.
                    if first == last || triangle.meets([left, top], [left + size, top + size]) {
                        rows[y as usize].push([x, number as u32]);
                    }
                }
            }
        },
    );
    let rows = cpu.map(BINS as usize, |row| {
        let mut bins = vec![Vec::new(); BINS as usize];
        for &[x, number] in rows.part(row) {
            bins[x as usize].push(number);
        }
        bins
    });
    rows.into_iter().flatten().collect()
}

impl DepthSource for Mesh {
    fn resolution(&self) -> Resolution {
        self.resolution
    }

    fn light(&self) -> Option<LightSpace> {
        Some(self.light)
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        tile.check_places(self.resolution, [enter, exit])?;
        let mut scratch = Scratch::new(self, false);
        let part = scratch.start(tile);
        let level = tile.side.trailing_zeros() as usize - 3;
        let mut write = |at: [u32; 2], texels: &Tile| {
            for row in 0..8 {
                let to = ((at[1] - tile.y) as usize + row) * tile.side as usize
                    + (at[0] - tile.x) as usize;
                enter[to..to + 8].copy_from_slice(&texels.enter[8 * row..][..8]);
                exit[to..to + 8].copy_from_slice(&texels.exit[8 * row..][..8]);
            }
        };
        fill(
            &mut scratch,
            level,
            part,
            self.resolution.side(),
            &mut write,
        );
        Ok(Exits::Closed)
    }
}

/// Writes all 8×8 tiles of a footprint.
fn fill(
    scratch: &mut Scratch<'_>,
    level: usize,
    part: Part,
    side: u32,
    write: &mut impl FnMut([u32; 2], &Tile),
) {
    let mut texels = Tile::default();
    match scratch.content(level, part, &mut texels) {
        Content::Texels => write(part.origin(level), &texels),
        Content::Quarters(quarters) => {
            for quarter in quarters {
                fill(scratch, level - 1, quarter, side, write);
            }
            scratch.leave(part);
        }
        Content::Uniform(interval) | Content::Flat(interval) => {
            texels.enter.fill(interval.enter.min(side));
            texels.exit.fill(interval.exit.min(side));
            let [x, y] = part.origin(level);
            for row in 0..1 << level {
                for column in 0..1 << level {
                    write([x + 8 * column, y + 8 * row], &texels);
                }
            }
        }
    }
}
