//! The shadow volumes of many lights, side by side in one buffer.
//!
//! Based on: Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013,
//! sections 3.1.3 and 3.1.4: one pass rectifies the shadow maps of all lights,
//! each in an epipolar space of its own, and one segmented scan extrudes all
//! grids; tiles without a light are skipped.
//!
//! Departures. The tiles lie one after the other and not side by side, so that a
//! tile is a [`Grid`](crate::Grid) word for word and all queries work on it. Bits
//! are set and extruded in the same pass: a column of words belongs to one unit of
//! work, which needs no barriers because there are columns enough.

use epipolar::{Lattice, LightRay, Resolution};
use gpu_backend::{Backend, Buffer, Cpu, Host, Memory};

use crate::error::{same_length, same_resolution, too_many_tiles};
use crate::rectify::rectify_plane;
use crate::{Error, Sampling, ShadowVolume};

/// The [index maps](crate::IndexMap) of many lights, one after the other.
#[derive(Debug)]
pub struct AtlasMap<M: Memory> {
    resolution: Resolution,
    tiles: usize,
    indices: M::Buffer<u32>,
}

/// The [grids](crate::Grid) of many lights, one after the other.
#[derive(Debug)]
pub struct AtlasGrid<M: Memory> {
    resolution: Resolution,
    tiles: usize,
    words: M::Buffer<u32>,
}

/// The elements of so many tiles; so many that nothing can hold them if there is
/// no such number.
fn all(tiles: usize, each: usize) -> usize {
    tiles.saturating_mul(each)
}

impl<M: Memory> AtlasMap<M> {
    /// Maps for a step to write.
    ///
    /// # Errors
    /// [`Error::TooManyTiles`] if they do not fit on the backend.
    pub fn new<B: Backend<Memory = M>>(
        backend: &B,
        resolution: Resolution,
        tiles: usize,
    ) -> Result<Self, Error> {
        let each = resolution.light_rays();
        let named = too_many_tiles("an atlas of index maps", resolution, tiles, each);
        Ok(Self {
            indices: backend.zeros(all(tiles, each)).map_err(named)?,
            resolution,
            tiles,
        })
    }

    /// Maps from their entries.
    ///
    /// # Errors
    /// [`gpu_backend::Error::LengthMismatch`] unless there are
    /// [`Resolution::light_rays`] of them for each tile.
    pub fn from_indices(
        resolution: Resolution,
        tiles: usize,
        indices: M::Buffer<u32>,
    ) -> Result<Self, Error> {
        let expected = all(tiles, resolution.light_rays());
        same_length("the rectified shadow maps", expected, indices.len())?;
        Ok(Self {
            resolution,
            tiles,
            indices,
        })
    }

    /// How many voxels each tile is for.
    pub fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// How many tiles there are.
    pub fn tiles(&self) -> usize {
        self.tiles
    }

    /// The entries of all tiles.
    pub fn indices(&self) -> &M::Buffer<u32> {
        &self.indices
    }

    #[cfg(feature = "wgpu")]
    pub(crate) fn indices_mut(&mut self) -> &mut M::Buffer<u32> {
        &mut self.indices
    }
}

impl<M: Memory> AtlasGrid<M> {
    /// Grids without shadow.
    ///
    /// # Errors
    /// [`Error::TooManyTiles`] if they do not fit on the backend; see
    /// [`BuildAtlas::atlas_capacity`].
    pub fn new<B: Backend<Memory = M>>(
        backend: &B,
        resolution: Resolution,
        tiles: usize,
    ) -> Result<Self, Error> {
        let each = resolution.words();
        let named = too_many_tiles("an atlas of bit grids", resolution, tiles, each);
        Ok(Self {
            words: backend.zeros(all(tiles, each)).map_err(named)?,
            resolution,
            tiles,
        })
    }

