//! The media in the air of a scene, as rays ask for them.

mod part;
mod pieces;
#[cfg(test)]
mod tests;

pub use part::{MediaPart, Scattering};
pub use pieces::{MediaPiece, MediaPieces};

use glam::{DVec3, Vec3};

use crate::cubic::Cubic;
use crate::{
    Bounds, DensityGrid, HeightFog, Interval, Medium, Particle, Particles, Profile, Ray, Scene,
    Translucent,
};

/// A homogeneous medium, fog that thins out with altitude, density grids and particles. Any of
/// them may be missing or overlap; where several are at one place, their coefficients add up.
///
/// A ray can ask for values at a point: the [extinction](Media::extinction_at), and what is
/// [scattered and emitted](Media::scattering_at). It can also ask about a part of itself: for
/// the [optical depth](Media::optical_depth), or for its [pieces](Media::along). On each piece
/// every coefficient is a polynomial or an exponential, so that a gather of scattered light
/// needs no step size for the density.
///
/// ```
/// use glam::{DVec3, Vec3};
/// use scene::{Bounds, DensityGrid, Interpolation, Media, Medium, PhaseFunction};
///
/// let fog = Medium::new(Vec3::splat(0.01), Vec3::ZERO, PhaseFunction::Isotropic)?;
/// let bounds = Bounds::new(Vec3::ZERO, Vec3::ONE)?;
/// // Twice as dense on the right as on the left.
/// let smoke = DensityGrid::new(bounds, [2, 1, 1], vec![1.0, 2.0], 5.0, Interpolation::Linear)?;
/// let casters = [smoke.into()];
/// let media = Media::new(Some(&fog), None, &casters);
/// let mut pieces = media.along(DVec3::new(-2.0, 0.5, 0.5), DVec3::X, 0.0, 10.0);
/// let mut ends = Vec::new();
/// while let Some(piece) = pieces.advance() {
///     ends.push((piece.end(), piece.depth_before().x + piece.optical_depth().x));
/// }
/// assert_eq!(ends.len(), 3); // in front of the smoke, through it, behind it
/// assert!((ends[1].1 - (0.01 * 3.0 + 5.0 * 1.5)).abs() < 1e-9);
/// # Ok::<(), scene::SceneError>(())
/// ```
///
/// Strands are not a medium and not included. Every ray tests every particle: O(particles) per
/// ray.
#[derive(Debug, Clone)]
pub struct Media<'a> {
    medium: Option<Medium>,
    height_fog: Option<HeightFog>,
    grids: Vec<&'a DensityGrid>,
    balls: Vec<Ball<'a>>,
}

/// A particle, and the particles that it belongs to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball<'a> {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
    pub(crate) sigma_t: f64,
    pub(crate) of: &'a Particles,
}

impl<'a> Ball<'a> {
    fn new(particle: &Particle, of: &'a Particles) -> Option<Self> {
        (particle.radius > 0.0 && particle.sigma_t > 0.0).then(|| Self {
            centre: particle.centre.as_dvec3(),
            radius: particle.radius.into(),
            sigma_t: particle.sigma_t.into(),
            of,
        })
    }

    /// The extinction, 1/m, between two distances on a line whose chord extends `half` on
    /// either side of `middle`.
    fn cubic(&self, half: f64, middle: f64, from: f64, to: f64) -> Cubic {
        match self.of.profile() {
            Profile::Constant => Cubic::constant(self.sigma_t),
            Profile::Soft => {
                // The polar form h² − s t of (h² − t²) / R², which is positive within the
                // chord.
                let (a, b) = (from - middle, to - middle);
                let polar = |s: f64, t: f64| (half * half - s * t).max(0.0);
                let scale = self.sigma_t / (self.radius * self.radius);
                Cubic::quadratic([polar(a, a), polar(a, b), polar(b, b)].map(|q| scale * q))
            }
        }
    }

    /// Extinction at a point, 1/m.
    fn extinction(&self, point: DVec3) -> f64 {
        let share = (point - self.centre).length_squared() / (self.radius * self.radius);
        match self.of.profile() {
            _ if share >= 1.0 => 0.0,
            Profile::Constant => self.sigma_t,
            Profile::Soft => self.sigma_t * (1.0 - share),
        }
    }
}

impl<'a> Media<'a> {
    /// Collects the media; strands are ignored.
    pub fn new(
        medium: Option<&Medium>,
        height_fog: Option<&HeightFog>,
        translucent: &'a [Translucent],
    ) -> Self {
        let mut media = Self {
            medium: medium.copied(),
            height_fog: height_fog.copied(),
            grids: Vec::new(),
            balls: Vec::new(),
        };
        for caster in translucent {
            match caster {
                Translucent::Grid(grid) => media.grids.push(grid),
                Translucent::Particles(particles) => {
                    let all = particles.all().iter();
                    media
                        .balls
                        .extend(all.filter_map(|particle| Ball::new(particle, particles)));
                }
                Translucent::Strands(_) => {}
            }
        }
        media
    }

    /// The media of a scene.
    pub fn of(scene: &'a Scene) -> Self {
        Self::new(
            scene.medium.as_ref(),
            scene.height_fog.as_ref(),
            &scene.translucent,
        )
    }

    /// The homogeneous medium, if there is one.
    pub fn medium(&self) -> Option<&Medium> {
        self.medium.as_ref()
    }

    /// The fog that thins out with altitude, if there is any.
    pub fn height_fog(&self) -> Option<&HeightFog> {
        self.height_fog.as_ref()
    }

    /// The density grids.
    pub fn grids(&self) -> &[&'a DensityGrid] {
        &self.grids
    }

