//! What makes a scene hard for a shadow map, in numbers.

mod figures;
mod topology;

pub use figures::{Figures, MAX_RESOLUTION, ResolutionError, figures};
pub use topology::closed_components;
