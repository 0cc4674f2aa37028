//! Steps along rays through filtered shadow maps.

use std::sync::Arc;

use super::{Moments, Prefilter, PrefilteredMap};
use crate::Touching;
use crate::methods::march::{March, STEPS, Spacing};
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, Work,
};
use crate::shadow_map::{RenderShadowMap, face_count};

/// The largest memory for the moments of a light, bytes: WebGPU's limit for a binding.
const MOST_BYTES: f64 = (1_u64 << 27) as f64;

/// The share of the map's texels along a side that a ray is assumed to cross, which decides the
/// level for a number of steps.
const CROSSED: f64 = 0.25;

/// The finest level at which the moments of a light fit into memory, with so many values for
/// each texel.
pub(in crate::methods) fn finest_level(
    inputs: &FrameInputs<'_>,
    light: usize,
    numbers: f64,
) -> u32 {
    let faces = face_count(inputs.geometry, &inputs.emitters[light]);
    let texels = faces as f64 * f64::from(inputs.map).powi(2);
    let bytes = 4.0 * numbers * texels;
    // Conversions saturate.
    (0.5 * (bytes / MOST_BYTES).log2()).ceil() as u32
}

/// A march through the moments of every light.
#[derive(Debug, Clone, Copy)]
struct Filtered {
    name: &'static str,
    title: &'static str,
    moments: Moments,
}

impl Filtered {
    /// The level at which a texel is about as long as a step, or the finest one that fits into
    /// memory if that is coarser.
    fn level(self, inputs: &FrameInputs<'_>, light: usize, steps: u32) -> u32 {
        let fits = finest_level(inputs, light, self.moments.channels() as f64);
        let step = CROSSED * f64::from(inputs.map) / f64::from(steps.max(1));
        (step.log2().round() as u32).max(fits)
    }
}

impl LightSources for Filtered {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: self.name,
            title: self.title,
            quality: Some(STEPS),
            touching: Touching::Apart,
            is_sampled: true,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        // Each step looks up four bounds.
        let lookup = 4.0 * (1.0 + self.moments.channels() as f64);
        let map = inputs.map_work();
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps) * lookup,
            once: 2.0 * map.once,
            ..map
        }
    }
}

impl<B: RenderShadowMap + Prefilter> SourceOn<B> for Filtered {
    type Source = March<Arc<PrefilteredMap<B::Memory>>>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, steps: u32) -> Result<(), MethodError> {
        self.source(frame, light, steps).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        steps: u32,
    ) -> Result<Self::Source, MethodError> {
        let inputs = &frame.inputs;
        let level = self.level(inputs, light, steps);
        let of_light = OfLight {
            light,
            resolution: inputs.map,
        };
        let key = (of_light, self.moments, level);
        let map = frame
            .store
            .get("filtered moments", key, PrefilteredMap::bytes, || {
                let map = frame.shadow_map(light)?;
                let bounds = inputs.geometry.bounds();
                PrefilteredMap::new(frame.backend, &map, self.moments, &bounds, level)
                    .map_err(MethodError::from)
            })?;
        Ok(March::new(map, steps, Spacing::Distance))
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let kinds = [
        (
            "variance",
            "variance shadow maps",
            Moments::Variance,
            "soft and cheap; light bleeds where casters lie behind each other",
            "Donnelly and Lauritzen, Variance Shadow Maps, I3D 2006",
        ),
        (
            "exponential-variance",
            "exponential variance shadow maps",
            Moments::ExponentialVariance,
            "as variance, and less light bleeds",
            "Lauritzen and McCool, Layered Variance Shadow Maps, GI 2008",
        ),
        (
            "moments-4",
            "moment shadow maps, four",
            Moments::Four,
            "few steps that see what lies between them; two casters in line without bleeding",
            "Peters and Klein, Moment Shadow Mapping, I3D 2015; Peters et al., I3D 2016",
        ),
        (
            "moments-6",
            "moment shadow maps, six",
            Moments::Six,
            "as four, and three casters in line",
            "Peters et al., Beyond Hard Shadows, I3D 2016",
        ),
    ];
    let mut all = Vec::new();
    for (name, title, moments, purpose, paper) in kinds {
        all.extend(pairs!(
            Filtered {
                name,
                title,
                moments
            },
            &[Compared {
                airlight: "midpoint",
                detail: Some(1),
                title,
                purpose,
                paper,
                qualities: (&[], &[], 0),
                role: Role::Variant,
                is_baseline: false,
            }]
        ));
    }
    all
}
