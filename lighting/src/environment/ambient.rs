//! Uniform light from all directions that fog scatters towards the eye, in front of what the
//! eye sees.
//!
//! Based on: Gautron, Marvie and François, Volumetric Shadow Mapping, SIGGRAPH 2009 Talks,
//! which adds a scattered ambient term for coherent lighting and does not say which. Here it is
//! the single scattering of a radiance `L_a` from all directions, which nothing blocks on its
//! way to the ray:
//! ```text
//! L = ∫_0^D σ_s e^{−σ_t x} ∫ p(ω, ω') L_a dω' dx = σ_s/σ_t · L_a (1 − e^{−σ_t D})
//! ```
//!
//! because a phase function integrates to 1. D is the length of the ray in the fog, up to the
//! surface that it meets.

use glam::Vec3;

use super::EnvironmentError;
use crate::Ray;
use crate::scene::Medium;

/// Uniform light from all directions in fog.
///
/// ```
/// use glam::Vec3;
/// use lighting::Ray;
/// use lighting::environment::Ambient;
/// use lighting::scene::{Medium, PhaseFunction};
///
/// let fog = Medium::new(Vec3::splat(0.06), Vec3::splat(0.02), PhaseFunction::Rayleigh)?;
/// let ambient = Ambient::new([1.0, 2.0, 4.0], &fog)?;
/// let seen = |length| ambient.seen(&Ray::new(Vec3::ZERO, Vec3::X, length).unwrap());
/// // Endless fog is as bright as what lights it, but for what it absorbs.
/// assert!((seen(f32::INFINITY) - 0.75 * Vec3::new(1.0, 2.0, 4.0)).length() < 1e-5);
/// assert!(seen(1.0).z < 0.25);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ambient {
    pub(super) radiance: Vec3,
    pub(super) medium: Medium,
    pub(super) before_sky: bool,
}

impl Ambient {
    /// Radiance from all directions, linear RGB, in a medium.
    ///
    /// # Errors
    /// [`EnvironmentError::Ambient`] unless each channel is from 0 to 1e20.
    pub fn new(radiance: [f32; 3], medium: &Medium) -> Result<Self, EnvironmentError> {
        let is_sound = |value: &f32| (0.0..=1e20).contains(value);
        if let Some(value) = radiance.into_iter().find(|value| !is_sound(value)) {
            return Err(EnvironmentError::Ambient { value });
        }
        Ok(Self {
            radiance: radiance.into(),
            medium: *medium,
            before_sky: true,
        })
    }

    /// The same for rays that end on a surface only. In front of the sky, the halo of an
    /// [environment](super::AddEnvironment::add_sky) is the light of the fog.
    #[must_use]
    pub fn before_surfaces(self) -> Self {
        Self {
            before_sky: false,
            ..self
        }
    }

    /// What the fog along a ray scatters into the eye: `σ_s/σ_t · L_a (1 − e^{−σ_t D})` per
    /// channel, exact to rounding. D is infinite for a ray to the sky in fog without bounds; in
    /// a box of fog it is the length inside, and 0 if the ray misses the box. Vacuum, and fog
    /// that only absorbs, give 0.
    pub fn seen(&self, ray: &Ray) -> Vec3 {
        if !self.before_sky && ray.length().is_infinite() {
            return Vec3::ZERO;
        }
        let medium = &self.medium;
        let way = medium.length_inside(ray.origin(), ray.direction(), ray.length());
        let (sigma_s, sigma_t) = (medium.sigma_s(), medium.sigma_t());
        let scattered = |channel: usize| {
            if sigma_s[channel] == 0.0 {
                return 0.0;
            }
            let share = -(-sigma_t[channel] * way).exp_m1();
            sigma_s[channel] / sigma_t[channel] * self.radiance[channel] * share
        };
        Vec3::new(scattered(0), scattered(1), scattered(2))
    }
}
