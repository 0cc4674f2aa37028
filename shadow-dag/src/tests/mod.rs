//! What must hold of shadows as a whole, against voxels one by one.

mod build;
mod file;
mod light;
mod maps;
mod mesh;
mod queries;
mod rays;
