//! Precomputed voxelized shadows: baked once for static casters, then traversed in large steps.

use std::sync::Arc;

use gpu_backend::{Cpu, Host, Memory};

use super::dynamic::{BesideDynamic, mapped};
use super::{BakedShadow, Builder, Resolution};
use crate::Touching;
use crate::methods::many_lights::{SourcesTogether, Together};
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, OfStatic, Role,
    SourceAbout, SourceOn, SourceQuality, Store, Verdict, Work,
};
use crate::scene::{Geometry, SceneError};
use crate::shadow_map::face_count;

const VOXELS: SourceQuality = SourceQuality {
    unit: "voxels per axis",
    qualities: &[256, 512, 1024, 2048, 4096, 8192],
    quick: &[512, 2048],
    pictured: 2048,
    usual: 2048,
};

/// The name of the visibility source in pairs.
pub const PRECOMPUTED: &str = "precomputed";

/// The quality that stands for shadows that the caller has put into the store, for example from
/// a file, whatever their resolution.
pub const FROM_FILE: u32 = 0;

/// The work for a node of the shadows, in texels of a shadow map: the node is found, compared
/// and numbered. Counted on a city and a fence.
const TILE: f64 = 60.0;

/// The precomputed shadows of every light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Baked;

impl LightSources for Baked {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: PRECOMPUTED,
            title: "precomputed voxelized shadows",
            quality: Some(VOXELS),
            // Where grids meet, a lit part continues in the next one.
            touching: Touching::Joined,
            is_sampled: false,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: false,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        match inputs.geometry.static_part() {
            Some(_) => Verdict::Applies,
            None => Verdict::Impossible("all casters are dynamic: there is nothing to bake".into()),
        }
    }

    fn uses_maps_of(&self, geometry: &Geometry) -> bool {
        geometry.dynamic_part().is_some()
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let dynamic = inputs.geometry.dynamic_part();
        let note = dynamic.map(|dynamic| {
            format!(
                "the shadows of {} dynamic triangles are those of shadow maps of {} texels per \
                 side around them, and the time of a frame is without these maps",
                dynamic.triangles().len(),
                inputs.map
            )
        });
        note.into_iter().collect()
    }

    fn work(&self, inputs: &FrameInputs<'_>, side: u32) -> Work {
        let lights = inputs.emitters.len() as f64;
        let side = f64::from(side);
        let dynamic = inputs.geometry.dynamic_part();
        let faces = dynamic.map_or(0, |dynamic| {
            (inputs.emitters.iter().enumerate())
                .filter(|(light, _)| inputs.dynamic_reached(*light).is_some())
                .map(|(_, emitter)| face_count(dynamic, emitter))
                .sum()
        });
        let triangles = dynamic.map_or(0, |dynamic| dynamic.triangles().len());
        let texels = faces as f64 * f64::from(inputs.map).powi(2);
        Work {
            // For the trees of the dynamic casters' map.
            per_frame: texels,
            // The number of nodes at silhouettes grows with the side, that on faces of open
            // meshes with its square. The map is kept in a store.
            once: TILE * lights * side.powf(1.5) + texels + (faces * triangles) as f64,
            per_ray: lights * side.sqrt(),
            ..Work::default()
        }
    }
}

/// Their name in stores and messages.
pub(super) const WHAT: &str = "precomputed shadows";

/// Puts the shadows of a light into a store. Methods use them with the quality [`FROM_FILE`].
pub fn share_precomputed(host: &Store<Host>, light: usize, shadow: &Arc<BakedShadow>) {
    let resolution = FROM_FILE;
    let key = OfStatic(OfLight { light, resolution });
    host.insert(WHAT, key, shadow.clone(), shadow.bytes());
}

/// The shadows of the static casters from a light, in the memory of the host.
pub(super) fn baked(
    inputs: &FrameInputs<'_>,
    light: usize,
    resolution: u32,
) -> Result<Arc<BakedShadow>, MethodError> {
    let key = OfStatic(OfLight { light, resolution });
    let bytes = |shadow: &BakedShadow| shadow.bytes();
    inputs.host.get(WHAT, key, bytes, || {
        let casters = inputs.geometry.static_part();
        let casters = casters.ok_or_else(|| MethodError::resource(WHAT)(SceneError::Empty))?;
        let side = Resolution::new(resolution).map_err(MethodError::resource(WHAT))?;
        let emitter = &inputs.emitters[light];
        let cpu = Cpu::new();
        BakedShadow::bake(&cpu, casters, emitter, side, Builder::new())
            .map(|(shadow, _)| shadow)
            .map_err(MethodError::resource(WHAT))
    })
}

impl SourceOn<Cpu> for Baked {
    type Source = BesideDynamic<Host>;

    fn prepare(&self, frame: &Frame<'_, Cpu>, light: usize, side: u32) -> Result<(), MethodError> {
        baked(&frame.inputs, light, side)?;
        mapped(frame, light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, Cpu>,
        light: usize,
        side: u32,
    ) -> Result<Self::Source, MethodError> {
        BesideDynamic::new(frame, light, baked(&frame.inputs, light, side)?)
    }
}

/// Roughly how many loop iterations a walk through the finest of these grids takes. A ray meets
/// far fewer homogeneous volumes than there are voxels along it, and each takes a few
/// iterations.
pub(super) fn turns<'a, M: Memory>(shadows: impl IntoIterator<Item = &'a BakedShadow<M>>) -> f64 {
    let grids = shadows.into_iter().flat_map(BakedShadow::grids);
    let sides = grids.map(|grid| f64::from(grid.resolution().side()));
    sides.fold(0.0, f64::max)
}

impl SourcesTogether<Cpu> for Baked {
    type Together = Vec<Arc<BakedShadow>>;

    fn prepare_light(
        &self,
        frame: &Frame<'_, Cpu>,
        light: usize,
        side: u32,
    ) -> Result<(), MethodError> {
        baked(&frame.inputs, light, side).map(|_| ())
    }

    fn together(
        &self,
        frame: &Frame<'_, Cpu>,
        side: u32,
    ) -> Result<Vec<Together<Self::Together>>, MethodError> {
        let lights = frame.inputs.emitters.len();
        let all = (0..lights).map(|light| baked(&frame.inputs, light, side));
        let source = all.collect::<Result<_, _>>()?;
        Ok(vec![Together { source, lights }])
    }

    fn is_apart(&self, inputs: &FrameInputs<'_>, light: usize) -> bool {
        inputs.dynamic_reached(light).is_some()
    }

    fn turns(source: &Self::Together) -> f64 {
        turns(source.iter().map(AsRef::as_ref))
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, detail, title, purpose, paper| Compared {
        airlight,
        detail: Some(detail),
        title,
        purpose,
        paper,
        qualities: (&[], &[], 0),
        role,
        is_baseline: false,
    };
    pairs!(
        many: Baked,
        &[
            compared(
                Role::Paper,
                "gauss",
                8,
                "precomputed voxelized shadows",
                "static scenes: baked once, walked in large steps, fine enough for any view",
                "Sintorn et al., Compact Precomputed Voxelized Shadows, SIGGRAPH 2014; Kämpe et al., I3D 2015",
            ),
            compared(
                Role::Variant,
                "table",
                64,
                "precomputed voxelized shadows, airlight table",
                "point lights in static scenes: two lookups for a lit run",
                "Sintorn et al., SIGGRAPH 2014; Kämpe et al., I3D 2015; Sun et al., SIGGRAPH 2005, for the integral",
            ),
        ]
    )
}
