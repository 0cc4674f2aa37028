//! The light volume of every light's shadow map.

use std::sync::Arc;

use super::{BuildLightVolume, LightVolume};
use crate::Touching;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, SourceQuality, Work,
};
use crate::shadow_map::RenderShadowMap;

const PARTS: SourceQuality = SourceQuality {
    unit: "parts of a texel",
    qualities: &[1, 4, 16],
    quick: &[4],
    pictured: 4,
    usual: 4,
};

/// Meshes that are as near to the texels of the map as a part of a texel's width.
#[derive(Debug, Clone, Copy)]
struct Volumes;

/// The mesh of a light in a store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfParts {
    of: OfLight,
    parts: u32,
}

impl LightSources for Volumes {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: "light-volumes",
            title: "light volumes",
            quality: Some(PARTS),
            touching: Touching::Joined,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, _: u32) -> Work {
        let map = inputs.map_work();
        let side = f64::from(inputs.map);
        Work {
            // A height of each texel, and the nodes above it.
            once: 3.0 * map.once,
            bytes: 11 * map.bytes / 4,
            // The way down to each end of a run and back.
            per_ray: inputs.emitters.len() as f64 * 16.0 * side.log2(),
            ..map
        }
    }
}

impl<B: RenderShadowMap + BuildLightVolume> SourceOn<B> for Volumes {
    type Source = Arc<LightVolume<B::Memory>>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, parts: u32) -> Result<(), MethodError> {
        self.source(frame, light, parts).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        parts: u32,
    ) -> Result<Self::Source, MethodError> {
        if parts == 0 {
            return Err(MethodError::Quality {
                value: parts,
                unit: PARTS.unit,
                expected: "at least 1".into(),
            });
        }
        let resolution = frame.inputs.map;
        let of = OfLight { light, resolution };
        let key = OfParts { of, parts };
        frame
            .store
            .get("light volume", key, LightVolume::bytes, || {
                let map = frame.shadow_map(light)?;
                Ok(frame.backend.light_volume(&map, 1.0 / parts as f32)?)
            })
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, detail, title, purpose| Compared {
        airlight,
        detail: Some(detail),
        title,
        purpose,
        paper: "Billeter, Sintorn and Assarsson, Real Time Volumetric Shadows using Polygonal Light Volumes, HPG 2010",
        qualities: (&[], &[], 0),
        role,
        is_baseline: false,
    };
    pairs!(
        Volumes,
        &[
            compared(
                Role::Paper,
                "gauss",
                8,
                "light volumes",
                "lights and casters that stay: one mesh of the lit air, whatever the view",
            ),
            compared(
                Role::Variant,
                "table",
                64,
                "light volumes, airlight table",
                "point lights: two lookups for a lit run, one for each face that bounds it",
            ),
        ]
    )
}
