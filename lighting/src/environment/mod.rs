//! Light from all around: the sky, seen through fog and on surfaces.
//!
//! Based on: Sun, Ramamoorthi, Narasimhan and Nayar, A practical analytic single
//! scattering model for real time rendering, SIGGRAPH 2005. An environment of radiance
//! `L` behind fog of the optical depth `T` in all directions is seen as
//!
//! ```text
//! L_seen(ω) = e^{−T} [ L(ω) + σ_s/σ_t T ∫ N(γ; T) L(ω') dω' ]
//! ```
//!
//! that is, attenuated, and with a halo around everything bright. `N` is the [point-spread
//! function](airlight::point_spread) of fog. [`AddEnvironment`] adds this radiance where a
//! picture shows the sky, and adds the light of the environment that surfaces reflect.
//!
//! An environment is infinitely far away, so the length of the way to it through the fog has to
//! be defined:
//!
//! | medium | way through the fog in a direction |
//! |---|---|
//! | none | 0: the environment is seen as it is |
//! | in a box | from the eye, or from the surface, to the face of the box |
//! | without bounds | the distance that [`Environment::at_distance`] sets; without one nothing would be seen, and [`EnvironmentMap::new`] says so |
//!
//! Departures from the paper: the point-spread function is convolved over the sphere (see
//! [`airlight::point_spread`]), and fog may end at a box. In a box the attenuation is exact,
//! while the halo in a direction is that of an eye in the centre of a ball of fog whose depth
//! is that of the box in this direction.
//!
//! # Limits
//!
//! The halo is that of isotropic scattering, whatever the phase function of the fog. Fog
//! between the eye and a surface attenuates. What this fog scatters of the environment into the
//! eye is a separate step, for uniform light ([`Ambient`], [`AddEnvironment::add_ambient`]):
//! nothing casts a shadow into it, and see-through surfaces do not dim what the fog behind them
//! scatters. A surface sees the share of the environment that is its
//! [openness](SurfacePoint::openness), as if what covers its sky covered all directions
//! equally.
//!
//! ```
//! use gpu_backend::{Backend, Cpu, Download};
//! use lighting::Ray;
//! use lighting::environment::{AddEnvironment, Environment, EnvironmentMap};
//! use glam::Vec3;
//!
//! let cpu = Cpu::new();
//! let sky = EnvironmentMap::new(&cpu, &Environment::even([0.2, 0.3, 0.5])?, None)?;
//! let rays = cpu.upload(&[Ray::new(Vec3::ZERO, Vec3::Y, f32::INFINITY).expect("a sound ray")])?;
//! let mut radiance = cpu.zeros::<[f32; 4]>(1)?;
//! cpu.add_sky(&rays, &sky, &mut radiance)?;
//! assert!((cpu.download(&radiance)?[0][2] - 0.5).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ambient;
#[cfg(feature = "wgpu")]
mod gpu;
mod grid;
mod map;
#[cfg(test)]
mod tests;

pub use ambient::Ambient;
pub use map::EnvironmentMap;

use glam::Vec3;
use gpu_backend::{Backend, Cpu, Error, Memory};

use crate::gather::check_lengths;
use crate::{Ray, SurfacePoint};

/// The largest number of texels along each side of an environment.
pub const MAX_SIDE: usize = 16384;

/// Why an environment cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnvironmentError {
    /// The picture has no texels, too many, or not as many as its size says.
    #[error(
        "an environment of {width} x {height} texels was given {texels}, expected 1 to {MAX_SIDE} along each side and width x height in all"
    )]
    Size {
        /// Texels per row.
        width: usize,
        /// Number of rows.
        height: usize,
        /// Texels given.
        texels: usize,
    },
    /// A radiance in the picture is negative, too large or not finite.
    #[error("a texel of the environment is {value}, expected 0 to 1e20 in each channel")]
    Texel {
        /// The value of the channel that is wrong.
        value: f32,
    },
    /// The ambient radiance is negative, too large or not finite.
    #[error("the ambient radiance is {value} in a channel, expected 0 to 1e20")]
    Ambient {
        /// The value of the channel that is wrong.
        value: f32,
    },
    /// The distance is out of range.
    #[error("the distance of the environment is {value} m, expected 0 to 1e9")]
    Distance {
        /// The value that was given.
        value: f32,
    },
    /// Fog without bounds would hide an infinitely distant environment.
    #[error(
        "fog without bounds hides an infinitely distant environment: give the environment a distance, or the fog a box"
    )]
    NoDistance,
    /// A distance was given although the medium already defines the way through the fog.
    #[error(
        "the distance of an environment applies to fog without bounds only, and the scene has no such fog"
    )]
    UnusedDistance,
    /// The fog is too thick for computing its halo.
    #[error(transparent)]
    Halo(#[from] airlight::Error),
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] Error),
}

/// Radiance from all directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
    distance: Option<f32>,
}