    /// Grids from their words.
    ///
    /// # Errors
    /// [`gpu_backend::Error::LengthMismatch`] unless there are
    /// [`Resolution::words`] of them for each tile.
    pub fn from_words(
        resolution: Resolution,
        tiles: usize,
        words: M::Buffer<u32>,
    ) -> Result<Self, Error> {
        let expected = all(tiles, resolution.words());
        same_length("an atlas of bit grids", expected, words.len())?;
        Ok(Self {
            resolution,
            tiles,
            words,
        })
    }

    /// How many voxels a tile has.
    pub fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// How many tiles there are.
    pub fn tiles(&self) -> usize {
        self.tiles
    }

    /// The words of all tiles, each in the order of a [`Grid`](crate::Grid).
    pub fn words(&self) -> &M::Buffer<u32> {
        &self.words
    }

    #[cfg(feature = "wgpu")]
    pub(crate) fn words_mut(&mut self) -> &mut M::Buffer<u32> {
        &mut self.words
    }

    /// The shadow volume of a tile, which answers all that one of a single light
    /// does.
    ///
    /// # Errors
    /// [`Error::Tile`] if there is no such tile; those of [`ShadowVolume::new`].
    pub fn volume<'a>(
        &'a self,
        tile: usize,
        lattice: &'a Lattice,
        sampling: Sampling,
    ) -> Result<ShadowVolume<'a, M>, Error> {
        same_resolution(
            "an atlas of bit grids",
            lattice.resolution(),
            self.resolution,
        )?;
        has_tiles(tile.saturating_add(1), self.tiles)?;
        ShadowVolume::of_words(
            lattice,
            &self.words,
            tile * self.resolution.words(),
            sampling,
        )
    }
}

/// The first blockers of many lights: shadow maps of any kind, or a ray tracer.
/// Closures are one.
pub trait AtlasBlocker: Sync {
    /// What [`FirstBlocker::distance`](crate::FirstBlocker::distance) is for the
    /// light of a tile.
    fn distance(&self, tile: usize, ray: &LightRay) -> f32;

    /// The same for many rays of a tile, one distance for each.
    #[inline]
    fn distances(&self, tile: usize, rays: &[LightRay], distances: &mut [f32]) {
        for (ray, distance) in rays.iter().zip(distances) {
            *distance = self.distance(tile, ray);
        }
    }
}

impl<F: Fn(usize, &LightRay) -> f32 + Sync> AtlasBlocker for F {
    fn distance(&self, tile: usize, ray: &LightRay) -> f32 {
        self(tile, ray)
    }
}

/// Samples blockers of type `S` along the light rays of many lattices.
pub trait RectifyAtlas<S: ?Sized>: Backend {
    /// Writes the index maps of the first tiles, one for each lattice, as
    /// [`Rectify`](crate::Rectify) writes one. All other tiles stay as they are.
    ///
    /// # Errors
    /// [`Error::Tile`] for more lattices than tiles, [`Error::Resolution`] unless
    /// all have the resolution of `map`; errors of the backend.
    fn rectify_atlas(
        &self,
        lattices: &[Lattice],
        source: &S,
        map: &mut AtlasMap<Self::Memory>,
    ) -> Result<(), Error>;
}

/// Fills atlases.
pub trait BuildAtlas: Backend {
    /// The largest number of tiles that an atlas and its index maps may have here;
    /// 0 if not even one fits. More lights take several atlases, or the same one
    /// several times.
    ///
    /// On a GPU this is what can be bound, 128 MiB by WebGPU's default limits: 512
    /// tiles of 128³ voxels. On the CPU it is 1 GiB.
    fn atlas_capacity(&self, resolution: Resolution) -> usize;

