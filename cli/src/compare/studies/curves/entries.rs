//! How each kind of curves is measured on rays.

use std::fmt::Debug;
use std::hint::black_box;
use std::time::Instant;

use transmittance::baseline::{Deep, FourierCurve, Moments, OpacityCurve};
use transmittance::{Accumulate, Curve, Evaluate, Linear, Stream};

use super::kinds::{Named, Visit, range, visit_all};
use super::rays::{Ray, Rays};
use super::{Family, Line};
use crate::compare::study::Key;
use crate::compare::times::Times;
use crate::failure::Failure;

/// Lookups per curve in one round of measuring.
const LOOKUPS: usize = 64;

/// A kind of curve at a setting.
pub(crate) struct Entry {
    pub(crate) family: Family,
    pub(crate) setting: String,
    /// True if it has to be given a range of depths.
    pub(crate) knows_range: bool,
    measure: Measure,
}

/// Takes rays, and about how long each time is taken in seconds.
type Measure = Box<dyn Fn(&Rays, f64) -> Measurement>;

/// Errors, times and memory of a kind at a setting.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measurement {
    pub(crate) mean: f64,
    pub(crate) max: f64,
    pub(crate) insertion: Times,
    pub(crate) lookup: Times,
    pub(crate) bytes: f64,
}

impl Entry {
    /// Errors and times; measuring each time takes about `seconds`.
    pub(crate) fn measure(&self, rays: &Rays, seconds: f64) -> Measurement {
        (self.measure)(rays, seconds)
    }
}

