//! Point lights and suns in fog without bounds, in closed form.

use std::f64::consts::{FRAC_PI_2, PI};

use airlight::gauss::Rule;
use airlight::surface::LobeTable;
use glam::Vec3;

use super::{Covers, NotCovered, SurfaceEvaluator};
use crate::Emitter;
use crate::scene::{Emission, Medium, PhaseFunction, ScatteringAngle};

/// Entries of the table for suns, over the cosine from −1 to 1.
pub(super) const SUN_ENTRIES: usize = 257;

/// The light that fog without bounds scatters onto a surface, in closed form and without
/// shadows.
///
/// For a point light that shines alike in all directions, at the distance `D` and with the
/// angle θ between the normal and the direction to the light, in fog that scatters
/// isotropically:
///
/// ```text
/// E = σ_s I / (2π D) · G_0(σ_t D, θ)
/// ```
///
/// with a relative error of 1e-4 ([`LobeTable`]). At `D = 0` it is 0, because nothing else is
/// lit there either. For a sun, whose light reaches all of the fog undimmed, and any phase
/// function `p`:
///
/// ```text
/// E = E_sun σ_s/σ_t ∫_{n·ω > 0} (n·ω) p(ω·s) dω
/// ```
///
/// where `s` is the direction to the sun. For isotropic scattering this is `E_sun σ_s/4σ_t` on
/// every surface, whatever its normal. A table over `n·s` holds the integral with an error of
/// at most `2e-5 / (1 − |g|)²` of its largest possible value, which is 1.
///
/// Two channels with the same extinction cost as much as one.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedForm {
    lambertian: LobeTable,
    phase: PhaseFunction,
    sun: Vec<f32>,
}

impl ClosedForm {
    /// A closed form for the phase function of this medium; the medium's coefficients do not
    /// matter. It is made by quadrature: keep it for all frames with this phase function.
    pub fn new(medium: &Medium) -> Self {
        let phase = medium.phase();
        let table = (0..SUN_ENTRIES).map(|index| {
            let cos = 2.0 * index as f64 / (SUN_ENTRIES - 1) as f64 - 1.0;
            sun_on_surface(phase, cos.acos()) as f32
        });
        Self {
            lambertian: LobeTable::lambertian(),
            phase,
            sun: table.collect(),
        }
    }

    /// Whether a light in a medium is covered: point lights without a range that shine alike in
    /// all directions, in fog that scatters isotropically; and suns in fog with the phase
    /// function that this was made for; both only in fog without bounds.
    ///
    /// # Errors
    /// The reason why it is not covered; [`Quadrature`](super::Quadrature) covers it.
    pub fn covers(&self, emitter: &Emitter, medium: &Medium) -> Result<(), NotCovered> {
        if medium.bounds().is_some() {
            return Err(NotCovered::Bounds);
        }
        match emitter {
            Emitter::Directional(_) if medium.phase() != self.phase => Err(NotCovered::OtherPhase),
            Emitter::Directional(_) => Ok(()),
            Emitter::Point(_) if medium.phase() != PhaseFunction::Isotropic => {
                Err(NotCovered::Phase)
            }
            Emitter::Point(point) if *point.emission() != Emission::Isotropic => {
                Err(NotCovered::Emission)
            }
            Emitter::Point(point) if point.range() < f32::INFINITY => Err(NotCovered::Range),
            Emitter::Point(_) => Ok(()),
        }
    }

    #[cfg(feature = "wgpu")]
    pub(super) fn lobe(&self) -> &LobeTable {
        &self.lambertian
    }

    #[cfg(feature = "wgpu")]
    pub(super) fn sun(&self) -> &[f32] {
        &self.sun
    }
}

impl Covers for ClosedForm {
    fn covers(&self, emitter: &Emitter, medium: &Medium) -> Result<(), NotCovered> {
        self.covers(emitter, medium)
    }
}

impl SurfaceEvaluator for ClosedForm {
    fn irradiance(&self, position: Vec3, normal: Vec3, emitter: &Emitter, medium: &Medium) -> Vec3 {
        let (sigma_s, sigma_t) = (medium.sigma_s(), medium.sigma_t());
        match emitter {
            Emitter::Point(point) => {
                let to_light = point.position() - position;
                let distance = to_light.length();
                if distance == 0.0 {
                    return Vec3::ZERO;
                }
                let cos = normal.dot(to_light / distance);
                let gathered = per_channel(sigma_t, |sigma_t| {
                    self.lambertian.value(sigma_t * distance, cos)
                });
                sigma_s * point.intensity() * gathered * (0.5 / std::f32::consts::PI / distance)
            }
            Emitter::Directional(sun) => {
                let cos = normal.dot(-sun.direction());
                let x = (0.5 * cos + 0.5).clamp(0.0, 1.0) * (SUN_ENTRIES - 1) as f32;
                let first = (x as usize).min(SUN_ENTRIES - 2);
                let (low, high) = (self.sun[first], self.sun[first + 1]);
                let share = low + (x - first as f32) * (high - low);
                // A channel without extinction scatters nothing.
                let albedo = Vec3::select(sigma_t.cmpgt(Vec3::ZERO), sigma_s / sigma_t, Vec3::ZERO);
                albedo * sun.irradiance() * share
            }
        }
    }
}

/// A function of a coefficient, evaluated once for channels with equal coefficients.
fn per_channel(sigma: Vec3, f: impl Fn(f32) -> f32) -> Vec3 {
    let red = f(sigma.x);
    let green = if sigma.y == sigma.x { red } else { f(sigma.y) };
    let blue = if sigma.z == sigma.y {
        green
    } else {
        f(sigma.z)
    };
    Vec3::new(red, green, blue)
}

/// `∫ max(0, n·ω) p(ω·s) dω` for the angle θ between `n` and `s`, as an integral over rings
/// around `s`.
fn sun_on_surface(phase: PhaseFunction, theta: f64) -> f64 {
    let kink = (FRAC_PI_2 - theta).abs();
    let rule = Rule::new(24).expect("24 nodes");
    // Panels that are halved towards both ends resolve the peaks of the phase function. The
    // kinks are where rings begin to leave the hemisphere.
    let mut cuts: Vec<f64> = (1..10).map(|k| PI * 0.5_f64.powi(k)).collect();
    cuts.extend((2..10).map(|k| PI * (1.0 - 0.5_f64.powi(k))));
    cuts.extend([0.0, kink, PI - kink, PI]);
    cuts.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for panel in cuts.windows(2) {
        let (start, width) = (panel[0], panel[1] - panel[0]);
        for (node, weight) in rule.iter() {
            let gamma = start + width * node;
            let half = (0.5 * gamma).tan();
            let angle = ScatteringAngle::<f64>::from_half_tangent(half, 1.0);
            sum += width * weight * gamma.sin() * phase.value(angle) * ring(gamma, theta);
        }
    }
    sum
}

/// `∫_0^{2π} max(0, cos γ cos θ + sin γ sin θ cos ψ) dψ`.
fn ring(gamma: f64, theta: f64) -> f64 {
    let a = gamma.cos() * theta.cos();
    let b = gamma.sin() * theta.sin();
    if a >= b {
        2.0 * PI * a
    } else if a <= -b {
        0.0
    } else {
        2.0 * (a * (-a / b).acos() + ((b - a) * (b + a)).sqrt())
    }
}
