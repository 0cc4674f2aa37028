//! Spans of shadow volumes, marched in the shadow map of every light.

use std::sync::Arc;

use gpu_backend::{Backend, Cpu, Host};

use super::{BuildLitVolumes, Choice, Hybrid, LitVolumes, ShadowVolumes, Spread, Volumes};
use crate::Touching;
use crate::methods::march::STEPS;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, Work,
};
use crate::shadow_map::{RenderShadowMap, ShadowMap};

/// A march between the shadow volumes of every light.
#[derive(Debug, Clone, Copy)]
struct Hybrids {
    name: &'static str,
    title: &'static str,
    spread: Spread,
}

impl LightSources for Hybrids {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: self.name,
            title: self.title,
            quality: Some(STEPS),
            touching: Touching::Joined,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        notes(inputs, self.spread)
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        let map = inputs.map_work();
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps),
            // Volumes visit the triangles once more, and a cell covers 64 texels.
            once: 1.25 * map.once,
            bytes: map.bytes + map.bytes / 48,
            ..map
        }
    }
}

/// Which volumes the lights of a frame have, and why.
pub(super) fn notes(inputs: &FrameInputs<'_>, spread: Spread) -> Vec<String> {
    let (steps, total) = (STEPS.usual, inputs.emitters.len());
    let choices: Vec<(Known, Choice)> = (0..total)
        .filter_map(|light| choice(inputs, light, (steps, spread)).ok()?)
        .collect();
    let of = |known: fn(Known) -> bool| -> Vec<Choice> {
        let all = choices.iter().filter(|(which, _)| known(*which));
        all.map(|(_, choice)| *choice).collect()
    };
    let mean = |all: &[Choice], value: fn(&Choice) -> f64| {
        all.iter().map(value).sum::<f64>() / all.len() as f64
    };
    let mut notes = Vec::new();
    let marched = of(|known| known == Known::NOTHING);
    if !marched.is_empty() {
        notes.push(format!(
            "of {steps} steps shadow volumes would save {:.0} and cost as much as {:.0}: all \
             of each ray is marched then ({} of {total})",
            mean(&marched, Choice::saved),
            mean(&marched, Choice::cost),
            marched.len(),
        ));
    }
    let lit = of(|known| known.light);
    if !lit.is_empty() {
        notes.push(format!(
            "mostly in shadow: outside of volumes of light all is dark, and of {steps} steps \
             {:.0} are asked about ({} of {total})",
            mean(&lit, |choice| choice.asked),
            lit.len(),
        ));
    }
    notes
}

/// The volumes of a light, on the host.
fn on_host(
    inputs: &FrameInputs<'_>,
    light: usize,
) -> Result<Arc<ShadowVolumes<Host>>, MethodError> {
    let resolution = inputs.map;
    let key = OfLight { light, resolution };
    let what = "shadow volumes";
    inputs.host.get(what, key, ShadowVolumes::bytes, || {
        let emitter = &inputs.emitters[light];
        Ok(ShadowVolumes::new(
            &Cpu::new(),
            inputs.geometry,
            emitter,
            resolution,
        )?)
    })
}

/// The cost of making lit volumes, per texel of the map, in steps: measured on a CPU.
const TEXEL: f64 = 0.1;

/// An estimate of the lit volumes, on the host.
fn estimated(
    inputs: &FrameInputs<'_>,
    light: usize,
    shadows: &ShadowVolumes<Host>,
) -> Result<Arc<LitVolumes<Host>>, MethodError> {
    let resolution = inputs.map;
    let key = Estimated(OfLight { light, resolution });
    let what = "estimated volumes of light";
    inputs.host.get(what, key, LitVolumes::bytes, || {
        Ok(LitVolumes::estimated(shadows))
    })
}

/// The key of the volumes of a light that the choice is based on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Estimated(OfLight);

/// The volumes of a light that are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Known {
    pub(super) shadow: bool,
    pub(super) light: bool,
}

impl Known {
    pub(super) const NOTHING: Self = Self {
        shadow: false,
        light: false,
    };
}

