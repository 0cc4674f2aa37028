//! Visibility between 0 and 1, sampled from a map of transmittance.

use transmittance::Evaluate;

use super::VisibilitySource;
use super::march::{Spacing, for_each_step};
use crate::translucent::TransmittanceMap;
use crate::{Interval, LightPath, LitInterval};

/// Marches a ray in `samples` steps and asks the map at the middle of each which
/// share of the light gets there.
///
/// Yields one interval per step that is not dark. It goes with the same
/// evaluators as [`ShadowMapMarch`](super::ShadowMapMarch), of which it is the
/// translucent counterpart: second order in the length of a step where the
/// shadow is smooth, first order at the edges of opaque casters.
///
/// `M` is a [`TransmittanceMap`] on the CPU, and a
/// [`StoredMap`](crate::translucent::StoredMap) on a GPU.
#[derive(Debug)]
pub struct TransmittanceMarch<'a, M> {
    map: &'a M,
    samples: u32,
    spacing: Spacing,
}

impl<'a, M> TransmittanceMarch<'a, M> {
    /// A march of `samples` steps (0 counts as 1) through `map`, which must be
    /// the map of the light that is gathered.
    pub fn new(map: &'a M, samples: u32, spacing: Spacing) -> Self {
        Self {
            map,
            samples: samples.max(1),
            spacing,
        }
    }

    /// The map that is sampled.
    pub fn map(&self) -> &'a M {
        self.map
    }

    /// Number of steps per ray.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// How the steps are spread.
    pub fn spacing(&self) -> Spacing {
        self.spacing
    }
}

impl<T: Evaluate + Sync> VisibilitySource for TransmittanceMarch<'_, TransmittanceMap<T>> {
    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        for_each_step(path, self.samples, self.spacing, |start, middle, end| {
            let visibility = self.map.transmittance(path.ray().at(middle));
            if visibility > 0.0 {
                lit.push(LitInterval {
                    interval: Interval::new(start, end),
                    visibility,
                });
            }
        });
    }
}
