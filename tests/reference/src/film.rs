//! How far a film is from its reference, and how much of that moves.
//!
//! With the pictures `I_t` of a film, those of its reference `R_t` and the errors
//! `e_t = I_t − R_t`:
//!
//! ```text
//! rmse    = rms over t of e_t                 what is wrong in each frame
//! change  = rms over t of e_t − e_{t−1}       what flickers: the error from frame to frame
//! ratio   = change / rmse
//! ```
//!
//! Both are over all channels of all pixels and divided by the mean radiance of the
//! reference film. An error that stays where it is has the ratio 0, one that is new in
//! each frame √2, and one that changes its sign in each frame 2; one frame of n that is off
//! by far more than the others makes √(2n / (n − 1)). An error that stays on the
//! scene while the camera moves slowly is between 0 and 1.
//!
//! *Lag* is the shift s, in frames, with which the film fits its reference best: the least
//!
//! ```text
//! D²(s) = mean over t of |I_t − R_{t−s}|²
//! ```
//!
//! where R is interpolated between frames. Errors that have nothing to do with the past can
//! fit a shift, too: what is drawn half a pixel to the left lags while the camera moves to
//! one side, and leads while it moves to the other; what is blurred fits the mean of two
//! frames. So a film should go forth and back by the same places, with its turn in the
//! middle (frame n / 2 of n): then such errors fit the past and the future alike, and only what fits the
//! past better counts.

use crate::metrics::Reference;

/// By how much the past must fit better than the future, as a share: rounding is less.
const CLEARLY: f64 = 1e-3;

/// The largest lag that is looked for, in frames.
const MOST_LAG: usize = 16;

/// The fewest frames that have a [`lag`].
pub const LEAST_FRAMES: usize = 5;

/// The error of a film in linear radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmError {
    /// Root of the mean squared difference over all frames, divided by `mean`.
    pub rmse: f64,
    /// The same of what the difference changes by from each frame to the next; 0 for a
    /// single frame.
    pub change: f64,
    /// Mean radiance of the reference over all channels of all pixels of all frames.
    pub mean: f64,
    /// The reference is black and nothing was divided.
    pub absolute: bool,
}

impl FilmError {
    /// `change` as a multiple of `rmse`; 0 if nothing changes, infinite if `change` is.
    pub fn ratio(&self) -> f64 {
        match self.change {
            change if change.is_infinite() => f64::INFINITY,
            change if change > 0.0 => change / self.rmse,
            _ => 0.0,
        }
    }
}

/// By how many frames a film is late.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// The shift that fits best; 0 if no earlier frame fits better than a later one.
    pub frames: f64,
    /// The share of the squared error that is gone with that shift, beside what a shift into
    /// the future takes away, 0 to 1.
    pub share: f64,
}

/// The error of a film (RGB and an ignored fourth component per pixel).
///
/// NaN and infinite pixels give infinite errors. A film without frames has no error.
///
/// # Panics
/// If the film and its reference differ in their numbers of frames or pixels.
pub fn film_error<P: AsRef<[[f32; 4]]>>(film: &[P], reference: &[Reference]) -> FilmError {
    check(film, reference);
    let frames = film.len().max(1) as f64;
    let mean = reference.iter().map(Reference::mean).sum::<f64>() / frames;
    let absolute = !(mean > 0.0);
    let unit = if absolute { 1.0 } else { mean };
    let pairs = || film.iter().map(AsRef::as_ref).zip(reference);
    let (mut squares, mut changes) = (0.0, 0.0);
    let (mut channels, mut changing) = (0_usize, 0_usize);
    for (picture, truth) in pairs() {
        squares += errors(picture, truth)
            .map(|e| square(e / unit))
            .sum::<f64>();
        channels += 3 * picture.len();
    }
    for ((before, truth_before), (now, truth)) in pairs().zip(pairs().skip(1)) {
        let both = errors(before, truth_before).zip(errors(now, truth));
        changes += both.map(|(a, b)| square((b - a) / unit)).sum::<f64>();
        changing += 3 * now.len();
    }
    FilmError {
        rmse: (squares / channels.max(1) as f64).sqrt(),
        change: (changes / changing.max(1) as f64).sqrt(),
        mean,
        absolute,
    }
}

