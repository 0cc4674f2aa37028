//! Area lights as many voxelized shadow volumes, without a picture: how long their steps take
//! beside those of a volume for each light, and from which numbers their error comes.
//!
//! Tables 1 and 2, figures 6, 11 and 13 and the sweep of resolutions in the text of
//! Wyman and Dai, "Imperfect Voxelized Shadow Volumes", 2013, in numbers.

mod frames;
mod interpolation;
mod light_sizes;
mod points;
mod reductions;
mod resolutions;
mod steps;

use gpu_backend::Cpu;
use lighting::Ray;
use lighting::scene::trace::{Hit, Tracer};
use lighting::scene::view::View;
use lighting::scene::{AreaLight, Camera, Geometry, Medium};
use lighting::voxelized::Eye;
use reference::metrics::Reference;
use reference::oracle::area;
use reference::oracle::image::Options;

use super::{Kind, Limit, Subject, record, value_columns};
use crate::compare::study::Study;
use crate::failure::Failure;
use crate::progress;

pub(super) const KIND: Kind = Kind {
    title: "area lights as many shadow volumes",
    csv: "area-lights.csv",
    columns: value_columns,
    seconds: Some([1.5, 40.0]),
    in_fog: true,
    pointless,
    run,
};

/// About how many rays errors are measured on.
const RAYS: usize = 300;
const QUICK_RAYS: usize = 60;

/// Width and height of the picture whose steps are timed.
const TIMED: [u32; 2] = [320, 180];

/// Relative tolerance of the truth, below the errors that are measured.
const TOLERANCE: f64 = 5e-3;

/// An area light of a scene, and the rays that see it.
#[derive(Clone, Copy)]
struct Scene<'a> {
    geometry: &'a Geometry,
    tracer: &'a Tracer,
    medium: &'a Medium,
    light: &'a AreaLight,
    camera: &'a Camera,
    eye: Eye,
    rays: &'a [Ray],
    hits: &'a [Option<Hit>],
}

impl<'a> Scene<'a> {
    /// The first area light that is seen; `None` if there is none.
    fn of(subject: &Subject<'a>) -> Option<Self> {
        let size = [subject.size.width, subject.size.height];
        Some(Self {
            geometry: subject.geometry,
            tracer: subject.tracer,
            medium: subject.medium,
            light: &subject.areas.first()?.light,
            camera: subject.camera,
            eye: Eye::of_camera(subject.camera, size, subject.rays, subject.medium),
            rays: subject.rays,
            hits: subject.hits,
        })
    }

    /// The radiance of the light itself along some of the rays.
    fn truth(&self) -> Reference {
        let lights = std::slice::from_ref(self.light);
        let options = Options {
            tolerance: TOLERANCE,
            ..Options::default()
        };
        area::reference(self.rays, &[], lights, self.medium, self.geometry, options)
    }
}

