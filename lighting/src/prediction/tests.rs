use std::convert::Infallible;

use glam::Vec3;
use reference::random::Random;

use super::error::estimate;
use super::interpolate::along_logarithms;
use super::*;
use crate::methods::Work;
use crate::scene::Emission;
use crate::{Emitter, Ray};

fn row(method: &str, quality: u32, once: f64, frame: f64, rmse: f64) -> Prediction {
    Prediction {
        setting: quality as usize,
        method: method.into(),
        backend: "cpu".into(),
        quality,
        unit: "steps",
        start: 0.0,
        once,
        frame,
        bytes: 1 << 20,
        rmse,
        rmse_spread: 0.1 * rmse,
        known: Known::Probed,
        counted: [1e6, 1e7],
    }
}

fn example() -> Forecast {
    Forecast {
        rows: vec![
            row("march", 8, 0.0, 1e-3, 0.2),
            row("march", 64, 0.0, 8e-3, 0.02),
            row("voxels", 64, 1.0, 2e-3, 0.02),
            row("exact", 2, 0.0, 50e-3, 1e-6),
            row("broken", 2, 0.0, 1e-6, f64::NAN),
        ],
        skipped: Vec::new(),
    }
}

#[test]
fn the_choice_is_the_best_that_meets_the_target() {
    let forecast = example();
    let chosen = |target, frames| {
        let row = forecast.choose(target, frames).unwrap();
        (row.method.as_str(), row.quality)
    };
    let many = f64::INFINITY;
    assert_eq!(chosen(Target::Error(0.5), many), ("march", 8));
    assert_eq!(chosen(Target::Error(0.02), many), ("voxels", 64));
    // What is made once counts where there are few frames.
    assert_eq!(chosen(Target::Error(0.02), 1.0), ("march", 64));
    assert_eq!(chosen(Target::Error(0.001), 1.0), ("exact", 2));
    assert_eq!(chosen(Target::Time(10e-3), 1.0), ("march", 64));
    assert_eq!(chosen(Target::Time(1.0), many), ("exact", 2));
}

/// The same settings on a second backend that has to be started.
fn started(rows: &[Prediction], start: f64, faster: impl Fn(usize) -> f64) -> Forecast {
    let others = rows.iter().enumerate().map(|(index, row)| Prediction {
        backend: "gpu".into(),
        start,
        frame: row.frame / faster(index),
        ..row.clone()
    });
    Forecast {
        rows: rows.iter().cloned().chain(others).collect(),
        skipped: Vec::new(),
    }
}

#[test]
fn a_backend_that_starts_for_longer_than_its_frames_save_is_named() {
    let rows = [
        row("march", 8, 0.0, 1e-3, 0.2),
        row("march", 64, 0.5, 8e-3, 0.02),
    ];
    let forecast = started(&rows, 0.0725, |_| 8.0);
    let slow = forecast.slow_starts(1.0);
    assert_eq!(slow.len(), 1);
    assert_eq!((slow[0].backend.as_str(), slow[0].start), ("gpu", 0.0725));
    // 7 ms are saved by each frame with 64 steps.
    assert_eq!(slow[0].pays_from, 11.0);
    assert!(
        (slow[0].saving - 0.0655).abs() < 1e-12,
        "{}",
        slow[0].saving
    );
    assert_eq!(forecast.slow_starts(10.0).len(), 1);
    for frames in [11.0, 1e9, f64::INFINITY] {
        assert!(forecast.slow_starts(frames).is_empty(), "{frames}");
    }
    // What runs already, what is fast at once, and what only it has is worth it.
    assert!(started(&rows, 0.0, |_| 0.5).slow_starts(1.0).is_empty());
    assert!(started(&rows, 1e-3, |_| 8.0).slow_starts(1.0).is_empty());
    let mut alone = forecast.clone();
    alone.rows.remove(0);
    assert!(alone.slow_starts(1.0).is_empty());
    // It never pays where its frames are slower.
    let never = started(&rows, 0.07, |_| 0.5).slow_starts(1e6);
    assert_eq!(never[0].pays_from, f64::INFINITY);
}