/// Chooses the volumes of a light that are best for the rays of a frame, with what they
/// achieve. Lit volumes are considered if avoiding dark steps among those in shadow volumes
/// could pay for making them in this frame. If no volumes are worth it, what shadow volumes
/// would achieve.
pub(super) fn choice(
    inputs: &FrameInputs<'_>,
    light: usize,
    steps: (u32, Spread),
) -> Result<Option<(Known, Choice)>, MethodError> {
    let shadows = on_host(inputs, light)?;
    let emitter = &inputs.emitters[light];
    let of = |volumes: Volumes<'_>| {
        Choice::new(
            &shadows,
            volumes,
            inputs.rays,
            emitter,
            inputs.medium,
            steps,
        )
    };
    let shadow = Some(&*shadows);
    let Some(first) = of(Volumes {
        shadow,
        light: None,
    }) else {
        return Ok(None);
    };
    let known = |shadow, light| Known { shadow, light };
    let mut best = (known(true, false), first);
    // The cost of the lit volumes, divided by the number of rays.
    let texels = f64::from(inputs.map).powi(2) * shadows.cells.pictures.len() as f64;
    let made = TEXEL * texels / inputs.rays.len() as f64;
    if first.dark > made {
        let lit = estimated(inputs, light, &shadows)?;
        for shadow in [shadow, None] {
            let choice = of(Volumes {
                shadow,
                light: Some(&*lit),
            });
            let Some(choice) = choice else { continue };
            let least = match best.0.light {
                true => best.1.cost_at(&first),
                false => best.1.cost_at(&first) - made,
            };
            if choice.cost_at(&first) < least {
                best = (known(shadow.is_some(), true), choice);
            }
        }
    }
    Ok(Some(match best.1.is_worth_it() {
        true => best,
        false => (Known::NOTHING, first),
    }))
}

/// The same volumes, in the memory of the backend.
pub(in crate::methods) fn volumes<B: Backend>(
    frame: &Frame<'_, B>,
    light: usize,
) -> Result<Arc<ShadowVolumes<B::Memory>>, MethodError> {
    let on_host = on_host(&frame.inputs, light)?;
    let key = OfLight {
        light,
        resolution: frame.inputs.map,
    };
    let what = "shadow volumes";
    frame.store.get(what, key, ShadowVolumes::bytes, || {
        Ok(on_host.upload(frame.backend)?)
    })
}

/// The lit volumes of a shadow map, in the memory of the backend.
pub(super) fn lit_volumes<B: RenderShadowMap + BuildLitVolumes>(
    frame: &Frame<'_, B>,
    light: usize,
) -> Result<Arc<LitVolumes<B::Memory>>, MethodError> {
    let resolution = frame.inputs.map;
    let key = OfLight { light, resolution };
    let what = "volumes of light";
    frame.store.get(what, key, LitVolumes::bytes, || {
        Ok(frame.backend.lit_volumes(&*frame.shadow_map(light)?)?)
    })
}

impl<B: RenderShadowMap + BuildLitVolumes> SourceOn<B> for Hybrids {
    type Source = Hybrid<Arc<ShadowMap<B::Memory>>, B::Memory>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, steps: u32) -> Result<(), MethodError> {
        self.source(frame, light, steps).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        steps: u32,
    ) -> Result<Self::Source, MethodError> {
        let choice = choice(&frame.inputs, light, (steps, self.spread))?;
        let known = choice.map_or(Known::NOTHING, |(known, _)| known);
        let shadows = match known.shadow {
            true => Some(volumes(frame, light)?),
            false => None,
        };
        let hybrid = Hybrid::new(frame.shadow_map(light)?, shadows, steps)?;
        let hybrid = hybrid.spread_over(self.spread);
        Ok(match known.light {
            true => hybrid.with_lit_volumes(lit_volumes(frame, light)?)?,
            false => hybrid,
        })
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, detail, title, purpose| Compared {
        airlight,
        detail: Some(detail),
        title,
        purpose,
        paper: "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008",
        qualities: (&[], &[], 0),
        role,
        is_baseline: false,
    };
    let mut all = pairs!(
        Hybrids {
            name: "hybrid",
            title: "march between shadow volumes",
            spread: Spread::Span,
        },
        &[
            compared(
                Role::Paper,
                "gauss",
                8,
                "march between shadow volumes",
                "shadows in parts of a view: no lookups where there is none",
            ),
            compared(
                Role::Variant,
                "table",
                64,
                "march between shadow volumes, airlight table",
                "point lights with shadows in parts of a view: two lookups for a lit run",
            ),
            compared(
                Role::Variant,
                "quadrature",
                4,
                "march between shadow volumes, quadrature",
                "lights with a cookie: a lit run is divided at its texels",
            ),
        ]
    );
    all.extend(pairs!(
        Hybrids {
            name: "hybrid-rays",
            title: "march between volumes, steps of rays",
            spread: Spread::Ray,
        },
        &[]
    ));
    all
}
