//! Shaders put together from parts.
//!
//! A crate that is of use in other people's shaders ships its WGSL as plain
//! text: structures, constants and functions, all with the crate's prefix, and
//! neither entry points nor bindings. A [`Part`] is such text together with the
//! data it reads. Whoever assembles a shader puts a part into a [`Slot`], which
//! is a question that the rest of the shader asks: *which parts of this ray are
//! lit?*, say.
//!
//! The functions of a part have names of its own, those of a slot have names
//! that the rest of the shader knows. A few generated lines of *glue* connect the
//! two, so that two parts that answer the same question can meet in one shader.
//! [`Assembly`] writes the glue, declares the bindings of all parts in one bind
//! group, numbered as they come, and leaves out text that is there already.
//!
//! ```
//! use gpu_backend::shader::{Assembly, Part, Slot};
//!
//! /// How bright is a pixel?
//! struct Brightness;
//!
//! impl Slot for Brightness {
//!     fn glue(part: &str) -> String {
//!         format!("fn brightness(pixel: u32) -> f32 {{ return {part}_brightness(pixel); }}")
//!     }
//! }
//!
//! let stored = Part::new("picture")
//!     .source("fn picture_brightness(pixel: u32) -> f32 { return picture_pixels[pixel]; }")
//!     .read("picture_pixels", "array<f32>");
//! let mut shader = Assembly::new(&["@fragment fn shade() -> @location(0) vec4<f32> {
//!     return vec4(brightness(7u));
//! }"]);
//! shader.fill::<Brightness>(&stored)?;
//! let parts = shader.finish(1);
//! assert!(parts.concat().contains("@group(1) @binding(0) var<storage> picture_pixels: array<f32>;"));
//! # Ok::<(), gpu_backend::Error>(())
//! ```
//!
//! With the feature `wgpu`, a type that shaders can read implements
//! `gpu::InShader` for each slot that it fits: the trait joins the part, which is
//! the same for all values of the type, with the arguments of one value.

mod assembly;
mod part;

pub use assembly::Assembly;
pub use part::{Binding, BindingKind, Part};

/// A question that the rest of a shader asks, and that a part answers.
///
/// Implemented by an empty type for each question; it is only a name.
pub trait Slot {
    /// WGSL that defines what the rest of the shader calls, by calling the
    /// functions of the part with the name `part`.
    fn glue(part: &str) -> String;
}
