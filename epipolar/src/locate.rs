//! The step that finds the voxels of many points.

use glam::{Vec3, Vec4};
use gpu_backend::{Backend, BufferOf, Cpu, Error};

use crate::Lattice;

/// Points per unit of work.
const CHUNK: usize = 4096;

/// Finds the positions of points in a lattice.
pub trait Locate: Backend {
    /// Writes the positions along (α, θ, φ) of each point (metres; the fourth
    /// components are not used and set to 0).
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] unless there are as many positions as points.
    fn locate(
        &self,
        lattice: &Lattice,
        points: &BufferOf<Self, [f32; 4]>,
        positions: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

impl Locate for Cpu {
    fn locate(
        &self,
        lattice: &Lattice,
        points: &Vec<[f32; 4]>,
        positions: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        check_lengths(points.len(), positions.len())?;
        self.for_each_chunk(positions, CHUNK, |first, chunk| {
            for (position, point) in chunk.iter_mut().zip(&points[first..]) {
                let place = lattice
                    .space()
                    .coordinates(Vec4::from_array(*point).truncate());
                *position = Vec3::new(
                    lattice.alpha_position(place.ray.alpha),
                    lattice.theta_position(place.ray.theta),
                    lattice.phi_position(place.phi),
                )
                .extend(0.0)
                .to_array();
            }
        });
        Ok(())
    }
}

pub(crate) fn check_lengths(points: usize, positions: usize) -> Result<(), Error> {
    if points == positions {
        return Ok(());
    }
    Err(Error::LengthMismatch {
        what: "the positions of points",
        expected: points,
        actual: positions,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, Resolution, Space, Spacing, ViewVolume};

    #[test]
    fn a_batch_is_its_points_one_by_one_and_lengths_are_checked() {
        let space = Space::new(Light::point(Vec3::X).unwrap(), Vec3::ZERO).unwrap();
        let view = ViewVolume::all_around(0.0, 10.0).unwrap();
        let resolution = Resolution::new(8, 8, 32).unwrap();
        let lattice = Lattice::new(space, &view, resolution, Spacing::Angle).unwrap();
        let points: Vec<_> = (0..10_000)
            .map(|i| [0.001 * i as f32, 1.0, -0.5, 9.0])
            .collect();
        let mut one = vec![[7.0; 4]; points.len()];
        let mut many = one.clone();
        Cpu::single_threaded()
            .locate(&lattice, &points, &mut one)
            .unwrap();
        Cpu::new().locate(&lattice, &points, &mut many).unwrap();
        assert_eq!(one, many);
        assert!(one.iter().all(|p| p[3] == 0.0 && p[0] < 8.0 && p[2] < 32.0));
        one.pop();
        let error = Cpu::new().locate(&lattice, &points, &mut one).unwrap_err();
        assert!(matches!(error, Error::LengthMismatch { actual: 9999, .. }));
    }
}
