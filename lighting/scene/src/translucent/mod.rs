//! Translucent casters: hair and smoke, which let a share of the light through.

mod cell_walk;
mod grid;
mod occupancy;
mod particles;
mod strands;

pub use cell_walk::{CellSpan, CellWalk, OccupiedCells};
pub use grid::{DensityGrid, Interpolation, MAX_SAMPLES};
pub use particles::{Particle, Particles, Profile};
pub use strands::{Piece, StrandPoint, Strands};

use glam::Vec3;

use super::{Bounds, SceneError};

/// Something that takes a share of the light that meets it.
///
/// It casts shadows onto surfaces, into the air and onto itself; see the module `translucent`.
/// [`Media`](crate::Media) tells what smoke scatters and emits itself.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a scene has a few of them, each of which owns far more"
)]
pub enum Translucent {
    /// Hair, fur, grass.
    Strands(Strands),
    /// Smoke on a grid.
    Grid(DensityGrid),
    /// Smoke as balls.
    Particles(Particles),
}

impl Translucent {
    /// A box around all of it, without the empty cells at the sides of a grid; `None` if it is
    /// empty.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Self::Strands(strands) => strands.bounds(),
            Self::Grid(grid) => Some(grid.occupied_bounds()),
            Self::Particles(particles) => particles.bounds(),
        }
    }

    /// A description with its size, for reports.
    pub fn describe(&self) -> String {
        match self {
            Self::Strands(strands) => format!("{} strands", strands.len()),
            Self::Grid(grid) => {
                let [x, y, z] = grid.resolution();
                format!("a density grid of {x} x {y} x {z}")
            }
            Self::Particles(particles) => format!("{} particles", particles.all().len()),
        }
    }
}

impl From<Strands> for Translucent {
    fn from(strands: Strands) -> Self {
        Self::Strands(strands)
    }
}

impl From<DensityGrid> for Translucent {
    fn from(grid: DensityGrid) -> Self {
        Self::Grid(grid)
    }
}

impl From<Particles> for Translucent {
    fn from(particles: Particles) -> Self {
        Self::Particles(particles)
    }
}

/// A box around balls of these centres and radii, `None` around none; never
/// flat.
fn around(balls: impl Iterator<Item = (Vec3, f32)>) -> Option<Bounds> {
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (centre, radius) in balls {
        min = min.min(centre - radius);
        max = max.max(centre + radius);
    }
    let margin = (1e-6 * (max - min).max(min.abs()).max(max.abs()).max_element()).max(1e-6);
    Bounds::new(min - margin, max + margin).ok()
}

/// Checks a coordinate, and leaves room for radii.
fn check_position(owner: impl FnOnce() -> String, position: Vec3) -> Result<(), SceneError> {
    if position.abs().cmple(Vec3::splat(MAX_POSITION)).all() {
        return Ok(());
    }
    Err(SceneError::bad_value(
        owner(),
        "position",
        position,
        "coordinates within 5e8 m",
    ))
}

/// Half of the largest coordinate of a scene, so that balls stay within it.
const MAX_POSITION: f32 = 5e8;

/// A thickness or a radius.
fn check_size(
    owner: impl FnOnce() -> String,
    what: &'static str,
    value: f32,
) -> Result<(), SceneError> {
    if (0.0..=1e8).contains(&value) {
        return Ok(());
    }
    Err(SceneError::bad_value(
        owner(),
        what,
        value,
        "a length from 0 to 1e8 m",
    ))
}

/// An extinction coefficient.
fn check_extinction(
    owner: impl FnOnce() -> String,
    what: &'static str,
    value: f32,
) -> Result<(), SceneError> {
    if (0.0..=1e15).contains(&value) {
        return Ok(());
    }
    Err(SceneError::bad_value(
        owner(),
        what,
        value,
        "a number from 0 to 1e15",
    ))
}

/// Linear RGB of a limited range.
fn check_colour(
    owner: impl FnOnce() -> String,
    what: &'static str,
    colour: Vec3,
    most: f32,
    expected: &'static str,
) -> Result<(), SceneError> {
    let is_within = |channel: &f32| (0.0..=most).contains(channel);
    if colour.to_array().iter().all(is_within) {
        return Ok(());
    }
    Err(SceneError::bad_value(owner(), what, colour, expected))
}