#[test]
fn no_choice_is_finished_later_without_slow_starts() {
    let mut random = Random::new(17);
    let (mut named, mut kept) = (0, 0);
    for _ in 0..300 {
        let rows: Vec<Prediction> = (0..8)
            .map(|quality| {
                let [once, frame] = [1e-4, 1e-3].map(|low| random.log_uniform(low, 1.0));
                row("any", quality, once, frame, random.log_uniform(1e-5, 1.0))
            })
            .collect();
        let gains: Vec<f64> = rows.iter().map(|_| random.log_uniform(0.5, 10.0)).collect();
        let all = started(&rows, random.log_uniform(1e-2, 10.0), |index| gains[index]);
        let frames = random.log_uniform(1.0, 100.0).floor();
        let slow = all.slow_starts(frames);
        if slow.is_empty() {
            kept += 1;
            continue;
        }
        named += 1;
        assert!(slow[0].saving > 0.0 || slow[0].saving.abs() < 1e-12);
        let without = Forecast {
            rows: rows.clone(),
            skipped: Vec::new(),
        };
        let target = Target::Error(random.log_uniform(1e-4, 1.0));
        match (all.choose(target, frames), without.choose(target, frames)) {
            (Ok(a), Ok(b)) => assert!(b.seconds(frames) <= a.seconds(frames)),
            (Err(_), Err(_)) => {}
            (a, b) => panic!("{a:?} {b:?}"),
        }
    }
    assert!(named > 30 && kept > 30, "{named} {kept}");
}

#[test]
fn a_profile_knows_how_long_backends_start() {
    let rows = [
        row("march", 8, 0.0, 1e-3, 0.2),
        row("exact", 8, 0.0, 1e-3, 0.2),
    ];
    let mut first = started(&rows, 0.8, |_| 1.0);
    first.rows[3].start = 0.9;
    let learned = Profile::learned([&first, &started(&rows, 0.1, |_| 1.0)]);
    assert_eq!(learned.starts().collect::<Vec<_>>(), [("gpu", 0.8)]);
    let work = Work {
        once: 1e6,
        per_ray: 10.0,
        ..Work::default()
    };
    let mut profile = Profile::new();
    let costs = Costs {
        once: 1e-8,
        frame: 1e-9,
    };
    profile.insert("gpu", "march", costs);
    let without = profile.first_picture("gpu", "march", &work, 1000);
    assert!((without - 1.001e-2).abs() < 1e-9, "{without}");
    profile.insert_start("gpu", 0.5);
    let with = profile.first_picture("gpu", "march", &work, 1000);
    assert!((with - without - 0.5).abs() < 1e-9, "{with}");
}

/// Settles the example within 10 ms, where frames take so many times what is expected, and
/// gives the choice and the methods that were measured.
fn settled(rows: Vec<Prediction>, seconds: f64, factor: f64) -> (String, Vec<String>) {
    let mut forecast = Forecast {
        rows,
        skipped: Vec::new(),
    };
    let target = Target::Time(10e-3);
    let mut measured = Vec::new();
    let settled = forecast.settle(target, f64::INFINITY, seconds, |row| {
        measured.push(row.method.clone());
        Ok::<_, Infallible>((row.method != "broken").then_some(factor * row.frame))
    });
    let Ok(()) = settled;
    let chosen = forecast.choose(target, f64::INFINITY).unwrap();
    (chosen.method.clone(), measured)
}

#[test]
fn what_is_in_doubt_is_measured_as_far_as_the_choice_depends_on_it() {
    let rows = || {
        vec![
            row("sure", 1, 0.0, 1e-3, 0.2),
            row("worse", 2, 0.0, 9e-3, 0.3),
            row("good", 3, 0.0, 11e-3, 0.01),
            row("better", 4, 0.0, 12e-3, 0.001),
            row("slow", 5, 0.0, 50e-3, 1e-6),
        ]
    };
    let of = |chosen: &str, measured: &[&str]| {
        let measured = measured.iter().map(|name| (*name).to_owned());
        (chosen.to_owned(), measured.collect::<Vec<_>>())
    };
    assert_eq!(settled(rows(), 1.0, 0.8), of("better", &["better"]));
    assert_eq!(settled(rows(), 1.0, 0.9), of("good", &["better", "good"]));
    assert_eq!(settled(rows(), 1.0, 1.0), of("sure", &["better", "good"]));
    // Time for one of them, or for none.
    assert_eq!(settled(rows(), 0.06, 0.9), of("sure", &["better"]));
    assert_eq!(settled(rows(), 0.0, 0.5), of("sure", &[]));
    // What has to be made first takes time too.
    let mut unmade = rows();
    (unmade[3].once, unmade[3].known) = (2.0, Known::Interpolated);
    assert_eq!(settled(unmade, 1.0, 0.9), of("good", &["good"]));
    let mut broken = rows();
    broken[2] = row("broken", 3, 0.0, 9e-3, 0.01);
    broken.remove(3);
    assert_eq!(settled(broken, 1.0, 0.9), of("sure", &["broken"]));
    // An error needs no times.
    let mut forecast = example();
    let settled = forecast.settle(Target::Error(0.1), 1.0, 1.0, |_| Err("asked"));
    assert_eq!((settled, forecast.rows.len()), (Ok(()), 5));
}

