//! The step that answers many questions on any backend.

use glam::{IVec3, IVec4, UVec2, Vec3, Vec4};
use gpu_backend::{Backend, BufferOf, Cpu, Host};

use super::batch::{CountLit, FilterBilinear, IsLit, batch};
use super::filter::FilterSize;
use super::ray::Ray;
use crate::error::same_length;
use crate::{Error, ResidentDag};

/// Rays per unit of work.
const CHUNK: usize = 64;

/// A ray in a buffer; see [`Ray`].
///
/// One that [`Ray::new`] would refuse has no lit parts.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RayRecord {
    /// Where it begins, in the world; in voxels for shadows without a light.
    pub origin: Vec3,
    /// Where it ends, in units of its direction; [`f32::MAX`] for nowhere.
    pub length: f32,
    /// Any length but 0.
    pub direction: Vec3,
    /// To fill up a record of shaders.
    pub padding: f32,
}

impl RayRecord {
    /// The record of a ray.
    pub fn new(origin: Vec3, direction: Vec3, length: f32) -> Self {
        Self {
            origin,
            length,
            direction,
            padding: 0.0,
        }
    }
}

/// Answers questions in batches, where the nodes are. What is given to a
/// question and what comes back are buffers of the same length.
///
/// On a GPU integers are those of the CPU, bit by bit; see `gpu` (feature
/// `wgpu`) for numbers with a fraction. Those in buffers must be finite.
pub trait Query: Backend {
    /// [`ShadowDag::is_lit`](crate::ShadowDag::is_lit) of voxels: 1 or 0. The
    /// fourth numbers are not used.
    ///
    /// # Errors
    /// [`Error::Length`] unless there are as many places as questions; errors
    /// of the backend.
    fn is_lit(
        &self,
        dag: &ResidentDag<Self::Memory>,
        voxels: &BufferOf<Self, [i32; 4]>,
        lit: &mut BufferOf<Self, u32>,
    ) -> Result<(), Error>;

    /// The number of lit voxels of those that
    /// [`ShadowDag::filter`](crate::ShadowDag::filter) averages over.
    ///
    /// # Errors
    /// As for [`Query::is_lit`].
    fn count_lit(
        &self,
        dag: &ResidentDag<Self::Memory>,
        size: FilterSize,
        voxels: &BufferOf<Self, [i32; 4]>,
        counts: &mut BufferOf<Self, u32>,
    ) -> Result<(), Error>;

