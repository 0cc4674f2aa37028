//! Marching between shadow volumes: the shadow map is asked only where the volumes say that
//! there may be a shadow, and everything outside of them is lit, which needs no steps.
//!
//! Based on: Wyman and Ramsey, Interactive Volumetric Shadows in Participating Media with
//! Single-Scattering, RT 2008.
//!
//! A ray is lit in front of its first shadow volume and behind its last one. Between the two it
//! is divided into N steps of equal length, and the shadow map is asked at the middle of each.
//! Where a lit step is next to a dark one, the interval between their middles is halved a few
//! times, so that the ends of runs are within 1/16 of a step of where the map has them. The
//! gather joins parts that touch, and any evaluator integrates each lit run as a whole.
//!
//! # Which volumes
//!
//! The paper extrudes the silhouettes of the casters and rasterises them from the eye in each
//! frame, at a cost that grows with the number of triangles; and silhouettes need closed
//! meshes. Here coarse stand-ins are extruded, as section 3.3 of the paper suggests, and in the
//! pictures of the light instead of the eye's ([`ShadowVolumes`]). A cell of eight texels, or
//! of any larger power of two, counts as a caster at the smallest distance of anything in it,
//! and its volume is the part of the cell behind that. A ray passes through these cells from
//! both of its ends, by large cells as long as it is in front of them, until it enters a volume
//! in a cell that it crosses within a quarter of a step of the whole ray.
//!
//! * The volumes depend on light and casters alone, and not on the view. They are made once, on
//!   the CPU for either backend, in less time than the shadow map takes.
//! * They are conservative. A triangle counts in every cell that it touches or comes within a
//!   texel of, at no more than its smallest distance there. So no shadow is outside of them,
//!   neither one of the map nor an exact one; rounding is allowed for.
//! * Open meshes, eyes and lights inside of casters, near planes, and volumes that leave the
//!   picture need no special cases, because fronts and backs are not counted.
//! * Rays are independent of each other: no raster of the eye's has to be dilated, and rays may
//!   belong to any pixels.
//! * Casters whose volumes cannot reach a ray cost it nothing.
//!
//! # Scenes that are mostly dark
//!
//! In a room with a window, the spans of shadow volumes are whole rays. Section 5 of the paper
//! proposes the inverse, which is made of the shadow map here ([`LitVolumes`],
//! [`BuildLitVolumes`]): in a cell there is no light behind its farthest texel. A ray is dark
//! in front of the first of these volumes and behind the last one. Either kind of volumes works
//! alone or with the other: a ray is lit in front of the first volume of shadow, dark in front
//! of the first volume of light, and the map is asked only between. No lit sample of the map is
//! outside of lit volumes, and no dark one outside of shadow volumes: this was tested with ten
//! million rays each and twenty samples per ray, for lights and eyes inside and outside of
//! casters and of boxes of fog.
//!
//! # What steps are spread over
//!
//! They are spread over the span between the volumes, as in the paper ([`Spread::Span`]), or
//! over the whole ray, up to ten mean free paths to the sky, of which only the steps in the
//! span ask the map ([`Spread::Ray`]). With the latter, runs are the same with and without
//! volumes, bit for bit on a CPU. With the former, a short span of a long ray, for example to
//! the sky, has as many steps as any other. The table shows how much faster than a march with
//! midpoints either reaches the same error, on a CPU with maps of 1024 texels and 240 × 135
//! rays. Numbers in brackets leave out the time to make the volumes, which serve all frames
//! (`lighting/examples/equal_error.rs` in the repository, with Gauss–Legendre of 8 nodes; RMSE
//! relative to the mean, against the runs of the map):
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
//! Two runs of the same measurement differ by up to a tenth, and more in the time to make
//! volumes.
//!
//! A third of the rays or more go to the sky in all of these scenes except the room. In `fence`
//! the lamp is in view, for which midpoints need thousands of steps. A frame of `landscape`
//! takes a few milliseconds, which is less than its volumes take; they pay off over several
//! frames. With the cookie of `textured-spot`, nearly all of the time is spent on its texels
//! (`quadrature`): the factors are 1.1 at 2 %, and 2.3 (2.4) at 0.5 %.
//!
//! # Further departures from the paper
//!
//! * After a number of steps in a row with the same result, the ray looks for the next volume
//!   of the other kind, and leaps there.
//! * The paper's first and last borders are exact because its volumes are polygons. Here all
//!   borders are found by halving.
//! * Lights with a cookie need no steps for their colours, because an evaluator integrates them
//!   ([`Quadrature`](crate::airlight::Quadrature)). [`textured`](super::textured) takes steps
//!   for them, as the paper does.
//! * Scattering at a low resolution is a method around any other, `methods::reduced`.
//!
//! # Casters that count as a texture
//!
//! Between the volumes of leaves, hair or a fence, nearly every step has a border of its own,
//! and most shadows are finer than a step. For these section 5 of the paper proposes to treat
//! shadows as a texture. [`FilteredHybrid`] asks which share of each step is lit, in a mip
//! pyramid of moments ([`MomentPyramid`](super::prefiltered::MomentPyramid)), at a level one
//! finer than the step is long in the picture of the light. Halving is not used then, because a
//! border within a step darkens the step by its share. The fronts and backs of volumes stay
//! where they are. The table has errors against the runs of the map, RMSE relative to the mean,
//! with 160 × 90 rays in `fence` and 96 × 54 in `hairball`; `hybrid` and `hybrid-filtered` with
//! Gauss–Legendre of 8 nodes, and `exponential-variance` (the same moments in steps of whole
//! rays) with equi-angular samples:
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
//! Shares are worth it with few steps, up to 16 in these scenes: the error is then a tenth to
//! two fifths less. With more steps they are worse than samples of the map with halved borders,
//! because moments are filtered across the ray as well and leak light. On a CPU a step costs
//! about twice as much in `hairball`; in equal times, the errors of 2 and 4 steps are a tenth
//! and a fifth less than those of 4 and 8 steps of `hybrid`. The pyramid takes twice as long to
//! make as the volumes. The method is not suited to small errors: a frame of `fence` with an
//! error of 2 % takes 2.6 times as long as with `hybrid`. Variance alone has twice the error
//! with 16 steps or more of `fence`; four moments have a tenth less, at twice the time.
//!
//! # Volumes made on a GPU
//!
//! [`ShadowVolumes::new`] makes volumes on the host, where the choice below needs them. The
//! methods in the list upload them, so that both backends search the same volumes. If casters
//! or lights move from frame to frame, [`BuildShadowVolumes`] makes them on the device from the
//! triangles that it has for the shadow map. It uses one invocation for each triangle and
//! picture, and a workgroup shares the cells of large triangles. Everything is within WebGPU's
//! default limits, and as conservative as on the host: error bounds of sums and products are
//! carried along, and each test within them is decided in favour of the triangle. Triangles are
//! not clipped at the light, because half-spaces and edges of homogeneous corners tell which
//! part of them lies in front of it. Over 64,000 cells of slivers, wires and rooms, seen by
//! lights of all kinds, depths are 1e-4 smaller on average than the host's, and one cell in a
//! thousand is included in addition.
//!
//! # Which casters have volumes
//!
//! The paper would leave out casters that are far from the viewer. The distance of a caster
//! does not bound the error: a low sun throws the shadow of a distant hill onto the eye. The
//! distance of the shadow does. If everything beyond a distance D counts as lit, the error of a
//! ray is at most the light from there: under a sun e^(−σ D) of the light of the ray if all of
//! it were lit.
//!
//! This saves nothing here, because volumes that a ray does not reach cost it nothing. For an
//! error of 0.5 %, D is 5.3 mean free paths. It changes no frame of `landscape`. In `city` the
//! steps become shorter, and the error with 16 steps falls from 1.6 % to 1.4 %, but that with
//! 64 steps rises from 0.26 % to 0.67 %; the times of frames differ by less than those of two
//! runs. Without the casters of `city` beyond 300 m, which are 2 mean free paths, its volumes
//! are made in 0.6 of the time, once for all frames, and the error of 64 steps rises to 0.45 %.
//! Without those beyond 600 m neither changes (measured once). So all casters have volumes.
//!
//! # Which kinds of volumes are searched
//!
//! This is decided for each light before a frame, from some of its rays ([`Choice`]). Lit
//! volumes are considered if avoiding dark steps among those in shadow volumes could pay for
//! making them in this frame. Their effect is estimated without looking at the map, which may
//! be in the memory of a GPU, by assuming that casters fill each cell of the shadow volumes
//! that contains one. If steps are so few, or spans so long, that searching volumes costs more
//! than it saves, the whole of every ray is marched, since more steps of whole rays would then
//! reach the same error in less time. As some of the rays of a frame decide, a frame with some
//! of the pixels may divide its rays differently from a frame with all of them.
//!
//! With equal numbers of steps a frame takes longer than that of a march, two to four times as
//! long with 4 to 32 steps in `fence`: the hybrid searches, halves borders, and integrates each
//! lit run with several nodes. The errors there are a twentieth to a hundredth of the march's.
//!
//! # Error and cost
//!
//! The error is of first order in the length of a step. Shadows and gaps shorter than a step
//! may be missed; the result converges to the runs of the map
//! ([`MapRuns`](super::epipolar::MapRuns)). A ray visits ten to twenty cells for every light,
//! each of which costs as much as 1.6 steps. Each kind of volumes takes up to 0.33 MiB for each
//! picture of a light. A ray to the sky ends after ten mean free paths, see
//! [`Spacing::Distance`](super::march::Spacing::Distance). Volumes are widened by the rounding
//! of positions within the scene. For an eye a hundred times as far away as the scene is large,
//! rounding is larger than that, so that a dark or lit step may be missed at an edge.

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

