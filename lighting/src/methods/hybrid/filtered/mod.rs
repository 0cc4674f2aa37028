//! A march between volumes whose steps may be partly lit.

#[cfg(feature = "wgpu")]
mod gpu;
#[cfg(feature = "methods")]
mod method;
#[cfg(test)]
mod tests;

#[cfg(feature = "methods")]
pub(in crate::methods) use method::methods;

use std::sync::Arc;

use gpu_backend::{Error, Host, Memory};

use super::asking::Asking;
use super::{LitVolumes, ShadowVolumes, Spread, Volumes};
use crate::visibility::{LitInterval, PointVisibility, Share, VisibilitySource};
use crate::{Interval, LightPath};

/// A march between volumes of shadow and of light that asks which share of each step is lit.
///
/// Casters that are finer than a step, such as leaves and hair, are treated as a texture: a
/// source such as a [`MomentPyramid`](crate::methods::prefiltered::MomentPyramid) is [filtered
/// over the step](PointVisibility::visibility_between). A source that cannot be filtered is
/// asked at the middle.
///
/// It yields one part for each step that is not dark, and the parts in front of the volumes and
/// behind them as a whole. Borders are not found by halving: a shadow that begins within a step
/// darkens the step by its share. The fronts and backs of volumes are those of
/// [`Hybrid`](super::Hybrid), and steps are spread over the part between them
/// ([`Spread::Span`]).
#[derive(Debug)]
pub struct FilteredHybrid<P, M: Memory> {
    points: P,
    volumes: Option<Arc<ShadowVolumes<M>>>,
    lit_volumes: Option<Arc<LitVolumes<M>>>,
    steps: u32,
}

impl<P, M: Memory> FilteredHybrid<P, M> {
    /// A march of `steps` steps (0 counts as 1) that asks `points`, between volumes of the same
    /// light. Without volumes, the whole of every ray is marched.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the two kinds of volumes belong to maps of different sizes.
    pub fn new(
        points: P,
        volumes: Option<Arc<ShadowVolumes<M>>>,
        lit_volumes: Option<Arc<LitVolumes<M>>>,
        steps: u32,
    ) -> Result<Self, Error> {
        if let (Some(shadow), Some(light)) = (&volumes, &lit_volumes) {
            let [expected, actual] = [&shadow.cells, &light.cells].map(|cells| {
                let (resolution, pictures) = cells.of_map();
                resolution as usize * pictures
            });
            if expected != actual {
                return Err(Error::LengthMismatch {
                    what: "the texels per side of a map with volumes, times its faces",
                    expected,
                    actual,
                });
            }
        }
        Ok(Self {
            points,
            volumes,
            lit_volumes,
            steps: steps.max(1),
        })
    }

    /// The source that is asked at every step.
    pub fn points(&self) -> &P {
        &self.points
    }

    /// The shadow volumes.
    pub fn volumes(&self) -> Option<&ShadowVolumes<M>> {
        self.volumes.as_deref()
    }

    /// The lit volumes.
    pub fn lit_volumes(&self) -> Option<&LitVolumes<M>> {
        self.lit_volumes.as_deref()
    }

    /// Number of steps.
    pub fn steps(&self) -> u32 {
        self.steps
    }
}

impl<P> FilteredHybrid<P, Host> {
    fn asking(&self, path: &LightPath<'_>) -> Asking<'_> {
        let volumes = Volumes {
            shadow: self.volumes(),
            light: self.lit_volumes(),
        };
        let origin = volumes.origin().unwrap_or_default();
        Asking::new(path, origin, volumes, (self.steps, Spread::Span))
    }
}

impl<P: PointVisibility> VisibilitySource for FilteredHybrid<P, Host> {
    type Share = P::Share;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval<P::Share>>) {
        let at = |x: f32| path.ray().at(x);
        let mut put = |start: f32, end: f32, visibility: P::Share| {
            if start < end && !visibility.is_dark() {
                lit.push(LitInterval {
                    interval: Interval::new(start, end),
                    visibility,
                });
            }
        };
        let mut asking = self.asking(path);
        let (steps, whole) = (asking.steps, asking.whole());
        // Steps that do not ask have a known result: those in front of the first one that asks,
        // and those that are skipped.
        let (mut from, mut is_known_lit) = (whole.start, asking.is_lit_before());
        while let Some((number, share)) = asking.next_step(|steps, number| {
            let [start, end] = [number, number + 1].map(|number| at(steps.start(number)));
            let share = self.points.visibility_between(start, end);
            let is_either = share == Share::ALL || share.is_dark();
            (share, is_either.then_some(share == Share::ALL))
        }) {
            let [start, end] = [number, number + 1].map(|number| steps.start(number));
            if is_known_lit {
                put(from, start, Share::ALL);
            }
            put(start, end, share);
            (from, is_known_lit) = (end, share == Share::ALL);
        }
        let (end, is_lit_behind) = asking.rest();
        if is_known_lit {
            put(from, end, Share::ALL);
        }
        if is_lit_behind {
            put(from.max(end), whole.end, Share::ALL);
        }
    }
}
