//! The light that froxels scatter, and the steps that turn it into a picture.

use glam::Vec3;
use gpu_backend::{Backend, Buffer, BufferOf, Cpu, Error, Memory};

use super::{FroxelGrid, Jitter};
use crate::airlight::mean_exponential;
use crate::gather::check_lengths;
use crate::scene::{DirectionalEmitter, Medium, PointEmitter, ScatteringAngle};
use crate::visibility::{PointVisibility, Share};
use crate::{Emitter, Interval, LightPath, Ray};

/// The smallest squared distance to a light, m², which keeps the light of a froxel finite.
const LEAST_SQUARE: f32 = 1e-24;

/// The light that the froxels of a view scatter to the eye. The first three channels of a
/// froxel are the radiance from one metre of the ray through it, before the extinction between
/// froxel and eye. The fourth is the number of frames whose mean it is.
#[derive(Debug)]
pub struct FroxelVolume<M: Memory> {
    pub(super) grid: FroxelGrid,
    pub(super) jitter: Jitter,
    /// The froxels, column after column, each from the eye on.
    pub(super) scattered: M::Buffer<[f32; 4]>,
    /// Number of lights in it. While it is 0, the buffer may hold anything.
    pub(super) lights: usize,
}

impl<M: Memory> FroxelVolume<M> {
    /// Dark froxels. Light will be sampled at the place `jitter` of each.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    pub fn new<B>(backend: &B, grid: FroxelGrid, jitter: Jitter) -> Result<Self, Error>
    where
        B: Backend<Memory = M>,
    {
        Ok(Self {
            grid,
            jitter,
            scattered: backend.zeros(grid.froxels())?,
            lights: 0,
        })
    }

    /// The same as [`FroxelVolume::new`], in the memory of this volume if it has the same size.
    ///
    /// # Errors
    /// As [`FroxelVolume::new`].
    pub fn again<B>(self, backend: &B, grid: FroxelGrid, jitter: Jitter) -> Result<Self, Error>
    where
        B: Backend<Memory = M>,
    {
        if self.scattered.len() != grid.froxels() {
            return Self::new(backend, grid, jitter);
        }
        Ok(Self {
            grid,
            jitter,
            scattered: self.scattered,
            lights: 0,
        })
    }

    /// The grid of the froxels.
    pub fn grid(&self) -> &FroxelGrid {
        &self.grid
    }

    /// The scattered light, column after column (rows from the top), each from the eye on.
    /// Undefined if no light has been injected yet.
    pub fn scattered(&self) -> &M::Buffer<[f32; 4]> {
        &self.scattered
    }

    /// Makes the froxels dark if there is no light in them yet.
    pub(super) fn settle<B>(&mut self, backend: &B) -> Result<(), Error>
    where
        B: Backend<Memory = M>,
    {
        if self.lights == 0 {
            self.scattered = backend.zeros(self.grid.froxels())?;
        }
        Ok(())
    }
}

/// The airlight between the eye and the end of each froxel.
#[derive(Debug)]
pub struct FroxelAirlight<M: Memory> {
    pub(super) grid: FroxelGrid,
    pub(super) radiance: M::Buffer<[f32; 4]>,
}

impl<M: Memory> FroxelAirlight<M> {
    /// Memory for froxels of this grid, which are dark at first.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit into memory.
    pub fn new<B>(backend: &B, grid: FroxelGrid) -> Result<Self, Error>
    where
        B: Backend<Memory = M>,
    {
        Ok(Self {
            grid,
            radiance: backend.zeros(grid.froxels())?,
        })
    }

    /// The grid of the froxels.
    pub fn grid(&self) -> &FroxelGrid {
        &self.grid
    }

    /// The radiance, in the first three channels and in the order of
    /// [`FroxelVolume::scattered`].
    pub fn radiance(&self) -> &M::Buffer<[f32; 4]> {
        &self.radiance
    }

    /// Uses the memory for another grid, if there is enough for its froxels.
    pub(super) fn fit<B>(&mut self, backend: &B, grid: FroxelGrid) -> Result<(), Error>
    where
        B: Backend<Memory = M>,
    {
        if self.radiance.len() != grid.froxels() {
            self.radiance = backend.zeros(grid.froxels())?;
        }
        self.grid = grid;
        Ok(())
    }
}

/// A light that is injected into froxels.
#[derive(Debug, Clone, Copy)]
pub struct FroxelLight<'a> {
    /// The light.
    pub emitter: &'a Emitter,
    /// The medium that scatters it.
    pub medium: &'a Medium,
    /// Whether the medium dims the light on its way to the froxels. Engines leave that out.
    pub extinction: bool,
}