/// Every kind at every setting, those that need a range of depths with one
/// `looser` times as long as the tight one.
pub(crate) fn entries(looser: f64, tight: [f32; 2]) -> Result<Vec<Entry>, Failure> {
    struct Entries(Vec<Entry>);

    impl Visit for Entries {
        fn kind<A, T>(&mut self, name: Named, clear: A, bytes: impl Fn(&T) -> usize + 'static)
        where
            A: Accumulate + Clone + Sync + 'static,
            A::Curve: Into<T>,
            T: Evaluate + Debug + Send + Sync + 'static,
        {
            self.0.push(entry(name, clear, bytes));
        }
    }

    let mut entries = Entries(Vec::new());
    visit_all(range(looser, tight)?, &mut entries)?;
    Ok(entries.0)
}

/// Curves that start as copies of `clear` and are stored as a `T`.
fn entry<A, T>(
    Named { family, setting }: Named,
    clear: A,
    bytes: impl Fn(&T) -> usize + 'static,
) -> Entry
where
    A: Accumulate + Clone + 'static,
    A::Curve: Into<T>,
    T: Evaluate + 'static,
{
    let measure = move |rays: &Rays, seconds: f64| {
        let (mut curves, insertion) = timed(rays.segments(), seconds, || {
            let made = rays.iter().map(|ray| made(&clear, ray));
            made.collect::<Vec<T>>()
        });
        let (mean, max) = errors(rays, &curves);
        let lookups = curves.len() * LOOKUPS;
        let (_, lookup) = timed(lookups, seconds, || {
            let mut sum = 0.0;
            for (curve, ray) in curves.iter().zip(rays.iter()) {
                // Depths as receivers have them, in no order.
                for index in 0..LOOKUPS {
                    let depth = ray.samples[index * 37 % ray.samples.len()];
                    sum += black_box(curve).evaluate(depth)[0];
                }
            }
            sum
        });
        let total: usize = curves.iter().map(&bytes).sum();
        let bytes = total as f64 / curves.len() as f64;
        curves.clear();
        Measurement {
            mean,
            max,
            insertion,
            lookup,
            bytes,
        }
    };
    let ranged = [Family::Opacity, Family::Fourier, Family::Moments];
    Entry {
        knows_range: ranged.contains(&family),
        family,
        setting,
        measure: Box::new(measure),
    }
}

fn made<A, T>(clear: &A, ray: &Ray) -> T
where
    A: Accumulate + Clone,
    A::Curve: Into<T>,
{
    let mut curve = clear.clone();
    for segment in &ray.segments {
        curve.insert(black_box(segment));
    }
    curve.finish().into()
}

/// The result of `work`, and its time divided by the number of things that it does.
fn timed<R>(things: usize, seconds: f64, mut work: impl FnMut() -> R) -> (R, Times) {
    let mut times = Vec::new();
    let clock = Instant::now();
    loop {
        let round = Instant::now();
        let result = black_box(work());
        times.push(round.elapsed().as_secs_f64() / things as f64);
        let enough = times.len() >= 3 || seconds == 0.0;
        if enough && (clock.elapsed().as_secs_f64() >= seconds || times.len() >= 1000) {
            return (result, Times::of(&times));
        }
    }
}

/// Mean and largest error of transmittance.
fn errors<T: Evaluate>(rays: &Rays, curves: &[T]) -> (f64, f64) {
    let (mut sum, mut count, mut max) = (0.0, 0, 0.0_f64);
    for (curve, ray) in curves.iter().zip(rays.iter()) {
        let error = |(&depth, &truth): (&f32, &f64)| {
            let error = (f64::from(curve.evaluate(depth)[0]) - truth).abs();
            // A NaN must not hide behind a comparison.
            if error.is_nan() { 1.0 } else { error }
        };
        for sample in ray.samples.iter().zip(&ray.sample_truths) {
            let error = error(sample);
            (sum, count, max) = (sum + error, count + 1, max.max(error));
        }
        for end in ray.ends.iter().zip(&ray.end_truths) {
            max = max.max(error(end));
        }
    }
    (sum / f64::from(count.max(1)), max)
}

/// The paper's figure 6: each method on one ray.
pub(crate) fn lines_of_all(rays: &Rays) -> Result<Vec<Line>, Failure> {
    let range = range(1.0, rays.range())?;
    Ok(vec![
        truth(rays),
        line(rays, Family::Paper, "12 nodes", &Curve::<12, Linear>::new()),
        line(rays, Family::Area, "12 nodes", &Stream::<12>::new()),
        line(rays, Family::Opacity, "32", &OpacityCurve::<32>::new(range)),
        line(rays, Family::Fourier, "16", &FourierCurve::<16>::new(range)),
        line(rays, Family::Deep, "0.01", &Deep::new(0.01)?),
        line(rays, Family::Moments, "8", &Moments::new(8, range)?),
    ])
}

/// The paper's figure 7: sizes of adaptive curves.
pub(crate) fn lines_of_sizes(rays: &Rays) -> Result<Vec<Line>, Failure> {
    let mut lines = vec![
        truth(rays),
        line(rays, Family::Paper, "4 nodes", &Curve::<4, Linear>::new()),
        line(rays, Family::Paper, "8 nodes", &Curve::<8, Linear>::new()),
        line(rays, Family::Paper, "12 nodes", &Curve::<12, Linear>::new()),
        line(rays, Family::Paper, "16 nodes", &Curve::<16, Linear>::new()),
        line(rays, Family::Area, "8 nodes", &Stream::<8>::new()),
    ];
    // Most lines are of one kind, with whose colour they would look alike.
    for (slot, line) in lines.iter_mut().enumerate() {
        line.key = Key::new(slot);
    }
    Ok(lines)
}

fn truth(rays: &Rays) -> Line {
    let ray = rays.shown();
    Line {
        name: format!("exact, {} blockers", ray.segments.len()),
        key: Key::new(0),
        values: ray.truths(&rays.plotted_depths()),
    }
}

fn line<A>(rays: &Rays, family: Family, setting: &str, clear: &A) -> Line
where
    A: Accumulate + Clone,
{
    let curve: A::Curve = made(clear, rays.shown());
    let at = |depth: f32| f64::from(curve.evaluate(depth)[0]);
    Line {
        name: format!("{}, {setting}", family.title()),
        key: family.key(),
        values: rays.plotted_depths().into_iter().map(at).collect(),
    }
}
