//! The light along a bundle of rays.

use std::fmt::{self, Debug};

use glam::Vec3;
use gpu_backend::{Backend, Cpu, Error, Memory};

use crate::scene::Medium;
use crate::visibility::join_touching;
use crate::{AirlightEvaluator, Emitter, EyePanes, Interval, LightPath, Ray, VisibilitySource};

/// What a visibility source and an evaluator are asked about.
#[derive(Debug)]
pub struct LitRays<'a, M: Memory> {
    /// The rays, in the memory of the backend.
    pub rays: &'a M::Buffer<Ray>,
    /// Number of the first of them, from which [`LightPath::index`] counts: 0, but
    /// for parts of a frame that are gathered by themselves.
    pub first: u32,
    /// The light.
    pub emitter: &'a Emitter,
    /// What scatters it.
    pub medium: &'a Medium,
    /// What becomes of lit parts that touch.
    pub touching: Touching,
    /// What covers parts of the rays before their origins, by the number of each ray;
    /// `None` if nothing does.
    pub panes: Option<&'a EyePanes>,
    /// Told of progress, on backends that make any.
    pub watch: &'a dyn Watch,
}

/// Somebody who waits for images.
pub trait Watch: Sync {
    /// The airlight of so many more rays, of one light each, is there.
    fn gathered(&self, _rays: usize) {}

    /// `done` of `total` lights are ready to be gathered; `false` makes a method stop
    /// there.
    fn goes_on(&self, _done: usize, _total: usize) -> bool {
        true
    }
}

/// Nobody.
impl Watch for () {}

impl Debug for dyn Watch + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}

/// What a gather does with lit parts of a ray that touch and are equally visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Touching {
    /// Each is evaluated by itself: right for one sample per step.
    #[default]
    Apart,
    /// They are joined first, see [`join_touching`]: right for evaluators that are
    /// accurate over any length.
    Joined,
}

impl<'a, M: Memory> LitRays<'a, M> {
    /// All rays of a frame, touching parts apart.
    pub fn new(rays: &'a M::Buffer<Ray>, emitter: &'a Emitter, medium: &'a Medium) -> Self {
        Self {
            rays,
            first: 0,
            emitter,
            medium,
            touching: Touching::Apart,
            panes: None,
            watch: &(),
        }
    }

    /// The same with touching parts joined.
    #[must_use]
    pub fn joined(self) -> Self {
        Self {
            touching: Touching::Joined,
            ..self
        }
    }
}

/// The step that turns a visibility source `V` and an airlight evaluator `A`
/// into an image.
///
/// Implemented for the CPU for every pair; a backend with shaders implements
/// it for the sources and evaluators that bring a shader part.
pub trait Gather<V, A>: Backend {
    /// Adds to `radiance[i]` the airlight of `lit.rays[i]` due to one light: the
    /// sum over the lit intervals of the ray of visibility × radiance, as far as
    /// [panes](LitRays::panes) before them let it through. The
    /// fourth component is left alone.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length;
    /// nothing is written then.
    fn gather(
        &self,
        lit: &LitRays<'_, Self::Memory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;
}

/// One sum per ray.
pub(crate) fn check_lengths(rays: usize, radiance: usize) -> Result<(), Error> {
    if rays == radiance {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what: "the radiance buffer",
        expected: rays,
        actual: radiance,
    })
}

impl<V, A> Gather<V, A> for Cpu
where
    V: VisibilitySource,
    A: AirlightEvaluator,
{
    fn gather(
        &self,
        lit: &LitRays<'_, Self::Memory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(lit.rays.len(), radiance.len())?;
        if lit.medium.scatters_nothing() {
            return Ok(());
        }
        self.for_each_chunk(radiance, 64, |first, chunk| {
            let mut parts = Vec::new();
            let rays = chunk.len();
            for (i, sum) in (first..).zip(chunk) {
                let Some(path) = LightPath::new(&lit.rays[i], lit.emitter, lit.medium) else {
                    continue;
                };
                // More rays than a u32 counts do not fit into memory.
                let path = path.with_index(lit.first + i as u32).off_the_light();
                let mut panes = lit.panes.map_or(&[][..], |panes| panes.of(path.index()));
                let mut seen = Vec3::ONE;
                parts.clear();
                visibility.lit_intervals(&path, &mut parts);
                if lit.touching == Touching::Joined {
                    join_touching(&mut parts, 0);
                }
                for part in &parts {
                    let Interval { mut start, end } = part.interval;
                    loop {
                        let mut to = end;
                        while let [next, others @ ..] = panes {
                            if next.from > start {
                                to = to.min(next.from);
                                break;
                            }
                            (seen, panes) = (next.share, others);
                        }
                        let light = airlight.radiance(&path, Interval::new(start, to));
                        let light = seen * (part.visibility * light);
                        for channel in 0..3 {
                            sum[channel] += light[channel];
                        }
                        start = to;
                        if !(start < end) {
                            break;
                        }
                    }
                }
            }
            lit.watch.gathered(rays);
        });
        Ok(())
    }
}
