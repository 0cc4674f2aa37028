//! Checks of the pictures of hard cases.

use lighting::methods::Entry;
use reference::metrics::{Reference, image_error};
use reference::tolerances::Allowed;

/// A method in a case on a backend.
pub(super) struct Finding {
    pub(super) case: &'static str,
    pub(super) method: String,
    pub(super) backend: String,
    pub(super) quality: u32,
    pub(super) outcome: Outcome,
}

/// The outcome of a method in a case.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// Why there is no picture: an error with a reason.
    pub(super) refused: Option<String>,
    /// RMSE over the mean of the reference.
    pub(super) error: f64,
    /// Everything that is wrong with it.
    pub(super) violations: Vec<String>,
    image: Vec<[f32; 4]>,
    mean: f64,
}

impl Outcome {
    pub(super) fn refused(why: String) -> Self {
        Self {
            refused: Some(why),
            ..Self::default()
        }
    }

    pub(super) fn of(entry: &Entry, quality: u32, image: &[[f32; 4]], truth: &Reference) -> Self {
        let found = image_error(image, truth);
        let mut violations = Vec::new();
        if let Some(pixel) = image.iter().position(|light| !is_light(light)) {
            violations.push(format!("pixel {pixel} is {:?}", &image[pixel][..3]));
        }
        let bound = |tolerance| tolerance + Allowed::ExactImage.error();
        if let Some(bound) = entry.method().tolerance(quality).map(bound)
            && !(found.rmse <= bound)
        {
            violations.push(format!("error {:.1e}, bound {bound:.1e}", found.rmse));
        }
        Self {
            refused: None,
            error: found.rmse,
            violations,
            image: image.to_vec(),
            mean: if found.absolute { 1.0 } else { found.mean },
        }
    }
}

impl Finding {
    /// Whether anything is wrong.
    pub(super) fn is_violation(&self) -> bool {
        !self.outcome.violations.is_empty()
    }
}

/// Finite and not negative.
fn is_light(light: &[f32; 4]) -> bool {
    light[..3].iter().all(|c| c.is_finite() && *c >= 0.0)
}

/// Two pictures of one method show the same, so they may differ by the sum of their errors. Where
/// these are smaller, they may differ as much as two maps that different rasterisers have drawn,
/// which differ in a few texels at edges: if one of 91 rays ends a texel of 256 earlier, that is
/// 1/256 / √91, and twice that is allowed.
const ROUNDING: f64 = 1e-3;

/// Compares each picture of the GPU with that of the CPU.
pub(super) fn compare_backends(findings: &mut [Finding]) {
    for index in 0..findings.len() {
        let (case, method) = (findings[index].case, findings[index].method.clone());
        let first = findings[..index]
            .iter()
            .find(|other| other.case == case && other.method == method);
        let Some(first) = first else { continue };
        let this = &findings[index].outcome;
        let other = &first.outcome;
        if this.refused.is_some() || other.refused.is_some() {
            continue;
        }
        let off = difference(&this.image, &other.image, other.mean);
        let allowed = 2.0 * other.error + ROUNDING;
        if !(off <= allowed) && this.violations.is_empty() && other.violations.is_empty() {
            let what = format!("{off:.1e} from {}, allowed {allowed:.1e}", first.backend);
            findings[index].outcome.violations.push(what);
        }
    }
}

/// Root mean square of the difference over a mean.
fn difference(a: &[[f32; 4]], b: &[[f32; 4]], mean: f64) -> f64 {
    let squares: f64 = a
        .iter()
        .zip(b)
        .flat_map(|(a, b)| (0..3).map(move |c| (f64::from(a[c]) - f64::from(b[c])) / mean))
        .map(|difference| difference * difference)
        .sum();
    (squares / (3 * a.len()).max(1) as f64).sqrt()
}
