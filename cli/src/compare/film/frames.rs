//! The frames of a shot with their references.

use std::sync::Arc;
use std::time::Instant;

use gpu_backend::Cpu;
use lighting::Emitter;
use lighting::plan::Plan;
use lighting::scene::view::View;
use lighting::scene::{AreaEmitters, Camera};
use reference::metrics::Reference;

use super::path::{Moved, Pose, Shot};
use super::{Limit, REFERENCES};
use crate::args::Compare;
use crate::compare::measure::Job;
use crate::compare::prepare::Prepared;
use crate::compare::truth;
use crate::failure::Failure;
use crate::parse::Size;
use crate::progress;

/// A frame before anybody makes it.
pub(super) struct Scenery {
    pub(super) camera: Camera,
    pub(super) view: Arc<View>,
    pub(super) emitters: Vec<Emitter>,
    pub(super) areas: Vec<AreaEmitters>,
}

/// All frames of a shot.
pub(super) struct Frames {
    pub(super) size: Size,
    pub(super) moved: Moved,
    pub(super) all: Vec<Scenery>,
    pub(super) references: Vec<Reference>,
    /// Exposure of pictures, stops.
    pub(super) exposure: f32,
}

impl Scenery {
    /// The job of this frame, for methods and the reference.
    pub(super) fn job<'a>(&'a self, job: Job<'a>, size: Size) -> Job<'a> {
        Job {
            camera: &self.camera,
            view: &self.view,
            emitters: &self.emitters,
            areas: &self.areas,
            size,
            ..job
        }
    }
}

impl Frames {
    /// Computes the references; the inner error says why there is no time for them.
    pub(super) fn new(
        args: &Compare,
        prepared: &Prepared,
        job: Job<'_>,
        shot: &Shot,
        size: Size,
        limit: Limit<'_>,
    ) -> Result<Result<Self, String>, Failure> {
        let all = sceneries(args, prepared, shot, size)?;
        let bar = progress::bar("references of a film", all.len() as u64);
        let share = Limit {
            budget: limit.budget.share(REFERENCES),
            ..limit
        };
        let mut references = Vec::new();
        let mut last = 0.0;
        for (index, scenery) in all.iter().enumerate() {
            let rest = (all.len() - index) as f64;
            if let Some(why) = share.reached_after(rest * last) {
                bar.finish_and_clear();
                return Ok(Err(why));
            }
            let clock = Instant::now();
            let job = scenery.job(job, size);
            let tolerance = truth::tolerance(&job, args.tolerance, args.quick);
            references.push(truth::refine(&job, scenery.view.rays(), tolerance, &|_| {}));
            last = clock.elapsed().as_secs_f64();
            bar.inc(1);
        }
        bar.finish_and_clear();
        let first = crate::picture::Picture::of_reference(size, &references[0].radiance);
        Ok(Ok(Self {
            size,
            moved: shot.moved,
            all,
            references,
            exposure: first.automatic_exposure(),
        }))
    }
}

/// The frames of a shot. All of them have the lights that the plan of any of them keeps, so
/// that lights have one number each.
fn sceneries(
    args: &Compare,
    prepared: &Prepared,
    shot: &Shot,
    size: Size,
) -> Result<Vec<Scenery>, Failure> {
    let input = &prepared.input;
    let view =
        |camera: &Camera| View::new(&Cpu::new(), camera, &input.tracer, size.width, size.height);
    let still = Arc::new(view(&prepared.camera)?);
    let mut all = Vec::new();
    let mut kept: Vec<usize> = Vec::new();
    for pose in &shot.poses {
        let (mut camera, mut seen, mut lights) =
            (prepared.camera, still.clone(), input.scene.lights.clone());
        match shot.moved {
            Moved::Camera => {
                camera = pose.of_camera(&camera)?;
                seen = Arc::new(view(&camera)?);
            }
            Moved::Lights => lights = moved(&lights, pose),
        }
        let mut emitters = Vec::new();
        for light in &lights {
            emitters.extend(light.emitters(args.options.lights)?);
        }
        let plan = match prepared.sees_media {
            true => Plan::of_media(&emitters, &input.media(), seen.rays()),
            false => Plan::new(&emitters, prepared.medium.as_ref(), seen.rays()),
        };
        kept.extend(plan.emitters());
        all.push((camera, seen, lights, emitters));
    }
    kept.sort_unstable();
    kept.dedup();
    let scenery =
        |(camera, view, lights, emitters): (Camera, Arc<View>, Vec<_>, Vec<Emitter>)| Scenery {
            camera,
            view,
            emitters: kept.iter().map(|index| emitters[*index].clone()).collect(),
            areas: input.areas_of(&lights, &kept),
        };
    Ok(all.into_iter().map(scenery).collect())
}

fn moved(lights: &[lighting::scene::Light], pose: &Pose) -> Vec<lighting::scene::Light> {
    lights.iter().map(|light| pose.of_light(light)).collect()
}
