//! Marching between shadow volumes: a shadow map is asked only where volumes say that
//! there may be a shadow, and what is outside of them is lit in closed form.
//!
//! Based on: Wyman and Ramsey, Interactive Volumetric Shadows in Participating Media with
//! Single-Scattering, RT 2008.
//!
//! A ray is lit before the front of its first shadow volume and behind the back of its last
//! one. Between the two it is divided into N steps of equal length, and the shadow map is
//! asked at the middle of each. Where a lit step is next to a dark one, the part between
//! their middles is halved a few times, so that the ends of runs are within 1/16 of a step
//! of where the map has them. The gather joins what touches, and any evaluator integrates
//! each lit run as one.
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
//! volume in a cell that it crosses within a quarter of a step of the whole ray.
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
//! # Scenes that are mostly dark
//!
//! In a room with a window the spans of shadow volumes are whole rays. Section 5 of the
//! paper proposes the inverse, which is here made of the shadow map ([`LitVolumes`],
//! [`BuildLitVolumes`]): in a cell there is no light behind its farthest texel. A ray is
//! dark before it comes to the first of these volumes and behind the last one. Either kind
//! works alone or with the other: lit before the first volume of shadow, dark before the
//! first one of light, and asked only between. No lit sample of the map is outside of
//! them, as no dark one is outside of those of shadow: in ten million rays each, twenty
//! samples a ray, of lights and eyes inside and outside of casters and of boxes of fog.
//!
//! # What steps are spread over
//!
//! Over the span between the volumes, as in the paper ([`Spread::Span`]), or over the whole
//! ray, up to ten mean free paths to the sky, of which only those in the span are asked
//! about ([`Spread::Ray`]). With the latter the runs are the same with and without volumes,
//! to the last bit on a CPU; with the former short spans of long rays, those to the sky
//! above all, have as many steps as any. How much faster than a march of midpoints either
//! reaches the same error, on a CPU with maps of 1024 texels and 240 × 135 rays; in
//! brackets without the time to make the volumes, which serve all frames (example
//! `equal_error` with Gauss–Legendre of 8 nodes, RMSE relative to the mean, against the runs
//! of the map):
//!
//! | scene | error | steps of rays | steps of spans |
//! |---|---|---|---|
//! | `smoke` | 2 % | 2.6 (3.1) | 2.2 (3.1) |
//! | | 0.5 % | 3.3 (3.8) | 3.3 (3.8) |
//! | `city` | 2 % | 2.2 (3.7) | 2.9 (6.6) |
//! | | 0.5 % | 5.8 (8.1) | 10.3 (18.6) |
//! | `coil` | 2 % | 3.0 (3.6) | 3.4 (4.2) |
//! | | 0.5 % | 9.3 (11.3) | 9.1 (11.5) |
//! | `landscape` | 2 % | 0.4 (1.4) | 0.4 (1.4) |
//! | | 0.5 % | 1.4 (3.8) | 1.5 (3.6) |
//! | `fence` | 5 % | 30 (32) | 51 (56) |
//! | dark room with a window | 2 % | 14 (17) | 15 (16) |
//! | | 0.5 % | 42 (47) | 36 (39) |
//!
//! Two runs of the same differ by up to a tenth, what is made first by more.
//!
//! A third of the rays or more go to the sky in all of these but the room. The lamp is in
//! view in `fence`, where midpoints need thousands of steps. A frame of `landscape` takes a
//! few milliseconds, less than its volumes, which pay over several frames. With the
//! cookie of `textured-spot` nearly all of the time is spent on its texels (`quadrature`):
//! 1.1 at 2 %, 2.3 (2.4) at 0.5 %.
//!
//! # How it departs from the paper besides
//!
//! * After so many steps in a row that are alike the ray looks for the next volume of the
//!   other kind, and leaps.
//! * The paper's first and last borders are exact because polygons are; here all borders
//!   are halved.
//! * Lights with a cookie need no steps for their colours, which an evaluator integrates
//!   ([`Quadrature`](crate::airlight::Quadrature)); [`textured`](super::textured) takes
//!   them, as the paper does.
//! * Scattering at a low resolution is a method around any other, `methods::reduced`.
//!
//! # Casters that count as a texture
//!
//! Between the volumes of leaves, hair or a fence nearly every step has a border of its own,
//! and most shadows are finer than a step. For these section 5 of the paper proposes to
//! treat shadows as a texture. [`FilteredHybrid`] asks what share of each step is lit, in a mip
//! pyramid of moments ([`MomentPyramid`](super::prefiltered::MomentPyramid)), one level
//! finer than the step is long in the picture of the light. Halving finds no
//! borders then, because a border within a step darkens it by its share. The fronts and
//! backs of volumes stay where they are. Errors against the runs of the map, RMSE relative
//! to the mean, with 160 × 90 rays in `fence` and 96 × 54 in `hairball`; `hybrid` and
//! `hybrid-filtered` with Gauss–Legendre of 8 nodes, `exponential-variance` (the same moments
//! in steps of whole rays) with equi-angular samples:
//!
//! | scene | steps | `hybrid` | `hybrid-filtered` | `exponential-variance` |
//! |---|---|---|---|---|
//! | `fence` | 2 | 0.27 | 0.20 | 1.28 |
//! | | 4 | 0.18 | 0.11 | 1.12 |
//! | | 8 | 0.12 | 0.084 | 1.10 |
//! | | 16 | 0.064 | 0.057 | 1.05 |
//! | | 32 | 0.031 | 0.033 | 1.01 |
//! | | 128 | 0.0058 | 0.0097 | 0.55 |
//! | `hairball` | 2 | 2.5 | 1.8 | 1.3 |
//! | | 4 | 2.0 | 1.2 | 1.1 |
//! | | 8 | 1.5 | 1.1 | 0.90 |
//! | | 16 | 1.4 | 1.1 | 1.2 |
//! | | 32 | 1.2 | 0.94 | 1.1 |
//! | | 128 | 0.31 | 0.38 | 0.32 |
//!
//! Shares pay in few steps, up to 16 in these scenes: the error is then a tenth to two
//! fifths less. With more of them moments that are filtered across the ray as well, and
//! light that bleeds, are worse than samples of the map with halved borders. On a CPU a step
//! costs about twice as much in `hairball`: in equal times the errors of 2 and 4 steps are a
//! tenth and a fifth less than those of 4 and 8 steps of `hybrid`. The pyramid takes twice as
//! long to make as the volumes. It is no method for small errors: a frame of `fence` to 2 %
//! takes 2.6 times as long as with `hybrid`. Variance alone has twice the error in 16 steps
//! and more of `fence`; four moments have a tenth less, at twice the time.
//!
//! # Volumes made on a GPU
//!
//! [`ShadowVolumes::new`] makes volumes on the host, where the choice below needs them, and
//! the methods of the list upload them: both backends then look for the same. Where casters
//! or lights move from frame to frame, [`BuildShadowVolumes`] makes them on the device from
//! the triangles that it has for the shadow map: an invocation for each triangle and
//! picture, whose workgroup shares the cells of large ones. Everything is within WebGPU's
//! default limits, and as conservative as on the host: what sums and products may be off by is
//! carried along, and each test is decided in favour of the triangle within that.
//! Triangles are not clipped at the light, because half-spaces and edges of homogeneous
//! corners tell what of them lies in front. Over 64,000 cells of slivers, wires and
//! rooms, seen by lights of all kinds, depths are 1e-4 less on average than the host's, and
//! one cell in a thousand is taken in besides.
//!
//! # Which casters
//!
//! The paper would leave out casters that are far from the viewer. How far a caster is gives no
//! bound on what is then wrong: a low sun throws the shadow of a far hill upon the eye. How
//! far the shadow is does. Where all beyond a distance D counts as lit, a ray is off by no
//! more than the light from there: under a sun e^(−σ D) of what it would have if all of it
//! were lit.
//!
//! That saves nothing here, since volumes that a ray does not come to cost it nothing anyway. For
//! an error of 0.5 %, D is 5.3 mean free paths. It changes no frame of `landscape`. In `city`
//! the steps get shorter, and the error of 16 falls from 1.6 % to 1.4 %, but that of 64
//! rises from 0.26 % to 0.67 %; the times of frames differ by less than those of two runs do.
//! Without the casters of `city` beyond 300 m, which are 2 mean free paths, its volumes are made
//! in 0.6 of the time, once for all frames, and the error of 64 steps rises to 0.45 %;
//! without those beyond 600 m neither changes (measured once). So all casters have volumes.
//!
//! # Which volumes are looked for
//!
//! That is decided for each light before a frame, by some of its rays ([`Choice`]). Volumes
//! of light are considered where the dark steps among those of shadow could pay for them in
//! this frame. What they would do is estimated without a look at the map, which may be in
//! the memory of a GPU: as if casters filled each cell of the volumes of shadow in which
//! there is one. Where steps are so few, or spans so long, that looking for volumes costs more
//! than it saves, all of every ray is marched: more steps of whole rays would then reach the
//! same error in less time. As some of the rays of a frame decide, those of some of its
//! pixels may be divided in another way than all of them.
//!
//! At equal numbers of steps a frame takes longer than that of a march, two to four times
//! as long at 4 to 32 steps of `fence`: the hybrid searches, halves borders and integrates
//! each lit run with several nodes. The errors there are a twentieth to a hundredth of the
//! march's.
//!
//! # Error and cost
//!
//! First order in the length of a step: shadows and gaps shorter than a step may be missed,
//! and converge to the runs of the map ([`MapRuns`](super::epipolar::MapRuns)). A ray looks at
//! ten to twenty cells, each of which costs 1.6 steps, for every light; volumes
//! take up to 0.33 MiB of each kind for each picture of a light. A ray to the sky ends after
//! ten mean free paths, see [`Spacing::Distance`](super::march::Spacing::Distance). Volumes
//! are wider by the roundings of positions within the scene; those of an eye a hundred times
//! as far away as the scene is large are larger, so that a dark or lit step may be missed at
//! an edge.

