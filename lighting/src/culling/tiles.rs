//! The rays of a picture, sorted by tiles.

use glam::{DVec3, Vec3};
use gpu_backend::Cpu;

use super::reach::{Bundle, Reach};
use crate::{Emitter, Ray};

/// Pixels along each side of a tile, and tiles along each side of a block.
const SIDE: u32 = 4;

/// Number of levels of tiles and blocks. Blocks of the largest level are 256 pixels wide.
pub(super) const LEVELS: usize = 4;

/// Number of bits that give the place of a tile in its block.
const PLACE: u32 = 2 * SIDE.ilog2();

/// A number by which tiles are sorted: that of the largest block, followed by the place within
/// each smaller block.
fn place_of([x, y]: [u32; 2]) -> u64 {
    let largest = SIDE.pow(LEVELS as u32);
    let mut place = (u64::from(y / largest) << 24) | u64::from(x / largest);
    for level in (1..LEVELS as u32).rev() {
        let [column, row] = [x, y].map(|i| u64::from(i / SIDE.pow(level) % SIDE));
        place = (place << PLACE) | (row * u64::from(SIDE) + column);
    }
    place
}

/// The rays of a picture, in tiles and blocks of tiles.
#[derive(Debug, Clone)]
pub struct RayTiles {
    eye: DVec3,
    /// Indices of the rays, sorted by their place in the largest block, then in each smaller
    /// one.
    order: Vec<u32>,
    lengths: Vec<f32>,
    directions: Vec<Vec3>,
    /// The tile of each ray.
    tile_of: Vec<u32>,
    /// Blocks and tiles, the largest blocks first.
    levels: [Vec<Tile>; LEVELS],
}

/// Consecutive rays in one tile.
struct Run {
    place: u64,
    first: u32,
    end: u32,
}

/// A tile, or a block of tiles.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    pub(super) bundle: Bundle,
    /// Index of the first of its tiles on the next level, or of the first of its rays in
    /// `order`.
    pub(super) first: usize,
    pub(super) end: usize,
}

impl RayTiles {
    /// Sorts the rays of a picture that is `width` pixels wide. `pixels` gives the pixel of
    /// each ray, counted row by row, unless the rays are those of all pixels. Pixels below the
    /// picture are allowed.
    ///
    /// `None` if the rays do not all start at one eye, if there are none, or if there are not
    /// as many `pixels` as rays.
    pub fn new(cpu: &Cpu, rays: &[Ray], width: u32, pixels: Option<&[u32]>) -> Option<Self> {
        let eye = rays.first()?.origin();
        let is_sound = rays.iter().all(|ray| ray.origin() == eye)
            && pixels.is_none_or(|pixels| pixels.len() == rays.len());
        if !is_sound {
            return None;
        }
        let width = width.max(1);
        let place = |ray: usize| {
            let pixel = pixels.map_or(ray as u32, |pixels| pixels[ray]);
            place_of([pixel % width, pixel / width])
        };
        // Memory holds no more rays than a u32 counts.
        let places: Vec<u64> = cpu.map(rays.len(), place);
        let mut runs: Vec<Run> = Vec::with_capacity(rays.len() / SIDE as usize);
        for of_one in places.chunk_by(|a, b| a == b) {
            let first = runs.last().map_or(0, |run| run.end);
            let end = first + of_one.len() as u32;
            let place = of_one[0];
            runs.push(Run { place, first, end });
        }
        runs.sort_unstable_by_key(|run| (run.place, run.first));
        let order: Vec<u32> = runs.iter().flat_map(|run| run.first..run.end).collect();
        let of_rays = |ray: u32| &rays[ray as usize];
        let lengths = cpu.map(order.len(), |i| of_rays(order[i]).length());
        let directions = cpu.map(order.len(), |i| of_rays(order[i]).direction());
        let levels = Self::levels(cpu, &runs, &directions, &lengths);
        let mut tile_of = vec![0; rays.len()];
        for (number, tile) in (0..).zip(&levels[LEVELS - 1]) {
            for ray in &order[tile.first..tile.end] {
                tile_of[*ray as usize] = number;
            }
        }
        Some(Self {
            eye: eye.as_dvec3(),
            order,
            lengths,
            directions,
            tile_of,
            levels,
        })
    }

    /// The tiles, and the blocks around them on each level.
    fn levels(
        cpu: &Cpu,
        runs: &[Run],
        directions: &[Vec3],
        lengths: &[f32],
    ) -> [Vec<Tile>; LEVELS] {
        // The place of each tile on a level, and its range of rays or of tiles on the next
        // level.
        let mut places: Vec<u64> = Vec::new();
        let mut inside: Vec<[usize; 2]> = Vec::new();
        let mut end = 0;
        for tile in runs.chunk_by(|a, b| a.place == b.place) {
            let rays: u32 = tile.iter().map(|run| run.end - run.first).sum();
            let first = end;
            end += rays as usize;
            places.push(tile[0].place);
            inside.push([first, end]);
        }
        let mut levels: [Vec<Tile>; LEVELS] = Default::default();
        levels[LEVELS - 1] = cpu.map(inside.len(), |tile| {
            let [first, end] = inside[tile];
            let ways = directions[first..end].iter().zip(&lengths[first..end]);
            let bundle = Bundle::new(ways.map(|(direction, length)| (*direction, *length)));
            Tile { bundle, first, end }
        });
        for level in (0..LEVELS - 1).rev() {
            let (mut outer, mut blocks) = (Vec::new(), Vec::new());
            let mut end = 0;
            for block in places.chunk_by(|a, b| a >> PLACE == b >> PLACE) {
                let first = end;
                end += block.len();
                outer.push(block[0] >> PLACE);
                let bundle = Bundle::around(levels[level + 1][first..end].iter());
                blocks.push(Tile { bundle, first, end });
            }
            levels[level] = blocks;
            places = outer;
        }
        levels
    }