/// How many times the interval between a lit step and a dark one is halved to find the border.
const HALVINGS: u32 = 3;

/// The part of a ray over which its steps are spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spread {
    /// The whole ray, up to ten mean free paths to the sky. Steps outside of the volumes count,
    /// but do not ask the map.
    Ray,
    /// The part between the front of the first volume and the back of the last one, as in the
    /// paper; a short span has as many steps as a long one. Without volumes, the whole ray.
    #[default]
    Span,
}

/// A march that asks a shadow map only where volumes of shadow and of light leave open whether
/// a ray is lit. The map is borrowed or shared.
///
/// It yields the lit runs of the ray. If steps are spread over whole rays ([`Spread::Ray`]),
/// the runs are the same with and without volumes, bit for bit on a CPU.
#[derive(Debug)]
pub struct Hybrid<P, M: Memory> {
    map: P,
    volumes: Option<Arc<ShadowVolumes<M>>>,
    lit_volumes: Option<Arc<LitVolumes<M>>>,
    steps: u32,
    spread: Spread,
}

/// Checks that volumes have the texels per side and the faces of a map.
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
    /// A march of `steps` steps (0 counts as 1), spread over spans, through the map of a light
    /// and the light's shadow volumes. Without volumes, the whole of every ray is marched.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the volumes belong to a map of another size.
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

    /// The same march with its steps spread over another part of a ray.
    #[must_use]
    pub fn spread_over(self, spread: Spread) -> Self {
        Self { spread, ..self }
    }

    /// The same march with the lit volumes of the same map, outside of which everything is
    /// dark.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if they belong to a map of another size.
    pub fn with_lit_volumes(mut self, volumes: Arc<LitVolumes<M>>) -> Result<Self, Error> {
        check(&volumes.cells, self.map())?;
        self.lit_volumes = Some(volumes);
        Ok(self)
    }

    /// The map.
    pub fn map(&self) -> &ShadowMap<M> {
        self.map.borrow()
    }

    /// The shadow volumes.
    pub fn volumes(&self) -> Option<&ShadowVolumes<M>> {
        self.volumes.as_deref()
    }

    /// The lit volumes.
    pub fn lit_volumes(&self) -> Option<&LitVolumes<M>> {
        self.lit_volumes.as_deref()
    }

    /// Number of steps.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// The part of a ray over which steps are spread.
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

    /// The number of steps that ask the map; the volumes decide about all others.
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
            // There is no border at the start of the ray.
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
        // A run that ends with the last volume has a border, too.
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