impl Environment {
    /// A picture of `height` rows of `width` texels, evenly spaced in latitude and longitude,
    /// in linear RGB radiance. The first row is around +Y; the middle of each row is at −Z, and
    /// +X is to its right.
    ///
    /// # Errors
    /// [`EnvironmentError::Size`] and [`EnvironmentError::Texel`].
    pub fn new(
        width: usize,
        height: usize,
        texels: Vec<[f32; 3]>,
    ) -> Result<Self, EnvironmentError> {
        let sides = 1..=MAX_SIDE;
        let fits = sides.contains(&width) && sides.contains(&height);
        if !fits || width * height != texels.len() {
            return Err(EnvironmentError::Size {
                width,
                height,
                texels: texels.len(),
            });
        }
        let is_sound = |value: &&f32| (0.0..=1e20).contains(*value);
        if let Some(&value) = texels.iter().flatten().find(|value| !is_sound(value)) {
            return Err(EnvironmentError::Texel { value });
        }
        Ok(Self {
            width,
            height,
            texels,
            distance: None,
        })
    }

    /// The same radiance from all directions.
    ///
    /// # Errors
    /// [`EnvironmentError::Texel`].
    pub fn even(radiance: [f32; 3]) -> Result<Self, EnvironmentError> {
        Self::new(1, 1, vec![radiance])
    }

    /// The same environment behind so many metres of fog, for fog without bounds.
    ///
    /// # Errors
    /// [`EnvironmentError::Distance`] unless the distance is from 0 to 1e9 m.
    pub fn at_distance(self, distance: f32) -> Result<Self, EnvironmentError> {
        if !(0.0..=1e9).contains(&distance) {
            return Err(EnvironmentError::Distance { value: distance });
        }
        Ok(Self {
            distance: Some(distance),
            ..self
        })
    }

    /// Texels per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The texels, row by row from the top.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Metres of fog in front of it, in fog without bounds.
    pub fn distance(&self) -> Option<f32> {
        self.distance
    }
}

/// The steps that add the light of an environment to a picture.
pub trait AddEnvironment: Backend {
    /// Adds to the first three components of `radiance` what every ray that meets no surface
    /// sees of the environment. The picture is interpolated between the centres of texels.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length; nothing is written
    /// then.
    fn add_sky(
        &self,
        rays: &<Self::Memory as Memory>::Buffer<Ray>,
        environment: &EnvironmentMap<Self::Memory>,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;

    /// Adds to the first three components of `radiance` the light of the environment that
    /// surfaces reflect: `response · openness · ∫ max(0, n·ω) L_seen(ω) dω`.
    ///
    /// The integral is a sum over 288 patches of the environment, each with its mean radiance.
    /// For a uniform environment it is within 0.5 % of the irradiance. A sun that is smaller
    /// than a patch is spread over 15 degrees.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if points and radiance differ in length; nothing is written
    /// then.
    fn add_environment_light(
        &self,
        points: &<Self::Memory as Memory>::Buffer<SurfacePoint>,
        environment: &EnvironmentMap<Self::Memory>,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;

    /// Adds to the first three components of `radiance` what the fog along every ray scatters
    /// of uniform light from all directions: [`Ambient::seen`].
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length; nothing is written
    /// then.
    fn add_ambient(
        &self,
        rays: &<Self::Memory as Memory>::Buffer<Ray>,
        ambient: &Ambient,
        radiance: &mut <Self::Memory as Memory>::Buffer<[f32; 4]>,
    ) -> Result<(), Error>;
}

/// Pixels in a unit of work.
const CHUNK: usize = 1024;

impl AddEnvironment for Cpu {
    fn add_sky(
        &self,
        rays: &Vec<Ray>,
        environment: &EnvironmentMap<Self::Memory>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        self.for_each_chunk(radiance, CHUNK, |first, chunk: &mut [[f32; 4]]| {
            for (sum, ray) in chunk.iter_mut().zip(&rays[first..]) {
                if ray.length().is_infinite() {
                    add(sum, environment.seen(ray));
                }
            }
        });
        Ok(())
    }

    fn add_environment_light(
        &self,
        points: &Vec<SurfacePoint>,
        environment: &EnvironmentMap<Self::Memory>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(points.len(), radiance.len())?;
        self.for_each_chunk(radiance, CHUNK, |first, chunk: &mut [[f32; 4]]| {
            for (sum, point) in chunk.iter_mut().zip(&points[first..]) {
                if point.reflects() && point.openness() > 0.0 {
                    let irradiance = environment.irradiance(point.position(), point.normal());
                    add(sum, point.response() * point.openness() * irradiance);
                }
            }
        });
        Ok(())
    }

    fn add_ambient(
        &self,
        rays: &Vec<Ray>,
        ambient: &Ambient,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        self.for_each_chunk(radiance, CHUNK, |first, chunk: &mut [[f32; 4]]| {
            for (sum, ray) in chunk.iter_mut().zip(&rays[first..]) {
                add(sum, ambient.seen(ray));
            }
        });
        Ok(())
    }
}

fn add(sum: &mut [f32; 4], light: Vec3) {
    for (sum, light) in sum.iter_mut().zip(light.to_array()) {
        *sum += light;
    }
}