mod asking;
mod cells;
mod choice;
mod filtered;
#[cfg(feature = "methods")]
#[cfg(test)]
mod frame_tests;
#[cfg(feature = "wgpu")]
pub(crate) mod gpu;
mod lit_volumes;
#[cfg(feature = "methods")]
mod method;
mod picture;
mod search;
mod span;
#[cfg(test)]
mod tests;
mod volumes;
#[cfg(feature = "wgpu")]
pub(crate) mod volumes_gpu;

#[cfg(feature = "methods")]
pub(super) use method::volumes as volumes_of;

use std::borrow::Borrow;
use std::sync::Arc;

use gpu_backend::{Error, Host, Memory};

pub use asking::Volumes;
pub use choice::Choice;
pub use filtered::FilteredHybrid;
pub use lit_volumes::{BuildLitVolumes, LitVolumes};
pub use volumes::{BuildShadowVolumes, ShadowVolumes};

use asking::Asking;
use cells::Cells;

use crate::shadow_map::ShadowMap;
use crate::{LightPath, LitInterval, VisibilitySource};

#[cfg(feature = "methods")]
pub(super) fn methods() -> Vec<crate::methods::Entry> {
    let mut all = method::methods();
    all.extend(filtered::methods());
    all
}

/// How often the part between a lit step and a dark one is halved to find the border.
const HALVINGS: u32 = 3;

