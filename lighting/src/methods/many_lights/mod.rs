//! Many lights in one pass: every pixel asks the lights of its tile, and no others.
//!
//! Light by light, a picture of N lights takes N passes, however few of its pixels each light
//! reaches. [`GatherMany`] takes the [lists](crate::culling::TileLights) of lights that may
//! reach each tile of 4 × 4 pixels and adds the light of all of them in one pass. Every ray
//! asks the lights of its tile, each for its own lit part of the ray, clipped to range and
//! cone. So the cost grows with the number of lights that reach a pixel, not with the number of
//! lights.
//!
//! Based on: Kämpe, Sintorn and Assarsson, Fast, Memory-Efficient Construction of Voxelized
//! Shadows, I3D 2015, section 4, who light the surfaces of a city in this way by 165 spotlights
//! with precomputed shadows; and Olsson, Billeter and Assarsson, Clustered Deferred and Forward
//! Shading, HPG 2012.
//!
//! Departures from the papers: lights are gathered along whole rays through fog and not on
//! surfaces alone; lists have no length limit; and lights are added in their order.
//!
//! # Which methods use it
//!
//! It needs no option. Pairs of every evaluator with no shadows (`none`) or with precomputed
//! shadows (`precomputed`) use it where [lights are culled](crate::culling#in-a-picture). The
//! exception are tables that are made for a frame, because each light has its own. Pairs whose
//! source is made anew for each light in each frame stay light by light. So do those lights of
//! `precomputed` that reach a dynamic caster: they are gathered between the others, in the
//! order of the lights.
//!
//! # What is guaranteed
//!
//! On the CPU the picture has the same bits as by a [`Gather`](crate::Gather) of one light
//! after the other. On a GPU it does not depend on the lists, as long as no light that reaches
//! a ray is left out, because sums are in the order of the lights. It agrees with the CPU as
//! [`gpu`](crate::gpu) says.
//!
//! # On GPUs
//!
//! Lights, their cookies and the lists are in storage buffers, and one dispatch gathers all of
//! them. More than one dispatch is needed
//!
//! * if precomputed shadows do not fit into one binding, which is 128 MiB with the default
//!   limits of WebGPU: each dispatch takes as many lights as fit;
//! * if a ray has so many lights that the loops of an invocation would exceed some 50,000
//!   iterations, after which some drivers end them: each dispatch takes a part of every list.
//!
//! ```
//! use glam::Vec3;
//! use gpu_backend::{Backend, Cpu};
//! use lighting::airlight::EquiAngular;
//! use lighting::culling::{RayTiles, TileLights};
//! use lighting::methods::many_lights::{GatherMany, LitByMany};
//! use lighting::scene::{Camera, Emission, Medium, PhaseFunction};
//! use lighting::visibility::Unshadowed;
//! use lighting::{Emitter, Gather, LitRays, Ray};
//!
//! let camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0)?;
//! let pixel = |i: u32| camera.direction((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5, 64, 32);
//! let rays: Vec<Ray> = (0..64 * 32)
//!     .map(|i| Ray::new(Vec3::ZERO, pixel(i), 20.0).expect("a sound ray"))
//!     .collect();
//! let lamp = |i: u32| {
//!     let at = Vec3::new(0.1 * i as f32 - 5.0, 0.0, -10.0);
//!     Emitter::point(at, Vec3::ONE, 0.5, Emission::Isotropic)
//! };
//! let lamps = (0..100).map(lamp).collect::<Result<Vec<_>, _>>()?;
//! let fog = Medium::new(Vec3::splat(0.1), Vec3::ZERO, PhaseFunction::Isotropic)?;
//!
//! let (cpu, airlight) = (Cpu::new(), EquiAngular::new(4)?);
//! let tiles = RayTiles::new(&cpu, &rays, 64, None).expect("rays from one eye");
//! let lists = TileLights::new(&cpu, &tiles, &lamps)?;
//! let mut together = cpu.zeros::<[f32; 4]>(rays.len())?;
//! let lit = LitByMany::new(&rays, &lamps, &lists, &fog);
//! cpu.gather_many(&lit, &Unshadowed, &airlight, &mut together)?;
//!
//! let mut one_by_one = cpu.zeros::<[f32; 4]>(rays.len())?;
//! for lamp in &lamps {
//!     let lit = LitRays::new(&rays, lamp, &fog);
//!     cpu.gather(&lit, &Unshadowed, &airlight, &mut one_by_one)?;
//! }
//! assert_eq!(together, one_by_one);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "wgpu")]
#[cfg(test)]
mod gpu_tests;
#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
pub(crate) mod tests;

#[cfg(feature = "wgpu")]
pub use gpu::ManyVisibilitySlot;
#[cfg(feature = "methods")]
pub use method::{ManyLights, SourcesTogether, Together};

use gpu_backend::{Backend, Buffer, BufferOf, Cpu, Error, Memory};

use crate::culling::TileLights;
use crate::gather::{Batch, check_lengths, find_parts};
use crate::scene::Medium;
use crate::visibility::Unshadowed;
use crate::{AirlightEvaluator, Emitter, LightPath, Ray, Touching, VisibilitySource, Watch};

