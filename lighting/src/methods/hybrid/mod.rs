//! Marching between shadow volumes: a shadow map is asked only where volumes say that
//! there may be a shadow, and what is outside of them is lit in closed form.
//!
//! Based on: Wyman and Ramsey, Interactive Volumetric Shadows in Participating Media with
//! Single-Scattering, RT 2008.
//!
//! A ray is divided into steps of equal length. Those before the front of its first shadow
//! volume and behind the back of its last one are lit, whatever their number; between
//! the two the shadow map is asked at the middle of each step. Where a lit step is next to
//! a dark one, the part between their middles is halved a few times, so that the ends of
//! runs are within 1/16 of a step of where the map has them. The gather joins what
//! touches, and any evaluator integrates each lit run as one.
//!
//! # Which volumes
//!
//! The paper extrudes the silhouettes of the casters and rasterises them from the eye, in
//! each frame anew, at a cost that grows with the triangles; and silhouettes need closed
//! meshes. Here coarse stand-ins are extruded, as section 3.3 of the paper suggests, in the
//! pictures of the light instead of the eye's ([`ShadowVolumes`]): a cell of eight texels,
//! or of any larger power of two, is a caster at the least distance of anything in it, and
//! its volume is what of the cell lies behind. Each ray goes through these cells from both
//! of its ends, by large cells as long as it is in front of them, until it comes to a
//! volume in a cell that it crosses within a step.
//!
//! * The volumes depend on light and casters alone, not on the view: they are made once,
//!   on the CPU for either backend, in less time than the shadow map.
//! * They are conservative. A triangle counts in every cell that it touches, or comes
//!   within a texel of, and with no more than its least distance there. So no
//!   shadow is outside of them, neither the map's nor an exact one, and roundings are
//!   provided for.
//! * Open meshes, eyes and lights inside of casters, near planes and volumes that leave
//!   the picture are no special cases: there is no count of fronts and backs.
//! * Every ray is by itself: no raster of the eye's has to be dilated, and rays may be
//!   those of any pixels.
//! * Casters whose volumes cannot reach a ray cost it nothing.
//!
//! # How it departs from the paper besides
//!
//! * Steps belong to the whole ray, not to the span, and their number is the quality. So the
//!   picture is the same with volumes and without: they only say what need not be asked.
//!   The paper spreads as many steps over a short span as over a long one, which is better
//!   for short spans of long rays, those to the sky above all. Its first and last borders
//!   are exact because polygons are; here all borders are halved.
//! * After so many lit steps in a row the ray looks for the next volume, and leaps.
//! * The inverse, volumes of light in scenes that are mostly dark, is left out, and so are
//!   casters that count as a texture.
//! * Lights with a cookie need no steps for their colours, which an evaluator integrates
//!   ([`Quadrature`](crate::airlight::Quadrature)).
//! * Scattering at a low resolution is a method around any other, `methods::reduced`.
//!
//! # When not
//!
//! Where spans are nearly whole rays, or steps are few, looking for volumes costs more
//! than it saves. That is decided for each light before a frame, by some of its rays
//! ([`Choice`]): then all of every ray is marched.
//!
//! # Error and cost
//!
//! First order in the length of a step: shadows and gaps shorter than a step may be missed,
//! and converge to the runs of the map ([`MapRuns`](super::epipolar::MapRuns)). A ray looks at
//! ten to twenty cells, each of which costs 1.6 steps, for every light; volumes
//! take up to 0.33 MiB for each picture of a light. A ray to the sky ends after ten mean free
//! paths, see [`Spacing::Distance`](super::march::Spacing::Distance). Volumes are wider by
//! the roundings of positions within the scene; those of an eye a hundred times as far away
//! as the scene is large are larger, so that a dark step may be missed at an edge.

mod asking;
mod choice;
#[cfg(feature = "methods")]
#[cfg(test)]
mod frame_tests;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
#[cfg(feature = "methods")]
mod method;
mod picture;
mod search;
mod span;
#[cfg(test)]
mod tests;
mod volumes;

#[cfg(feature = "methods")]
pub(super) use method::{methods, volumes as volumes_of};

use std::borrow::Borrow;
use std::sync::Arc;

