//! What a gather reads from the voxels along a ray.

use std::borrow::Borrow;
use std::marker::PhantomData;

use gpu_backend::{Host, Memory};
use voxel_shadow::{RayShadow, ShadowVolume};

use super::{State, VoxelVolume};
use crate::visibility::LitOfEach;
use crate::{Interval, LightPath, LitInterval, VisibilitySource};

/// What is read from the voxels along a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Detail {
    /// The share of voxels that are lit, as the visibility of the whole ray, which is the
    /// paper's gather. It is right if shadow and light are mixed evenly along the ray, or if
    /// all voxels have the same light. It is the cheapest.
    Average,
    /// One part for each lit voxel. With an evaluator of one sample, this is a sum with a
    /// weight for each bit.
    Voxels,
    /// One part for each run of lit voxels. This needs the fewest evaluations and is exact
    /// except at the ends of runs.
    #[default]
    Runs,
}

/// The lit parts of rays, from a [`VoxelVolume`] that is borrowed or shared.
#[derive(Debug, Clone, Copy)]
pub struct VoxelShadow<V, M> {
    volume: V,
    detail: Detail,
    memory: PhantomData<fn() -> M>,
}

impl<V: Borrow<VoxelVolume<M>>, M: Memory> VoxelShadow<V, M> {
    /// Reads `volume` in this detail.
    pub fn new(volume: V, detail: Detail) -> Self {
        Self {
            volume,
            detail,
            memory: PhantomData,
        }
    }

    /// The voxels.
    pub fn volume(&self) -> &VoxelVolume<M> {
        self.volume.borrow()
    }

    /// What is read from them.
    pub fn detail(&self) -> Detail {
        self.detail
    }

    /// Returns the volume as it was given.
    pub fn into_volume(self) -> V {
        self.volume
    }
}

impl<V: Borrow<VoxelVolume<Host>> + Sync> VoxelShadow<V, Host> {
    /// What is read, if anything has to be.
    fn shadow(&self) -> State<ShadowVolume<'_, Host>> {
        let volume = self.volume();
        match volume.state() {
            State::Lit => State::Lit,
            State::Dark => State::Dark,
            State::Voxels(lattice) => {
                let volume = ShadowVolume::new(lattice, volume.grid(), volume.sampling());
                // It was checked when the voxels were made.
                volume.map_or(State::Dark, State::Voxels)
            }
        }
    }
}

impl<V: Borrow<VoxelVolume<Host>> + Sync> VisibilitySource for VoxelShadow<V, Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        self.detail.lit_parts(&self.shadow(), path, lit);
    }

    fn lit_of_neighbours(&self, paths: &[LightPath<'_>], each: &mut LitOfEach<'_, f32>) {
        self.detail.lit_parts_of(&self.shadow(), paths, each);
    }
}

impl Detail {
    /// Appends the lit parts of a path.
    fn lit_parts(
        self,
        volume: &State<ShadowVolume<'_, Host>>,
        path: &LightPath<'_>,
        lit: &mut Vec<LitInterval>,
    ) {
        let span = path.span();
        let volume = match volume {
            State::Lit => return lit.push(LitInterval::unshadowed(span.start, span.end)),
            State::Dark => return,
            State::Voxels(volume) => volume,
        };
        let [x, y, z, surface] = ray_of(path);
        let shadow = volume.ray_shadow([x, y, z], surface);
        let within = |part| part_within(span, part);
        match self {
            Self::Average => lit.extend(within(average(span, &shadow))),
            Self::Voxels => lit.extend(shadow.lit_voxels().filter_map(within)),
            Self::Runs => lit.extend(shadow.lit_runs().filter_map(within)),
        }
    }

    /// The same of many paths at once, for less time: calls `each` with the index of each path
    /// and its lit parts, in order.
    pub(crate) fn lit_parts_of(
        self,
        volume: &State<ShadowVolume<'_, Host>>,
        paths: &[LightPath<'_>],
        each: &mut LitOfEach<'_, f32>,
    ) {
        let mut lit = Vec::new();
        let State::Voxels(volume) = volume else {
            for (index, path) in paths.iter().enumerate() {
                lit.clear();
                self.lit_parts(volume, path, &mut lit);
                each(index, &mut lit);
            }
            return;
        };
        let rays: Vec<[f32; 4]> = paths.iter().map(ray_of).collect();
        let mut parts_of = |index: usize, parts: &[voxel_shadow::LitInterval]| {
            let span = paths[index].span();
            lit.clear();
            lit.extend(parts.iter().filter_map(|part| part_within(span, *part)));
            each(index, &mut lit);
        };
        match self {
            Self::Average => volume.ray_shadows(&rays, |index, shadow| {
                parts_of(index, &[average(paths[index].span(), &shadow)]);
            }),
            Self::Voxels => volume.lit_voxels(&rays, parts_of),
            Self::Runs => volume.lit_intervals(&rays, parts_of),
        }
    }
}

/// The ray of a path, as voxels are asked.
fn ray_of(path: &LightPath<'_>) -> [f32; 4] {
    let ray = path.ray();
    ray.direction()
        .extend(ray.length().min(f32::MAX))
        .to_array()
}

/// The whole span with the share of its voxels that are lit.
fn average(span: Interval, shadow: &RayShadow<'_>) -> voxel_shadow::LitInterval {
    let end = span.end.min(f32::MAX);
    voxel_shadow::LitInterval {
        start: span.start,
        end,
        visibility: shadow.lit_fraction_between(span.start, end),
    }
}

/// What of a part lies in a span; `None` if nothing does or if it is dark.
fn part_within(span: Interval, part: voxel_shadow::LitInterval) -> Option<LitInterval> {
    // A ray to the sky ends at f32::MAX or beyond.
    let end = if part.end < f32::MAX {
        part.end
    } else {
        f32::INFINITY
    };
    let interval = Interval::new(part.start.max(span.start), end.min(span.end));
    let is_lit = interval.start < interval.end && part.visibility > 0.0;
    is_lit.then_some(LitInterval {
        interval,
        visibility: part.visibility,
    })
}