    /// [`ShadowDag::filter`](crate::ShadowDag::filter) of voxels.
    ///
    /// # Errors
    /// As for [`Query::is_lit`].
    fn filter(
        &self,
        dag: &ResidentDag<Self::Memory>,
        size: FilterSize,
        voxels: &BufferOf<Self, [i32; 4]>,
        lit: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;

    /// [`ShadowDag::filter_bilinear`](crate::ShadowDag::filter_bilinear) of
    /// positions; the fourth numbers are not used.
    ///
    /// # Errors
    /// As for [`Query::is_lit`].
    fn filter_bilinear(
        &self,
        dag: &ResidentDag<Self::Memory>,
        size: FilterSize,
        positions: &BufferOf<Self, [f32; 4]>,
        lit: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;

    /// [`ShadowDag::depth`](crate::ShadowDag::depth) of texels.
    ///
    /// # Errors
    /// As for [`Query::is_lit`].
    fn depth(
        &self,
        dag: &ResidentDag<Self::Memory>,
        texels: &BufferOf<Self, [u32; 2]>,
        depths: &mut BufferOf<Self, u32>,
    ) -> Result<(), Error>;

    /// [`ShadowDag::visibility`](crate::ShadowDag::visibility) of boxes, given
    /// by their first and their last voxel, as the number of a
    /// [`Visibility`](crate::Visibility). The fourth numbers are not used.
    ///
    /// # Errors
    /// As for [`Query::is_lit`].
    fn visibility(
        &self,
        dag: &ResidentDag<Self::Memory>,
        boxes: &BufferOf<Self, [[i32; 4]; 2]>,
        seen: &mut BufferOf<Self, u32>,
    ) -> Result<(), Error>;

    /// [`ShadowDag::lit_length`](crate::ShadowDag::lit_length) of rays.
    ///
    /// # Errors
    /// As for [`Query::is_lit`].
    fn lit_length(
        &self,
        dag: &ResidentDag<Self::Memory>,
        rays: &BufferOf<Self, RayRecord>,
        lengths: &mut BufferOf<Self, f32>,
    ) -> Result<(), Error>;

    /// [`ShadowDag::lit_intervals`](crate::ShadowDag::lit_intervals) of rays.
    /// `intervals` has the same number of places for each ray, its length
    /// divided by that of the rays; `counts` are how many intervals each ray
    /// has, of which those beyond its places are left out. Places without an
    /// interval keep what they held.
    ///
    /// # Errors
    /// [`Error::Length`] unless there is one count per ray and a whole number
    /// of places; errors of the backend.
    fn lit_intervals(
        &self,
        dag: &ResidentDag<Self::Memory>,
        rays: &BufferOf<Self, RayRecord>,
        intervals: &mut BufferOf<Self, [f32; 2]>,
        counts: &mut BufferOf<Self, u32>,
    ) -> Result<(), Error>;
}

/// The voxel in a buffer.
#[inline]
fn three(voxel: &[i32; 4]) -> IVec3 {
    IVec4::from_array(*voxel).truncate()
}

impl Query for Cpu {
    fn is_lit(
        &self,
        dag: &ResidentDag<Host>,
        voxels: &Vec<[i32; 4]>,
        lit: &mut Vec<u32>,
    ) -> Result<(), Error> {
        dag.ask(self, IsLit, voxels, lit, three, u32::from)
    }

    fn count_lit(
        &self,
        dag: &ResidentDag<Host>,
        size: FilterSize,
        voxels: &Vec<[i32; 4]>,
        counts: &mut Vec<u32>,
    ) -> Result<(), Error> {
        dag.ask(self, CountLit(size), voxels, counts, three, |count| count)
    }

    fn filter(
        &self,
        dag: &ResidentDag<Host>,
        size: FilterSize,
        voxels: &Vec<[i32; 4]>,
        lit: &mut Vec<f32>,
    ) -> Result<(), Error> {
        let share = |count| size.share(count);
        dag.ask(self, CountLit(size), voxels, lit, three, share)
    }

    fn filter_bilinear(
        &self,
        dag: &ResidentDag<Host>,
        size: FilterSize,
        positions: &Vec<[f32; 4]>,
        lit: &mut Vec<f32>,
    ) -> Result<(), Error> {
        let three = |position: &[f32; 4]| Vec4::from_array(*position).truncate();
        dag.ask(self, FilterBilinear(size), positions, lit, three, |lit| lit)
    }

    fn depth(
        &self,
        dag: &ResidentDag<Host>,
        texels: &Vec<[u32; 2]>,
        depths: &mut Vec<u32>,
    ) -> Result<(), Error> {
        batch(self, texels, depths, |texel| {
            dag.depth(UVec2::from_array(*texel))
        })
    }

    fn visibility(
        &self,
        dag: &ResidentDag<Host>,
        boxes: &Vec<[[i32; 4]; 2]>,
        seen: &mut Vec<u32>,
    ) -> Result<(), Error> {
        batch(self, boxes, seen, |ends| {
            let [first, last] = ends.map(|voxel| IVec4::from_array(voxel).truncate());
            dag.visibility(first, last) as u32
        })
    }

    fn lit_length(
        &self,
        dag: &ResidentDag<Host>,
        rays: &Vec<RayRecord>,
        lengths: &mut Vec<f32>,
    ) -> Result<(), Error> {
        batch(self, rays, lengths, |ray| {
            let ray = Ray::new(ray.origin, ray.direction, ray.length);
            ray.map_or(0.0, |ray| dag.lit_length(&ray) as f32)
        })
    }

    fn lit_intervals(
        &self,
        dag: &ResidentDag<Host>,
        rays: &Vec<RayRecord>,
        intervals: &mut Vec<[f32; 2]>,
        counts: &mut Vec<u32>,
    ) -> Result<(), Error> {
        let places = places(rays.len(), intervals.len(), counts.len())?;
        let find = |ray: &RayRecord| {
            let ray = Ray::new(ray.origin, ray.direction, ray.length);
            ray.map_or(Vec::new(), |ray| dag.lit_intervals(&ray))
        };
        if places == 0 {
            return batch(self, rays, counts, |ray| find(ray).len() as u32);
        }
        // The places and the count of a ray, as one item of work.
        let mut work: Vec<_> = intervals.chunks_mut(places).zip(counts).collect();
        self.for_each_chunk(&mut work, CHUNK, |first, work| {
            for ((places, count), ray) in work.iter_mut().zip(&rays[first..]) {
                let found = find(ray);
                **count = found.len() as u32;
                for (place, interval) in places.iter_mut().zip(&found) {
                    *place = interval.map(|s| s as f32);
                }
            }
        });
        Ok(())
    }
}

/// The number of places per ray.
pub(crate) fn places(rays: usize, intervals: usize, counts: usize) -> Result<usize, Error> {
    same_length("counts of lit intervals", rays, counts)?;
    let places = intervals.checked_div(rays).unwrap_or(0);
    same_length("places for lit intervals", places * rays, intervals)?;
    Ok(places)
}