use gpu_backend::{Error, Host, Memory};

pub use choice::Choice;
pub use volumes::ShadowVolumes;

use asking::Asking;

use crate::shadow_map::ShadowMap;
use crate::{LightPath, LitInterval, VisibilitySource};

/// How often the part between a lit step and a dark one is halved to find the border.
const HALVINGS: u32 = 3;

/// A march that asks a shadow map only where a ray is in shadow volumes; the map is
/// borrowed or shared.
///
/// Yields the lit runs of the ray. It is the same with volumes and without them, to the
/// last bit on a CPU.
#[derive(Debug)]
pub struct Hybrid<P, M: Memory> {
    map: P,
    volumes: Option<Arc<ShadowVolumes<M>>>,
    steps: u32,
}

impl<P: Borrow<ShadowMap<M>>, M: Memory> Hybrid<P, M> {
    /// A march of `steps` steps for a whole ray (0 counts as 1) through the map of a
    /// light, and the light's volumes; without any all of the ray is marched.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the volumes go with a map of another size.
    pub fn new(map: P, volumes: Option<Arc<ShadowVolumes<M>>>, steps: u32) -> Result<Self, Error> {
        let of_map = |map: &ShadowMap<M>| (map.resolution(), map.faces().len());
        if let Some(volumes) = &volumes {
            let (expected, actual) = (of_map(map.borrow()), volumes.size());
            if expected != actual {
                return Err(Error::LengthMismatch {
                    what: "the texels per side of a map with shadow volumes",
                    expected: expected.0 as usize * expected.1,
                    actual: actual.0 as usize * actual.1,
                });
            }
        }
        Ok(Self {
            map,
            volumes,
            steps: steps.max(1),
        })
    }

    /// The map.
    pub fn map(&self) -> &ShadowMap<M> {
        self.map.borrow()
    }

    /// The volumes.
    pub fn volumes(&self) -> Option<&ShadowVolumes<M>> {
        self.volumes.as_deref()
    }

    /// Number of steps of a whole ray.
    pub fn steps(&self) -> u32 {
        self.steps
    }
}

impl<P: Borrow<ShadowMap<Host>>> Hybrid<P, Host> {
    fn asking(&self, path: &LightPath<'_>) -> Asking<'_> {
        let origin = self.map().faces()[0].origin;
        Asking::new(path, origin, self.volumes(), self.steps)
    }

    /// The number of steps for which the map is asked; all others are lit.
    pub fn asked(&self, path: &LightPath<'_>) -> u32 {
        let map = self.map();
        let mut asking = self.asking(path);
        let mut asked = 0;
        while asking.next(|x| map.is_lit(path.ray().at(x))).is_some() {
            asked += 1;
        }
        asked
    }
}

impl<P: Borrow<ShadowMap<Host>> + Sync> VisibilitySource for Hybrid<P, Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let map = self.map();
        let is_lit = |x: f32| map.is_lit(path.ray().at(x));
        let mut asking = self.asking(path);
        let (steps, whole) = (asking.steps, asking.whole());
        let border = |number: u32, was_lit: bool| {
            let [mut before, mut after] = [number - 1, number].map(|i| steps.middle(i));
            for _ in 0..HALVINGS {
                let x = 0.5 * (before + after);
                if is_lit(x) == was_lit {
                    before = x;
                } else {
                    after = x;
                }
            }
            0.5 * (before + after)
        };
        let mut put = |start: f32, end: f32| {
            if start < end {
                lit.push(LitInterval::unshadowed(start, end));
            }
        };
        let (mut lit_from, mut was_lit) = (whole.start, true);
        while let Some((number, now_lit)) = asking.next(is_lit) {
            // A ray that begins in shadow has no border there.
            if now_lit != was_lit && number > 0 {
                let at = border(number, was_lit);
                if was_lit {
                    put(lit_from, at);
                } else {
                    lit_from = at;
                }
            }
            was_lit = now_lit;
        }
        // A shadow that ends with the last volume has a border, too.
        if !was_lit && asking.end() < self.steps {
            lit_from = border(asking.end(), false);
            was_lit = true;
        }
        if was_lit {
            put(lit_from, whole.end);
        }
    }
}