/// The step that injects a light into froxels. It asks `P` which share of the light reaches
/// each.
///
/// It is implemented on the CPU for every source of visibility at points, and on GPUs for those
/// that bring a shader part.
pub trait InjectFroxels<P>: Backend {
    /// Adds to each froxel the light that it scatters,
    ///
    /// ```text
    /// σ_s p(cos θ) V I T(d) / max(d², w Δ / 8)        T(d) = exp(−σ_t d), or 1
    /// ```
    ///
    /// sampled at one point. For a sun, the irradiance takes the place of the intensity over
    /// the square. w and Δ are the width and the length of the froxel.
    ///
    /// # Errors
    /// Those of the backend.
    fn inject(
        &self,
        light: &FroxelLight<'_>,
        points: &P,
        volume: &mut FroxelVolume<Self::Memory>,
    ) -> Result<(), Error>;
}

/// The steps from the scattered light of froxels to a picture.
pub trait FroxelSteps: Backend {
    /// Blends each froxel of `now` with the value of `before` at the same place of the world,
    /// by trilinear interpolation: `s ← s + (s_before − s) min(share, n/(n+1))`, where `before`
    /// is the mean of n frames there. A froxel whose place was not in view before stays as it
    /// is.
    ///
    /// # Errors
    /// Those of the backend.
    fn blend(
        &self,
        before: &FroxelVolume<Self::Memory>,
        share: f32,
        now: &mut FroxelVolume<Self::Memory>,
    ) -> Result<(), Error>;

    /// Integrates along each column of froxels from the eye on; see the [module](super).
    ///
    /// # Errors
    /// Those of the backend.
    fn integrate(
        &self,
        medium: &Medium,
        volume: &mut FroxelVolume<Self::Memory>,
        airlight: &mut FroxelAirlight<Self::Memory>,
    ) -> Result<(), Error>;

