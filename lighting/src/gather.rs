//! The light along a bundle of rays.

use std::fmt::{self, Debug};

use glam::Vec3;
use gpu_backend::{Backend, Cpu, Error, Host, Memory};

use crate::eye_panes::Behind;
use crate::scene::Medium;
use crate::visibility::{Share, join_touching};
use crate::{
    AirlightEvaluator, Emitter, EyePanes, Interval, LightPath, LitInterval, Ray, VisibilitySource,
};

/// Some drivers end an invocation after 65535 iterations, counted over all of its loops. This
/// leaves a quarter of them for loops that are not counted.
#[cfg(feature = "shadow-map")]
pub(crate) const MOST_TURNS: f64 = 0.75 * 65_535.0;

/// The rays of a gather, and the light and the medium along them.
#[derive(Debug)]
pub struct LitRays<'a, M: Memory> {
    /// The rays, in the memory of the backend.
    pub rays: &'a M::Buffer<Ray>,
    /// The number of the first ray, from which [`LightPath::index`] counts: 0, unless a part of
    /// a frame is gathered by itself.
    pub first: u32,
    /// The light.
    pub emitter: &'a Emitter,
    /// The medium that scatters the light.
    pub medium: &'a Medium,
    /// Whether lit parts that touch are joined.
    pub touching: Touching,
    /// The see-through surfaces and the hair in front of the ends of the rays, by the number of
    /// each ray; `None` if there are none.
    pub panes: Option<&'a EyePanes>,
    /// Is told of progress, on backends that report any.
    pub watch: &'a dyn Watch,
}

/// Follows the progress of an image, and can stop it.
pub trait Watch: Sync {
    /// The airlight of so many more rays, from one light each, has been gathered.
    fn gathered(&self, _rays: usize) {}

    /// Something is done in another way than was asked for: a sentence without a stop, which
    /// may come more than once.
    fn told(&self, _what: &str) {}

    /// Is asked when `done` of `total` lights have been gathered; `false` stops the method.
    fn goes_on(&self, _done: usize, _total: usize) -> bool {
        true
    }
}

/// Follows nothing and stops nothing.
impl Watch for () {}

impl Debug for dyn Watch + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}

/// What a gather does with lit parts of a ray that touch and are equally visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Touching {
    /// It evaluates each by itself, which is right for one sample per step.
    #[default]
    Apart,
    /// It joins them first (see [`join_touching`]), which is right for evaluators that are
    /// accurate over any length.
    Joined,
}

impl<'a, M: Memory> LitRays<'a, M> {
    /// All rays of a frame; parts that touch are kept apart.
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

    /// The same rays; parts that touch are joined.
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
    /// Adds to the first three components of `radiance[i]` the airlight of `lit.rays[i]` due to
    /// one light: the sum over the lit intervals of the ray of visibility × radiance, times
    /// what the [panes](LitRays::panes) in front let through.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length; nothing is written
    /// then.
    fn gather(
        &self,
        lit: &LitRays<'_, Self::Memory>,
        visibility: &V,
        airlight: &A,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;
}

/// Checks that there is one sum for each ray.
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

/// Rays that one thread gathers at a time.
pub(crate) const RAYS: usize = 64;

/// Replaces the contents of a list by the lit parts of a path.
pub(crate) fn find_parts<V: VisibilitySource>(
    visibility: &V,
    path: &LightPath<'_>,
    touching: Touching,
    parts: &mut Vec<LitInterval<V::Share>>,
) {
    parts.clear();
    visibility.lit_intervals(path, parts);
    if touching == Touching::Joined {
        join_touching(parts, 0);
    }
}

/// Collects lit parts of the rays of a chunk, so that their light is computed together.
pub(crate) struct Batch<'a, A> {
    airlight: &'a A,
    /// For each path, the number of its ray in the chunk.
    rays: Vec<usize>,
    paths: Vec<LightPath<'a>>,
    parts: Vec<(usize, Interval)>,
    shares: Vec<Vec3>,
    radiances: Vec<Vec3>,
}

impl<'a, A: AirlightEvaluator> Batch<'a, A> {
    /// Parts that are computed together, at most: enough to fill vectors, and few enough to
    /// stay in the fastest cache.
    const MOST: usize = 64;

    pub(crate) fn new(airlight: &'a A) -> Self {
        Self {
            airlight,
            rays: Vec::with_capacity(RAYS),
            paths: Vec::with_capacity(RAYS),
            parts: Vec::with_capacity(Self::MOST),
            shares: Vec::with_capacity(Self::MOST),
            radiances: Vec::with_capacity(Self::MOST),
        }
    }