    /// Number of rays.
    pub fn rays(&self) -> usize {
        self.order.len()
    }

    /// Number of tiles. A tile has at most 16 rays, unless pixels occur more than once.
    pub fn tiles(&self) -> usize {
        self.levels[LEVELS - 1].len()
    }

    /// Indices of the rays of a tile; none if there is no such tile.
    pub fn rays_of(&self, tile: usize) -> &[u32] {
        let tile = self.levels[LEVELS - 1].get(tile);
        tile.map_or(&[], |tile| &self.order[tile.first..tile.end])
    }

    /// The tile that a ray is in; `None` if there is no such ray.
    pub fn tile_of(&self, ray: usize) -> Option<usize> {
        self.tile_of.get(ray).map(|tile| *tile as usize)
    }

    /// Indices of all rays, tile by tile. Rays that are next to each other in this list are
    /// neighbours in the picture.
    #[cfg(feature = "methods")]
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// The common origin of all rays.
    pub(super) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Directions and lengths of the rays of a tile, in the order of [`RayTiles::rays_of`].
    pub(super) fn ways_of(&self, tile: usize) -> impl Iterator<Item = (Vec3, f32)> {
        let tile = self.levels[LEVELS - 1].get(tile);
        let range = tile.map_or(0..0, |tile| tile.first..tile.end);
        let directions = self.directions[range.clone()].iter().copied();
        directions.zip(self.lengths[range].iter().copied())
    }

    /// The blocks of a level, or the tiles, which are the last level; the largest blocks are
    /// level 0.
    pub(super) fn level(&self, level: usize) -> &[Tile] {
        &self.levels[level]
    }

    /// Indices of the rays that a light may reach, tile by tile; `None` for a light without
    /// bounds, which may reach all of them.
    pub fn reached(&self, emitter: &Emitter) -> Option<Vec<u32>> {
        let reach = Reach::new(emitter, self.eye)?;
        let mut rays = Vec::new();
        self.add(&reach, 0, 0..self.levels[0].len(), &mut rays);
        Some(rays)
    }

    /// Appends the rays that the light may reach in some blocks or tiles of a level.
    fn add(&self, reach: &Reach, level: usize, tiles: std::ops::Range<usize>, rays: &mut Vec<u32>) {
        for tile in &self.levels[level][tiles] {
            let Some([start, _]) = reach.part(&tile.bundle) else {
                continue;
            };
            let Tile { first, end, .. } = *tile;
            if level + 1 < LEVELS {
                self.add(reach, level + 1, first..end, rays);
                continue;
            }
            let own = self.order[first..end].iter().zip(&self.lengths[first..end]);
            let far_enough = own.filter(|(_, length)| f64::from(**length) >= start);
            rays.extend(far_enough.map(|(ray, _)| ray));
        }
    }
}

impl Bundle {
    /// The cone around some rays from one eye, given by their directions and lengths.
    pub(super) fn new(rays: impl Iterator<Item = (Vec3, f32)> + Clone) -> Self {
        let directions = rays
            .clone()
            .map(|(direction, _)| direction.as_dvec3().normalize());
        let sum: DVec3 = directions.clone().sum();
        // If the directions cancel out there is no axis, and any vector will do.
        let axis = sum.try_normalize().unwrap_or(DVec3::Z);
        let spread = directions.map(|direction| (direction - axis).length());
        let lengths = rays.map(|(_, length)| f64::from(length));
        Self {
            axis,
            spread: spread.fold(0.0, f64::max),
            farthest: lengths.fold(0.0, f64::max),
        }
    }

    /// The cone around the cones of some tiles.
    fn around<'a>(tiles: impl Iterator<Item = &'a Tile> + Clone) -> Self {
        let bundles = tiles.map(|tile| &tile.bundle);
        let sum: DVec3 = bundles.clone().map(|inner| inner.axis).sum();
        let axis = sum.try_normalize().unwrap_or(DVec3::Z);
        // As chords on the unit sphere: the distance to a ray is at most the distance to the
        // axis of the tile plus the distance from there to the ray.
        let spread = bundles
            .clone()
            .map(|inner| (inner.axis - axis).length() + inner.spread);
        Self {
            axis,
            spread: spread.fold(0.0, f64::max),
            farthest: bundles.fold(0.0, |most, inner| inner.farthest.max(most)),
        }
    }
}
