//! The lines of a comparison: every method, and some of them once more.

use lighting::methods::{Entry, FrameInputs, Registry, Role};

use super::results::MethodFacts;
use crate::maps;

/// The finest refined shadow maps, texels per side.
const FINEST: u32 = 4096;

/// The coarsest of them.
const COARSEST: u32 = 16;

/// A method as a comparison shows it.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    pub(crate) entry: Entry,
    pub(crate) title: String,
    /// Its shadow maps grow along with its quality, so that both errors fall.
    pub(crate) refines_map: bool,
}

/// All methods in the order of the registry; behind them, once more, those of papers
/// and the baseline if they look into shadow maps, with maps that are refined along.
pub(crate) fn all(methods: &Registry) -> Vec<Shown> {
    let plain = methods.compared().map(|entry| Shown {
        entry: entry.clone(),
        title: entry.about().title.into(),
        refines_map: false,
    });
    let is_refined = |entry: &&Entry| {
        let about = entry.about();
        about.uses_shadow_map && matches!(about.role, Role::Paper | Role::Baseline)
    };
    let refined = methods.compared().filter(is_refined).map(|entry| Shown {
        entry: entry.clone(),
        title: format!("{}, map refined along", entry.about().title),
        refines_map: true,
    });
    plain.chain(refined).collect()
}

impl Shown {
    /// Texels per side of the shadow maps at a quality: those of the comparison, or
    /// the more the higher the quality is, and the same at the method's usual one.
    pub(crate) fn map(&self, quality: u32, inputs: &FrameInputs<'_>) -> u32 {
        if !self.refines_map {
            return inputs.map;
        }
        let usual = self.entry.about().usual.max(1);
        let proportional = u64::from(inputs.map) * u64::from(quality) / u64::from(usual);
        let finest = FINEST.max(inputs.map);
        let map = proportional.clamp(COARSEST.into(), finest.into()) as u32;
        maps::affordable(map, inputs.geometry, inputs.emitters, &mut Vec::new())
    }

    /// The method as a report knows it.
    pub(crate) fn facts(&self) -> MethodFacts {
        let about = self.entry.about();
        // The halves of a pair, the second with its quality where that is fixed.
        let (visibility, airlight) = about.name.split_once(" x ").unwrap_or((&about.name, ""));
        MethodFacts {
            visibility: visibility.into(),
            airlight: airlight.into(),
            title: self.title.clone(),
            quality: about.quality.into(),
            has_shadows: about.role != Role::Unshadowed,
            is_baseline: about.role == Role::Baseline && !self.refines_map,
            is_of_engines: about.role == Role::Engine,
            samples_shadow_map: about.uses_shadow_map,
            refines_map: self.refines_map,
            name: about.name.into_owned(),
        }
    }
}
