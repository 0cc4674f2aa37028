//! Spans of shadow volumes, marched in filtered shadow maps of every light.

use std::sync::Arc;

use super::FilteredHybrid;
use crate::Touching;
use crate::methods::hybrid::method::{Known, choice, lit_volumes, notes};
use crate::methods::hybrid::{BuildLitVolumes, Spread, volumes_of};
use crate::methods::march::STEPS;
use crate::methods::prefiltered::{MomentPyramid, Moments, Prefilter, finest_level};
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, Work,
};
use crate::shadow_map::RenderShadowMap;

/// A march between the shadow volumes of every light, through moments of its map.
#[derive(Debug, Clone, Copy)]
struct FilteredHybrids {
    name: &'static str,
    title: &'static str,
    moments: Moments,
}

impl LightSources for FilteredHybrids {
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
        notes(inputs, Spread::Span)
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        // Each step looks up four bounds.
        let lookup = 4.0 * (1.0 + self.moments.channels() as f64);
        let map = inputs.map_work();
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps) * lookup,
            // The moments, and a second visit of the triangles.
            once: 2.25 * map.once,
            bytes: map.bytes + map.bytes / 3 * 4 * self.moments.channels() as u64,
            ..map
        }
    }
}

impl<B: RenderShadowMap + BuildLitVolumes + Prefilter> SourceOn<B> for FilteredHybrids {
    type Source = FilteredHybrid<Arc<MomentPyramid<B::Memory>>, B::Memory>;

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
        let of_light = OfLight {
            light,
            resolution: inputs.map,
        };
        let key = (of_light, self.moments);
        let map = frame
            .store
            .get("moments, all levels", key, MomentPyramid::bytes, || {
                let map = frame.shadow_map(light)?;
                let bounds = inputs.geometry.bounds();
                // All levels together take a third more than the finest.
                let numbers = self.moments.channels() as f64 * 4.0 / 3.0;
                let finest = finest_level(inputs, light, numbers);
                MomentPyramid::new(frame.backend, &map, self.moments, &bounds, finest)
                    .map_err(MethodError::from)
            })?;
        let choice = choice(inputs, light, (steps, Spread::Span))?;
        let known = choice.map_or(Known::NOTHING, |(known, _)| known);
        let shadows = match known.shadow {
            true => Some(volumes_of(frame, light)?),
            false => None,
        };
        let lit = match known.light {
            true => Some(lit_volumes(frame, light)?),
            false => None,
        };
        Ok(FilteredHybrid::new(map, shadows, lit, steps)?)
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let title = "march, casters as a texture";
    pairs!(
        FilteredHybrids {
            name: "hybrid-filtered",
            title,
            moments: Moments::ExponentialVariance,
        },
        &[Compared {
            airlight: "gauss",
            detail: Some(8),
            title,
            purpose: "foliage, hair and fences in few steps, each of which is lit in part",
            paper: "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008, section 5",
            qualities: (&[], &[], 0),
            role: Role::Variant,
            is_baseline: false,
        }]
    )
}