    /// Begins a path, along the ray of this number in the chunk: the parts that follow belong
    /// to it. All paths between two calls of [`Batch::finish`] must be of the same light.
    pub(crate) fn path(&mut self, ray: usize, path: LightPath<'a>) {
        self.rays.push(ray);
        self.paths.push(path);
    }

    /// Adds a part and the share of the light that reaches it.
    pub(crate) fn part(&mut self, part: Interval, share: Vec3, sums: &mut [[f32; 4]]) {
        self.parts.push((self.paths.len() - 1, part));
        self.shares.push(share);
        if self.parts.len() >= Self::MOST {
            self.add(sums);
        }
    }

    /// Adds lit parts of the last path, and cuts them where the ray meets one of the panes.
    pub(crate) fn lit_parts<S: Share>(
        &mut self,
        parts: &[LitInterval<S>],
        mut panes: &[Behind],
        sums: &mut [[f32; 4]],
    ) {
        let mut seen = Vec3::ONE;
        for part in parts {
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
                let share = part.visibility * seen;
                self.part(Interval::new(start, to), share, sums);
                start = to;
                if !(start < end) {
                    break;
                }
            }
        }
    }

    /// Adds the light of the collected parts to the sums, in the order in which they came.
    fn add(&mut self, sums: &mut [[f32; 4]]) {
        self.radiances.clear();
        self.airlight
            .radiances(&self.paths, &self.parts, &mut self.radiances);
        let lights = self.parts.iter().zip(&self.shares).zip(&self.radiances);
        for (((path, _), share), radiance) in lights {
            let light = *share * *radiance;
            for (sum, light) in sums[self.rays[*path]].iter_mut().zip(light.to_array()) {
                *sum += light;
            }
        }
        self.parts.clear();
        self.shares.clear();
    }

    /// Adds the light of the remaining parts to the sums. The paths may be dropped then.
    pub(crate) fn finish(&mut self, sums: &mut [[f32; 4]]) {
        self.add(sums);
        self.rays.clear();
        self.paths.clear();
    }
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
        let order = visibility.neighbours(lit.rays, lit.emitter);
        in_bundles(self, order.as_deref(), radiance, |rays, sums| {
            gather_together(lit, rays, visibility, airlight, sums);
        });
        Ok(())
    }
}

/// Calls `gather` for bundles of rays, with their numbers and the sums to which it adds: rays that
/// are next to each other in this order, or in that of their numbers.
pub(crate) fn in_bundles(
    cpu: &Cpu,
    order: Option<&[u32]>,
    radiance: &mut [[f32; 4]],
    gather: impl Fn(&[u32], &mut [[f32; 4]]) + Sync,
) {
    let Some(order) = order else {
        return cpu.for_each_chunk(radiance, RAYS, |first, chunk| {
            // Memory holds no more rays than a u32 counts.
            let rays: Vec<u32> = (first as u32..(first + chunk.len()) as u32).collect();
            gather(&rays, chunk);
        });
    };
    let before: &[[f32; 4]] = radiance;
    let sums = cpu.map(order.len().div_ceil(RAYS), |unit| {
        let first = unit * RAYS;
        let rays = &order[first..order.len().min(first + RAYS)];
        let mut sums: Vec<[f32; 4]> = rays.iter().map(|ray| before[*ray as usize]).collect();
        gather(rays, &mut sums);
        sums
    });
    for (ray, sum) in order.iter().zip(sums.into_iter().flatten()) {
        radiance[*ray as usize] = sum;
    }
}

/// Adds the light of rays, given by their numbers, to one sum for each. The source is asked about
/// all of them together.
fn gather_together<V: VisibilitySource, A: AirlightEvaluator>(
    lit: &LitRays<'_, Host>,
    rays: &[u32],
    visibility: &V,
    airlight: &A,
    sums: &mut [[f32; 4]],
) {
    let mut numbers = Vec::with_capacity(sums.len());
    let mut paths = Vec::with_capacity(sums.len());
    for (number, ray) in rays.iter().enumerate() {
        let path = LightPath::new(&lit.rays[*ray as usize], lit.emitter, lit.medium);
        if let Some(path) = path {
            numbers.push(number);
            paths.push(path.with_index(lit.first + ray).off_the_light());
        }
    }
    let mut batch = Batch::new(airlight);
    visibility.lit_of_neighbours(&paths, &mut |index, parts| {
        if lit.touching == Touching::Joined {
            join_touching(parts, 0);
        }
        let path = paths[index];
        let panes = lit.panes.map_or(&[][..], |panes| panes.of(path.index()));
        batch.path(numbers[index], path);
        batch.lit_parts(parts, panes, sums);
    });
    batch.finish(sums);
    lit.watch.gathered(sums.len());
}
