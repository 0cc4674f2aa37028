//! The lights that may reach each tile of a picture.

use std::borrow::Borrow;
use std::sync::atomic::{AtomicUsize, Ordering};

use gpu_backend::Cpu;

use super::reach::{Bundle, Reach};
use super::tiles::{LEVELS, RayTiles};
use crate::Emitter;

/// The largest number of entries in the lists of all tiles together. They are 64 MiB of light
/// indices, half of what a GPU with the default limits of WebGPU binds at once.
pub const MOST_LISTED: usize = 1 << 24;

/// Lists of lights would take too much memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the lists of {lights} lights have more than {MOST_LISTED} entries in {tiles} tiles, \
     expected fewer lights at a time"
)]
pub struct TooManyLights {
    pub(super) lights: usize,
    pub(super) tiles: usize,
}

/// For each tile of a picture, the lights that may reach its rays, in the order of the lights.
///
/// The length of a single list is not limited: a tile that all lights reach lists all of them.
/// Lights without bounds are in every list.
///
/// Cost: each light is tested against the largest blocks of tiles, and then against the blocks
/// and tiles inside of those that it may reach. So the cost grows with the entries of the
/// lists, apart from one test for each light and block of 256 × 256 pixels.
#[derive(Debug, Clone)]
pub struct TileLights<'t> {
    tiles: &'t RayTiles,
    /// The index at which the list of each tile begins, and the end of the last list.
    offsets: Vec<u32>,
    lights: Vec<u32>,
    /// For each entry, the distances from the eye between which its light may reach rays of the
    /// tile.
    parts: Vec<[f32; 2]>,
    /// The region that each light reaches; `None` for a light without bounds.
    reaches: Vec<Option<Reach>>,
}

/// The lists of some tiles, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Lists {
    /// Entries of each list.
    pub(super) counts: Vec<u32>,
    pub(super) lights: Vec<u32>,
    pub(super) parts: Vec<[f32; 2]>,
}

impl Lists {
    /// Concatenates lists. The first result is the index at which each list begins, and the end
    /// of the last list.
    pub(super) fn join(all: &[Self]) -> (Vec<u32>, Vec<u32>, Vec<[f32; 2]>) {
        let mut offsets = vec![0];
        let (mut lights, mut parts) = (Vec::new(), Vec::new());
        let mut end = 0;
        for lists in all {
            for count in &lists.counts {
                end += count;
                offsets.push(end);
            }
            lights.extend_from_slice(&lists.lights);
            parts.extend_from_slice(&lists.parts);
        }
        (offsets, lights, parts)
    }
}

/// Counts entries, and notices when there are too many.
pub(super) struct Budget(AtomicUsize);

impl Budget {
    pub(super) fn new() -> Self {
        Self(AtomicUsize::new(0))
    }

    /// Takes so many entries from the budget; false if it is exhausted.
    pub(super) fn take(&self, entries: usize) -> bool {
        self.0.fetch_add(entries, Ordering::Relaxed) + entries <= MOST_LISTED
    }

    /// Whether the budget sufficed. The answer does not depend on the order of the takers.
    pub(super) fn is_kept(&self) -> bool {
        self.0.load(Ordering::Relaxed) <= MOST_LISTED
    }
}

impl<'t> TileLights<'t> {
    /// Makes the lists of all tiles.
    ///
    /// # Errors
    /// [`TooManyLights`] if the lists of all tiles, or those of larger blocks on the way to
    /// them, have more than [`MOST_LISTED`] entries. Lists of only some of the lights are
    /// shorter.
    pub fn new<L: Borrow<Emitter> + Sync>(
        cpu: &Cpu,
        tiles: &'t RayTiles,
        emitters: &[L],
    ) -> Result<Self, TooManyLights> {
        let too_many = TooManyLights {
            lights: emitters.len(),
            tiles: tiles.tiles(),
        };
        // Light indices are u32.
        if emitters.len() > MOST_LISTED {
            return Err(too_many);
        }
        let eye = tiles.eye();
        let reaches = cpu.map(emitters.len(), |light| {
            Reach::new(emitters[light].borrow(), eye)
        });
        let part = |level: usize, tile: usize, light: u32| {
            part_of(
                reaches[light as usize].as_ref(),
                &tiles.level(level)[tile].bundle,
            )
        };
        let all: Vec<u32> = (0..emitters.len() as u32).collect();
        // The lights of each block of one level, and for each block the block around it.
        let mut blocks: Vec<Vec<u32>> = Vec::new();
        let mut around: Vec<usize> = Vec::new();
        for level in 0..LEVELS - 1 {
            let budget = Budget::new();
            let found = cpu.map(tiles.level(level).len(), |block| {
                let of_outer = around.get(block).map_or(&all, |outer| &blocks[*outer]);
                if !budget.is_kept() {
                    return Vec::new();
                }
                let lights = of_outer.iter().copied();
                let reached = lights.filter(|light| part(level, block, *light).is_some());
                let reached: Vec<u32> = reached.collect();
                if budget.take(reached.len()) {
                    reached
                } else {
                    Vec::new()
                }
            });
            if !budget.is_kept() {
                return Err(too_many);
            }
            let inside = tiles
                .level(level)
                .iter()
                .map(|block| block.end - block.first);
            around = (0..)
                .zip(inside)
                .flat_map(|(block, count)| std::iter::repeat_n(block, count))
                .collect();
            blocks = found;
        }
        let budget = Budget::new();
        let last = tiles.level(LEVELS - 2);
        let lists = cpu.map(last.len(), |block| {
            let mut lists = Lists::default();
            for tile in last[block].first..last[block].end {
                let before = lists.lights.len();
                if !budget.is_kept() {
                    break;
                }
                for light in &blocks[block] {
                    if let Some(part) = part(LEVELS - 1, tile, *light) {
                        lists.lights.push(*light);
                        lists.parts.push(outwards(part));
                    }
                }
                let count = lists.lights.len() - before;
                budget.take(count);
                lists.counts.push(count as u32);
            }
            lists
        });
        if !budget.is_kept() {
            return Err(too_many);
        }
        let (offsets, lights, parts) = Lists::join(&lists);
        Ok(Self {
            tiles,
            offsets,
            lights,
            parts,
            reaches,
        })
    }

