//! Spans of shadow volumes, marched in the shadow map of every light.

use std::sync::Arc;

use gpu_backend::{Backend, Cpu, Host};

use super::{Choice, Hybrid, ShadowVolumes};
use crate::Touching;
use crate::methods::march::STEPS;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, Work,
};
use crate::shadow_map::{RenderShadowMap, ShadowMap};

/// A march within the shadow volumes of every light.
#[derive(Debug, Clone, Copy)]
struct Hybrids;

impl LightSources for Hybrids {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: "hybrid",
            title: "march between shadow volumes",
            quality: Some(STEPS),
            touching: Touching::Joined,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let steps = STEPS.usual;
        let all = 0..inputs.emitters.len();
        let marched: Vec<Choice> = all
            .filter_map(|light| choice(inputs, light, steps).ok()?)
            .filter(|choice| !choice.is_worth_it())
            .collect();
        if marched.is_empty() {
            return Vec::new();
        }
        let mean = |value: fn(&Choice) -> f64| {
            let sum: f64 = marched.iter().map(value).sum();
            sum / marched.len() as f64
        };
        vec![format!(
            "of {steps} steps shadow volumes would save {:.0} and cost as much as {:.0}: all of \
             each ray is marched then ({} of {})",
            mean(Choice::saved),
            mean(Choice::cost),
            marched.len(),
            inputs.emitters.len()
        )]
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        let map = inputs.map_work();
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps),
            // The triangles once more, and a cell for 64 texels.
            once: 1.25 * map.once,
            bytes: map.bytes + map.bytes / 48,
            ..map
        }
    }
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

/// What the volumes of a light do for the rays of a frame.
fn choice(
    inputs: &FrameInputs<'_>,
    light: usize,
    steps: u32,
) -> Result<Option<Choice>, MethodError> {
    let volumes = on_host(inputs, light)?;
    let emitter = &inputs.emitters[light];
    Ok(Choice::new(
        &volumes,
        inputs.rays,
        emitter,
        inputs.medium,
        steps,
    ))
}

/// The same where the frame is made.
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

impl<B: RenderShadowMap> SourceOn<B> for Hybrids {
    type Source = Hybrid<Arc<ShadowMap<B::Memory>>, B::Memory>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, _: u32) -> Result<(), MethodError> {
        volumes(frame, light)?;
        frame.shadow_map(light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        steps: u32,
    ) -> Result<Self::Source, MethodError> {
        let is_worth_it = choice(&frame.inputs, light, steps)?.is_some_and(|c| c.is_worth_it());
        let volumes = match is_worth_it {
            true => Some(volumes(frame, light)?),
            false => None,
        };
        Ok(Hybrid::new(frame.shadow_map(light)?, volumes, steps)?)
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
    pairs!(
        Hybrids,
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
    )
}
