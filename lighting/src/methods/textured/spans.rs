//! Shadows between the front of the first shadow volume and the back of the last one.

use std::borrow::Borrow;
use std::sync::Arc;

use gpu_backend::{Error, Host, Memory};

use super::lattice::{Placement, Steps};
use super::within_reach;
use crate::methods::hybrid::ShadowVolumes;
use crate::shadow_map::ShadowMap;
use crate::{Emitter, LightPath, LitInterval, VisibilitySource};

/// How many times the interval between a lit step and a dark one is halved to find the border.
pub(super) const HALVINGS: u32 = 3;

/// The three spans of a ray: in front of its first shadow volume and behind its last one it is
/// lit; between the two a shadow map is asked at the middle of each step.
///
/// It yields the lit runs of a ray, up to ten mean free paths to the sky. Their ends are within
/// 1/16 of a step of where the map has them; shadows and gaps shorter than a step may be
/// missed.
#[derive(Debug)]
pub struct ShadowSpans<P, M: Memory> {
    map: P,
    volumes: Option<Arc<ShadowVolumes<M>>>,
    steps: Steps,
}

impl<P: Borrow<ShadowMap<M>>, M: Memory> ShadowSpans<P, M> {
    /// For the map of a light and the light's shadow volumes; without volumes the map is asked
    /// along the whole ray. Steps are so long that `steps` of them fit across the beam: 1 to
    /// 2²⁰; other numbers count as the nearest of these.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the volumes belong to a map of another size.
    pub fn new(
        map: P,
        volumes: Option<Arc<ShadowVolumes<M>>>,
        light: &Emitter,
        steps: u32,
        placement: Placement,
    ) -> Result<Self, Error> {
        if let Some(volumes) = &volumes {
            volumes.go_with(map.borrow())?;
        }
        Ok(Self {
            map,
            volumes,
            steps: Steps::new(light, steps, placement),
        })
    }

    /// The map.
    pub fn map(&self) -> &ShadowMap<M> {
        self.map.borrow()
    }

    /// The volumes.
    pub fn volumes(&self) -> Option<&ShadowVolumes<M>> {
        self.volumes.as_deref()
    }

    #[cfg(feature = "wgpu")]
    pub(super) fn steps(&self) -> &Steps {
        &self.steps
    }
}

impl<P: Borrow<ShadowMap<Host>> + Sync> VisibilitySource for ShadowSpans<P, Host> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let whole = within_reach(path);
        let mut put = |start: f32, end: f32| {
            if start < end {
                lit.push(LitInterval::unshadowed(start, end));
            }
        };
        let asked = match &self.volumes {
            None => Some(whole),
            Some(volumes) => {
                let step = whole.length() / self.steps.count as f32;
                volumes.between(path.ray(), whole, step)
            }
        };
        let Some(asked) = asked.filter(|part| part.start < part.end) else {
            put(whole.start, whole.end);
            return;
        };
        let map = self.map();
        let is_lit = |x: f32| map.is_lit(path.ray().at(x));
        let border = |mut before: f32, mut after: f32, was_lit: bool| {
            for _ in 0..HALVINGS {
                let x = 0.5 * (before + after);
                if is_lit(x) == was_lit {
                    before = x;
                } else {
                    after = x;
                }
            }
            0.5 * (before + after)
        };
        let lattice = self.steps.of_path(path, asked);
        let mut marks = lattice.behind(asked.start);
        let (mut lit_from, mut was_lit) = (whole.start, true);
        // The last position at which it was known whether there is light, if there is one.
        let mut last = (asked.start > whole.start).then_some(asked.start);
        let mut start = asked.start;
        while start < asked.end {
            let end = marks.advance().min(asked.end);
            if !(start < end) {
                continue;
            }
            let middle = lattice.middle(start, end);
            let now_lit = is_lit(middle);
            if now_lit != was_lit {
                // A ray that begins in shadow has no border at its start.
                let at = last.map_or(start, |last| border(last, middle, was_lit));
                if was_lit {
                    put(lit_from, at);
                } else {
                    lit_from = at;
                }
                was_lit = now_lit;
            }
            (last, start) = (Some(middle), end);
        }
        if !was_lit && asked.end < whole.end {
            lit_from = border(last.unwrap_or(start), asked.end, false);
            was_lit = true;
        }
        if was_lit {
            put(lit_from, whole.end);
        }
    }
}
