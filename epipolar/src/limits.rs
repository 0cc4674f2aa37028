//! How near and how far things may be.

/// Eye and light must be this far apart, metres: products of distances stay
/// normal numbers in f32.
pub const SMALLEST_DISTANCE: f64 = 1e-18;

/// The largest coordinate, metres: squares of distances stay finite in f32.
/// Distances above this count as infinite.
pub const FARTHEST: f32 = 1e18;
