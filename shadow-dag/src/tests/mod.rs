//! What must hold of shadows as a whole, against voxels one by one.

mod bake;
mod build;
mod file;
mod light;
pub(crate) mod maps;
pub(crate) mod mesh;
mod planes;
mod queries;
mod rays;
mod rebuild;
mod set;

#[cfg(feature = "wgpu")]
pub(crate) use build::Hills;
#[cfg(feature = "wgpu")]
pub(crate) use rays::{ray, spaces as light_spaces};
