//! Any visibility source × any airlight evaluator, light by light.

use std::borrow::Cow;
use std::fmt::Debug;

use gpu_backend::{Backend, BufferOf, Cpu};

use super::{
    About, Evaluators, Frame, FrameInputs, Method, MethodError, Role, RunOn, Verdict, Work,
};
use crate::culling::{self, PickPixels, RayTiles};
use crate::scene::Geometry;
use crate::{Emitter, EyePanes, Gather, Interleaving, LitRays, Ray, Touching};

/// A kind of visibility source, which has one source for each light. `SourceOn` makes them on a
/// backend.
pub trait LightSources: Send + Sync + Debug {
    /// What it says of itself.
    fn about(&self) -> SourceAbout;

    /// Whether it applies to a frame.
    fn applies(&self, _inputs: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }

    /// See [`Method::uses_maps_of`].
    fn uses_maps_of(&self, _geometry: &Geometry) -> bool {
        self.about().uses_shadow_map
    }

    /// The light that remains for the evaluator to integrate. The default is the whole light; a
    /// source whose shares already contain some of the light's pattern returns the light
    /// without it.
    ///
    /// Rays that the light does not reach are left out before. So a source that returns another
    /// light must yield nothing where the light itself does not reach: beyond its range or
    /// outside of its cone.
    fn evaluated<'a>(&self, emitter: &'a Emitter) -> Cow<'a, Emitter> {
        Cow::Borrowed(emitter)
    }

    /// Whether the ends of lit parts are exact up to rounding.
    fn is_exact(&self) -> bool {
        false
    }

    /// See [`Method::interleaves`].
    fn interleaves(&self) -> Verdict {
        Verdict::Impossible("rays cannot share what finds their lit parts".into())
    }

    /// See [`Method::notes`].
    fn notes(&self, _inputs: &FrameInputs<'_>) -> Vec<String> {
        Vec::new()
    }

    /// The work that it expects for a frame with all lights, without the evaluations.
    fn work(&self, inputs: &FrameInputs<'_>, quality: u32) -> Work;
}

/// A kind of visibility source on a backend.
pub trait SourceOn<B: Backend>: LightSources {
    /// A source whose data is in the memory of the backend.
    type Source;

    /// Puts into the store what the source of light number `light` needs in every frame.
    ///
    /// # Errors
    /// [`MethodError`].
    fn prepare(&self, frame: &Frame<'_, B>, light: usize, quality: u32) -> Result<(), MethodError>;

    /// The source of light number `light` in this frame.
    ///
    /// # Errors
    /// [`MethodError`].
    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        quality: u32,
    ) -> Result<Self::Source, MethodError>;

    /// Takes back a source after its light has been gathered, so that memory can be used again.
    fn done(&self, _frame: &Frame<'_, B>, _source: Self::Source, _quality: u32) {}
}

/// How a kind of visibility source describes itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SourceAbout {
    /// The name by which it is asked for, such as `march`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// Its quality, if it has one.
    pub quality: Option<SourceQuality>,
    /// Whether its lit parts are joined where they touch.
    pub touching: Touching,
    /// Whether its lit parts are single samples, for which an evaluator with one node is
    /// enough.
    pub is_sampled: bool,
    /// Whether hair and smoke cast shadows into the air.
    pub sees_translucent: bool,
    /// Whether see-through triangles dim the light that passes them on its way into the air. If
    /// not, they cast no shadow there.
    pub sees_panes: bool,
    /// See [`About::uses_shadow_map`].
    pub uses_shadow_map: bool,
}

/// The quality of a kind of visibility source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SourceQuality {
    /// Its unit, such as `steps`.
    pub unit: &'static str,
    /// See [`About::qualities`].
    pub qualities: &'static [u32],
    /// See [`About::quick`].
    pub quick: &'static [u32],
    /// See [`About::pictured`].
    pub pictured: u32,
    /// The quality that is used unless another is asked for.
    pub usual: u32,
}