#[test]
fn a_lower_target_never_chooses_what_is_expected_to_be_worse() {
    let mut random = Random::new(5);
    for _ in 0..200 {
        let rows = (0..20).map(|quality| {
            let [once, frame, rmse] = [1e-3, 1e-4, 1e-5].map(|low| random.log_uniform(low, 1.0));
            row("any", quality, once, frame, rmse)
        });
        let forecast = Forecast {
            rows: rows.collect(),
            skipped: Vec::new(),
        };
        let mut targets = [random.log_uniform(1e-4, 1.0), random.log_uniform(1e-4, 1.0)];
        targets.sort_by(f64::total_cmp);
        let of_error = targets.map(|t| forecast.choose(Target::Error(t), 1.0));
        if let [Ok(low), Ok(high)] = of_error {
            assert!(low.rmse <= targets[0] && high.seconds(1.0) <= low.seconds(1.0));
        }
        let of_time = targets.map(|t| forecast.choose(Target::Time(t), 1.0));
        if let [Ok(low), Ok(high)] = of_time {
            assert!(low.seconds(1.0) <= targets[0] && high.rmse <= low.rmse);
        }
    }
}

#[test]
fn what_comes_nearest_is_named_where_nothing_meets_a_target() {
    let text = |target, forecast: &Forecast| forecast.choose(target, 1.0).unwrap_err().to_string();
    assert_eq!(
        text(Target::Error(1e-7), &example()),
        "nothing is expected to meet an error of 0.000 %; the nearest is exact with 2 steps on \
         cpu: 50.00 ms a frame, 0.00 ms before the first, RMSE 0.000 %"
    );
    let time = text(Target::Time(1e-4), &example());
    assert!(
        time.contains("a time of 0.100 ms; the nearest is march with 8"),
        "{time}"
    );
    let nothing = text(Target::Time(1.0), &Forecast::default());
    assert!(nothing.ends_with("no method is foreseen"), "{nothing}");
}

#[test]
fn samples_are_spread_over_any_picture() {
    for size in [
        [1, 1],
        [1, 700],
        [7, 13],
        [31, 4000],
        [480, 270],
        [4000, 31],
        [9000, 1],
    ] {
        for most in [64, 1000, 4096] {
            let sample = Sample::new(size, most);
            let total = size[0] as usize * size[1] as usize;
            let pixels = sample.pixels();
            assert_eq!(sample, Sample::new(size, most));
            assert!(pixels.is_sorted_by(|a, b| a < b), "{size:?} {most}");
            assert!(pixels.iter().all(|pixel| (*pixel as usize) < total));
            let all = sample.is_whole();
            assert!(
                all == (total <= 2 * most) || pixels.len() == total,
                "{size:?} {most}"
            );
            assert!(
                all || (most / 3..=most).contains(&pixels.len()),
                "{size:?} {most}"
            );
            // Both halves of the picture have their share.
            let upper = pixels.iter().filter(|pixel| (**pixel as usize) < total / 2);
            let share = upper.count() as f64 / pixels.len() as f64;
            assert!(
                total < 100 || most < 4096 || (0.35..0.65).contains(&share),
                "{size:?} {most}: {share}"
            );
            assert!(sample.smaller().iter().all(|pixel| pixels.contains(pixel)));
        }
    }
}

