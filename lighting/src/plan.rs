//! What a picture needs, decided before any of it is computed.

use std::fmt;

use crate::scene::{Emitter, Medium};
use crate::scene::{Media, PhaseFunction};
use crate::{LightPath, Ray};

/// Which passes a picture needs and which it does not, each with its reason.
///
/// Made from the lights, the medium and the rays of the view. Leaving out what
/// the plan leaves out never changes the picture: only emitters are dropped
/// whose airlight is 0 along every ray.
///
/// `Display` writes one line per pass.
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
/// assert_eq!(plan.to_string(), "left out: airlight (no medium)\n");
/// # Ok::<(), lighting::scene::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    passes: Vec<Pass>,
    left_out: Vec<LeftOut>,
    emitters: Vec<usize>,
}

/// A pass that will run.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pass {
    /// The airlight of these emitters, by any pair of visibility and evaluator.
    Airlight {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// For methods that look into shadow maps: one map each.
    ShadowMaps {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
    /// For equi-angular methods: steps of equal angle at these emitters.
    EquiAngularSteps {
        /// Indices of the emitters.
        emitters: Vec<usize>,
    },
}

/// A pass that will not run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// What would have run.
    pub subject: Subject,
    /// Why it need not.
    pub reason: Reason,
}

/// What can be left out.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Subject {
    /// All airlight: no emitter is gathered.
    Airlight,
    /// The airlight of these emitters, and their shadow maps.
    Emitters(Vec<usize>),
    /// Steps of equal angle.
    EquiAngularSteps,
}

/// Why something is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// Vacuum scatters nothing.
    NoMedium,
    /// The medium absorbs but does not scatter.
    NothingScattered,
    /// The scene has no light.
    NoLight,
    /// The light emits nothing.
    Dark,
    /// No ray of the view meets the medium within the light's range and cone.
    NeverMeetsTheView,
    /// Parallel light is seen from everywhere under one direction.
    OnlyDirectionalLight,
}

impl Plan {
    /// The plan for the airlight of `emitters` in `medium` (`None` is a
    /// vacuum) along `rays`.
    ///
    /// Costs at most one intersection of each ray with the cone, the range and
    /// the box of each emitter; an emitter that is needed is usually known to
    /// be after a few rays.
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
        };
        let (Some(medium), None) = (medium, nothing) else {
            plan.left_out.extend(nothing.map(|reason| LeftOut {
                subject: Subject::Airlight,
                reason,
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
        plan.leave_out(dark, Reason::Dark);
        plan.leave_out(unseen, Reason::NeverMeetsTheView);
        plan.add_passes(emitters);
        plan
    }

    /// The same for media that may be heterogeneous: smoke may be anywhere along the rays.
    pub fn of_media(emitters: &[Emitter], media: &Media<'_>, rays: &[Ray]) -> Self {
        if media.is_homogeneous() {
            return Self::new(emitters, media.medium(), rays);
        }
        let everywhere = Medium::new(glam::Vec3::ONE, glam::Vec3::ZERO, PhaseFunction::Isotropic)
            .expect("a sound medium");
        Self::new(emitters, Some(&everywhere), rays)
    }

    /// Indices of the emitters whose airlight is gathered, rising.
    pub fn emitters(&self) -> &[usize] {
        &self.emitters
    }

    /// What runs.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// What does not.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    fn leave_out(&mut self, emitters: Vec<usize>, reason: Reason) {
        if !emitters.is_empty() {
            self.left_out.push(LeftOut {
                subject: Subject::Emitters(emitters),
                reason,
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
            });
        } else {
            self.passes
                .push(Pass::EquiAngularSteps { emitters: points });
        }
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for pass in &self.passes {
            writeln!(f, "runs: {pass}")?;
        }
        for LeftOut { subject, reason } in &self.left_out {
            writeln!(f, "left out: {subject} ({reason})")?;
        }
        Ok(())
    }
}

impl fmt::Display for Pass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, emitters) = match self {
            Self::Airlight { emitters } => ("airlight of", emitters),
            Self::ShadowMaps { emitters } => ("if marched or voxelized, shadow map of", emitters),
            Self::EquiAngularSteps { emitters } => {
                ("if asked for, equi-angular steps at", emitters)
            }
        };
        write!(f, "{what} {}", list(emitters))
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Airlight => f.write_str("airlight"),
            Self::Emitters(emitters) => write!(f, "airlight of {}", list(emitters)),
            Self::EquiAngularSteps => f.write_str("equi-angular steps"),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoMedium => "no medium",
            Self::NothingScattered => "the medium scatters nothing",
            Self::NoLight => "no light",
            Self::Dark => "no intensity",
            Self::NeverMeetsTheView => "range and cone never meet the view inside the medium",
            Self::OnlyDirectionalLight => "a directional light has no equi-angular variable",
        })
    }
}

