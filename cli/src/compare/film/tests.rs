//! Films of small scenes.

use std::cell::RefCell;
use std::ffi::OsString;
use std::sync::atomic::AtomicBool;

use glam::Vec3;
use lighting::methods::{Method, Registry};

use super::frames::Frames;
use super::path::{Moved, Pose, Shot, Steps, shots};
use super::take::Take;
use super::*;
use crate::args::{Arguments, Command, FilmPath};
use crate::compare::study::{Part, Value};

const ARGUMENTS: &str = "crepuscular compare fence --size 24x14 --map 64 --backend cpu --film 7 \
                         --film-path both --methods";

fn args(methods: &str) -> Compare {
    let arguments = ARGUMENTS.split_whitespace().chain([methods]);
    let arguments = arguments.map(OsString::from);
    match Arguments::read(&Registry::standard(), arguments).map(|a| a.command) {
        Ok(Command::Compare(args)) => args,
        _ => panic!("a comparison is asked for"),
    }
}

fn prepared(args: &Compare) -> Prepared {
    Prepared::new(&Registry::standard(), args.asked(), f64::INFINITY).unwrap()
}

const SIZE: Size = Size {
    width: 24,
    height: 14,
};

#[test]
fn paths_are_the_same_in_every_run_and_lead_back() {
    let args = args("march x midpoint");
    let prepared = prepared(&args);
    let job = prepared.job(false).unwrap();
    for frames in [7, 16, 90] {
        let made = || shots(FilmPath::Both, frames, &job, SIZE);
        let all: Vec<Shot> = made().into_iter().map(Result::unwrap).collect();
        assert_eq!(all.len(), 4);
        assert!(
            made()
                .into_iter()
                .map(Result::unwrap)
                .eq(all.iter().cloned())
        );
        for shot in &all {
            assert_eq!(shot.poses.len(), frames);
            let length = shot.length.unwrap();
            let turn = frames / 2;
            let shift = |frame: usize| shot.poses[frame].shift;
            for frame in 1..frames {
                let step = shift(frame).distance(shift(frame - 1));
                match shot.steps {
                    Steps::Small => {
                        assert!((step / length - 1.0).abs() < 1e-3, "{step}");
                        let mirrored = (2 * turn).checked_sub(frame).filter(|m| *m < frames);
                        if let Some(mirrored) = mirrored {
                            assert_eq!(shot.poses[frame], shot.poses[mirrored]);
                        }
                    }
                    Steps::Large => {
                        assert!(shift(frame).length() <= length);
                        assert_ne!(shot.poses[frame], shot.poses[frame - 1]);
                    }
                }
            }
        }
    }
    // A third of a pixel in the middle of the picture, at the mean distance.
    let shot = shots(FilmPath::Camera, 7, &job, SIZE).remove(0).unwrap();
    let camera = shot.poses[2].of_camera(&prepared.camera).unwrap();
    assert_eq!(camera.rotation(), prepared.camera.rotation());
    assert!(camera.eye().distance(prepared.camera.eye()) <= 1.001 * shot.length.unwrap());
}

/// A film of a scene in which nothing moves.
fn still(args: &Compare, prepared: &Prepared, limit: Limit<'_>) -> Frames {
    let shot = Shot {
        moved: Moved::Lights,
        steps: Steps::Small,
        length: None,
        angle: 0.0,
        poses: vec![Pose::default(); 5],
    };
    let job = prepared.job(false).unwrap();
    Frames::new(args, prepared, job, &shot, SIZE, limit)
        .unwrap()
        .unwrap()
}

#[test]
fn a_film_in_which_nothing_moves_does_not_flicker_or_lag() {
    let args = args("march x midpoint,voxel-average x gauss,precomputed x gauss,froxels");
    let prepared = prepared(&args);
    let stop = AtomicBool::new(false);
    let limit = Limit {
        budget: Budget::unlimited(),
        stop: &stop,
    };
    let frames = still(&args, &prepared, limit);
    let device = &prepared.backends.present[0];
    let all = filmed(&args, &prepared, device);
    assert!(all.len() >= 4);
    for one in all {
        let take: Take = filmed_on(device, &prepared, &frames, &one, limit, &|| ())
            .unwrap()
            .unwrap();
        let error = reference::film::film_error(&take.pictures, &frames.references);
        let lag = reference::film::lag(&take.pictures, &frames.references).unwrap();
        assert!(error.rmse > 0.0);
        assert_eq!(lag.frames, 0.0, "{}", one.title);
        match one.entry.remembers_frames() {
            // Each frame is sampled at another place, and most of it is of earlier ones.
            true => assert!(error.ratio() < 1.0, "{error:?}"),
            false => assert_eq!(error.change, 0.0, "{}", one.title),
        }
    }
}

