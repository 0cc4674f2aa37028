//! What shadows can be asked.

mod batch;
mod blocks;
mod depth;
mod extent;
mod filter;
mod point;
mod ray;
mod step;

pub use extent::Visibility;
pub use filter::FilterSize;
pub use ray::{LitIntervals, Ray};
#[cfg(feature = "wgpu")]
pub(crate) use step::places;
pub use step::{Query, RayRecord};

#[cfg(test)]
pub(crate) use ray::stepping;
