//! Smoke as numbers on a grid.

use glam::{DVec3, Vec3};

use super::check_extinction;
use crate::{Bounds, SceneError};

/// The largest number of samples of a grid: 2²⁸, which is 1 GiB.
pub const MAX_SAMPLES: u64 = 1 << 28;

/// What lies between the samples of a [`DensityGrid`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Each sample fills a voxel: the box is divided into as many as there are
    /// samples.
    Constant,
    /// Trilinear between samples, the outer ones of which are on the faces of
    /// the box. Along an axis with a single sample nothing changes.
    Linear,
}

/// An extinction coefficient that varies over a box; nothing outside.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityGrid {
    bounds: Bounds,
    resolution: [u32; 3],
    density: Vec<f32>,
    scale: f32,
    interpolation: Interpolation,
}

impl DensityGrid {
    /// `resolution` samples of a density along x, y and z of `bounds`, x
    /// fastest. The extinction coefficient is `scale` × density, 1/m.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for a resolution of 0, more than
    /// [`MAX_SAMPLES`], a density or scale outside of 0 to 1e15;
    /// [`SceneError::LengthMismatch`] unless there is one density per sample.
    pub fn new(
        bounds: Bounds,
        resolution: [u32; 3],
        density: Vec<f32>,
        scale: f32,
        interpolation: Interpolation,
    ) -> Result<Self, SceneError> {
        let [x, y, z] = resolution.map(u64::from);
        let count = x.saturating_mul(y).saturating_mul(z);
        if count == 0 || count > MAX_SAMPLES {
            return Err(SceneError::bad_value(
                "density grid",
                "resolution",
                format!("{x} x {y} x {z}"),
                "1 to 2^28 samples",
            ));
        }
        if density.len() as u64 != count {
            return Err(SceneError::LengthMismatch {
                owner: "density grid".into(),
                what: "the list of densities",
                actual: density.len(),
                expected: count as usize,
            });
        }
        check_extinction(|| "density grid".into(), "scale", scale)?;
        for (index, &value) in density.iter().enumerate() {
            check_extinction(|| format!("density grid, sample {index}"), "density", value)?;
        }
        Ok(Self {
            bounds,
            resolution,
            density,
            scale,
            interpolation,
        })
    }

    /// Where it is.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Samples along x, y and z.
    pub fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    /// Densities, x fastest.
    pub fn density(&self) -> &[f32] {
        &self.density
    }

    /// Extinction coefficient of a density of 1, 1/m.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// What lies between samples.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The same grid of another scale.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] unless it is from 0 to 1e15.
    pub fn with_scale(self, scale: f32) -> Result<Self, SceneError> {
        check_extinction(|| "density grid".into(), "scale", scale)?;
        Ok(Self { scale, ..self })
    }

    /// The largest density of any sample.
    pub fn max_density(&self) -> f32 {
        self.density.iter().copied().fold(0.0, f32::max)
    }

    /// Cells along each axis in which the extinction is a polynomial.
    pub fn cells(&self) -> [u32; 3] {
        match self.interpolation {
            Interpolation::Constant => self.resolution,
            Interpolation::Linear => self.resolution.map(|count| (count - 1).max(1)),
        }
    }

    /// The extinction coefficient at `place` of a cell, 1/m: each coordinate of
    /// `place` from 0 to 1 across the cell.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn extinction(&self, cell: [u32; 3], place: DVec3) -> f64 {
        let [nx, ny, _] = self.resolution.map(|count| count as usize);
        let sample = |x: usize, y: usize, z: usize| f64::from(self.density[(z * ny + y) * nx + x]);
        let [x, y, z] = cell.map(|index| index as usize);
        let density = match self.interpolation {
            Interpolation::Constant => sample(x, y, z),
            Interpolation::Linear => {
                // A single sample along an axis is its own neighbour.
                let next =
                    |axis: usize, index: usize| (index + 1).min(self.resolution[axis] as usize - 1);
                let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
                let row =
                    |y: usize, z: usize| mix(sample(x, y, z), sample(next(0, x), y, z), place.x);
                let slice = |z: usize| mix(row(y, z), row(next(1, y), z), place.y);
                mix(slice(z), slice(next(2, z)), place.z)
            }
        };
        f64::from(self.scale) * density
    }

    /// The extinction coefficient at a point, 1/m; 0 outside of the box.
    pub fn extinction_at(&self, point: Vec3) -> f32 {
        let (min, max) = (self.bounds.min().as_dvec3(), self.bounds.max().as_dvec3());
        let share = (point.as_dvec3() - min) / (max - min);
        if !(share.cmpge(DVec3::ZERO).all() && share.cmple(DVec3::ONE).all()) {
            return 0.0;
        }
        let cells = self.cells();
        let place = share * DVec3::from_array(cells.map(f64::from));
        let cell = [0, 1, 2].map(|axis| (place[axis] as u32).min(cells[axis] - 1));
        self.extinction(cell, place - DVec3::from_array(cell.map(f64::from))) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Bounds {
        Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap()
    }

    #[test]
    fn samples_are_where_the_interpolation_puts_them() {
        let density = (0..12).map(|i| i as f32).collect::<Vec<_>>();
        let grid = |interpolation| {
            DensityGrid::new(unit(), [3, 2, 2], density.clone(), 2.0, interpolation).unwrap()
        };
        let voxels = grid(Interpolation::Constant);
        assert_eq!(voxels.extinction_at(Vec3::new(0.4, 0.1, 0.9)), 2.0 * 7.0);
        assert_eq!(voxels.extinction_at(Vec3::ONE), 2.0 * 11.0);
        assert_eq!(voxels.extinction_at(Vec3::new(0.5, 1.01, 0.5)), 0.0);
        let smooth = grid(Interpolation::Linear);
        assert_eq!(smooth.extinction_at(Vec3::ONE), 2.0 * 11.0);
        // Linear numbers are met exactly anywhere.
        let at = Vec3::new(0.25, 0.5, 0.125);
        let expected = 0.25 * 2.0 + 0.5 * 3.0 + 0.125 * 6.0;
        assert!((smooth.extinction_at(at) - 2.0 * expected).abs() < 1e-5);
        assert_eq!(smooth.extinction_at(Vec3::new(0.5, f32::NAN, 0.5)), 0.0);
    }

    #[test]
    fn bad_grids_name_their_cause() {
        let new = |resolution, density, scale| {
            DensityGrid::new(unit(), resolution, density, scale, Interpolation::Linear)
        };
        for (grid, cause) in [
            (new([2, 0, 2], vec![], 1.0), "2 x 0 x 2"),
            (new([u32::MAX; 3], vec![], 1.0), "2^28"),
            (new([1, 1, 2], vec![0.5], 1.0), "1 entries"),
            (new([1, 1, 2], vec![0.5, -1.0], 1.0), "sample 1"),
            (new([1, 1, 1], vec![f32::NAN], 1.0), "NaN"),
            (new([1, 1, 1], vec![1.0], f32::INFINITY), "scale is inf"),
        ] {
            let error = grid.unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }
}
