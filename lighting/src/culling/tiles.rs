//! The rays of a picture by the tiles that they are in.

use glam::DVec3;
use gpu_backend::Cpu;

use super::reach::{Bundle, Reach};
use crate::{Emitter, Ray};

/// Pixels along a side of a tile, and tiles along a side of a block.
const SIDE: u32 = 4;

/// Levels of tiles and blocks: blocks of the last are 64 pixels wide.
const LEVELS: usize = 3;

/// Bits of the place of a tile in its block.
const PLACE: u32 = 2 * SIDE.ilog2();

/// The number of the tile of a pixel: that of its largest block, then its place in each
/// block.
fn place_of([x, y]: [u32; 2]) -> u64 {
    let largest = SIDE.pow(LEVELS as u32);
    let mut place = (u64::from(y / largest) << 26) | u64::from(x / largest);
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
    /// Numbers of rays, tile by tile of every block of every larger block.
    order: Vec<u32>,
    lengths: Vec<f32>,
    /// The largest blocks first.
    levels: [Vec<Tile>; LEVELS],
}

/// A tile, or a block of them.
#[derive(Debug, Clone)]
struct Tile {
    bundle: Bundle,
    /// Its tiles on the next level, or its rays in their order.
    first: usize,
    end: usize,
}

impl RayTiles {
    /// The rays of a picture that is `width` pixels wide; `pixels` has the pixel of each, row
    /// by row, if they are not those of all pixels. Pixels below the picture are as good as
    /// others.
    ///
    /// `None` if they do not all start at one eye, there are none, or there are more or less
    /// `pixels` than rays.
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
        // More rays than a u32 counts do not fit into memory.
        let mut places: Vec<(u64, u32)> = cpu.map(rays.len(), |ray| (place(ray), ray as u32));
        places.sort_unstable();
        let order: Vec<u32> = places.iter().map(|(_, ray)| *ray).collect();
        let lengths = order
            .iter()
            .map(|ray| rays[*ray as usize].length())
            .collect();
        let ends = |level: usize| -> Vec<[usize; 2]> {
            let shift = PLACE * (LEVELS - 1 - level) as u32;
            let mut end = 0;
            let chunks = places.chunk_by(|a, b| a.0 >> shift == b.0 >> shift);
            chunks
                .map(|chunk| {
                    let first = end;
                    end += chunk.len();
                    [first, end]
                })
                .collect()
        };
        let all: [Vec<[usize; 2]>; LEVELS] = std::array::from_fn(ends);
        let levels = std::array::from_fn(|level| {
            let bundles = cpu.map(all[level].len(), |tile| {
                let [first, end] = all[level][tile];
                Bundle::new(order[first..end].iter().map(|ray| &rays[*ray as usize]))
            });
            let mut below = 0;
            let tiles = bundles.into_iter().zip(&all[level]);
            tiles
                .map(|(bundle, &[first, end])| {
                    let (mut first, mut end) = (first, end);
                    if let Some(next) = all.get(level + 1) {
                        let count = next[below..]
                            .iter()
                            .take_while(|tile| tile[1] <= end)
                            .count();
                        (first, end) = (below, below + count);
                        below = end;
                    }
                    Tile { bundle, first, end }
                })
                .collect()
        });
        Some(Self {
            eye: eye.as_dvec3(),
            order,
            lengths,
            levels,
        })
    }

    /// Number of rays.
    pub fn rays(&self) -> usize {
        self.order.len()
    }

    /// The numbers of the rays that a light may reach, tile by tile; `None` for a light
    /// without bounds, which may reach all of them.
    pub fn reached(&self, emitter: &Emitter) -> Option<Vec<u32>> {
        let reach = Reach::new(emitter, self.eye)?;
        let mut rays = Vec::new();
        self.add(&reach, 0, 0..self.levels[0].len(), &mut rays);
        Some(rays)
    }

    /// Adds the rays of some tiles of a level.
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
    /// A cone around some rays from one eye.
    fn new<'a>(rays: impl Iterator<Item = &'a Ray> + Clone) -> Self {
        let directions = rays
            .clone()
            .map(|ray| ray.direction().as_dvec3().normalize());
        let sum: DVec3 = directions.clone().sum();
        // Rays that look everywhere have no axis, and any will do.
        let axis = sum.try_normalize().unwrap_or(DVec3::Z);
        let spread = directions.map(|direction| (direction - axis).length());
        let lengths = rays.map(|ray| f64::from(ray.length()));
        Self {
            axis,
            spread: spread.fold(0.0, f64::max),
            farthest: lengths.fold(0.0, f64::max),
        }
    }
}