/// How comparisons show a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compared {
    /// The name of the evaluator.
    pub airlight: &'static str,
    /// The evaluator's quality where the source has one too; `None` if comparisons vary the
    /// evaluator's.
    pub detail: Option<u32>,
    /// See [`About::title`].
    pub title: &'static str,
    /// See [`About::purpose`].
    pub purpose: &'static str,
    /// See [`About::paper`].
    pub paper: &'static str,
    /// The evaluator's qualities, where comparisons vary them: all, those of a quick
    /// comparison, and the one that is pictured.
    pub qualities: (&'static [u32], &'static [u32], u32),
    /// See [`About::role`].
    pub role: Role,
    /// Whether it is shown beside hair and smoke although it does not see them, so that one
    /// sees how much their shadows matter.
    pub is_baseline: bool,
}

/// A method that finds the lit parts of rays by `S` and integrates them by `E`,
/// one light after the other.
///
/// Its quality is that of the source, if that has one, and else that of the
/// evaluator.
#[derive(Debug, Clone)]
pub struct PerLight<S, E> {
    sources: S,
    evaluators: E,
    /// The evaluator's quality where the quality of the method is that of the source.
    detail: u32,
    compared: Option<Compared>,
}

impl<S: LightSources, E: Evaluators> PerLight<S, E> {
    /// The pair; comparisons show it if `compared` is given.
    pub fn new(sources: S, evaluators: E, compared: Option<Compared>) -> Self {
        let is_sampled = sources.about().is_sampled;
        let usual = E::ABOUT.usual[usize::from(!is_sampled)];
        let detail = compared.and_then(|c| c.detail).unwrap_or(usual);
        Self {
            sources,
            evaluators,
            detail,
            compared,
        }
    }

    /// The same pair with another quality of the evaluator. Comparisons do not show it.
    #[must_use]
    pub fn with_detail(self, detail: u32) -> Self {
        Self {
            detail,
            compared: None,
            ..self
        }
    }

    /// Tells the evaluator about a frame whose lights are those that remain for it.
    fn with_evaluated<R>(
        &self,
        inputs: &FrameInputs<'_>,
        tell: impl FnOnce(&FrameInputs<'_>) -> R,
    ) -> R {
        let emitters = inputs.emitters.iter();
        let emitters = emitters.map(|emitter| self.sources.evaluated(emitter));
        let emitters: Vec<Emitter> = emitters.map(Cow::into_owned).collect();
        tell(&FrameInputs {
            emitters: &emitters,
            ..*inputs
        })
    }

    pub(super) fn sources(&self) -> &S {
        &self.sources
    }

    pub(super) fn evaluators(&self) -> &E {
        &self.evaluators
    }

    /// Qualities of the source and of the evaluator.
    pub(super) fn qualities(&self, quality: u32) -> [u32; 2] {
        match self.sources.about().quality {
            Some(_) => [quality, self.detail],
            None => [0, quality],
        }
    }
}

impl<S: LightSources, E: Evaluators> Method for PerLight<S, E> {
    fn about(&self) -> About {
        let source = self.sources.about();
        let evaluator = E::ABOUT;
        let name = match source.quality {
            Some(_) if evaluator.unit.is_some() => {
                format!("{} x {}-{}", source.name, evaluator.name, self.detail)
            }
            _ => format!("{} x {}", source.name, evaluator.name),
        };
        let (unit, (qualities, quick, pictured), usual) = match source.quality {
            Some(q) => (q.unit, (q.qualities, q.quick, q.pictured), q.usual),
            None => {
                let own = (&[][..], &[][..], self.detail);
                let qualities = self.compared.map_or(own, |c| c.qualities);
                let unit = evaluator.unit.unwrap_or("evaluations");
                (unit, qualities, self.detail)
            }
        };
        let is_compared = self.compared.is_some();
        About {
            name: Cow::Owned(name),
            title: self.compared.map_or(source.title, |c| c.title),
            purpose: self.compared.map_or("a pair of one's own", |c| c.purpose),
            paper: self.compared.map_or("", |c| c.paper),
            quality: unit,
            qualities: if is_compared { qualities } else { &[] },
            quick: if is_compared { quick } else { &[] },
            pictured,
            usual,
            role: self.compared.map_or(Role::Variant, |c| c.role),
            uses_shadow_map: source.uses_shadow_map,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        let is_baseline = self.compared.is_some_and(|c| c.is_baseline);
        let sees_all =
            inputs.translucent.is_empty() || self.sources.about().sees_translucent || is_baseline;
        self.sources
            .applies(inputs)
            .and(|| self.with_evaluated(inputs, |inputs| self.evaluators.applies(inputs)))
            .and(|| {
                match sees_all {
                true => Verdict::Applies,
                false => Verdict::Pointless(
                    "it does not see hair and smoke, which exact visibility and no shadows stand for"
                        .into(),
                ),
            }
            })
            .and(|| {
                let sees_all = !inputs.geometry.coatings().any_see_through()
                    || self.sources.about().sees_panes
                    || is_baseline;
                match sees_all {
                    true => Verdict::Applies,
                    false => Verdict::Pointless(
                        "it does not see what is see-through, which exact visibility and \
                         transmittance maps do"
                            .into(),
                    ),
                }
            })
    }

    fn uses_maps_of(&self, geometry: &Geometry) -> bool {
        self.sources.uses_maps_of(geometry)
    }

    fn distinct<'q>(
        &self,
        inputs: &FrameInputs<'_>,
        qualities: &'q [u32],
    ) -> (&'q [u32], Option<&'static str>) {
        let of_evaluator = self.sources.about().quality.is_none();
        if of_evaluator && inputs.has_only_suns() && qualities.len() > 1 {
            // The closed form has no nodes.
            let why = "the airlight of a directional light is in closed form";
            return (&qualities[..1], Some(why));
        }
        (qualities, None)
    }

