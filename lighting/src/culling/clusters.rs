//! The lights that may reach the surfaces of each tile of a picture.

use std::ops::Range;

use gpu_backend::Cpu;

use super::lights::{Budget, Lists, TileLights, TooManyLights};
use super::reach::Bundle;

/// The number of low bits of an f32 that the index of a slice leaves out. This gives eight
/// slices of depth per octave, each 6 to 13 % deep.
const SLICE: u32 = 20;

/// Tiles in a unit of work.
const CHUNK: usize = 64;

/// The cluster index of a ray without an end.
const NO_CLUSTER: u32 = u32::MAX;

/// For the surfaces on which the rays of a picture end, the lights that may reach them, in the
/// order of the lights.
///
/// Slices of depth are logarithmic, as in Olsson et al. A *cluster* contains the ends of those
/// rays of a tile that end in the same slice. It extends from the nearest to the farthest of
/// these ends, and only around these rays. So there are no clusters where no ray ends, and
/// clusters are small where depths in a tile differ, and where a surface faces the eye.
///
/// Cost: a comparison for each cluster and each light of its tile. Where a cluster does not
/// have all rays of its tile, lights at its depth are tested in addition. Results do not depend
/// on threads.
/// are at its depth where it has not all rays of the tile; on any number of threads.
#[derive(Debug, Clone)]
pub struct Clusters<'t> {
    rays: TileLights<'t>,
    /// The cluster that each ray ends in.
    of_ray: Vec<u32>,
    /// Nearest and farthest end of each cluster.
    depths: Vec<[f32; 2]>,
    /// The index at which the list of each cluster begins, and the end of the last list.
    offsets: Vec<u32>,
    lights: Vec<u32>,
}

/// The clusters of some tiles.
#[derive(Default)]
struct Chunk {
    /// Rays, each with the index of its cluster within the chunk.
    ends: Vec<(u32, u32)>,
    depths: Vec<[f32; 2]>,
    lists: Lists,
}

impl<'t> Clusters<'t> {
    /// Makes the clusters at the ends of the rays that the lists belong to.
    ///
    /// # Errors
    /// [`TooManyLights`] if the lists of all clusters together have more than
    /// [`MOST_LISTED`](super::MOST_LISTED) entries.
    pub fn new(cpu: &Cpu, rays: TileLights<'t>) -> Result<Self, TooManyLights> {
        let tiles = rays.tiles();
        let count = tiles.tiles();
        let budget = Budget::new();
        let chunks = cpu.map(count.div_ceil(CHUNK), |chunk| {
            let first = chunk * CHUNK;
            let mut chunk = Chunk::default();
            for tile in first..count.min(first + CHUNK) {
                chunk.add(&rays, tile, &budget);
            }
            chunk
        });
        if !budget.is_kept() {
            return Err(TooManyLights {
                lights: rays.emitters(),
                tiles: count,
            });
        }
        let mut of_ray = vec![NO_CLUSTER; tiles.rays()];
        let (mut depths, mut lists) = (Vec::new(), Vec::new());
        for chunk in chunks {
            // There are no more clusters than rays, which a u32 counts.
            let first = depths.len() as u32;
            for (ray, cluster) in chunk.ends {
                of_ray[ray as usize] = first + cluster;
            }
            depths.extend(chunk.depths);
            lists.push(chunk.lists);
        }
        let (offsets, lights, _) = Lists::join(&lists);
        Ok(Self {
            rays,
            of_ray,
            depths,
            offsets,
            lights,
        })
    }

    /// The lists along whole rays.
    pub fn rays(&self) -> &TileLights<'t> {
        &self.rays
    }

    /// Number of clusters.
    pub fn clusters(&self) -> usize {
        self.depths.len()
    }

    /// Number of entries in the lists of all clusters together.
    pub fn entries(&self) -> usize {
        self.lights.len()
    }

    /// The lights that may reach the point of a ray at a distance from the eye, in their order;
    /// none if there is no such ray. For a point in the cluster that the ray ends in, this is
    /// the list of the cluster. For another point, for example on a pane in front, it is those
    /// of the tile's lights that may reach the tile at this distance.
    pub fn at(&self, ray: usize, distance: f32) -> impl Iterator<Item = u32> {
        let cluster = self.cluster(ray, distance);
        let known = cluster.clone().map_or(&[][..], |list| &self.lights[list]);
        let others = cluster.is_none().then(|| self.rays.at(ray, distance));
        known.iter().copied().chain(others.into_iter().flatten())
    }

    /// The cluster of each ray, the index at which the list of each cluster begins with the end
    /// of the last one, and the lights. A ray without an end has an index that is that of no
    /// cluster.
    pub(super) fn into_lists(self) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
        (self.of_ray, self.offsets, self.lights)
    }

    /// The list of the cluster that a ray ends in, if the point at this distance is in it.
    fn cluster(&self, ray: usize, distance: f32) -> Option<Range<usize>> {
        let cluster = *self.of_ray.get(ray)? as usize;
        let [near, far] = *self.depths.get(cluster)?;
        let list = self.offsets[cluster] as usize..self.offsets[cluster + 1] as usize;
        (near <= distance && distance <= far).then_some(list)
    }
}

impl Chunk {
    /// Adds the clusters of one tile.
    fn add(&mut self, rays: &TileLights<'_>, tile: usize, budget: &Budget) {
        let tiles = rays.tiles();
        let ways = tiles.rays_of(tile).iter().zip(tiles.ways_of(tile));
        let mut ends: Vec<_> = ways.filter(|(_, (_, end))| end.is_finite()).collect();
        ends.sort_unstable_by(|(a, (_, x)), (b, (_, y))| x.total_cmp(y).then(a.cmp(b)));
        let all = tiles.rays_of(tile).len();
        let slice_of = |end: f32| end.to_bits() >> SLICE;
        let slices = ends.chunk_by(|(_, (_, a)), (_, (_, b))| slice_of(*a) == slice_of(*b));
        for slice in slices {
            if !budget.is_kept() {
                return;
            }
            let cluster = self.depths.len() as u32;
            self.ends
                .extend(slice.iter().map(|(ray, _)| (**ray, cluster)));
            let depths = slice.iter().map(|(_, (_, end))| *end);
            let depths = [
                depths.clone().fold(f32::INFINITY, f32::min),
                depths.fold(0.0, f32::max),
            ];
            self.depths.push(depths);
            let [near, far] = depths;
            let at_depth = rays
                .of(tile)
                .filter(|(_, [start, end])| *start <= far && near <= *end);
            let lights = at_depth.map(|(light, _)| light);
            let lists = &mut self.lists;
            let before = lists.lights.len();
            if slice.len() == all {
                lists.lights.extend(lights);
            } else {
                let bundle = Bundle::new(slice.iter().map(|(_, way)| *way));
                let reached = lights.filter(|light| rays.reaches(*light, &bundle, depths));
                lists.lights.extend(reached);
            }
            let count = lists.lights.len() - before;
            budget.take(count);
            lists.counts.push(count as u32);
        }
    }
}
