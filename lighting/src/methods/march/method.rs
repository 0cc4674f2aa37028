//! Marches along rays, in which the light's shadow map says of each step whether it is lit.

use std::sync::Arc;

use super::{March, Spacing};
use crate::Touching;
use crate::methods::evaluators::Midpoints;
use crate::methods::reduced::{Reduced, Reduction, ShownAs};
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, PerLight, Role, SourceAbout,
    SourceOn, SourceQuality, Verdict, Work,
};
use crate::shadow_map::{RenderShadowMap, ShadowMap};

/// The steps of every method that takes steps along rays.
pub(in crate::methods) const STEPS: SourceQuality = SourceQuality {
    unit: "steps",
    qualities: &[4, 8, 16, 32, 64, 128, 256],
    quick: &[8, 32, 128],
    pictured: 32,
    usual: 64,
};

/// A march through the shadow map of every light.
#[derive(Debug, Clone, Copy)]
pub(in crate::methods) struct Marches {
    pub(in crate::methods) name: &'static str,
    pub(in crate::methods) title: &'static str,
    pub(in crate::methods) spacing: Spacing,
    pub(in crate::methods) touching: Touching,
}

/// Why equal angles are pointless for suns.
pub(super) const NO_ANGLE: &str = "a directional light has no equi-angular variable";

/// Why steps in a picture are pointless for other lights.
pub(in crate::methods) const NO_PICTURE: &str = "only a spotlight has a picture on one plane";

impl LightSources for Marches {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: self.name,
            title: self.title,
            quality: Some(STEPS),
            touching: self.touching,
            is_sampled: self.touching == Touching::Apart,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if self.spacing == Spacing::EquiAngular && inputs.has_only_suns() {
            return Verdict::Pointless(NO_ANGLE.into());
        }
        if self.spacing == Spacing::Picture
            && inputs.emitters.iter().all(|light| light.spot().is_none())
        {
            return Verdict::Pointless(NO_PICTURE.into());
        }
        Verdict::Applies
    }

    fn interleaves(&self) -> Verdict {
        match self.touching {
            Touching::Apart => Verdict::Applies,
            Touching::Joined => {
                Verdict::Impossible("steps that rays share do not touch, to be joined".into())
            }
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps),
            ..inputs.map_work()
        }
    }
}

impl<B: RenderShadowMap> SourceOn<B> for Marches {
    type Source = March<Arc<ShadowMap<B::Memory>>>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, _: u32) -> Result<(), MethodError> {
        frame.shadow_map(light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        steps: u32,
    ) -> Result<Self::Source, MethodError> {
        let march = March::new(frame.shadow_map(light)?, steps, self.spacing);
        Ok(match self.touching {
            Touching::Apart => march.interleaved(frame.inputs.selection.interleaving),
            Touching::Joined => march,
        })
    }
}

/// The march at fewer pixels, and with fewer steps at each.
fn reduced(march: Marches) -> Vec<Entry> {
    let march = PerLight::new(march, Midpoints, None);
    let shown = |name, title, purpose, paper| ShownAs {
        name,
        title,
        purpose,
        paper,
        qualities: &[8, 32, 128],
        quick: &[32],
        pictured: 32,
    };
    let quarter = shown(
        "march quarter",
        "ray marching, a quarter of the pixels",
        "fog without thin shafts, at a quarter of the cost of any method",
        "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008, section 3.3",
    );
    let shared = shown(
        "march 2x2",
        "ray marching, interleaved 2 x 2",
        "the steps of a ray shared with its neighbours: as sharp along the ray as all of them",
        "Keller and Heidrich, Interleaved Sampling, EGWR 2001",
    );
    vec![
        Entry::everywhere(Reduced::new(march.clone(), Reduction::QUARTER).shown_as(quarter)),
        Entry::everywhere(Reduced::new(march, Reduction::WINDOWS_OF_2).shown_as(shared)),
    ]
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
    let sources = |name, title, spacing, touching| Marches {
        name,
        title,
        spacing,
        touching,
    };
    let mut all = pairs!(
        sources("march", "ray marching", Spacing::Distance, Touching::Apart),
        &[compared(
            Role::Baseline,
            "midpoint",
            1,
            "ray marching",
            "the classical baseline: any light, any medium, least code",
            "folklore; as the comparison in Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013",
        )]
    );
    all.extend(reduced(sources(
        "march",
        "ray marching",
        Spacing::Distance,
        Touching::Apart,
    )));
    all.extend(pairs!(
        sources(
            "march-merged",
            "ray marching, lit runs merged",
            Spacing::Distance,
            Touching::Joined
        ),
        &[
            compared(
                Role::Paper,
                "gauss",
                8,
                "ray marching, lit runs merged",
                "as ray marching, but the light of a lit run does not depend on the steps",
                "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008 (march between shadow bounds)",
            ),
            compared(
                Role::Variant,
                "frame-table",
                128,
                "ray marching, lit runs merged, table of the frame",
                "the same with two lookups for a run, in a table that each frame makes for each light",
                "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008, section 3.4",
            ),
        ]
    ));
    all.extend(pairs!(
        sources(
            "equi-angular",
            "equi-angular sampling",
            Spacing::EquiAngular,
            Touching::Apart
        ),
        &[compared(
            Role::Variant,
            "gauss",
            1,
            "equi-angular sampling",
            "point lights in view: steps gather where the inverse square is large",
            "Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012",
        )]
    ));
    all.extend(pairs!(
        sources(
            "equi-angular-merged",
            "equi-angular sampling, lit runs merged",
            Spacing::EquiAngular,
            Touching::Joined
        ),
        &[
            compared(
                Role::Variant,
                "gauss",
                8,
                "equi-angular sampling, lit runs merged",
                "point lights in view, with runs of lit steps integrated as one",
                "Kulla and Fajardo, EGSR 2012, for the steps; Sun et al., SIGGRAPH 2005, for the integral",
            ),
            compared(
                Role::Variant,
                "table",
                64,
                "equi-angular sampling, lit runs merged, airlight table",
                "point lights in view, with two lookups for a run of lit steps",
                "Kulla and Fajardo, EGSR 2012, for the steps; Sun et al., SIGGRAPH 2005, for the integral",
            ),
        ]
    ));
    all
}
