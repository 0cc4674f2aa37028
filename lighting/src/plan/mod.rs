//! What a picture needs, decided before any of it is computed.
//!
//! # What a plan does not leave out
//!
//! * *Casters whose shadows one view does not show.* Shadow maps, voxels and curves are kept
//!   for all frames, and the camera may move without new ones. What is out of sight in one
//!   frame is needed in the next.
//! * *Voxels finer than pixels.* They are more exact even where a pixel sees several: with at
//!   most two along an axis for each pixel of the picture's diagonal, the error of one of the
//!   embedded scenes rose by 4 %.
//! * *Rays that meet no shadow.* To find them is to ask for their shadows. Methods that gain by
//!   it ask for each ray, as `hybrid` does.

#[cfg(feature = "methods")]
mod casters;
#[cfg(feature = "methods")]
mod frame;
#[cfg(feature = "methods")]
mod hull;
mod parts;
#[cfg(test)]
mod tests;
mod words;

pub use parts::{LeftOut, Pass, Reason, Saving, Subject};

use crate::scene::{Emitter, Media, Medium, PhaseFunction};
use crate::{LightPath, Ray};

/// Which passes a picture needs, and which it does not need and why.
///
/// A plan is made from the lights, the medium and the rays of a view, or, with the feature
/// `methods`, from a whole frame (`Plan::of_frame`). What it leaves out never changes the
/// picture: it drops only emitters whose airlight is 0 along every ray, and only shadows of
/// lights that light everything in the view that they reach.
///
/// `Display` writes one line for each pass and one for each thing that is left out.
///
/// ```
/// use glam::Vec3;
/// use lighting::plan::Plan;
/// use lighting::{Emitter, Ray};
///
/// let sun = Emitter::directional(Vec3::NEG_Y, Vec3::ONE)?;
/// let rays = [Ray::new(Vec3::ZERO, Vec3::X, 5.0).expect("a sound ray")];
/// let plan = Plan::new(&[sun], None, &rays);
/// assert!(plan.emitters().is_empty());
/// assert_eq!(plan.to_string(), "left out: airlight (no medium; saves 1 ray)\n");
/// # Ok::<(), lighting::scene::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    passes: Vec<Pass>,
    left_out: Vec<LeftOut>,
    emitters: Vec<usize>,
    unshadowed: Vec<usize>,
}

impl Plan {
    /// The plan for the airlight of `emitters` along `rays` in `medium`; `None` is a vacuum.
    ///
    /// Each ray is intersected at most once with the cone, the range and the box of each
    /// emitter. For an emitter that is needed, a few rays usually suffice.
    pub fn new(emitters: &[Emitter], medium: Option<&Medium>, rays: &[Ray]) -> Self {
        let nothing = match medium {
            None => Some(Reason::NoMedium),
            Some(medium) if medium.scatters_nothing() => Some(Reason::NothingScattered),
            Some(_) if emitters.is_empty() => Some(Reason::NoLight),
            Some(_) => None,
        };
        let mut plan = Self {
            passes: Vec::new(),
            left_out: Vec::new(),
            emitters: Vec::new(),
            unshadowed: Vec::new(),
        };
        let asked = |emitters: usize| Saving {
            rays: rays.len() as u64 * emitters as u64,
            ..Saving::NOTHING
        };
        let (Some(medium), None) = (medium, nothing) else {
            plan.left_out.extend(nothing.map(|reason| LeftOut {
                subject: Subject::Airlight,
                reason,
                saving: asked(emitters.len()),
            }));
            return plan;
        };
        let (mut dark, mut unseen) = (Vec::new(), Vec::new());
        for (index, emitter) in emitters.iter().enumerate() {
            if emitter.intensity() == glam::Vec3::ZERO {
                dark.push(index);
            } else if rays
                .iter()
                .any(|ray| LightPath::new(ray, emitter, medium).is_some())
            {
                plan.emitters.push(index);
            } else {
                unseen.push(index);
            }
        }
        for (left_out, reason) in [(dark, Reason::Dark), (unseen, Reason::NeverMeetsTheView)] {
            let saving = asked(left_out.len());
            plan.leave_out(left_out, Subject::Emitters, reason, saving);
        }
        plan.add_passes(emitters);
        plan
    }

    /// The same for media that may be heterogeneous, for which smoke may be anywhere along the
    /// rays.
    pub fn of_media(emitters: &[Emitter], media: &Media<'_>, rays: &[Ray]) -> Self {
        if media.is_homogeneous() {
            return Self::new(emitters, media.medium(), rays);
        }
        let everywhere = Medium::new(glam::Vec3::ONE, glam::Vec3::ZERO, PhaseFunction::Isotropic)
            .expect("a sound medium");
        Self::new(emitters, Some(&everywhere), rays)
    }

    /// Indices of the emitters whose airlight is gathered, in rising order.
    pub fn emitters(&self) -> &[usize] {
        &self.emitters
    }

    /// Indices of those among them that nothing blocks, whose airlight has a closed form, in
    /// rising order.
    pub fn unshadowed(&self) -> &[usize] {
        &self.unshadowed
    }

    /// The passes that run.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// What does not run, with the reasons.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    fn leave_out(
        &mut self,
        emitters: Vec<usize>,
        subject: impl FnOnce(Vec<usize>) -> Subject,
        reason: Reason,
        saving: Saving,
    ) {
        if !emitters.is_empty() {
            self.left_out.push(LeftOut {
                subject: subject(emitters),
                reason,
                saving,
            });
        }
    }

    fn add_passes(&mut self, emitters: &[Emitter]) {
        if self.emitters.is_empty() {
            return;
        }
        let gathered = self.emitters.clone();
        let is_point = |index: &usize| matches!(emitters[*index], Emitter::Point(_));
        let points: Vec<usize> = gathered.iter().copied().filter(is_point).collect();
        self.passes.push(Pass::Airlight {
            emitters: gathered.clone(),
        });
        self.passes.push(Pass::ShadowMaps { emitters: gathered });
        if points.is_empty() {
            self.left_out.push(LeftOut {
                subject: Subject::EquiAngularSteps,
                reason: Reason::OnlyDirectionalLight,
                saving: Saving::NOTHING,
            });
        } else {
            self.passes
                .push(Pass::EquiAngularSteps { emitters: points });
        }
    }
}