    /// The kinds of particles, one after the other, without those that have no extinction.
    pub fn particles(&self) -> impl Iterator<Item = &'a Particles> {
        // Balls of the same kind follow each other.
        let kinds = self.balls.chunk_by(|a, b| std::ptr::eq(a.of, b.of));
        kinds.filter_map(|balls| balls.first().map(|ball| ball.of))
    }

    /// Boxes around media that do not fill all of space: a bounded homogeneous medium, the
    /// occupied part of each grid, and all particles of a kind.
    pub fn boxes(&self) -> impl Iterator<Item = Bounds> {
        let medium = self.medium.as_ref().and_then(Medium::bounds);
        medium.into_iter().chain(self.smoke_boxes())
    }

    /// Boxes around smoke alone: the occupied part of each grid, and all particles of a kind.
    pub fn smoke_boxes(&self) -> impl Iterator<Item = Bounds> {
        let grids = self.grids.iter().map(|grid| grid.occupied_bounds());
        let particles = self.particles().filter_map(Particles::bounds);
        grids.chain(particles)
    }

    /// True if there is no medium other than a homogeneous one.
    pub fn is_homogeneous(&self) -> bool {
        self.height_fog.is_none() && self.grids.is_empty() && self.balls.is_empty()
    }

    /// True if a grid emits light of its own.
    pub fn emits(&self) -> bool {
        self.grids.iter().any(|grid| !grid.emission().is_empty())
    }

    /// Calls `visit` with the coefficients of each medium that is at a point; media with
    /// different phase functions are kept apart.
    pub fn scattering_at(&self, point: DVec3, mut visit: impl FnMut(Scattering)) {
        if let Some(medium) = &self.medium
            && medium
                .bounds()
                .is_none_or(|bounds| bounds.contains(point.as_vec3()))
        {
            visit(Scattering {
                extinction: medium.sigma_t().as_dvec3(),
                scattering: medium.sigma_s().as_dvec3(),
                emission: DVec3::ZERO,
                phase: medium.phase(),
            });
        }
        if let Some(fog) = &self.height_fog {
            let density = fog.density(point.y);
            visit(Scattering {
                extinction: depth(fog.sigma_t().as_dvec3(), density),
                scattering: depth(fog.sigma_s().as_dvec3(), density),
                emission: DVec3::ZERO,
                phase: fog.phase(),
            });
        }
        for grid in &self.grids {
            if let Some((cell, place)) = grid.cell_at(point) {
                let extinction = grid.tint().as_dvec3() * grid.extinction(cell, place);
                visit(Scattering {
                    extinction,
                    scattering: grid.albedo_in(cell, place) * extinction,
                    emission: grid.emission_in(cell, place),
                    phase: grid.phase(),
                });
            }
        }
        for ball in &self.balls {
            let extinction = ball.extinction(point);
            if extinction > 0.0 {
                visit(Scattering {
                    extinction: DVec3::splat(extinction),
                    scattering: ball.of.albedo().as_dvec3() * extinction,
                    emission: DVec3::ZERO,
                    phase: ball.of.phase(),
                });
            }
        }
    }

    /// The extinction coefficient at a point, 1/m.
    pub fn extinction_at(&self, point: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        self.scattering_at(point, |medium| sum += medium.extinction);
        sum
    }

    /// The pieces of the line `origin + t direction` for t from `from` to `to`, where
    /// `direction` is a unit vector. `to` may be infinite, `from` must not be.
    pub fn along(&self, origin: DVec3, direction: DVec3, from: f64, to: f64) -> MediaPieces<'_> {
        MediaPieces::new(self, origin, direction, from, to)
    }

    /// The pieces of a part of an eye ray.
    pub fn along_ray(&self, ray: &Ray, interval: Interval) -> MediaPieces<'_> {
        let direction = ray.direction().as_dvec3().normalize();
        self.along(
            ray.origin().as_dvec3(),
            direction,
            interval.start.into(),
            interval.end.into(),
        )
    }

    /// The share of light from `distance` along a ray that reaches the ray's origin, per colour
    /// channel: `exp(−τ)`.
    pub fn transmittance(&self, ray: &Ray, distance: f32) -> Vec3 {
        let direction = ray.direction().as_dvec3().normalize();
        let depth = self.optical_depth(ray.origin().as_dvec3(), direction, 0.0, distance.into());
        (-depth).exp().as_vec3()
    }

    /// The optical depth of the line `origin + t direction` for t from `from` to `to`, per
    /// colour channel. It is exact except for rounding, to a relative 1e-13 in ordinary scenes.
    /// It is infinite along an endless way through fog, and 0 if `to` is not above `from`.
    pub fn optical_depth(&self, origin: DVec3, direction: DVec3, from: f64, to: f64) -> DVec3 {
        let mut sum = DVec3::ZERO;
        if !(from < to) {
            return sum;
        }
        if let Some(medium) = &self.medium
            && let Some((start, end)) = pieces::inside(medium, origin, direction, from, to)
        {
            sum += depth(medium.sigma_t().as_dvec3(), end - start);
        }
        if let Some(fog) = &self.height_fog {
            let y = origin.y + from * direction.y;
            sum += fog.optical_depth(y, direction.y, to - from);
        }
        for grid in &self.grids {
            let cells = grid.occupied_cells_along(origin, direction, from, to);
            let depth: f64 = cells.map(|span| grid.optical_depth(&span)).sum();
            sum += grid.tint().as_dvec3() * depth;
        }
        for ball in &self.balls {
            sum += DVec3::splat(pieces::depth_of_ball(ball, origin, direction, from, to));
        }
        sum
    }
}

/// Coefficients times a length, which may be infinite; 0 in channels without extinction.
pub(crate) fn depth(sigma: DVec3, length: f64) -> DVec3 {
    DVec3::select(sigma.cmpgt(DVec3::ZERO), sigma * length, DVec3::ZERO)
}
