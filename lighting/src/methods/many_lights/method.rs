//! Pairs that gather all lights of a frame in one pass.

use std::fmt::Debug;
use std::ops::Range;

use gpu_backend::{Backend, BufferOf, Cpu};

use super::{GatherMany, LitByMany};
use crate::culling::{PickPixels, RayTiles, TileLights, TooManyLights};
use crate::gather::MOST_TURNS;
use crate::methods::per_light::{Culled, is_culled, ray_tiles};
use crate::methods::{
    Evaluators, Frame, FrameInputs, Method, MethodError, PerLight, RunOn, SourceOn, Wraps,
};
use crate::scene::Emission;
use crate::{Emitter, Gather};

/// A kind of visibility source that can answer for many lights at once.
///
/// The evaluator gets its lights [unchanged](crate::methods::LightSources::evaluated).
pub trait SourcesTogether<B: Backend>: SourceOn<B> {
    /// The source of several lights.
    type Together;

    /// Puts into the store those things that [`SourcesTogether::together`] needs for a light
    /// and that take long to make.
    ///
    /// # Errors
    /// [`MethodError`].
    fn prepare_light(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        quality: u32,
    ) -> Result<(), MethodError>;

    /// The sources of all lights of the frame, in the order of the lights, in as few groups as
    /// hold them.
    ///
    /// # Errors
    /// [`MethodError`].
    fn together(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
    ) -> Result<Vec<Together<Self::Together>>, MethodError>;

    /// Whether a light is gathered by itself, from [`SourceOn::source`], because the source of
    /// many lights does not know all of its shadows.
    fn is_apart(&self, _inputs: &FrameInputs<'_>, _light: usize) -> bool {
        false
    }

    /// Roughly how many loop iterations the shader of a source takes for a ray and a light.
    fn turns(source: &Self::Together) -> f64;
}

/// The source of several consecutive lights.
#[derive(Debug, Clone)]
pub struct Together<T> {
    /// The source, in which the lights are numbered from 0.
    pub source: T,
    /// Number of lights.
    pub lights: usize,
}

/// A pair that gathers all lights of a frame in one pass where lights are culled, and one after
/// the other elsewhere. Its name and its picture are those of the [`PerLight`] of the pair.
#[derive(Debug, Clone)]
pub struct ManyLights<S, E>(PerLight<S, E>);

impl<S, E> ManyLights<S, E> {
    /// Makes it of a pair that gathers light by light.
    pub fn new(pair: PerLight<S, E>) -> Self {
        Self(pair)
    }
}

/// Loop iterations before a shader evaluates anything of a ray and a light: for the entry into
/// the cone, and for the kinks.
const TURNS_OF_PATH: f64 = 64.0;

/// The largest number of parts into which kinks divide a lit part.
const PARTS: f64 = 6.0;

/// The largest number of cookie texels in one table, mip levels included. They are half of what
/// a GPU with the default limits of WebGPU binds at once.
const MOST_TEXELS: usize = 1 << 22;

/// Number of texels of a light's cookie with its mip levels; 0 without a cookie.
fn texels(emitter: &Emitter) -> usize {
    let Emitter::Point(point) = emitter else {
        return 0;
    };
    let Emission::Spot(spot) = point.emission() else {
        return 0;
    };
    let levels = spot.texture().into_iter().chain(spot.mip_levels());
    levels.map(|level| level.texels().len()).sum()
}

/// The lists of as many lights, from the first on, as fit.
fn lists<'t>(
    tiles: &'t RayTiles,
    emitters: &[Emitter],
) -> Result<(TileLights<'t>, usize), TooManyLights> {
    let mut all = 0;
    let fits = emitters.iter().take_while(|emitter| {
        all += texels(emitter);
        all <= MOST_TEXELS
    });
    let mut count = fits.count().max(1).min(emitters.len());
    loop {
        match TileLights::new(&Cpu::new(), tiles, &emitters[..count]) {
            Ok(lists) => return Ok((lists, count)),
            Err(_) if count > 1 => count /= 2,
            Err(error) => return Err(error),
        }
    }
}