fn pointless(subject: &Subject<'_>) -> Option<&'static str> {
    if !subject.translucent.is_empty() {
        return Some("they do not see hair and smoke");
    }
    let none = subject.areas.is_empty();
    none.then_some("no light has an area")
}

fn run(subject: &Subject<'_>, limit: &Limit<'_>) -> Result<Study, Failure> {
    let mut study = KIND.blank();
    let Some(scene) = Scene::of(subject) else {
        return Ok(study);
    };
    let cpu = Cpu::new();
    let most = if subject.quick { QUICK_RAYS } else { RAYS };
    let step = (scene.rays.len() / most).max(1) | 1;
    let rays: Vec<Ray> = scene.rays.iter().step_by(step).copied().collect();
    let hits: Vec<Option<Hit>> = scene.hits.iter().step_by(step).copied().collect();
    let few = Scene {
        rays: &rays,
        hits: &hits,
        ..scene
    };
    let bar = progress::bar("area lights", 7);
    let quick = subject.quick;
    points::measure(&cpu, few, quick, (&mut study, limit))?;
    bar.inc(1);
    // Pictures of area lights are too small for times.
    let [width, height] = match quick {
        true => [subject.size.width, subject.size.height],
        false => TIMED,
    };
    let view = View::new(&cpu, subject.camera, subject.tracer, width, height)?;
    let timed = Scene {
        rays: view.rays(),
        hits: view.hits(),
        eye: Eye::of_camera(subject.camera, [width, height], view.rays(), subject.medium),
        ..scene
    };
    steps::measure(&cpu, timed, quick, (&mut study, limit))?;
    bar.inc(1);
    reductions::measure(&cpu, timed, [width, height], quick, (&mut study, limit))?;
    bar.inc(1);
    // The parts that follow are measured against the light itself, which takes long.
    if quick {
        study.leave_out(
            "errors over resolutions, sizes and with interpolation",
            "--quick",
        );
    } else if let Some(why) = limit.reached() {
        study.leave_out("errors over resolutions, sizes and with interpolation", why);
    } else {
        let truth = few.truth();
        bar.inc(1);
        resolutions::measure(&cpu, few, &truth, (&mut study, limit))?;
        bar.inc(1);
        interpolation::measure(&cpu, few, (&mut study, limit))?;
        bar.inc(1);
        light_sizes::measure(&cpu, few, (&mut study, limit))?;
    }
    bar.finish_and_clear();
    if !study.parts.is_empty() {
        study.introduction = "The first area light of the scene, on the CPU. Errors are the RMSE of the airlight over its mean. The paper's times are milliseconds on a GPU of 2013, with another scene and 1024² rays, so only ratios can be compared.".into();
    }
    Ok(study)
}

#[cfg(test)]
mod tests {
    use lighting::scene::AreaEmitters;
    use lighting::scene::procedural::Embedded;

    use super::*;
    use crate::compare::studies::tests::Stand;
    use crate::compare::study::{Part, Value};

    /// Nothing is left out without a word, whatever the time.
    #[test]
    fn everything_is_measured_where_there_is_time_and_left_out_where_there_is_none() {
        let stand = Stand::of(Embedded::Pergola);
        let areas = AreaEmitters::find(&stand.scene.lights, &[0]);
        let view = View::new(&Cpu::new(), &stand.camera, &stand.tracer, 8, 5).unwrap();
        let mut subject = stand.subject();
        assert_eq!((KIND.pointless)(&subject), Some("no light has an area"));
        subject.areas = &areas;
        subject.rays = view.rays();
        subject.hits = view.hits();
        assert_eq!((KIND.pointless)(&subject), None);
        let study = run(&subject, &Limit::of(f64::INFINITY)).unwrap();
        let tables = study
            .parts
            .iter()
            .filter(|part| matches!(part, Part::Table(_)));
        assert_eq!(tables.count(), 3);
        assert!(!study.introduction.is_empty() && study.left_out.len() == 1);
        for row in study.records.rows() {
            assert!(matches!(row.cells[3].value, Value::Number(value) if value >= 0.0));
        }
        let none = run(&subject, &Limit::of(0.0)).unwrap();
        assert!(none.records.rows().is_empty() && none.left_out.len() == 4);
    }

    /// The parts that a quick comparison leaves out, on as few rays as there are.
    #[test]
    fn errors_are_measured_against_the_light_itself() {
        let stand = Stand::of(Embedded::Pergola);
        let areas = AreaEmitters::find(&stand.scene.lights, &[0]);
        let view = View::new(&Cpu::new(), &stand.camera, &stand.tracer, 4, 3).unwrap();
        let mut subject = stand.subject();
        subject.areas = &areas;
        subject.rays = view.rays();
        subject.hits = view.hits();
        let (scene, cpu) = (Scene::of(&subject).unwrap(), Cpu::new());
        let mut study = KIND.blank();
        let limit = Limit::of(f64::INFINITY);
        interpolation::measure(&cpu, scene, (&mut study, &limit)).unwrap();
        assert_eq!(study.records.rows().len(), 4);
        let error = frames::Setting::default().error(&cpu, scene, &scene.truth());
        assert!(error.unwrap().rmse < 0.2);
    }
}