/// What the steps of a ray are spread over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spread {
    /// All of the ray, up to ten mean free paths to the sky: steps outside of the volumes
    /// count, and are not asked about.
    Ray,
    /// What lies between the front of the first volume and the back of the last one, as in
    /// the paper: a short span has as many steps as a long one. All of the ray without
    /// volumes.
    #[default]
    Span,
}

/// A march that asks a shadow map only where volumes of shadow and of light leave open
/// whether a ray is lit; the map is borrowed or shared.
///
/// Yields the lit runs of the ray. With steps that are spread over whole rays
/// ([`Spread::Ray`]) they are the same with volumes and without them, to the last bit on a
/// CPU.
#[derive(Debug)]
pub struct Hybrid<P, M: Memory> {
    map: P,
    volumes: Option<Arc<ShadowVolumes<M>>>,
    lit_volumes: Option<Arc<LitVolumes<M>>>,
    steps: u32,
    spread: Spread,
}

/// Makes sure that volumes have the texels per side and the faces of a map.
fn check<M: Memory>(cells: &Cells, map: &ShadowMap<M>) -> Result<(), Error> {
    let (expected, actual) = ((map.resolution(), map.faces().len()), cells.of_map());
    if expected == actual {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what: "the texels per side of a map with volumes, times its faces",
        expected: expected.0 as usize * expected.1,
        actual: actual.0 as usize * actual.1,
    })
}