    /// Adds to the first three components of `radiance[i]` the airlight at the end of ray i,
    /// interpolated within its slice and between the four nearest columns. Rays must start at
    /// the eye. Those that run beside the picture get the light at its border, and those behind
    /// the camera nothing.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if rays and radiance differ in length; nothing is written
    /// then.
    fn look_up(
        &self,
        airlight: &FroxelAirlight<Self::Memory>,
        rays: &BufferOf<Self, Ray>,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

/// The point at which a froxel is sampled.
struct Sample {
    point: Vec3,
    /// Smaller squared distances to a light count as this.
    least_square: f32,
}

impl<P: PointVisibility> InjectFroxels<P> for Cpu {
    fn inject(
        &self,
        light: &FroxelLight<'_>,
        points: &P,
        volume: &mut FroxelVolume<Self::Memory>,
    ) -> Result<(), Error> {
        let (grid, Jitter([across, down, along])) = (volume.grid, volume.jitter);
        let borders = grid.borders();
        let is_first = volume.lights == 0;
        let slices = grid.slices as usize;
        self.for_each_chunk(&mut volume.scattered, slices, |first, column| {
            if is_first {
                column.fill([0.0, 0.0, 0.0, 1.0]);
            }
            let number = first / slices;
            let (direction, inside) = grid.column(number, [across, down], light.medium);
            let Some(inside) = inside else { return };
            // Samples outside of the range and the cone of the light need no lookup.
            let Some(lit) = Ray::new(grid.eye, direction, grid.far)
                .and_then(|ray| LightPath::new(&ray, light.emitter, light.medium))
                .map(|path| path.span())
            else {
                return;
            };
            let start = (grid.slice(lit.start) as usize).saturating_sub(1);
            for (slice, froxel) in column.iter_mut().enumerate().skip(start) {
                let part = slice_inside(&borders, slice, inside);
                if part.start >= lit.end {
                    break;
                }
                if !(part.start < part.end) {
                    continue;
                }
                let length = part.end - part.start;
                let x = part.start + along * length;
                let sample = Sample {
                    point: grid.eye + x * direction,
                    least_square: (x * grid.tile * length / 8.0).max(LEAST_SQUARE),
                };
                let Some(light) = scattered(light, points, direction, &sample) else {
                    continue;
                };
                for channel in 0..3 {
                    froxel[channel] = (froxel[channel] + light[channel]).min(f32::MAX);
                }
            }
        });
        volume.lights += 1;
        Ok(())
    }
}

/// The part of a slice that is in the medium; it may be empty.
fn slice_inside(borders: &[f32], slice: usize, inside: Interval) -> Interval {
    let start = borders[slice].max(inside.start);
    Interval::new(start, borders[slice + 1].min(inside.end))
}

/// The light of an emitter that a metre of a ray scatters at a sample; `None` if there is none.
fn scattered<P: PointVisibility>(
    light: &FroxelLight<'_>,
    points: &P,
    direction: Vec3,
    sample: &Sample,
) -> Option<Vec3> {
    match light.emitter {
        Emitter::Point(point) => of_point(light, point, points, direction, sample),
        Emitter::Directional(sun) => of_sun(light, sun, points, direction, sample),
    }
}

fn of_point<P: PointVisibility>(
    light: &FroxelLight<'_>,
    point: &PointEmitter,
    points: &P,
    direction: Vec3,
    sample: &Sample,
) -> Option<Vec3> {
    let medium = light.medium;
    let offset = sample.point - point.position();
    let square = offset.length_squared();
    let d = square.sqrt();
    if !(d <= point.range()) {
        return None;
    }
    let along = if d > 0.0 { offset / d } else { direction };
    let factor = point.window(d) * point.emission().factor(along);
    if factor.max_element() <= 0.0 {
        return None;
    }
    let visibility = points.visibility(sample.point);
    if visibility.is_dark() {
        return None;
    }
    let leg = match light.extinction {
        true => medium.length_inside(sample.point, -along, d),
        false => 0.0,
    };
    let phase = phase(medium, direction, along);
    // Factors that may be 0 come first, so that large factors cannot overflow to 0 · ∞.
    let arriving = visibility * (factor * transmittance(medium, leg) * medium.sigma_s());
    Some(arriving * (phase * point.intensity()) * (1.0 / square.max(sample.least_square)))
}

fn of_sun<P: PointVisibility>(
    light: &FroxelLight<'_>,
    sun: &DirectionalEmitter,
    points: &P,
    direction: Vec3,
    sample: &Sample,
) -> Option<Vec3> {
    let medium = light.medium;
    let visibility = points.visibility(sample.point);
    if visibility.is_dark() {
        return None;
    }
    let leg = match medium.bounds() {
        Some(bounds) if light.extinction => {
            // Rounding may put a position on a face outside of the box.
            let point = sample.point.clamp(bounds.min(), bounds.max());
            medium.length_inside(point, -sun.direction(), f32::INFINITY)
        }
        _ => 0.0,
    };
    let phase = phase(medium, direction, sun.direction());
    let arriving = visibility * (transmittance(medium, leg) * medium.sigma_s());
    Some(arriving * (phase * sun.irradiance()))
}

/// The phase function between light that travels along `travel` and the way back along an eye
/// ray.
fn phase(medium: &Medium, direction: Vec3, travel: Vec3) -> f32 {
    let cos = (-direction.dot(travel)).clamp(-1.0, 1.0);
    medium.phase().value(ScatteringAngle::from_cos(cos))
}

fn transmittance(medium: &Medium, length: f32) -> Vec3 {
    let sigma_t = medium.sigma_t();
    // Grey media are common, and exponentials are most of the work.
    if sigma_t == Vec3::splat(sigma_t.x) {
        Vec3::splat((-sigma_t.x * length).exp())
    } else {
        (-sigma_t * length).exp()
    }
}

impl FroxelSteps for Cpu {
    fn blend(
        &self,
        before: &FroxelVolume<Self::Memory>,
        share: f32,
        now: &mut FroxelVolume<Self::Memory>,
    ) -> Result<(), Error> {
        now.settle(self)?;
        let (grid, is_same) = (now.grid, now.grid == before.grid);
        let slices = grid.slices as usize;
        self.for_each_chunk(&mut now.scattered, slices, |first, column| {
            let number = first / slices;
            let columns = grid.columns as usize;
            let tile = [(number % columns) as f32, (number / columns) as f32];
            let direction = grid.direction(tile.map(|i| i + 0.5));
            for (slice, froxel) in column.iter_mut().enumerate() {
                let earlier = match is_same {
                    true => Some(before.scattered[first + slice]),
                    false => at(
                        before,
                        grid.eye + grid.depth(slice as f32 + 0.5) * direction,
                    ),
                };
                let Some(earlier) = earlier else {
                    continue;
                };
                let of_earlier = share.min(earlier[3] / (earlier[3] + 1.0));
                for channel in 0..3 {
                    froxel[channel] += (earlier[channel] - froxel[channel]) * of_earlier;
                }
                froxel[3] = 1.0 / (1.0 - of_earlier);
            }
        });
        // All lights injected before count as one.
        now.lights += 1;
        Ok(())
    }

    fn integrate(
        &self,
        medium: &Medium,
        volume: &mut FroxelVolume<Self::Memory>,
        airlight: &mut FroxelAirlight<Self::Memory>,
    ) -> Result<(), Error> {
        volume.settle(self)?;
        airlight.fit(self, volume.grid)?;
        let grid = volume.grid;
        let borders = grid.borders();
        let slices = grid.slices as usize;
        let sigma_t = medium.sigma_t();
        self.for_each_chunk(&mut airlight.radiance, slices, |first, column| {
            let (_, inside) = grid.column(first / slices, [0.5; 2], medium);
            let Some(inside) = inside else {
                column.fill([0.0; 4]);
                return;
            };
            let mut sum = Vec3::ZERO;
            for (slice, (up_to, froxel)) in
                (column.iter_mut().zip(&volume.scattered[first..])).enumerate()
            {
                let part = slice_inside(&borders, slice, inside);
                if part.start < part.end {
                    let length = part.end - part.start;
                    let mean = match sigma_t == Vec3::splat(sigma_t.x) {
                        true => Vec3::splat(mean_exponential(sigma_t.x * length)),
                        false => (sigma_t * length).map(mean_exponential),
                    };
                    let before = transmittance(medium, part.start - inside.start);
                    let scattered = Vec3::new(froxel[0], froxel[1], froxel[2]);
                    sum += scattered * (before * mean * length);
                    sum = sum.min(Vec3::splat(f32::MAX));
                }
                *up_to = sum.extend(0.0).into();
            }
        });
        Ok(())
    }

    fn look_up(
        &self,
        airlight: &FroxelAirlight<Self::Memory>,
        rays: &Vec<Ray>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(rays.len(), radiance.len())?;
        self.for_each_chunk(radiance, 64, |first, chunk| {
            for (sum, ray) in chunk.iter_mut().zip(&rays[first..]) {
                let light = end_of_ray(airlight, ray);
                for channel in 0..3 {
                    sum[channel] += light[channel];
                }
            }
        });
        Ok(())
    }
}

/// For centres at whole numbers plus ½: the two neighbours of a position among `count` of them,
/// and the share of the second.
fn neighbours(position: f32, count: u32) -> ([usize; 2], f32) {
    let last = (count - 1) as f32;
    let from_first = (position - 0.5).clamp(0.0, last);
    let low = from_first.floor();
    let high = (low + 1.0).min(last);
    ([low as usize, high as usize], from_first - low)
}

fn end_of_ray(airlight: &FroxelAirlight<gpu_backend::Host>, ray: &Ray) -> Vec3 {
    let grid = &airlight.grid;
    let Some([a, b]) = grid.place(ray.direction()) else {
        return Vec3::ZERO;
    };
    if !(ray.length() > grid.near) {
        return Vec3::ZERO;
    }
    let u = grid.slice(ray.length().min(grid.far));
    let slice = (u as usize).min(grid.slices as usize - 1);
    let share = u - slice as f32;
    let at = |column: usize, row: usize| {
        let first = (row * grid.columns as usize + column) * grid.slices as usize + slice;
        let value = |index: usize| Vec3::from_slice(&airlight.radiance[index]);
        let before = match slice {
            0 => Vec3::ZERO,
            _ => value(first - 1),
        };
        before + (value(first) - before) * share
    };
    bilinear(grid, [a, b], at)
}

/// Interpolates between the centres of four tiles.
fn bilinear(grid: &FroxelGrid, [a, b]: [f32; 2], at: impl Fn(usize, usize) -> Vec3) -> Vec3 {
    let ([left, right], x) = neighbours(a, grid.columns);
    let ([top, bottom], y) = neighbours(b, grid.rows);
    let upper = at(left, top) + (at(right, top) - at(left, top)) * x;
    let lower = at(left, bottom) + (at(right, bottom) - at(left, bottom)) * x;
    upper + (lower - upper) * y
}

/// The value of a volume at a point of the world; `None` if none of its froxels is there.
fn at(volume: &FroxelVolume<gpu_backend::Host>, point: Vec3) -> Option<[f32; 4]> {
    let grid = &volume.grid;
    let offset = point - grid.eye;
    let [a, b] = grid.place(offset)?;
    let x = offset.length();
    let is_seen = (0.0..=grid.columns as f32).contains(&a)
        && (0.0..=grid.rows as f32).contains(&b)
        && (grid.near..=grid.far).contains(&x);
    if !is_seen {
        return None;
    }
    let ([left, right], s) = neighbours(a, grid.columns);
    let ([top, bottom], t) = neighbours(b, grid.rows);
    let ([near, far], u) = neighbours(grid.slice(x), grid.slices);
    let at = |column: usize, row: usize, slice: usize| {
        let column = row * grid.columns as usize + column;
        glam::Vec4::from(volume.scattered[column * grid.slices as usize + slice])
    };
    let along = |column, row| {
        let first = at(column, row, near);
        first + (at(column, row, far) - first) * u
    };
    let upper = along(left, top) + (along(right, top) - along(left, top)) * s;
    let lower = along(left, bottom) + (along(right, bottom) - along(left, bottom)) * s;
    Some((upper + (lower - upper) * t).into())
}