/// The rays of a gather of many lights, with the lights and the medium.
#[derive(Debug)]
pub struct LitByMany<'a, M: Memory> {
    /// The rays, in the memory of the backend.
    pub rays: &'a M::Buffer<Ray>,
    /// The lights that the lists refer to.
    pub emitters: &'a [Emitter],
    /// The index that the first of these lights has in the visibility source: 0, unless they
    /// are some of the lights that it knows.
    pub first: usize,
    /// Which of them may reach the rays, by tile.
    pub lists: &'a TileLights<'a>,
    /// The medium that scatters their light.
    pub medium: &'a Medium,
    /// Whether lit parts that touch are joined.
    pub touching: Touching,
    /// Entries of each list that one dispatch takes on a GPU, at least 1. Further dispatches
    /// take the entries after these.
    pub lights_per_dispatch: usize,
    /// Is told of progress, on backends that report any.
    pub watch: &'a dyn Watch,
}

impl<'a, M: Memory> LitByMany<'a, M> {
    /// The rays of a frame; parts that touch are kept apart, and one dispatch takes whole
    /// lists.
    pub fn new(
        rays: &'a M::Buffer<Ray>,
        emitters: &'a [Emitter],
        lists: &'a TileLights<'a>,
        medium: &'a Medium,
    ) -> Self {
        Self {
            rays,
            emitters,
            first: 0,
            lists,
            medium,
            touching: Touching::Apart,
            lights_per_dispatch: usize::MAX,
            watch: &(),
        }
    }
}

/// The step that turns the visibility sources `V` of many lights and an airlight evaluator `A`
/// into an image.
///
/// It is implemented on the CPU for every evaluator with all [`VisibilityOfMany`], and on GPUs
/// for those that bring a shader part.
pub trait GatherMany<V, A>: Backend {
    /// Adds to the first three components of `radiance[i]` the airlight of `lit.rays[i]` from
    /// the lights that its tile lists, in their order; for each light it is what
    /// [`Gather`](crate::Gather) adds.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the number of sums or of rays in tiles is not that of rays,
    /// or if the lists were made for another number of lights; nothing is written then. On a
    /// GPU [`Error::TooLarge`] if lights and cookies, or the lists, do not fit into one
    /// binding.
    fn gather_many(
        &self,
        lit: &LitByMany<'_, Self::Memory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

/// The visibility sources of many lights, on the CPU.
pub trait VisibilityOfMany: Sync {
    /// The source of a light.
    type Source: VisibilitySource;

    /// The source of the light of this index; `None` for an index of no light, which then
    /// lights nothing.
    fn of_light(&self, light: usize) -> Option<&Self::Source>;
}

/// Nothing blocks any light.
impl VisibilityOfMany for Unshadowed {
    type Source = Self;

    fn of_light(&self, _: usize) -> Option<&Self> {
        Some(self)
    }
}

impl<V: VisibilitySource + Send> VisibilityOfMany for Vec<V> {
    type Source = V;

    fn of_light(&self, light: usize) -> Option<&V> {
        self.get(light)
    }
}

fn check<M: Memory>(lit: &LitByMany<'_, M>, radiance: usize) -> Result<(), Error> {
    check_lengths(lit.rays.len(), radiance)?;
    let check = |what, expected, actual| {
        (expected == actual)
            .then_some(())
            .ok_or(Error::LengthMismatch {
                what,
                expected,
                actual,
            })
    };
    check(
        "the rays in tiles",
        lit.rays.len(),
        lit.lists.tiles().rays(),
    )?;
    check(
        "the lights of the lists",
        lit.emitters.len(),
        lit.lists.emitters(),
    )
}

/// Tiles in a unit of work.
const TILES: usize = 4;

impl<V: VisibilityOfMany, A: AirlightEvaluator> GatherMany<V, A> for Cpu {
    fn gather_many(
        &self,
        lit: &LitByMany<'_, Self::Memory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check(lit, radiance.len())?;
        if lit.medium.scatters_nothing() {
            return Ok(());
        }
        let tiles = lit.lists.tiles();
        let before: &[[f32; 4]] = radiance;
        let sums = self.map(tiles.tiles().div_ceil(TILES), |unit| {
            let first = unit * TILES;
            let mut all = Vec::new();
            let mut parts = Vec::new();
            let mut batch = Batch::new(airlight);
            for tile in first..tiles.tiles().min(first + TILES) {
                let rays = tiles.rays_of(tile);
                let place = all.len();
                all.extend(rays.iter().map(|ray| before[*ray as usize]));
                let sums = &mut all[place..];
                for light in lit.lists.of_tile(tile) {
                    let light = *light as usize;
                    let Some(source) = visibility.of_light(lit.first + light) else {
                        continue;
                    };
                    for (i, ray) in rays.iter().enumerate() {
                        let path = &lit.rays[*ray as usize];
                        let Some(path) = LightPath::new(path, &lit.emitters[light], lit.medium)
                        else {
                            continue;
                        };
                        let path = path.with_index(*ray).off_the_light();
                        find_parts(source, &path, lit.touching, &mut parts);
                        batch.path(i, path);
                        batch.lit_parts(&parts, &[], sums);
                    }
                    // A batch must be of a single light.
                    batch.finish(sums);
                }
            }
            lit.watch.gathered(all.len() * lit.emitters.len());
            all
        });
        let units = (0..tiles.tiles()).flat_map(|tile| tiles.rays_of(tile));
        for (ray, sum) in units.zip(sums.into_iter().flatten()) {
            radiance[*ray as usize] = sum;
        }
        Ok(())
    }
}