#[test]
fn estimates_are_right_on_average_and_their_spread_is_about_how_far_they_are_off() {
    let size = [320_u32, 180];
    let number = (size[0] * size[1]) as usize;
    let (mut off, mut spread) = (Vec::new(), Vec::new());
    for seed in 0..12 {
        // Light with an edge, near which a method is off.
        let slope = 0.2 + 0.1 * f64::from(seed);
        let light = |pixel: u32| {
            let [x, y] = [pixel % size[0], pixel / size[0]].map(f64::from);
            let beside = x - 100.0 - slope * y;
            let truth = if beside > 0.0 { 1.0 } else { 0.3 };
            (truth, truth + 0.2 * (-(beside / 6.0).powi(2)).exp())
        };
        let pixels = 0..number as u32;
        let squares: f64 = pixels
            .clone()
            .map(light)
            .map(|(t, x)| (x - t).powi(2))
            .sum();
        let mean = pixels.map(|pixel| light(pixel).0).sum::<f64>() / number as f64;
        let rmse = (squares / number as f64).sqrt() / mean;
        let sample = Sample::new(size, 2048);
        let judged = Judged::new(&sample, 600, |pixels| {
            Ok::<_, Infallible>(pixels.iter().map(|pixel| [light(*pixel).0; 3]).collect())
        })
        .unwrap();
        assert!((400..800).contains(&judged.number()), "{}", judged.number());
        let picture: Vec<[f32; 4]> = sample
            .pixels()
            .iter()
            .map(|pixel| [light(*pixel).1 as f32; 4])
            .collect();
        let found = estimate(&picture, &judged);
        off.push(found.rmse / rmse - 1.0);
        spread.push(found.spread / rmse);
    }
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let rms = mean(&off.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt();
    assert!(mean(&off).abs() < 0.1, "{off:?}");
    let ratio = mean(&spread) / rms;
    assert!((0.5..4.0).contains(&ratio), "{ratio}: {off:?} {spread:?}");
}

#[test]
fn what_a_few_pixels_near_a_light_are_off_is_found() {
    let size = [320_u32, 180];
    let number = (size[0] * size[1]) as usize;
    let lamp = Vec3::new(0.31, 0.2, -2.0);
    let emission = Emission::Isotropic;
    let lamp = Emitter::point(lamp, Vec3::ONE, f32::INFINITY, emission).unwrap();
    let rays: Vec<Ray> = (0..number as u32)
        .map(|pixel| {
            let [x, y] = [pixel % size[0], pixel / size[0]].map(|x| x as f32 / 180.0);
            Ray::new(Vec3::ZERO, Vec3::new(x - 0.89, 0.5 - y, -1.0), 10.0).unwrap()
        })
        .collect();
    let off = |pixel: u32| {
        let Emitter::Point(lamp) = &lamp else {
            return 0.0;
        };
        let direction = rays[pixel as usize].direction();
        1e-4 / f64::from(lamp.position().cross(direction).length_squared()).max(1e-6)
    };
    let squares: f64 = (0..number as u32).map(|pixel| off(pixel).powi(2)).sum();
    let rmse = (squares / number as f64).sqrt();
    let sample = Sample::new(size, 2048).with_nearest(&rays, std::slice::from_ref(&lamp), 256);
    assert!(
        sample.pixels().len() > 2048 - 64,
        "{}",
        sample.pixels().len()
    );
    let mut pixels = sample.pixels().to_vec();
    pixels.sort_unstable();
    assert!(pixels.is_sorted_by(|a, b| a < b), "no pixel is there twice");
    let truth = |pixels: &[u32]| Ok::<_, Infallible>(vec![[1.0; 3]; pixels.len()]);
    let judged = Judged::new(&sample, 600, truth).unwrap();
    let picture: Vec<[f32; 4]> = sample
        .pixels()
        .iter()
        .map(|pixel| [(1.0 + off(*pixel)) as f32; 4])
        .collect();
    let ratio = estimate(&picture, &judged).rmse / rmse;
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
    // Parallel light comes from nowhere.
    let sun = [Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap()];
    let plain = Sample::new(size, 2048);
    assert_eq!(plain.clone().with_nearest(&rays, &sun, 256), plain);
}

#[test]
fn lines_of_logarithms_go_through_their_points_and_on() {
    let points = [(1.0, 1.0), (2.0, 4.0), (8.0, 4.0)];
    let at = |x| along_logarithms(&points, x).unwrap();
    for (x, y) in [(1.0, 1.0), (2.0, 4.0), (4.0, 4.0), (0.5, 0.25), (16.0, 4.0)] {
        assert!((at(x) - y).abs() < 1e-12, "{x}: {}", at(x));
    }
    assert_eq!(along_logarithms(&points[..1], 7.0), Some(1.0));
    assert_eq!(along_logarithms(&[], 7.0), None);
}

#[test]
fn a_profile_is_the_median_of_what_was_probed() {
    let of = |frame| Forecast {
        rows: vec![row("march", 8, 1e-2, frame, 0.1)],
        skipped: Vec::new(),
    };
    let profile = Profile::learned(&[of(1e-2), of(1.0), of(3e-2)]);
    let costs = profile.costs("cpu", "march");
    assert!((costs.frame / 3e-9 - 1.0).abs() < 1e-9 && (costs.once / 1e-8 - 1.0).abs() < 1e-9);
    assert_eq!(profile.costs("gpu", "march"), Costs::ASSUMED);
    assert_eq!(profile.all().count(), 1);
    // What has nothing to make is assumed.
    let mut nothing = of(1e-2);
    nothing.rows[0].counted[0] = 0.0;
    nothing.rows[0].once = 0.0;
    let costs = Profile::learned(&[nothing]).costs("cpu", "march");
    assert_eq!(costs.once, Costs::ASSUMED.once);
}

#[test]
fn a_table_has_a_row_for_each_setting() {
    let mut forecast = example();
    forecast.skipped.push(Skipped {
        setting: 9,
        what: "bakes with 8192 voxels".into(),
        why: "too expensive".into(),
    });
    let text = forecast.to_string();
    assert_eq!(text.lines().count(), 7);
    assert!(text.starts_with("method"), "{text}");
    assert!(
        text.ends_with("not foreseen: bakes with 8192 voxels (too expensive)\n"),
        "{text}"
    );
}