    fn sees_cover(&self) -> bool {
        true
    }

    fn tolerance(&self, quality: u32) -> Option<f64> {
        let [_, of_evaluator] = self.qualities(quality);
        match self.sources.is_exact() {
            true => E::tolerance(of_evaluator),
            false => None,
        }
    }

    fn interleaves(&self, _: &FrameInputs<'_>) -> Verdict {
        self.sources.interleaves()
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = self.with_evaluated(inputs, |inputs| self.evaluators.notes(inputs));
        notes.extend(self.sources.notes(inputs));
        if !inputs.translucent.is_empty() && !self.sources.about().sees_translucent {
            notes.push(format!(
                "hair and smoke cast no shadow into the air with {} visibility",
                self.sources.about().name
            ));
        }
        let has_panes = inputs.geometry.coatings().any_see_through();
        if has_panes && !self.sources.about().sees_panes {
            notes.push(format!(
                "see-through surfaces cast no shadow into the air with {} visibility",
                self.sources.about().name
            ));
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, quality: u32) -> Work {
        let [steps, detail] = self.qualities(quality);
        let mut work = self.sources.work(inputs, steps);
        work.per_ray += inputs.emitters.len() as f64 * E::work(detail);
        work
    }
}

impl<B, S, E> RunOn<B> for PerLight<S, E>
where
    B: Backend + PickPixels + Gather<<S as SourceOn<B>>::Source, E::Evaluator>,
    S: SourceOn<B>,
    E: Evaluators,
{
    fn prepare(&self, frame: &Frame<'_, B>, quality: u32) -> Result<(), MethodError> {
        let [quality, detail] = self.qualities(quality);
        self.evaluators.kept(frame, detail)?;
        for light in 0..frame.inputs.emitters.len() {
            frame.inputs.go_on(light)?;
            self.sources.prepare(frame, light, quality)?;
        }
        Ok(())
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let qualities = self.qualities(quality);
        let panes = frame.inputs.panes()?;
        let culled = match panes.is_some() {
            true => None,
            false => ray_tiles(&frame.inputs).map(Culled::new),
        };
        for light in 0..frame.inputs.emitters.len() {
            let seen = (panes.as_ref(), culled.as_ref());
            self.add_light(frame, (light, qualities), seen, radiance)?;
        }
        Ok(())
    }
}

impl<S, E: Evaluators> PerLight<S, E> {
    /// Adds the airlight of one light, seen through panes, to the rays that the light may
    /// reach; with the qualities of the source and of the evaluator.
    pub(super) fn add_light<B>(
        &self,
        frame: &Frame<'_, B>,
        (light, [quality, detail]): (usize, [u32; 2]),
        (panes, culled): (Option<&EyePanes>, Option<&Culled>),
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError>
    where
        B: Backend + PickPixels + Gather<<S as SourceOn<B>>::Source, E::Evaluator>,
        S: SourceOn<B>,
    {
        let inputs = &frame.inputs;
        let emitter = &inputs.emitters[light];
        let reached = culled.and_then(|culled| culled.reached(emitter));
        let emitter = self.sources.evaluated(emitter);
        let skipped = reached.as_ref().map_or(0, |r| inputs.rays.len() - r.len());
        if skipped > 0 {
            inputs.watch.gathered(skipped);
        }
        if skipped == inputs.rays.len() {
            return Ok(());
        }
        let source = self.sources.source(frame, light, quality)?;
        let evaluator = self.evaluators.of_light(frame, &emitter, detail)?;
        let gather = |rays: &BufferOf<B, Ray>, radiance: &mut BufferOf<B, [f32; 4]>| {
            let lit = LitRays {
                touching: self.sources.about().touching,
                panes,
                watch: inputs.watch,
                ..LitRays::new(rays, &emitter, inputs.medium)
            };
            frame.pass("gather", || {
                Ok(frame.backend.gather(&lit, &source, &*evaluator, radiance)?)
            })
        };
        match reached {
            None => gather(&frame.rays, radiance)?,
            Some(reached) => {
                let rays = reached.iter().map(|ray| inputs.rays[*ray as usize]);
                let rays = frame.backend.upload(&rays.collect::<Vec<_>>())?;
                let reached = frame.backend.upload(&reached)?;
                let mut some = frame.backend.pick(radiance, &reached)?;
                gather(&rays, &mut some)?;
                frame.backend.put_back(&some, &reached, radiance)?;
            }
        }
        self.sources.done(frame, source, quality);
        Ok(())
    }
}

/// The rays of a frame in tiles, which find those that a light may reach.
pub(super) struct Culled(RayTiles);

/// A light that may reach a larger share of the rays than this is gathered along all of them:
/// the list of rays would cost more than it saves.
const MOST: f64 = 0.75;

/// Whether lights are culled: if there are enough of them, and if rays need not keep their
/// numbers.
pub(super) fn is_culled(inputs: &FrameInputs<'_>) -> bool {
    inputs.selection.interleaving == Interleaving::NONE && culling::is_worthwhile(inputs.emitters)
}

/// The rays of a frame in tiles, if its lights are culled.
pub(super) fn ray_tiles(inputs: &FrameInputs<'_>) -> Option<RayTiles> {
    let pixels = inputs.selection.pixels;
    let tiles = || RayTiles::new(&Cpu::new(), inputs.rays, inputs.size[0], pixels);
    is_culled(inputs).then(tiles).flatten()
}

impl Culled {
    /// Lights are culled against these tiles.
    pub(super) fn new(tiles: RayTiles) -> Self {
        Self(tiles)
    }

    pub(super) fn tiles(&self) -> &RayTiles {
        &self.0
    }

    /// The rays that the light may reach; `None` for all rays.
    fn reached(&self, emitter: &Emitter) -> Option<Vec<u32>> {
        let most = MOST * self.0.rays() as f64;
        self.0
            .reached(emitter)
            .filter(|rays| rays.len() as f64 <= most)
    }
}
