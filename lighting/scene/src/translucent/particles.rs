//! Smoke as balls.

use glam::Vec3;

use super::{around, check_colour, check_extinction, check_position, check_size};
use crate::{Bounds, PhaseFunction, SceneError};

/// A ball of smoke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particle {
    /// World position, m.
    pub centre: Vec3,
    /// Radius, m.
    pub radius: f32,
    /// Extinction coefficient at the centre, 1/m.
    pub sigma_t: f32,
}

/// How the extinction of a [`Particle`] falls with the distance `r` from its
/// centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Profile {
    /// The same up to the radius `R`.
    Constant,
    /// `(1 − r²/R²)` of the extinction at the centre, so that no edge is visible.
    Soft,
}

/// Balls with isotropic density profiles. Where they overlap, extinctions add up. New ones have
/// an albedo of 1 and scatter isotropically.
#[derive(Debug, Clone, PartialEq)]
pub struct Particles {
    all: Vec<Particle>,
    profile: Profile,
    albedo: Vec3,
    phase: PhaseFunction,
    bounds: Option<Bounds>,
}

impl Particles {
    /// Checks the particles and takes them over.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for a centre that is not finite or beyond
    /// 5e8 m, a radius outside of 0 to 1e8 m, an extinction outside of 0 to
    /// 1e15 per metre, more than 2²⁶ particles.
    pub fn new(all: Vec<Particle>, profile: Profile) -> Result<Self, SceneError> {
        const MAX_PARTICLES: usize = 1 << 26;
        if all.len() > MAX_PARTICLES {
            return Err(SceneError::bad_value(
                "particles",
                "their number",
                all.len(),
                "at most 2^26",
            ));
        }
        for (index, particle) in all.iter().enumerate() {
            let owner = || format!("particle {index}");
            check_position(owner, particle.centre)?;
            check_size(owner, "radius", particle.radius)?;
            check_extinction(owner, "sigma_t", particle.sigma_t)?;
        }
        Ok(Self {
            bounds: around(all.iter().map(|ball| (ball.centre, ball.radius))),
            all,
            profile,
            albedo: Vec3::ONE,
            phase: PhaseFunction::Isotropic,
        })
    }

    /// The same particles with an albedo: the share of the extinction that is scattering,
    /// linear RGB.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] unless all three are from 0 to 1.
    pub fn with_albedo(self, albedo: Vec3) -> Result<Self, SceneError> {
        let owner = || "particles".into();
        check_colour(owner, "albedo", albedo, 1.0, "shares from 0 to 1")?;
        Ok(Self { albedo, ..self })
    }

    /// The same particles with another phase function.
    ///
    /// # Errors
    /// [`SceneError::PhaseFunction`] if its parameters are out of range.
    pub fn with_phase(self, phase: PhaseFunction) -> Result<Self, SceneError> {
        let phase = phase.checked()?;
        Ok(Self { phase, ..self })
    }

    /// The share of the extinction that is scattering, linear RGB.
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }

    /// How scattered light spreads over directions.
    pub fn phase(&self) -> PhaseFunction {
        self.phase
    }

    /// All of them.
    pub fn all(&self) -> &[Particle] {
        &self.all
    }

    /// The profile of their extinction.
    pub fn profile(&self) -> Profile {
        self.profile
    }

    /// A box around them; `None` if there are none.
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_particles_name_their_cause() {
        let good = Particle {
            centre: Vec3::X,
            radius: 1.0,
            sigma_t: 0.5,
        };
        let new = |particle| Particles::new(vec![good, particle], Profile::Soft);
        for (bad, cause) in [
            (
                Particle {
                    centre: Vec3::NAN,
                    ..good
                },
                "particle 1",
            ),
            (
                Particle {
                    radius: -1.0,
                    ..good
                },
                "radius is -1",
            ),
            (
                Particle {
                    sigma_t: f32::INFINITY,
                    ..good
                },
                "sigma_t is inf",
            ),
        ] {
            let error = new(bad).unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
        let bounds = new(good).unwrap().bounds().unwrap();
        assert!((bounds.max() - Vec3::new(2.0, 1.0, 1.0)).length() < 1e-5);
    }
}
