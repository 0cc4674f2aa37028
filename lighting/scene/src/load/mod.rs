//! Scene files: glTF 2.0 and GLB (feature `gltf`), PLY (`ply`), HAIR (`hair`) and
//! VOL (`vol`).
//!
//! [`scene_from_path`] reads a file and whatever it refers to;
//! `gltf_from_slice`, `ply_from_slice`, `hair_from_slice` and `vol_from_slice` do
//! not touch the file system.
//! Whatever is ignored or assumed is told in [`Loaded::notes`]. A scene that
//! brings no camera or no light keeps none: see
//! [`Scene::complete`](crate::Scene::complete).
//!
//! Files are not trusted. Lengths, offsets and indices are compared with the
//! bytes that are there before anything is allocated, files are limited to
//! [`MAX_FILE_BYTES`] and what is decoded from them to [`MAX_DECODED_BYTES`].
//! Whether positions are finite is left to
//! [`Geometry::new`](crate::Geometry::new).
//!
//! # glTF
//!
//! The default scene is read, or the first if none is named.
//!
//! | in the file | becomes |
//! |---|---|
//! | nodes with meshes | instances; a node that mirrors gets a mesh with turned triangles, so that they stay counter-clockwise seen from outside |
//! | primitives | meshes; triangle lists, strips and fans, indexed or not |
//! | `baseColorFactor`, `baseColorTexture` | the albedo; every texture repeats |
//! | `emissiveFactor` × `KHR_materials_emissive_strength` × `emissiveTexture` | emitted radiance; on surfaces the texture's mean |
//! | a primitive of two triangles that form a rectangle and emit | an area light too, on its front side, with the emissive texture if that is mapped once and upright or turned by right angles |
//! | the first perspective camera | the camera; aspect ratio and clipping planes are the picture's affair |
//! | `KHR_lights_punctual` | lights; candela and lux times the linear colour are taken as they are |
//!
//! A light or camera takes its place and orientation from its node, never its
//! scale. Metalness, roughness, normals, alpha, vertex colours, skins, morph
//! targets and animations have no effect. A texture that cannot be read is
//! left out with a note; geometry that cannot be read is an error, and so is a
//! required extension that is not in the table.
//!
//! The medium comes from the `extras` of the scene, of the document or of its
//! `asset`, whichever is found first:
//!
//! ```json
//! {"medium": {"sigma_s": [0.02, 0.03, 0.05], "sigma_a": 0.001,
//!             "phase": "henyey-greenstein", "g": 0.3,
//!             "box": [[-5, 0, -5], [5, 4, 5]]}}
//! ```
//!
//! `sigma_s` and `sigma_a` are in 1/m, per colour channel or one number for
//! all; one that is missing is 0. `phase` is `isotropic` (also if it is
//! missing), `rayleigh`, `henyey-greenstein` or `cornette-shanks` with a `g`, or
//! `schlick` with a `k`. Without a `box` the medium is everywhere.
//!
//! # PLY
//!
//! ASCII and binary of either byte order. The element `vertex` needs `x`, `y`
//! and `z`, the element `face` a list `vertex_indices` or `vertex_index`; any
//! number types in any order. Polygons become fans around their first corner,
//! which is right for convex ones. Everything else in the file is skipped.
//!
//! # HAIR
//!
//! Cem Yuksel's format, with any combination of its arrays. A point's thickness
//! is the diameter of the strand, its opacity 1 − transparency; colours have no
//! effect. The file's unit is taken as the metre.
//!
//! # VOL
//!
//! Mitsuba's format, version 3: densities as f32, f16 or bytes (of which 255 is
//! 1), in one channel or as the mean of three; trilinear, the outer samples on
//! the faces of the box. A density is an extinction coefficient in 1/m; see
//! [`DensityGrid::with_scale`](crate::DensityGrid::with_scale).

#[cfg(test)]
mod damage;
mod error;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(feature = "hair")]
mod hair;
mod limits;
#[cfg(feature = "ply")]
mod ply;
#[cfg(feature = "vol")]
mod vol;
#[cfg(any(feature = "hair", feature = "vol"))]
mod words;

use std::path::Path;