/// The lag of a film whose frames follow each other closely, up to about a quarter of its
/// length and 16 frames at most; `None` if it has fewer than [`LEAST_FRAMES`] frames, or a
/// pixel that is not finite.
///
/// # Panics
/// As [`film_error`].
pub fn lag<P: AsRef<[[f32; 4]]>>(film: &[P], reference: &[Reference]) -> Option<Lag> {
    check(film, reference);
    if film.len() < LEAST_FRAMES {
        return None;
    }
    let turn = film.len() / 2;
    let side = film.len() - 1 - turn;
    let most = (side / 2).min(MOST_LAG);
    let window = turn + most - side..=turn + side - most;
    // Mean products of the differences to the references of two shifts.
    let product = |a: isize, b: isize| -> f64 {
        let of_frame = |t: usize| -> f64 {
            let to =
                |shift: isize| errors(film[t].as_ref(), &reference[t.wrapping_add_signed(-shift)]);
            to(a).zip(to(b)).map(|(a, b)| a * b).sum()
        };
        window.clone().map(of_frame).sum()
    };
    let unshifted = product(0, 0);
    // The best shift on one side: the sign tells which.
    let best = |sign: isize| {
        let mut best = (0.0, unshifted);
        let mut first = unshifted;
        for near in 0..most as isize {
            let [a, b] = [near, near + 1].map(|shift| sign * shift);
            let (both, second) = (product(a, b), product(b, b));
            let curvature = first - 2.0 * both + second;
            let part = match curvature > 0.0 {
                true => ((first - both) / curvature).clamp(0.0, 1.0),
                false => 0.0,
            };
            let rest = 1.0 - part;
            let left = rest * rest * first + 2.0 * rest * part * both + part * part * second;
            if left < best.1 {
                best = (near as f64 + part, left.max(0.0));
            }
            first = second;
        }
        best
    };
    let (past, future) = (best(1), best(-1));
    if !future.1.is_finite() {
        return None;
    }
    Some(match past.1 < (1.0 - CLEARLY) * future.1 {
        true => Lag {
            frames: past.0,
            share: 1.0 - past.1 / future.1,
        },
        false => Lag {
            frames: 0.0,
            share: 0.0,
        },
    })
}

fn check<P: AsRef<[[f32; 4]]>>(film: &[P], reference: &[Reference]) {
    assert_eq!(
        film.len(),
        reference.len(),
        "the film and its reference differ in length"
    );
    for (picture, truth) in film.iter().zip(reference) {
        assert_eq!(
            picture.as_ref().len(),
            truth.radiance.len(),
            "a frame and its reference differ in size"
        );
    }
}

/// The differences of all channels of all pixels.
fn errors<'a>(picture: &'a [[f32; 4]], truth: &'a Reference) -> impl Iterator<Item = f64> + 'a {
    let pixels = picture.iter().zip(&truth.radiance);
    pixels.flat_map(|(pixel, truth)| {
        std::array::from_fn::<_, 3, _>(|c| f64::from(pixel[c]) - truth[c])
    })
}