impl<S, E: Evaluators> ManyLights<S, E>
where
    PerLight<S, E>: Method,
{
    /// Whether the lights of a frame are gathered in one pass.
    fn is_at_once(&self, inputs: &FrameInputs<'_>) -> Result<bool, MethodError> {
        Ok(!E::IS_OF_LIGHT && !inputs.is_covered()? && is_culled(inputs))
    }
}

impl<S, E> Wraps for ManyLights<S, E>
where
    S: Send + Sync + Debug,
    E: Send + Sync + Debug,
    PerLight<S, E>: Method,
{
    type Wrapped = PerLight<S, E>;

    fn wrapped(&self) -> &PerLight<S, E> {
        &self.0
    }
}

impl<B, S, E> RunOn<B> for ManyLights<S, E>
where
    B: Backend
        + PickPixels
        + Gather<<S as SourceOn<B>>::Source, E::Evaluator>
        + GatherMany<<S as SourcesTogether<B>>::Together, E::Evaluator>,
    S: SourcesTogether<B>,
    E: Evaluators,
{
    fn prepare(&self, frame: &Frame<'_, B>, quality: u32) -> Result<(), MethodError> {
        if !self.is_at_once(&frame.inputs)? {
            return self.0.prepare(frame, quality);
        }
        let [quality, detail] = self.0.qualities(quality);
        self.0.evaluators().kept(frame, detail)?;
        let sources = self.0.sources();
        for light in 0..frame.inputs.emitters.len() {
            frame.inputs.go_on(light)?;
            sources.prepare_light(frame, light, quality)?;
            if sources.is_apart(&frame.inputs, light) {
                sources.prepare(frame, light, quality)?;
            }
        }
        sources.together(frame, quality).map(|_| ())
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let inputs = &frame.inputs;
        let tiles = self.is_at_once(inputs)?.then(|| ray_tiles(inputs));
        let Some(tiles) = tiles.flatten() else {
            return self.0.add_radiance(frame, quality, radiance);
        };
        let culled = Culled::new(tiles);
        let sources = self.0.sources();
        let [quality, detail] = self.0.qualities(quality);
        let evaluator = self.0.evaluators().kept(frame, detail)?;
        let mut first = 0;
        for Together { source, lights } in sources.together(frame, quality)? {
            let turns = TURNS_OF_PATH + S::turns(&source) + PARTS * E::work(detail);
            let all: Range<usize> = first..first + lights;
            first = all.end;
            let mut start = all.start;
            while start < all.end {
                if sources.is_apart(inputs, start) {
                    let seen = (None, Some(&culled));
                    (self.0).add_light(frame, (start, [quality, detail]), seen, radiance)?;
                    start += 1;
                    continue;
                }
                // Lights must be added in their order.
                let apart = (start..all.end).find(|light| sources.is_apart(inputs, *light));
                let rest = &inputs.emitters[start..apart.unwrap_or(all.end)];
                let (lists, count) = frame.pass("lists of lights", || {
                    lists(culled.tiles(), rest).map_err(MethodError::resource("lists of lights"))
                })?;
                let emitters = &rest[..count];
                // The lines of a cookie may take all iterations that are allowed.
                let lights_per_dispatch = match emitters.iter().any(|emitter| texels(emitter) > 0) {
                    true => 1,
                    false => (MOST_TURNS / turns).max(1.0) as usize,
                };
                let lit = LitByMany {
                    first: start - all.start,
                    touching: sources.about().touching,
                    lights_per_dispatch,
                    watch: inputs.watch,
                    ..LitByMany::new(&frame.rays, emitters, &lists, inputs.medium)
                };
                frame.pass("gather", || {
                    let backend = frame.backend;
                    Ok(backend.gather_many(&lit, &source, &*evaluator, radiance)?)
                })?;
                start += count;
            }
        }
        Ok(())
    }
}
