//! The lights that may reach each of some points.

use gpu_backend::Cpu;

use super::reach::is_worthwhile;
use super::{Clusters, RayTiles, TileLights};
use crate::{Emitter, Ray};

/// For each of some points, the lights that may reach it, in the order of the lights. Steps
/// that [light surfaces](crate::direct_light) take it.
///
/// Points with the same lights share a list.
#[derive(Debug, Clone)]
pub struct PointLists {
    /// Index of the list of each point.
    of_point: Vec<u32>,
    /// The index at which each list begins, and the end of the last list.
    offsets: Vec<u32>,
    lights: Vec<u32>,
    emitters: usize,
}

impl PointLists {
    /// Lists with all of so many lights for each of so many points.
    pub fn all(points: usize, emitters: usize) -> Self {
        // Memory holds no more lights than a u32 counts.
        let end = emitters as u32;
        Self {
            of_point: vec![0; points],
            offsets: vec![0, end],
            lights: (0..end).collect(),
            emitters,
        }
    }

    /// Lists for the points on which rays end, in the order of the rays. A ray without an end
    /// has no lights.
    pub fn of_ends(clusters: Clusters<'_>) -> Self {
        let emitters = clusters.rays().emitters();
        let empty = clusters.clusters() as u32;
        let (mut of_point, mut offsets, lights) = clusters.into_lists();
        for list in &mut of_point {
            *list = empty.min(*list);
        }
        // The list of points without lights.
        offsets.push(lights.len() as u32);
        Self {
            of_point,
            offsets,
            lights,
            emitters,
        }
    }

    /// Lists for the points on which the rays of a picture of this width end: those of their
    /// [clusters](Clusters), or all lights if there are too few for culling to be
    /// [worthwhile](is_worthwhile) or if the lists would be too long.
    pub fn of_picture(cpu: &Cpu, rays: &[Ray], width: u32, emitters: &[Emitter]) -> Self {
        let tiles = is_worthwhile(emitters)
            .then(|| RayTiles::new(cpu, rays, width, None))
            .flatten();
        let clusters = tiles.as_ref().and_then(|tiles| {
            let lights = TileLights::new(cpu, tiles, emitters);
            lights.and_then(|lights| Clusters::new(cpu, lights)).ok()
        });
        match clusters {
            Some(clusters) => Self::of_ends(clusters),
            None => Self::all(rays.len(), emitters.len()),
        }
    }

    /// The lights that may reach a point, in their order; none if there is no such point.
    pub fn of(&self, point: usize) -> &[u32] {
        self.of_point
            .get(point)
            .map_or(&[], |list| self.list(*list as usize))
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.of_point.len()
    }

    /// Number of all lights, listed or not.
    pub fn emitters(&self) -> usize {
        self.emitters
    }

    /// Length of the longest list.
    #[cfg(feature = "wgpu")]
    pub(crate) fn longest(&self) -> usize {
        let lists = 0..self.offsets.len() - 1;
        let lengths = lists.map(|list| self.list(list).len());
        lengths.max().unwrap_or(0)
    }

    /// The lists as shaders read them: the list of each point, the index at which each list
    /// begins, and the lights.
    #[cfg(feature = "wgpu")]
    pub(crate) fn words(&self) -> Vec<u32> {
        [&self.of_point[..], &self.offsets, &self.lights].concat()
    }

    /// Number of lists.
    #[cfg(feature = "wgpu")]
    pub(crate) fn lists(&self) -> usize {
        self.offsets.len() - 1
    }

    fn list(&self, list: usize) -> &[u32] {
        &self.lights[self.offsets[list] as usize..self.offsets[list + 1] as usize]
    }
}
