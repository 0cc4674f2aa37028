//! Triangles as shadow casters.
//!
//! Vertices are snapped to a grid that does not depend on the resolution, so
//! that the side of an edge on which a texel lies is decided exactly, the same
//! way for all triangles that share it, and at every resolution.

mod clip;
mod closed;
mod footprint;
mod holes;
mod surfaces;
mod texels;
mod triangle;

use glam::Vec3;

use crate::depths::{DepthSource, Exits, TileRect};
use crate::footprint::{Content, Footprints};
use crate::identity::Identity;
use crate::rule::Tile;
use crate::{Error, LightSpace, Resolution};
use footprint::Part;
pub(crate) use footprint::Scratch;
pub use holes::Holes;
use holes::Masks;
pub use surfaces::Surfaces;
#[cfg(feature = "wgpu")]
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
    bins: Vec<Vec<u32>>,
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

    fn of(surfaces: &Surfaces<'_>, light: LightSpace, resolution: Resolution) -> Self {
        let positions: &[Vec3] = bytemuck::cast_slice(&surfaces.positions);
        let points: Vec<_> = (positions.iter())
            .map(|position| light.homogeneous(position.as_dvec3().extend(1.0)))
            .collect();
        let setup = triangle::Setup::new(&light);
        let mut triangles = Vec::with_capacity(surfaces.indices.len());
        let holes = surfaces.holes.as_ref();
        let mut masks = holes.map(|(_, holes)| Masks::new(holes.clone()));
        for (index, corners) in surfaces.indices.iter().enumerate() {
            let corners = corners.map(|corner| points[corner as usize]);
            let before = triangles.len();
            setup.triangles(corners, surfaces.closed[index], &mut triangles);
            if let Some((has_holes, _)) = holes
                && let Some(masks) = &mut masks
                && has_holes[index]
            {
                let mask = masks.push(index as u32, corners);
                for part in &mut triangles[before..] {
                    part.cover(mask);
                }
            }
        }
        let mut bins = vec![Vec::new(); (BINS * BINS) as usize];
        for (number, triangle) in (0..).zip(&triangles) {
            let cell = |at: i32| (at.clamp(0, ONE - 1) / (ONE / BINS as i32)) as u32;
            let [low, high] = triangle.bounds();
            let hits = high[0] >= 0 && high[1] >= 0 && low[0] < ONE && low[1] < ONE;
            for y in cell(low[1])..=cell(high[1]) {
                for x in cell(low[0])..=cell(high[0]) {
                    let bin = |x: u32| x as i32 * (ONE / BINS as i32);
                    let size = ONE / BINS as i32;
                    if hits && triangle.meets([bin(x), bin(y)], [bin(x) + size, bin(y) + size]) {
                        bins[(y * BINS + x) as usize].push(number);
                    }
                }
            }
        }
        let mut identity = Identity::of_triangles(&light, positions, &surfaces.indices);
        if let Some((has_holes, holes)) = holes {
            for &has_holes in has_holes {
                identity = identity.with(u64::from(has_holes));
            }
            holes.describe(&mut |word| identity = identity.with(word));
        }
        Self {
            resolution,
            light,
            triangles,
            bins,
            masks,
            watertightness: surfaces.watertightness(),
            identity,
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
