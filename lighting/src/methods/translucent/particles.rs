//! Particles as a light sees them: the chord of each texel's ray through the
//! ball.
//!
//! With the distance `b` of the ray from the centre, half the chord is
//! `h = √(R² − b²)`, and from `t₀` to `t₁` behind the middle of the chord the
//! optical depth is
//!
//! ```text
//! constant:  σ (t₁ − t₀)
//! soft:      σ/R² [h² t − t³/3] from t₀ to t₁
//! ```

use glam::DVec3;
#[cfg(feature = "wgpu")]
use glam::{DVec2, Vec2};
use transmittance::BlockerSegment;

#[cfg(feature = "wgpu")]
use super::candidates::{BALL, CandidateRecord};
use super::view::{Texels, View};
use crate::scene::{Particle, Profile};

/// Number of parts into which the chord through a soft ball is cut. Each has constant
/// extinction and the exact optical depth.
pub(super) const PARTS: u32 = 4;

/// A ball in local coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    centre: DVec3,
    radius: f64,
    sigma_t: f64,
    profile: Profile,
}

impl Ball {
    pub(super) fn new(view: &View, particle: &Particle, profile: Profile) -> Self {
        Self {
            centre: view.local(particle.centre),
            radius: particle.radius.into(),
            sigma_t: particle.sigma_t.into(),
            profile,
        }
    }

    /// The texels that may see it; `None` if there is nothing to see.
    pub(super) fn texels(&self, view: &View) -> Option<Texels> {
        if self.radius == 0.0 || self.sigma_t == 0.0 {
            return None;
        }
        view.of_ball(self.centre, self.radius)
    }

    /// It as a candidate of shaders, in a face whose rows begin at `row`.
    #[cfg(feature = "wgpu")]
    pub(super) fn candidate(&self, view: &View, row: u32) -> Option<CandidateRecord> {
        let texels = self.texels(view)?;
        // A ball that is no nearer has its centre in the picture.
        let is_in_front = view.is_parallel() || self.centre.z > self.radius;
        let position = if is_in_front {
            let first = DVec2::new(texels.x[0].into(), texels.y[0].into());
            (view.texel(self.centre) - first).as_vec2()
        } else {
            Vec2::ZERO
        };
        Some(CandidateRecord {
            a: self.centre.as_vec3().to_array(),
            radius: self.radius as f32,
            b: [
                self.sigma_t as f32,
                f32::from(u8::from(self.profile == Profile::Soft)),
                0.0,
            ],
            corners: [
                [position.x, position.y, f32::from(u8::from(is_in_front))],
                [0.0; 3],
                [0.0; 3],
                [0.0; 3],
            ],
            ..CandidateRecord::new(BALL, texels, row)
        })
    }

    /// Calls `put` with what it takes from each texel.
    pub(super) fn segments(
        &self,
        view: &View,
        texels: Texels,
        put: &mut dyn FnMut([usize; 2], BlockerSegment),
    ) {
        texels.for_each(|x, y| {
            let (start, direction) = view.ray(x, y);
            let to_centre = self.centre - start;
            let middle = to_centre.dot(direction);
            let h2 = self.radius * self.radius - (to_centre - middle * direction).length_squared();
            if h2 <= 0.0 {
                return;
            }
            let half = h2.sqrt();
            // What is behind the origin of central rays casts no shadow.
            let least = if view.is_parallel() {
                -half
            } else {
                (-half).max(-middle)
            };
            if least >= half {
                return;
            }
            let parts = match self.profile {
                Profile::Constant => 1,
                Profile::Soft => PARTS,
            };
            let at = |part: u32| least + (half - least) * (f64::from(part) / f64::from(parts));
            for part in 0..parts {
                let (from, to) = (at(part), at(part + 1));
                let tau = self.optical_depth(h2, from, to);
                let (entry, exit) = ((middle + from) as f32, (middle + to) as f32);
                // This cannot fail: depths are finite and in order, and the integrand is
                // positive.
                if let Ok(segment) =
                    BlockerSegment::from_optical_depth(entry, exit, tau.max(0.0) as f32)
                {
                    put([x as usize, y as usize], segment);
                }
            }
        });
    }

    fn optical_depth(&self, h2: f64, from: f64, to: f64) -> f64 {
        match self.profile {
            Profile::Constant => self.sigma_t * (to - from),
            Profile::Soft => {
                let integral = |t: f64| t * (h2 - t * t / 3.0);
                self.sigma_t * ((integral(to) - integral(from)) / (self.radius * self.radius))
            }
        }
    }
}