pub use error::LoadError;
#[cfg(feature = "gltf")]
pub use gltf::gltf_from_slice;
#[cfg(feature = "hair")]
pub use hair::hair_from_slice;
pub use limits::{MAX_DECODED_BYTES, MAX_FILE_BYTES};
#[cfg(feature = "ply")]
pub use ply::ply_from_slice;
#[cfg(feature = "vol")]
pub use vol::vol_from_slice;

use crate::Scene;

/// A scene, and what the user should know about how it was read.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What was ignored or assumed, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a glTF, GLB, PLY, HAIR or VOL file, told apart by their first bytes,
/// and the files that a glTF file refers to, relative to its folder. The scene
/// is named like the file.
///
/// # Errors
/// Any [`LoadError`]. A format whose feature is off is
/// [`LoadError::Unsupported`].
pub fn scene_from_path(path: &Path) -> Result<Loaded, LoadError> {
    let bytes = limits::read_file(path)?;
    let mut loaded = match Format::of(&bytes, path)? {
        Format::Gltf => from_gltf(&bytes, path)?,
        Format::Ply => from_ply(&bytes)?,
        Format::Hair => from_hair(&bytes)?,
        Format::Vol => from_vol(&bytes)?,
    };
    if let Some(stem) = path.file_stem() {
        loaded.scene.name = stem.to_string_lossy().into_owned();
    }
    Ok(loaded)
}

#[cfg(feature = "gltf")]
fn from_gltf(bytes: &[u8], path: &Path) -> Result<Loaded, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    gltf_from_slice(bytes, &mut |uri| limits::read_file(&folder.join(uri)))
}

#[cfg(not(feature = "gltf"))]
fn from_gltf(_: &[u8], _: &Path) -> Result<Loaded, LoadError> {
    Err(LoadError::Unsupported(
        "glTF (feature `gltf` is off in this build)".into(),
    ))
}

#[cfg(feature = "ply")]
fn from_ply(bytes: &[u8]) -> Result<Loaded, LoadError> {
    ply_from_slice(bytes)
}

#[cfg(not(feature = "ply"))]
fn from_ply(_: &[u8]) -> Result<Loaded, LoadError> {
    Err(LoadError::Unsupported(
        "PLY (feature `ply` is off in this build)".into(),
    ))
}

#[cfg(feature = "hair")]
fn from_hair(bytes: &[u8]) -> Result<Loaded, LoadError> {
    hair_from_slice(bytes)
}

#[cfg(not(feature = "hair"))]
fn from_hair(_: &[u8]) -> Result<Loaded, LoadError> {
    Err(LoadError::Unsupported(
        "HAIR (feature `hair` is off in this build)".into(),
    ))
}

#[cfg(feature = "vol")]
fn from_vol(bytes: &[u8]) -> Result<Loaded, LoadError> {
    vol_from_slice(bytes)
}

#[cfg(not(feature = "vol"))]
fn from_vol(_: &[u8]) -> Result<Loaded, LoadError> {
    Err(LoadError::Unsupported(
        "VOL (feature `vol` is off in this build)".into(),
    ))
}

enum Format {
    Gltf,
    Ply,
    Hair,
    Vol,
}

impl Format {
    /// Trusts the contents more than the name, and the name if the contents
    /// are damaged, so that the error speaks of the format that was meant.
    fn of(bytes: &[u8], path: &Path) -> Result<Self, LoadError> {
        if bytes.is_empty() {
            return Err(LoadError::truncated("a scene file", 1, 0));
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if bytes.starts_with(b"glTF") || text.trim_ascii_start().starts_with(b"{") {
            return Ok(Self::Gltf);
        }
        if bytes.starts_with(b"ply") {
            return Ok(Self::Ply);
        }
        if bytes.starts_with(b"HAIR") {
            return Ok(Self::Hair);
        }
        if bytes.starts_with(b"VOL") {
            return Ok(Self::Vol);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("gltf" | "glb") => Ok(Self::Gltf),
            Some("ply") => Ok(Self::Ply),
            Some("hair") => Ok(Self::Hair),
            Some("vol") => Ok(Self::Vol),
            _ => Err(LoadError::Unsupported(
                "a file that is neither glTF, GLB, PLY, HAIR nor VOL".into(),
            )),
        }
    }
}
