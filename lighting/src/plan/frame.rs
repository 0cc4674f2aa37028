//! Plans that know a whole frame.

use super::casters::{Search, Source, corners};
use super::{LeftOut, Pass, Plan, Reason, Saving, Subject};
use crate::culling;
use crate::methods::{FrameInputs, MethodError};

impl Plan {
    /// The plan of a frame, casters included.
    ///
    /// # Errors
    /// Those of [`Plan::with_casters`].
    pub fn of_frame(inputs: &FrameInputs<'_>) -> Result<Self, MethodError> {
        Self::of_media(inputs.emitters, &inputs.media(), inputs.rays).with_casters(inputs)
    }

    /// Completes a plan of the emitters, the medium and the rays of a frame. It adds which
    /// lights nothing blocks, which shadows can be precomputed for all frames, and what methods
    /// leave out by themselves under conditions that they test in the frame.
    ///
    /// The points of an area light are unshadowed if no caster is in the way of any point of
    /// its area, so that this holds for the points that methods choose, too. No light is tested
    /// if the medium is heterogeneous.
    ///
    /// A light that casts shadows on most of the view costs 64 shadow rays. Other lights cost
    /// at most 16 boxes of the BVH per ray.
    ///
    /// # Errors
    /// Those of [`FrameInputs::tracer`] and [`FrameInputs::is_covered`].
    pub fn with_casters(mut self, inputs: &FrameInputs<'_>) -> Result<Self, MethodError> {
        for part in &mut self.left_out {
            if let Subject::Emitters(emitters) = &part.subject {
                let maps = shadow_maps(inputs, emitters);
                part.saving = Saving {
                    rays: part.saving.rays,
                    ..maps
                };
            }
        }
        if self.emitters.is_empty() {
            return Ok(self);
        }
        if inputs.media().is_homogeneous() {
            self.find_unshadowed(inputs)?;
        }
        self.find_dynamic(inputs);
        let gathered = self.emitters.iter().map(|index| &inputs.emitters[*index]);
        let reasons = [
            (
                !culling::is_worthwhile(gathered),
                Subject::LightLists,
                Reason::FewBoundedLights,
            ),
            (inputs.areas.is_empty(), Subject::Atlas, Reason::NoArea),
            (!inputs.has_cookies(), Subject::Cookies, Reason::NoCookie),
            (
                !inputs.has_translucent_casters(),
                Subject::Curves,
                Reason::NothingTranslucent,
            ),
            (
                !inputs.is_covered()?,
                Subject::Panes,
                Reason::NothingCoversTheAir,
            ),
        ];
        for (holds, subject, reason) in reasons {
            if holds {
                self.left_out.push(LeftOut {
                    subject,
                    reason,
                    saving: Saving::NOTHING,
                });
            }
        }
        Ok(self)
    }

    /// What methods with precomputed shadows make once, and what they make again.
    fn find_dynamic(&mut self, inputs: &FrameInputs<'_>) {
        let is_shadowed = |index: &usize| !self.unshadowed.contains(index);
        let shadowed: Vec<usize> = self.emitters.iter().copied().filter(is_shadowed).collect();
        // Where all is dynamic there is nothing to bake.
        if shadowed.is_empty() || inputs.geometry.static_part().is_none() {
            return;
        }
        let (moving, still): (Vec<usize>, Vec<usize>) =
            (shadowed.iter()).partition(|index| inputs.dynamic_reached(**index).is_some());
        self.passes.push(Pass::Bakes { emitters: shadowed });
        if !moving.is_empty() {
            self.passes.push(Pass::DynamicMaps { emitters: moving });
        }
        let (reason, saving) = match inputs.geometry.dynamic_part() {
            None => (Reason::NothingMoves, Saving::NOTHING),
            Some(_) => (Reason::ReachesNothingDynamic, shadow_maps(inputs, &still)),
        };
        self.leave_out(still, Subject::DynamicMaps, reason, saving);
    }

    fn find_unshadowed(&mut self, inputs: &FrameInputs<'_>) -> Result<(), MethodError> {
        let mut search = Search::new(inputs)?;
        let mut areas = Vec::new();
        for area in inputs.areas {
            let is_needed = self
                .emitters
                .iter()
                .any(|index| area.emitters.contains(index));
            let points = inputs.emitters.get(area.emitters.clone());
            let points = points.filter(|points| is_needed && !points.is_empty());
            // A light without sound corners has no points that methods could choose.
            let is_clear = (points.zip(corners(&area.light).ok()))
                .is_some_and(|(some, corners)| search.is_unshadowed(Source::area(&corners, some)));
            areas.push((area.emitters.clone(), is_clear));
        }
        let all = self.emitters.iter().copied();
        let (unshadowed, shadowed): (Vec<usize>, Vec<usize>) = all.partition(|index| {
            match areas.iter().find(|(emitters, _)| emitters.contains(index)) {
                Some((_, is_clear)) => *is_clear,
                None => search.is_unshadowed(Source::new(&inputs.emitters[*index])),
            }
        });
        if unshadowed.is_empty() {
            return Ok(());
        }
        for pass in &mut self.passes {
            if let Pass::Airlight { emitters } | Pass::ShadowMaps { emitters } = pass {
                emitters.clone_from(&shadowed);
            }
        }
        if shadowed.is_empty() {
            let is_shadowed =
                |pass: &Pass| !matches!(pass, Pass::Airlight { .. } | Pass::ShadowMaps { .. });
            self.passes.retain(is_shadowed);
        }
        self.passes.push(Pass::Unshadowed {
            emitters: unshadowed.clone(),
        });
        let saving = Saving {
            rays: (inputs.rays.len() * unshadowed.len()) as u64,
            ..shadow_maps(inputs, &unshadowed)
        };
        self.unshadowed.clone_from(&unshadowed);
        self.leave_out(
            unshadowed,
            Subject::Shadows,
            Reason::NothingInTheWay,
            saving,
        );
        Ok(())
    }
}

/// What the shadow maps of some emitters would take.
fn shadow_maps(inputs: &FrameInputs<'_>, emitters: &[usize]) -> Saving {
    let faces = inputs.map_faces(emitters.iter().map(|index| &inputs.emitters[*index]));
    let texels = faces as u64 * u64::from(inputs.map).pow(2);
    Saving {
        rays: 0,
        texels,
        bytes: 4 * texels,
    }
}