/// A NaN must not hide behind a comparison.
fn square(value: f64) -> f64 {
    match value.is_nan() {
        true => f64::INFINITY,
        false => value * value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const PIXELS: usize = 400;

    /// A film that goes forth and back over a landscape of hills.
    fn reference(frames: usize) -> Vec<Reference> {
        let at = |t: usize| {
            let place = 0.7 * t.abs_diff(frames / 2) as f64;
            let pixel = |i: usize| {
                let x = (i as f64 + place) * 0.11;
                [2.0 + x.sin(), 2.0 + (0.7 * x).cos(), 1.5 + (1.3 * x).sin()]
            };
            Reference {
                radiance: (0..PIXELS).map(pixel).collect(),
                bound: vec![0.0; PIXELS],
            }
        };
        (0..frames).map(at).collect()
    }

    fn film(
        reference: &[Reference],
        mut of: impl FnMut(usize, usize, [f64; 3]) -> [f64; 3],
    ) -> Vec<Vec<[f32; 4]>> {
        let picture = |(t, truth): (usize, &Reference)| {
            let pixels = truth.radiance.iter().enumerate();
            pixels
                .map(|(i, pixel)| {
                    let [r, g, b] = of(t, i, *pixel).map(|value| value as f32);
                    [r, g, b, 7.0]
                })
                .collect()
        };
        reference.iter().enumerate().map(picture).collect()
    }

    #[test]
    fn an_error_that_stays_does_not_flicker_and_does_not_lag() {
        let reference = reference(16);
        let film = film(&reference, |_, i, pixel| {
            pixel.map(|v| v + 0.1 * (i % 3) as f64)
        });
        let error = film_error(&film, &reference);
        assert!(error.rmse > 0.03 && error.change < 1e-7, "{error:?}");
        assert!(error.ratio() < 1e-5);
        let lag = lag(&film, &reference).unwrap();
        assert_eq!((lag.frames, lag.share), (0.0, 0.0));
    }

    #[test]
    fn a_film_of_a_still_scene_has_no_change_at_all() {
        let still = vec![reference(1).remove(0); 7];
        let film = film(&still, |_, i, pixel| {
            pixel.map(|v| v * if i % 2 == 0 { 1.1 } else { 0.8 })
        });
        let error = film_error(&film, &still);
        assert!(error.rmse > 0.1);
        assert_eq!((error.change, error.ratio()), (0.0, 0.0));
        let lag = lag(&film, &still).unwrap();
        assert_eq!((lag.frames, lag.share), (0.0, 0.0));
    }

    #[test]
    fn noise_that_is_new_in_each_frame_has_the_ratio_of_two_independent_errors() {
        let reference = reference(40);
        let mut random = Random::new(3);
        let film = film(&reference, |_, _, pixel| {
            pixel.map(|v| v + 0.2 * (random.unit_f64() - 0.5))
        });
        let error = film_error(&film, &reference);
        assert!(
            (error.ratio() / 2.0_f64.sqrt() - 1.0).abs() < 0.01,
            "{error:?}"
        );
        let lag = lag(&film, &reference).unwrap();
        assert!(lag.frames < 0.2 && lag.share < 0.05, "{lag:?}");
    }

    #[test]
    fn what_comes_late_lags_by_that_much() {
        for delay in [1, 2, 3] {
            let reference = reference(16);
            let film = film(&reference, |t, i, _| {
                reference[t.saturating_sub(delay)].radiance[i]
            });
            let lag = lag(&film, &reference).unwrap();
            assert!((lag.frames - delay as f64).abs() < 1e-6, "{lag:?}");
            assert!(lag.share > 0.999, "{lag:?}");
        }
        // The mean of this frame and the last is half a frame late.
        let reference = reference(17);
        let film = film(&reference, |t, i, pixel| {
            let before = reference[t.saturating_sub(1)].radiance[i];
            std::array::from_fn(|c| 0.5 * (pixel[c] + before[c]))
        });
        let lag = lag(&film, &reference).unwrap();
        assert!((lag.frames - 0.5).abs() < 1e-3, "{lag:?}");
    }

    #[test]
    fn a_trail_of_many_frames_lags() {
        let reference = reference(16);
        // Each frame is a tenth of its picture; the film went on before.
        let mut trail: Vec<[f64; 3]> = vec![[2.0; 3]; PIXELS];
        let mut late = Vec::new();
        for truth in [&reference[..]; 4].concat() {
            for (trail, pixel) in trail.iter_mut().zip(&truth.radiance) {
                *trail = std::array::from_fn(|c| 0.9 * trail[c] + 0.1 * pixel[c]);
            }
            late.push(trail.clone());
        }
        let late = &late[3 * 16..];
        let film = film(&reference, |t, i, _| late[t][i]);
        let lag = lag(&film, &reference).unwrap();
        assert!(lag.frames >= 2.0 && lag.share > 0.2, "{lag:?}");
    }

    #[test]
    fn what_is_shifted_or_blurred_in_space_does_not_lag() {
        let reference = reference(16);
        let near =
            |t: usize, i: isize| reference[t].radiance[i.clamp(0, PIXELS as isize - 1) as usize];
        let shifted = film(&reference, |t, i, _| near(t, i as isize + 1));
        let blurred = film(&reference, |t, i, _| {
            let [a, b] = [-9, 9].map(|step| near(t, i as isize + step));
            std::array::from_fn(|c| 0.5 * (a[c] + b[c]))
        });
        for film in [shifted, blurred] {
            assert!(film_error(&film, &reference).rmse > 0.01);
            let lag = lag(&film, &reference).unwrap();
            assert_eq!((lag.frames, lag.share), (0.0, 0.0));
        }
    }

    #[test]
    fn what_is_not_finite_is_an_infinite_error_and_black_films_are_absolute() {
        let reference = reference(5);
        let mut film = film(&reference, |_, _, pixel| pixel);
        film[2][7][1] = f32::NAN;
        let error = film_error(&film, &reference);
        assert!(error.rmse.is_infinite() && error.change.is_infinite());
        assert_eq!(error.ratio(), f64::INFINITY);
        assert_eq!(lag(&film, &reference), None);
        assert_eq!(lag(&film[..4], &reference[..4]), None);
        let black = [Reference {
            radiance: vec![[0.0; 3]; 2],
            bound: vec![0.0; 2],
        }];
        let error = film_error(&[vec![[0.25; 4]; 2]], &black);
        assert_eq!(
            (error.rmse, error.change, error.absolute),
            (0.25, 0.0, true)
        );
        let none = film_error::<Vec<[f32; 4]>>(&[], &[]);
        assert_eq!((none.rmse, none.change), (0.0, 0.0));
    }
}
