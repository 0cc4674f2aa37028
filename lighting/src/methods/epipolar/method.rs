//! The lit runs of every light's shadow map.

use std::sync::Arc;

use super::sampling::EpipolarSampling;
use super::{BuildLineTrees, BuildMapBlocks, MapBlocks, MapRuns};
use crate::Touching;
use crate::methods::evaluators::Gauss;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, Work,
};
use crate::shadow_map::{RenderShadowMap, ShadowMap};

/// Runs found with trees that are made anew for each view.
#[derive(Debug, Clone, Copy)]
struct Runs;

impl LightSources for Runs {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: "map-runs",
            title: "runs of the shadow map",
            quality: None,
            touching: Touching::Joined,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, _: u32) -> Work {
        let lights = inputs.emitters.len() as f64;
        let side = f64::from(inputs.map);
        Work {
            // Half a dozen blocks for every leaf, of as many lines.
            per_frame: lights * side * side,
            // A few nodes and texels at each end of a run.
            per_ray: lights * 4.0 * side.log2(),
            ..inputs.map_work()
        }
    }
}

/// The blocks of the shadow map of a light.
fn blocks<B: RenderShadowMap + BuildMapBlocks>(
    frame: &Frame<'_, B>,
    light: usize,
) -> Result<Arc<MapBlocks<B::Memory>>, MethodError> {
    let resolution = frame.inputs.map;
    let key = OfLight { light, resolution };
    let what = "blocks of a shadow map";
    frame.store.get(what, key, MapBlocks::bytes, || {
        Ok(frame.backend.map_blocks(&*frame.shadow_map(light)?)?)
    })
}

impl<B: RenderShadowMap + BuildMapBlocks + BuildLineTrees> SourceOn<B> for Runs {
    type Source = MapRuns<Arc<ShadowMap<B::Memory>>, B::Memory>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, _: u32) -> Result<(), MethodError> {
        blocks(frame, light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        _: u32,
    ) -> Result<Self::Source, MethodError> {
        let (map, blocks) = (frame.shadow_map(light)?, blocks(frame, light)?);
        let FrameInputs {
            emitters,
            medium,
            rays,
            ..
        } = frame.inputs;
        frame.pass("line trees", || {
            Ok(MapRuns::with_blocks(
                frame.backend,
                map,
                &blocks,
                rays,
                &emitters[light],
                medium,
            )?)
        })
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, title, purpose, qualities| Compared {
        airlight,
        detail: None,
        title,
        purpose,
        paper: "Chen et al., Real-Time Volumetric Shadows using 1D Min-Max Mipmaps, I3D 2011",
        qualities,
        role,
        is_baseline: false,
    };
    let mut all = pairs!(
        Runs,
        &[
            compared(
                Role::Paper,
                "gauss",
                "runs of the shadow map",
                "all that a shadow map knows, at less than a tenth of the lookups of its texels",
                (&[2, 4, 8, 16], &[2, 8], 8),
            ),
            compared(
                Role::Variant,
                "table",
                "runs of the shadow map, airlight table",
                "point lights: two lookups for a lit run of the map",
                (&[16, 64], &[64], 64),
            ),
        ]
    );
    all.push(Entry::everywhere(EpipolarSampling::new(Runs, Gauss, 8)));
    all
}
