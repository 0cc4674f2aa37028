//! Voxelized shadow volumes without a picture: how long their steps take, from which of their
//! resolutions an error comes, and how far behind their casters shadows begin.
//!
//! Table 1 and figures 7 and 8 of Wyman and Dai, "Imperfect Voxelized Shadow
//! Volumes", 2013, in numbers.

mod detachment;
mod resolutions;
mod steps;

use gpu_backend::{Cpu, Host};
use lighting::scene::trace::Tracer;
use lighting::scene::{Geometry, Medium};
use lighting::shadow_map::{Casters, RenderShadowMap, ShadowMap};
use lighting::voxelized::Eye;
use lighting::{Emitter, Ray};
use reference::oracle::image::{Options, reference};

use super::{Kind, Limit, Subject, record, value_columns};
use crate::compare::study::Study;
use crate::failure::Failure;
use crate::progress;
use detachment::Detachments;
use resolutions::Refinements;
use steps::Steps;

pub(super) const KIND: Kind = Kind {
    title: "voxelized shadow volumes",
    csv: "voxels.csv",
    columns: value_columns,
    seconds: Some([1.5, 15.0]),
    in_fog: true,
    pointless,
    run,
};

/// Resolutions that are compared, the finest last.
const SIZES: &[u32] = &[64, 128, 256, 512];
const QUICK_SIZES: &[u32] = &[64, 512];

/// Rays on which errors are measured.
const RAYS: usize = 2400;

/// One light of a scene, and the rays that see it.
#[derive(Clone, Copy)]
struct Scene<'a> {
    geometry: &'a Geometry,
    tracer: &'a Tracer,
    medium: &'a Medium,
    emitter: &'a Emitter,
    eye: Eye,
    rays: &'a [Ray],
    /// Texels per side of a shadow map.
    map: u32,
}

impl<'a> Scene<'a> {
    /// The first light that is seen; `None` if there is none.
    fn of(subject: &Subject<'a>) -> Option<Self> {
        let size = [subject.size.width, subject.size.height];
        Some(Self {
            geometry: subject.geometry,
            tracer: subject.tracer,
            medium: subject.medium,
            emitter: subject.emitters.first()?,
            eye: Eye::of_camera(subject.camera, size, subject.rays, subject.medium),
            rays: subject.rays,
            map: subject.map,
        })
    }
}

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    if !subject.translucent.is_empty() {
        return Some("they do not see hair and smoke");
    }
    let none = subject.emitters.is_empty();
    none.then_some("no light that voxels could be made for")
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let Some(scene) = Scene::of(subject) else {
        return Ok(study);
    };
    let (refinements, detachments) = match limit.reached() {
        Some(why) => {
            study.leave_out("resolutions and detachment", why);
            (Refinements::default(), Detachments::default())
        }
        None => measure_errors(&mut study, scene, subject.quick, limit)?,
    };
    let mut all_steps = Vec::new();
    for device in &subject.devices {
        let steps = match limit.budget_reached() {
            None => steps::measure_on(device, scene, subject.quick),
            Some(why) => Err(Failure::new(why)),
        };
        match steps {
            Ok(steps) => all_steps.extend(steps),
            // The pictures of such a device stay in the report.
            Err(failure) => {
                let part = format!("steps on {}", device.label);
                study.leave_out(&part, failure.to_string());
            }
        }
    }
    describe(&mut study, &all_steps, &refinements, &detachments);
    Ok(study)
}

/// Puts the measurements into words and tables.
fn describe(
    study: &mut Study,
    steps: &[Steps],
    refinements: &Refinements,
    detachments: &Detachments,
) {
    steps::describe(study, steps);
    refinements.describe(study);
    detachments.describe(study);
    if !study.parts.is_empty() {
        study.introduction = "The first light of the scene whose airlight is seen. Errors are the RMSE of the airlight over its mean, where the light of each voxel has its own weight.".into();
    }
}

/// Everything but the times, on the CPU.
fn measure_errors(
    study: &mut Study,
    scene: Scene<'_>,
    quick: bool,
    limit: &Limit<'_>,
) -> Result<(Refinements, Detachments), Failure> {
    let cpu = Cpu::new();
    let sizes = if quick { QUICK_SIZES } else { SIZES };
    let step = (scene.rays.len() / RAYS).max(1) | 1;
    let rays: Vec<Ray> = scene.rays.iter().step_by(step).copied().collect();
    let truth = reference(
        &rays,
        std::slice::from_ref(scene.emitter),
        scene.medium,
        scene.geometry,
        Options::default(),
    );
    let length = 5 * sizes.len() + detachment::ALPHAS.len();
    let bar = progress::bar("voxelized shadows", length as u64);
    let casters = Casters::upload(&cpu, scene.geometry)?;
    let maps: Vec<ShadowMap<Host>> = sizes
        .iter()
        .map(|size| cpu.shadow_map(&casters, scene.emitter, 2 * size))
        .collect::<Result<_, _>>()?;
    let picture = resolutions::Picture {
        scene,
        rays: &rays,
        truth: &truth,
        maps: &maps,
        sizes,
    };
    let refinements = picture.measure(&cpu, study, limit, &bar)?;
    let finest = (&maps[maps.len() - 1], sizes[sizes.len() - 1]);
    let detachments = detachment::measure(&cpu, scene, finest, (study, limit, &bar))?;
    bar.finish_and_clear();
    Ok((refinements, detachments))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::study::{Part, Value};
    use crate::compare::times::Times;

    #[test]
    fn every_number_is_recorded_and_shown() {
        let times = Times::of(&[1e-3]);
        let steps = [Steps {
            backend: "gpu (x, software)".into(),
            short: "gpu (software)".into(),
            rectify: times,
            voxelise: times,
            extrude: times,
            average: times,
            runs: times,
            rays: 8,
        }];
        let mut study = KIND.blank();
        let (refinements, detachments) =
            (resolutions::tests::example(), detachment::tests::example());
        describe(&mut study, &steps, &refinements, &detachments);
        // Five steps, two rests of five axes, four lengths, two biases.
        assert_eq!(study.records.rows().len(), 5 + 10 + 4 + 2);
        for row in study.records.rows() {
            assert!(matches!(row.cells[3].value, Value::Number(value) if value > 0.0));
        }
        let shown = |part: &Part| matches!(part, Part::Table(_));
        assert_eq!(study.parts.iter().filter(|part| shown(part)).count(), 3);
        let mut empty = KIND.blank();
        describe(
            &mut empty,
            &[],
            &Refinements::default(),
            &Detachments::default(),
        );
        assert!(empty.parts.is_empty() && empty.records.rows().is_empty());
        assert!(empty.introduction.is_empty());
    }
}