    /// Lists with all lights in each: nothing is culled.
    #[cfg(test)]
    pub(crate) fn all(tiles: &'t RayTiles, emitters: usize) -> Self {
        let count = tiles.tiles();
        Self {
            tiles,
            offsets: (0..=count).map(|tile| (tile * emitters) as u32).collect(),
            lights: (0..count).flat_map(|_| 0..emitters as u32).collect(),
            parts: vec![[0.0, f32::INFINITY]; count * emitters],
            reaches: vec![None; emitters],
        }
    }

    /// The tiles that the lists belong to.
    pub fn tiles(&self) -> &'t RayTiles {
        self.tiles
    }

    /// Number of all lights, listed or not.
    pub fn emitters(&self) -> usize {
        self.reaches.len()
    }

    /// Number of entries in all lists together.
    pub fn entries(&self) -> usize {
        self.lights.len()
    }

    /// The lights that may reach rays of a tile, in their order; none if there is no such tile.
    pub fn of_tile(&self, tile: usize) -> &[u32] {
        &self.lights[self.range(tile)]
    }

    /// The lights that may reach a ray between the eye and a distance, in their order; none if
    /// there is no such ray.
    pub fn of_ray(&self, ray: usize, length: f32) -> impl Iterator<Item = u32> {
        self.entries_where(ray, move |[start, _]| start <= length)
    }

    /// The lights that may reach a ray at a distance from the eye, in their order; none if
    /// there is no such ray.
    pub fn at(&self, ray: usize, distance: f32) -> impl Iterator<Item = u32> {
        self.entries_where(ray, move |[start, end]| {
            start <= distance && distance <= end
        })
    }

    /// The lists as shaders read them: the index at which each begins, and the lights.
    #[cfg(feature = "wgpu")]
    pub(crate) fn lists(&self) -> (&[u32], &[u32]) {
        (&self.offsets, &self.lights)
    }

    /// The entries of a tile: lights, each with the range of distances in which it may reach
    /// rays.
    pub(super) fn of(&self, tile: usize) -> impl Iterator<Item = (u32, [f32; 2])> {
        let range = self.range(tile);
        let lights = self.lights[range.clone()].iter().copied();
        lights.zip(self.parts[range].iter().copied())
    }

    /// Whether a light may reach some of the rays of a bundle between two distances.
    pub(super) fn reaches(&self, light: u32, bundle: &Bundle, [near, far]: [f32; 2]) -> bool {
        let reach = self.reaches[light as usize].as_ref();
        part_of(reach, bundle).is_some_and(|part| {
            let [start, end] = outwards(part);
            start <= far && near <= end
        })
    }

    fn entries_where(
        &self,
        ray: usize,
        reaches: impl Fn([f32; 2]) -> bool,
    ) -> impl Iterator<Item = u32> {
        let tile = self.tiles.tile_of(ray).unwrap_or(usize::MAX);
        self.of(tile)
            .filter(move |(_, part)| reaches(*part))
            .map(|(light, _)| light)
    }

    fn range(&self, tile: usize) -> std::ops::Range<usize> {
        match self.offsets.get(tile..tile.saturating_add(2)) {
            Some(&[first, end]) => first as usize..end as usize,
            _ => 0..0,
        }
    }
}

/// The distances from the eye between which a light may reach rays of a bundle.
fn part_of(reach: Option<&Reach>, bundle: &Bundle) -> Option<[f64; 2]> {
    match reach {
        Some(reach) => reach.part(bundle),
        None => Some([0.0, bundle.farthest]),
    }
}

/// The interval in f32, rounded outwards.
fn outwards([start, end]: [f64; 2]) -> [f32; 2] {
    // This widens the interval by more than the conversion can round.
    [start * (1.0 - 1e-7), end * (1.0 + 1e-7)].map(|x| x as f32)
}