    /// Makes the grids of the first `used` tiles from their index maps: sets the
    /// bit of the first voxel in shadow of every light ray and shadows all that are
    /// farther away. The other tiles stay as they are.
    ///
    /// The bits are those of [`BuildGrid`](crate::BuildGrid) for each tile by
    /// itself.
    ///
    /// # Errors
    /// [`Error::Tile`] if either has fewer tiles, [`Error::Resolution`] unless both
    /// have one resolution; errors of the backend.
    fn build_atlas(
        &self,
        map: &AtlasMap<Self::Memory>,
        used: usize,
        grid: &mut AtlasGrid<Self::Memory>,
    ) -> Result<(), Error>;
}

/// Bytes of an atlas on the CPU, at most.
const MOST_BYTES: usize = 1 << 30;

/// How many tiles fit into so many bytes.
pub(crate) fn capacity(resolution: Resolution, bytes: u64) -> usize {
    let tile = 4 * resolution.words().max(resolution.light_rays()) as u64;
    usize::try_from(bytes / tile).unwrap_or(usize::MAX)
}

pub(crate) fn has_tiles(needed: usize, tiles: usize) -> Result<(), Error> {
    if needed <= tiles {
        return Ok(());
    }
    Err(Error::Tile { needed, tiles })
}

pub(crate) fn check_lattices<M: Memory>(
    lattices: &[Lattice],
    map: &AtlasMap<M>,
) -> Result<(), Error> {
    has_tiles(lattices.len(), map.tiles)?;
    for lattice in lattices {
        same_resolution(
            "an atlas of index maps",
            lattice.resolution(),
            map.resolution,
        )?;
    }
    Ok(())
}

pub(crate) fn check_build<M: Memory>(
    map: &AtlasMap<M>,
    used: usize,
    grid: &AtlasGrid<M>,
) -> Result<(), Error> {
    same_resolution("an atlas of index maps", grid.resolution, map.resolution)?;
    has_tiles(used, map.tiles)?;
    has_tiles(used, grid.tiles)
}

impl<S: AtlasBlocker + ?Sized> RectifyAtlas<S> for Cpu {
    fn rectify_atlas(
        &self,
        lattices: &[Lattice],
        source: &S,
        map: &mut AtlasMap<Host>,
    ) -> Result<(), Error> {
        check_lattices(lattices, map)?;
        let (planes, bits) = (map.resolution.theta() as usize, map.resolution.bits());
        let rays = map.resolution.light_rays();
        let used = &mut map.indices[..lattices.len() * rays];
        self.for_each_chunk(used, bits as usize, |first, plane| {
            let tile = first / rays;
            let lattice = &lattices[tile];
            let theta = first / bits as usize % planes;
            rectify_plane(lattice, theta, plane, |rays, distances| {
                source.distances(tile, rays, distances);
            });
        });
        Ok(())
    }
}

impl BuildAtlas for Cpu {
    fn atlas_capacity(&self, resolution: Resolution) -> usize {
        capacity(resolution, MOST_BYTES as u64)
    }

    /// A tile is a unit of work, which passes through the cache once.
    fn build_atlas(
        &self,
        map: &AtlasMap<Host>,
        used: usize,
        grid: &mut AtlasGrid<Host>,
    ) -> Result<(), Error> {
        check_build(map, used, grid)?;
        let resolution = grid.resolution;
        let (tile, width) = (resolution.words(), resolution.words_per_row());
        let rays = resolution.light_rays();
        self.for_each_chunk(&mut grid.words[..used * tile], tile, |first, words| {
            words.fill(0);
            let indices = &map.indices[first / tile * rays..][..rays];
            for (column, entries) in indices.chunks_exact(32).enumerate() {
                for (bit, &index) in entries.iter().enumerate() {
                    if index < resolution.alpha() {
                        words[index as usize * width + column] |= 1 << bit;
                    }
                }
            }
            let mut rest = words;
            while rest.len() > width {
                let (last, after) = rest.split_at_mut(width);
                for (word, last) in after[..width].iter_mut().zip(last.iter()) {
                    *word |= last;
                }
                rest = after;
            }
        });
        Ok(())
    }
}
