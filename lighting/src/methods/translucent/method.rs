//! Adaptive volumetric shadow maps: a transmittance curve of hair, smoke and see-through
//! surfaces for each texel of a light's map, which is asked in equi-angular steps.

use std::sync::Arc;

use gpu_backend::{Cpu, Host};
use transmittance::Stream;

use super::{Casters, TransmittanceMap};
use crate::Touching;
use crate::methods::march::{March, NO_PICTURE, STEPS, Spacing};
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, OfLight, Role, SourceAbout,
    SourceOn, Verdict, Work,
};

/// A march through the transmittance map of every light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curves {
    name: &'static str,
    title: &'static str,
    pub(super) spacing: Spacing,
}

/// The map of a light, in the memory of the host. It contains opaque casters too.
pub(super) fn map(
    inputs: &FrameInputs<'_>,
    light: usize,
) -> Result<Arc<TransmittanceMap<Host>>, MethodError> {
    let casters = Casters::new(inputs.translucent, Some(inputs.geometry));
    let resolution = casters.resolution(inputs.map, inputs.emitters, &inputs.emitters[light]);
    let key = OfLight { light, resolution };
    inputs
        .host
        .get("map of transmittance", key, TransmittanceMap::bytes, || {
            let (cpu, clear) = (Cpu::new(), Stream::<8>::new());
            TransmittanceMap::build_as_needed(
                &cpu,
                &casters,
                &inputs.emitters[light],
                resolution,
                &clear,
            )
            .map_err(MethodError::resource("a map of transmittance"))
        })
}

impl LightSources for Curves {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: self.name,
            title: self.title,
            quality: Some(STEPS),
            touching: Touching::Apart,
            is_sampled: true,
            sees_translucent: true,
            sees_panes: true,
            uses_shadow_map: true,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if !inputs.has_translucent_casters() {
            return Verdict::Pointless("nothing in the scene is translucent".into());
        }
        if self.spacing == Spacing::Picture
            && inputs.emitters.iter().all(|light| light.spot().is_none())
        {
            return Verdict::Pointless(NO_PICTURE.into());
        }
        Verdict::Applies
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        let maps = inputs.map_work();
        let casters = Casters::new(inputs.translucent, Some(inputs.geometry));
        let curves = 8 * casters.channels();
        Work {
            once: curves as f64 * maps.once,
            bytes: curves as u64 * maps.bytes,
            per_ray: inputs.emitters.len() as f64 * 4.0 * f64::from(steps),
            ..maps
        }
    }
}

impl SourceOn<Cpu> for Curves {
    type Source = March<Arc<TransmittanceMap<Host>>>;

    fn prepare(&self, frame: &Frame<'_, Cpu>, light: usize, _: u32) -> Result<(), MethodError> {
        map(&frame.inputs, light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, Cpu>,
        light: usize,
        steps: u32,
    ) -> Result<Self::Source, MethodError> {
        let map = map(&frame.inputs, light)?;
        Ok(March::new(map, steps, self.spacing))
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |title, purpose, paper, role| Compared {
        airlight: "gauss",
        detail: Some(1),
        title,
        purpose,
        paper,
        qualities: (&[], &[], 0),
        role,
        is_baseline: false,
    };
    let mut all = pairs!(
        Curves {
            name: "translucent",
            title: "adaptive volumetric shadow map",
            spacing: Spacing::EquiAngular,
        },
        &[compared(
            "adaptive volumetric shadow map",
            "hair, smoke and glass: a curve of 8 nodes per texel tells how much gets how far",
            "Salvi et al., Adaptive Volumetric Shadow Maps, EGSR 2010; nodes by least area instead of theirs",
            Role::Paper,
        )]
    );
    all.extend(pairs!(
        Curves {
            name: "translucent-light-space",
            title: "marching in a map of transmittance",
            spacing: Spacing::Picture,
        },
        &[compared(
            "marching in a map of transmittance",
            "soft shadows of hair, smoke and glass in beams: steps as dense as texels",
            "Gautron, Marvie and François, Volumetric Shadow Mapping, SIGGRAPH 2009 Talks (future work)",
            Role::Variant,
        )]
    ));
    all
}