impl<P: Borrow<ShadowMap<M>>, M: Memory> Hybrid<P, M> {
    /// A march of `steps` steps (0 counts as 1), spread over spans, through the map of a
    /// light, and the light's volumes of shadow; without any volumes all of the ray is
    /// marched.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the volumes go with a map of another size.
    pub fn new(map: P, volumes: Option<Arc<ShadowVolumes<M>>>, steps: u32) -> Result<Self, Error> {
        if let Some(volumes) = &volumes {
            check(&volumes.cells, map.borrow())?;
        }
        Ok(Self {
            map,
            volumes,
            lit_volumes: None,
            steps: steps.max(1),
            spread: Spread::default(),
        })
    }

    /// The same with its steps spread over something else.
    #[must_use]
    pub fn spread_over(self, spread: Spread) -> Self {
        Self { spread, ..self }
    }

    /// The same with volumes of light, outside of which all is dark: those of the same
    /// map.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if they go with a map of another size.
    pub fn with_lit_volumes(mut self, volumes: Arc<LitVolumes<M>>) -> Result<Self, Error> {
        check(&volumes.cells, self.map())?;
        self.lit_volumes = Some(volumes);
        Ok(self)
    }

    /// The map.
    pub fn map(&self) -> &ShadowMap<M> {
        self.map.borrow()
    }

    /// The volumes.
    pub fn volumes(&self) -> Option<&ShadowVolumes<M>> {
        self.volumes.as_deref()
    }

    /// The volumes of light.
    pub fn lit_volumes(&self) -> Option<&LitVolumes<M>> {
        self.lit_volumes.as_deref()
    }

    /// Number of steps.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// What they are spread over.
    pub fn spread(&self) -> Spread {
        self.spread
    }
}

impl<P: Borrow<ShadowMap<Host>>> Hybrid<P, Host> {
    fn asking(&self, path: &LightPath<'_>) -> Asking<'_> {
        let origin = self.map().faces()[0].origin;
        let volumes = Volumes {
            shadow: self.volumes(),
            light: self.lit_volumes(),
        };
        Asking::new(path, origin, volumes, (self.steps, self.spread))
    }

    /// The number of steps for which the map is asked; what all others are is known.
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
            let [mut before, mut after] = [steps.before(number), steps.middle(number)];
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
        let (mut lit_from, mut was_lit) = (whole.start, asking.is_lit_before());
        while let Some((number, now_lit)) = asking.next(is_lit) {
            // There is no border where the ray begins.
            if now_lit != was_lit && asking.is_anything_before(number) {
                let at = border(number, was_lit);
                if was_lit {
                    put(lit_from, at);
                } else {
                    lit_from = at;
                }
            }
            was_lit = now_lit;
        }
        // What ends with the last volume has a border, too.
        if let Some((number, is_lit)) = asking.behind()
            && is_lit != was_lit
        {
            if asking.is_anything_before(number) {
                let at = border(number, was_lit);
                if was_lit {
                    put(lit_from, at);
                } else {
                    lit_from = at;
                }
            }
            was_lit = is_lit;
        }
        if was_lit {
            put(lit_from, whole.end);
        }
    }
}
