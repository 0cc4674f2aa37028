//! What shadows can be asked.

mod batch;
mod depth;
mod extent;
mod filter;
mod point;
mod ray;

pub use extent::Visibility;
pub use filter::FilterSize;
pub use ray::{LitIntervals, Ray};

#[cfg(test)]
pub(crate) use ray::stepping;
