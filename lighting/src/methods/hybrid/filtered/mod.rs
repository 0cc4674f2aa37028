//! A march between volumes whose steps are lit in part.

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

/// A march between volumes of shadow and of light that asks what share of each step is lit.
///
/// Casters that are finer than a step, as leaves and hair are, count as a texture: what is
/// asked, a [`MomentPyramid`](crate::methods::prefiltered::MomentPyramid) say, is
/// [filtered over the step](PointVisibility::visibility_between). What cannot be filtered is
/// asked in the middle.
///
/// Yields one part for each step that is not dark, and what lies before and behind the
/// volumes as a whole. Steps have no borders to be found by halving: a shadow that begins
/// within a step darkens it by its share. The fronts and backs of volumes are where they are
/// in [`Hybrid`](super::Hybrid), and steps are spread over what lies between
/// ([`Spread::Span`]).
#[derive(Debug)]
pub struct FilteredHybrid<P, M: Memory> {
    points: P,
    volumes: Option<Arc<ShadowVolumes<M>>>,
    lit_volumes: Option<Arc<LitVolumes<M>>>,
    steps: u32,
}

impl<P, M: Memory> FilteredHybrid<P, M> {
    /// A march of `steps` steps (0 counts as 1) that asks `points`, between volumes of the
    /// same light; without any volumes all of the ray is marched.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the two kinds of volumes go with maps of different
    /// sizes.
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

    /// What is asked at every step.
    pub fn points(&self) -> &P {
        &self.points
    }

    /// The volumes of shadow.
    pub fn volumes(&self) -> Option<&ShadowVolumes<M>> {
        self.volumes.as_deref()
    }

    /// The volumes of light.
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
        // What is known of the steps that are not asked about: before the first, and those
        // that are leaped over.
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