/// `emitter 3`, `emitters 0 to 4, 7`.
fn list(indices: &[usize]) -> String {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for &index in indices {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == index => *last = index,
            _ => runs.push((index, index)),
        }
    }
    let texts: Vec<String> = runs
        .iter()
        .map(|&(first, last)| match last - first {
            0 => first.to_string(),
            1 => format!("{first}, {last}"),
            _ => format!("{first} to {last}"),
        })
        .collect();
    let plural = if indices.len() == 1 { "" } else { "s" };
    format!("emitter{plural} {}", texts.join(", "))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};
    use gpu_backend::Cpu;
    use reference::random::noise;

    use super::*;
    use crate::airlight::EquiAngular;
    use crate::scene::{Bounds, Cone, Emission, PhaseFunction};
    use crate::visibility::Unshadowed;
    use crate::{Gather, LitRays};

    fn fog() -> Medium {
        Medium::new(
            Vec3::splat(0.1),
            Vec3::splat(0.02),
            PhaseFunction::HenyeyGreenstein { g: 0.5 },
        )
        .unwrap()
    }

    /// A narrow picture along -Z.
    fn view() -> Vec<Ray> {
        (0..200)
            .map(|i| {
                let (x, y) = ((i % 20) as f32 / 20.0 - 0.5, (i / 20) as f32 / 10.0 - 0.5);
                let length = if i % 7 == 0 { f32::INFINITY } else { 12.0 };
                Ray::new(Vec3::ZERO, Vec3::new(x, y, -1.0), length).unwrap()
            })
            .collect()
    }

    /// Lights of every kind all around the view, some of them in vain.
    fn lights() -> Vec<Emitter> {
        let mut all = vec![
            Emitter::directional(Vec3::new(0.3, -1.0, 0.2), Vec3::ONE).unwrap(),
            Emitter::directional(Vec3::NEG_Y, Vec3::ZERO).unwrap(),
        ];
        let cone = Cone {
            inner: 0.1,
            outer: 0.4,
        };
        for i in 0..60_u32 {
            let unit = |k: u32| noise(u64::from(i * 9 + k));
            let position = 30.0 * Vec3::new(unit(0) - 0.5, unit(1) - 0.5, unit(2) - 0.7);
            let turn = Quat::from_euler(glam::EulerRot::YXZ, 6.3 * unit(3), 3.0 * unit(4), 0.0);
            let emission = match i % 3 {
                0 => Emission::Isotropic,
                1 => Emission::spot(turn, cone, None).unwrap(),
                _ => Emission::Cosine {
                    normal: turn * Vec3::X,
                },
            };
            let intensity = if i % 10 == 9 { 0.0 } else { 5.0 };
            let range = 1.0 + 8.0 * unit(5);
            let light = Emitter::point(position, Vec3::splat(intensity), range, emission);
            all.push(light.unwrap());
        }
        all
    }

    fn picture<'a>(emitters: impl Iterator<Item = &'a Emitter>, medium: &Medium) -> Vec<[f32; 4]> {
        let rays = view();
        let mut radiance = vec![[0.0; 4]; rays.len()];
        let rule = EquiAngular::new(8).unwrap();
        for emitter in emitters {
            Cpu::new()
                .gather(
                    &LitRays::new(&rays, emitter, medium),
                    &Unshadowed,
                    &rule,
                    &mut radiance,
                )
                .unwrap();
        }
        radiance
    }

    #[test]
    fn what_is_left_out_does_not_change_a_bit_of_the_picture() {
        let in_a_box = Bounds::new(Vec3::new(-4.0, -1.0, -9.0), Vec3::new(2.0, 1.0, -2.0)).unwrap();
        let nothing = Medium::new(Vec3::ZERO, Vec3::ONE, PhaseFunction::Isotropic).unwrap();
        for medium in [fog(), fog().within(in_a_box), nothing] {
            let all = lights();
            let plan = Plan::new(&all, Some(&medium), &view());
            let forced = picture(all.iter(), &medium);
            let planned = picture(plan.emitters().iter().map(|index| &all[*index]), &medium);
            assert_eq!(forced, planned);
            let skipped = all.len() - plan.emitters().len();
            assert!(skipped > 10, "{skipped} of {} were skipped", all.len());
        }
    }

    #[test]
    fn every_reason_is_given_where_it_holds() {
        let (all, rays) = (lights(), view());
        let reasons = |emitters: &[Emitter], medium: Option<&Medium>, rays: &[Ray]| {
            let plan = Plan::new(emitters, medium, rays);
            plan.left_out().iter().map(|l| l.reason).collect::<Vec<_>>()
        };
        let medium = fog();
        let black = Medium::new(Vec3::ZERO, Vec3::ONE, PhaseFunction::Isotropic).unwrap();
        let sun = &all[..1];
        assert_eq!(reasons(&all, None, &rays), [Reason::NoMedium]);
        assert_eq!(
            reasons(&all, Some(&black), &rays),
            [Reason::NothingScattered]
        );
        assert_eq!(reasons(&[], Some(&medium), &rays), [Reason::NoLight]);
        assert_eq!(
            reasons(sun, Some(&medium), &rays),
            [Reason::OnlyDirectionalLight]
        );
        assert_eq!(
            reasons(sun, Some(&medium), &[]),
            [Reason::NeverMeetsTheView]
        );
        let mixed = reasons(&all, Some(&medium), &rays);
        assert_eq!(mixed, [Reason::Dark, Reason::NeverMeetsTheView]);
    }

    #[test]
    fn a_plan_can_be_read() {
        let all = lights();
        let text = Plan::new(&all[..2], Some(&fog()), &view()).to_string();
        assert_eq!(
            text,
            "runs: airlight of emitter 0\n\
             runs: if marched or voxelized, shadow map of emitter 0\n\
             left out: airlight of emitter 1 (no intensity)\n\
             left out: equi-angular steps (a directional light has no equi-angular variable)\n"
        );
        assert_eq!(list(&[0, 1, 2, 5, 7, 8]), "emitters 0 to 2, 5, 7, 8");
    }
}