#[test]
fn a_film_has_a_row_for_each_method_in_each_shot_and_strips_where_it_is_continuous() {
    let mut args = args("march x midpoint,runs of the shadow map");
    args.film_frames = true;
    let prepared = prepared(&args);
    let stop = AtomicBool::new(false);
    let names = RefCell::new(Vec::new());
    let film = make(&args, &prepared, Budget::unlimited(), &stop, &|name, _| {
        names.borrow_mut().push(name.to_owned());
        Ok(())
    });
    let film = film.unwrap().unwrap();
    assert_eq!((film.frames, film.size), (7, SIZE));
    assert!(film.study.left_out.is_empty(), "{:?}", film.study.left_out);
    let methods = filmed(&args, &prepared, &prepared.backends.present[0]).len();
    assert_eq!(film.study.records.rows().len(), 4 * methods);
    let column = |name: &str| {
        let mut columns = film.study.records.columns.iter();
        columns.position(|column| column.name == name).unwrap()
    };
    for row in film.study.records.rows() {
        let number = |name: &str| match &row.cells[column(name)].value {
            Value::Number(number) => Some(*number),
            Value::Count(count) => Some(*count as f64),
            Value::Text(_) => None,
        };
        let is_small = row.cells[column("steps")].text() == Some("small");
        assert!(number("error_rmse") > Some(0.0));
        let ratio = number("error_change").unwrap() / number("error_rmse").unwrap();
        assert!((number("change_ratio").unwrap() - ratio).abs() < 1e-9);
        // Neither method knows of the frames before.
        assert_eq!(number("lag_frames"), is_small.then_some(0.0));
        assert!(number("things_made") > Some(0.0));
        let moved = row.cells[column("moved")].text();
        if moved == Some("camera") {
            assert!(number("things_reused") >= Some(6.0));
        }
    }
    let strips = film.study.parts.iter().filter_map(|part| match part {
        Part::Strips(strips) => Some(strips.len()),
        _ => None,
    });
    assert_eq!(strips.collect::<Vec<_>>(), [methods; 2]);
    // The frames of all methods and of the reference, in four shots.
    let names = names.into_inner();
    assert_eq!(names.len(), 4 * (methods + 1) * 7);
    assert!(
        names.contains(&"film-camera-small-reference-0000.png".to_owned()),
        "{names:?}"
    );
    assert!(
        names.contains(&"film-lights-large-march-x-midpoint-32-0006.png".to_owned()),
        "{names:?}"
    );
    assert!(names.iter().all(|name| is_ours(name)));
    for other in [
        "film-poster.png",
        "film-camera-small-0000.png",
        "film-camera-small-march-1.png",
        "film-camera-small-my holidays-0001.png",
        "film-0001.png",
    ] {
        assert!(!is_ours(other), "{other}");
    }
}

#[test]
fn what_there_is_no_time_for_is_left_out_whole() {
    let args = args("march x midpoint");
    let prepared = prepared(&args);
    for (is_stopped, budget, why) in [
        (true, Budget::unlimited(), "interrupted"),
        (false, Budget::new(0.0), NO_TIME),
    ] {
        let stop = AtomicBool::new(is_stopped);
        let film = make(&args, &prepared, budget, &stop, &|_, _| Ok(()));
        let film = film.unwrap().unwrap();
        assert!(film.study.records.rows().is_empty() && film.study.parts.is_empty());
        assert_eq!(film.study.left_out.len(), 4);
        for left_out in &film.study.left_out {
            assert!(left_out.what.contains("film") && left_out.why.starts_with(why));
        }
    }
}

#[test]
fn a_film_has_its_own_share_of_the_time() {
    let mut args = args("march");
    let (seconds, share) = seconds_and_share(&args, 150.0);
    assert_eq!(seconds, 150.0 + SECONDS_PER_FRAME * 7.0 * 4.0);
    assert!(((1.0 - share) * seconds - 150.0).abs() < 1e-9);
    args.time_budget = Some(60.0);
    assert_eq!(seconds_and_share(&args, 150.0), (60.0, SHARE));
    args.film = None;
    assert_eq!(seconds_and_share(&args, 150.0), (60.0, 0.0));
}

#[test]
fn a_film_that_is_too_large_is_refused() {
    let mut args = args("march");
    let prepared = prepared(&args);
    assert!(check(&args, &prepared).is_ok());
    args.film = Some(600);
    assert!(check(&args, &prepared).is_ok());
    let of = |width: u32, height: u32, prepared| Prepared {
        size: Size { width, height },
        ..prepared
    };
    let usual = of(160, 90, prepared);
    assert!(check(&args, &usual).is_ok());
    let large = of(480, 270, usual);
    // Halved.
    assert!(check(&args, &large).is_ok());
    args.fixed = true;
    let refused = check(&args, &large).unwrap_err().to_string();
    assert!(
        refused.contains("--film 600") && refused.contains("at most"),
        "{refused}"
    );
}

#[test]
fn poses_move_what_they_are_of() {
    use lighting::scene::{DirectionalLight, Light, PointLight};
    let pose = Pose {
        shift: Vec3::X,
        turn: [0.1, 0.0],
    };
    let Light::Point(point) = pose.of_light(&Light::Point(PointLight::default())) else {
        panic!("a point light stays one");
    };
    assert_eq!(point.position, PointLight::default().position + Vec3::X);
    let sun = DirectionalLight {
        direction: 2.0 * Vec3::NEG_Y,
        ..DirectionalLight::default()
    };
    let Light::Directional(turned) = pose.of_light(&Light::Directional(sun.clone())) else {
        panic!("a sun stays one");
    };
    assert!((turned.direction.angle_between(sun.direction) - 0.1).abs() < 1e-4);
}

#[test]
fn suns_alone_turn_and_have_no_length() {
    let mut args = args("march x midpoint");
    args.scene = "city".into();
    let prepared = prepared(&args);
    let job = prepared.job(false).unwrap();
    for shot in shots(FilmPath::Light, 7, &job, SIZE) {
        let shot = shot.unwrap();
        assert_eq!(shot.length, None);
        assert!(shot.angle > 0.0);
        for pose in &shot.poses {
            assert!(pose.turn.iter().all(|turn| turn.abs() <= 4.0 * shot.angle));
        }
    }
}
