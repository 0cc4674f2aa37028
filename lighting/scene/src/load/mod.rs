//! Scene files: glTF 2.0 and GLB (feature `gltf`), PLY (`ply`), OBJ (`obj`), HAIR
//! (`hair`), VOL (`vol`), NanoVDB (`nvdb`) and OpenVDB (`vdb`).
//!
//! [`scene_from_path`] reads a file and whatever it refers to;
//! `gltf_from_slice`, `ply_from_slice`, `obj_from_slice`, `hair_from_slice`,
//! `vol_from_slice`, `nvdb_from_slice` and `vdb_from_slice` do not touch the file system.
//! Whatever is ignored or assumed is told in [`Loaded::notes`]. A scene that
//! brings no camera or no light keeps none: see
//! [`Scene::complete`](crate::Scene::complete).
//!
//! Files are not trusted. Lengths, offsets and indices are compared with the
//! bytes that are there before anything is allocated, files are limited to
//! [`MAX_FILE_BYTES`] and what is decoded from them to [`MAX_DECODED_BYTES`].
//! Files that a file refers to have to lie in its folder or below
//! [`LoadOptions::assets`], symbolic links followed. No error message repeats
//! text of a file that is not a name or a number in it.
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
//! | `EXT_mesh_gpu_instancing` | an instance each |
//! | `KHR_node_visibility` | nodes that are not visible, and all below them, are left out with their lights; cameras stay |
//! | primitives | meshes; triangle lists, strips and fans, indexed or not |
//! | sparse accessors, `KHR_mesh_quantization`, `EXT_meshopt_compression`, `KHR_meshopt_compression`, `KHR_draco_mesh_compression` | what they stand for |
//! | morph targets | positions, at the default weights |
//! | skins | the pose of the nodes as they are in the file |
//! | `COLOR_0` | vertex colours |
//! | `baseColorFactor`, `baseColorTexture` with sampler and `KHR_texture_transform` | albedo and opacity; white without a material |
//! | `alphaMode`, `alphaCutoff`, `doubleSided` | the same in [`Material`](crate::Material) |
//! | `KHR_materials_transmission` | the transmission; its texture is ignored |
//! | `emissiveFactor` × `KHR_materials_emissive_strength` × `emissiveTexture` | emitted radiance; on surfaces the texture's mean |
//! | a primitive of two triangles that form a rectangle and emit | an area light too, on its front side (on both if it is double-sided), with the emissive texture if that is mapped once and upright or turned by right angles |
//! | the first perspective camera | the camera; aspect ratio and clipping planes are the picture's affair |
//! | an orthographic camera, if there is no other | a perspective one of 30° that looks the same way, and whose frame has the same height in the middle of the scene: rays of one picture start at one eye |
//! | `KHR_lights_punctual` | lights; candela and lux times the linear colour are taken as they are; a `range` of 0 is no limit, towards any other the light fades smoothly |
//! | `EXT_lights_area` | area lights, rectangles and disks |
//!
//! A light or camera takes its place and orientation from its node, never its
//! scale; an area light takes the largest component of the scale. Lights have
//! the name of the light, or of the node if it has none. Metalness, roughness,
//! normals and animations have no effect. A texture that cannot be read is
//! left out with a note; geometry that cannot be read is an error.
//!
//! An extension that is not in the table is left out with a note if it is known
//! to concern only what surfaces look like. If the file requires it, or if it
//! may carry or remove geometry, it is an error unless
//! [`LoadOptions::lenient`].
//!
//! ## Extras
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
//! missing), `rayleigh`, `henyey-greenstein` or `cornette-shanks` with a `g`,
//! `schlick` with a `k`, `double-henyey-greenstein` with two numbers `g` and the
//! `weight` of the first, or `droplets` of fog with a `diameter` in micrometres, 5 to
//! 50. Without a `box` the medium is everywhere.
//!
//! `{"heightFog": {"sigma_s": 0.02, "scaleHeight": 30}}` there is fog that thins out with
//! altitude besides: coefficients and phase function as those of the medium, at the
//! `altitude` (0 if it is missing) in metres, and [thinner](crate::HeightFog) by a factor
//! of e every `scaleHeight` metres above it.
//!
//! `{"smoke": {"uri": "plume.vdb"}}` in the extras of a node puts the grid of a VOL, NanoVDB
//! or OpenVDB file there, turned and scaled like the node; its extinction and its emission
//! stay what they are per metre. An `albedo`, one number or three, and a `phase` with its
//! parameters are those of the grid.
//!
//! Colours of smoke may be in VOL files of their own, with as many samples as the densities
//! ([`SmokeColours`]; a NanoVDB or OpenVDB file has one sample more on each side than the
//! box of its voxels, two more along each axis): `"albedo": {"uri": "albedo.vol"}` has an albedo for each sample,
//! `"emission": {"uri": "fire.vol", "scale": [5, 2, 1]}` the radiance that comes from a metre
//! of it, times `scale`, one number or three (1 if it is missing). Without a `uri` the scale
//! is a factor on the emission in the file of densities.
//!
//! `{"castsShadow": false}` in the extras of a node (for it and all below it),
//! of a mesh or of a material makes [instances](crate::Instance::no_shadow) that
//! light passes through.
//!
//! `{"dynamic": true}` in the extras of a node, for it and all below it that does not say
//! otherwise, makes [instances](crate::Instance::dynamic) that may move from one frame to
//! the next.
//!
//! `{"cookie": {"image": 2, "rotation": 0.5}}` in the extras of a spotlight, or
//! of its node, puts image 2 of the document in front of it (see
//! [`SpotLight::texture`](crate::SpotLight::texture)), turned counter-clockwise
//! by `rotation` radians (0 if it is missing) as the light looks.
//!
//! `{"angularDiameter": 0.0093}` in the extras of a directional light, or of its
//! node, is [the angle](crate::DirectionalLight::angular_diameter) in radians
//! that it spans in the sky.
//!
//! `{"falloff": "hard"}` in the extras of a light with a `range`, or of its node,
//! lights all within the range undiminished; `"smooth"`, which is meant if it is
//! missing, [fades](crate::Falloff::Smooth) towards it.
//!
//! # PLY
//!
//! ASCII and binary of either byte order, with any of the three line ends. The
//! element `vertex` needs `x`, `y` and `z`; the element `face` a list
//! `vertex_indices` or `vertex_index`, or else the element `tristrips` such a
//! list in which −1 begins a new strip; any number types in any order. Polygons
//! that are convex seen along their normal become fans around their first
//! corner, all others are cut into triangles at their ears. Everything else in
//! the file is skipped.
//!
//! # OBJ
//!
//! Wavefront's format with its materials: `Kd`, `map_Kd`, `Ke`, `d` or `Tr` (as
//! [`AlphaMode::Blend`](crate::AlphaMode::Blend)); each object, group and
//! material becomes a mesh. Polygons are treated like those of PLY.
//!
//! # Far from the origin
//!
//! Coordinates of PLY and OBJ, and the transforms of glTF's nodes, are read in
//! double precision. If single precision would move a vertex (glTF: if a mesh
//! stands farther out than 65,536 m), and they are farther out than 16 times
//! their extent, the scene is moved to the origin with its camera, its lights and
//! its medium; [`Loaded::offset`] is by how much.
//!
//! # HAIR
//!
//! Cem Yuksel's format, with any combination of its arrays. A point's thickness
//! is the diameter of the strand, its opacity 1 − transparency. Colours, those of the
//! points or that of the header, are taken as linear RGB from 0 to 1.
//!
//! # VOL
//!
//! Mitsuba's format, version 3: densities as f32, f16 or bytes (of which 255 is
//! 1), in one channel or as the mean of three; trilinear, the outer samples on
//! the faces of the box. A density is an extinction coefficient per unit of
//! length of the file; see
//! [`DensityGrid::with_scale`](crate::DensityGrid::with_scale). The ratio of three
//! channels, taken over all of the grid, becomes its
//! [tint](crate::DensityGrid::tint). Files of colours that go with one of densities,
//! an albedo or an emission, are read by `vol_colours_from_slice` and put to it by
//! [`SmokeColours`].
//!
//! # NanoVDB and OpenVDB
//!
//! Fog volumes of the type `float`: the grid called `density`, or else the first that is
//! not called like an emission. Between voxels the density is trilinear, and it falls to 0
//! over one voxel around the box of those that are there (OpenVDB: that are active); the
//! grid is dense here, however sparse the file is. The file's transform becomes that of the
//! grid. A density is an extinction coefficient per unit of length of the file, as for VOL.
//!
//! A second grid called `emission`, or else `flames` or `flame`, is the
//! [emission](crate::DensityGrid::with_emission): radiance per unit of length of the file,
//! the same in all colour channels. It needs the transform of the densities, and is left
//! out with a note if it has another. A file of emission alone is a grid of density 0.
//!
//! Of NanoVDB, files of the major version 32 are read whose values are not quantised, as
//! they are in memory or compressed by ZIP. Of OpenVDB, files of the versions 222 to 224
//! (OpenVDB 2.3 and later) with places of their grids, values saved in full or as half
//! floats, not compressed or by ZIP or Blosc (LZ4, as OpenVDB writes it, or ZLIB), with all
//! inactive values or without; transforms of any affine kind. Level sets, points and
//! frusta are not read.

#[cfg(test)]
mod damage;
mod error;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(feature = "hair")]
mod hair;
#[cfg(any(feature = "gltf", feature = "obj"))]
mod image;
mod limits;
#[cfg(feature = "nvdb")]
mod nvdb;
#[cfg(feature = "obj")]
mod obj;
mod options;
#[cfg(any(feature = "ply", feature = "obj"))]
mod place;
#[cfg(feature = "ply")]
mod ply;
#[cfg(any(feature = "ply", feature = "obj"))]
mod polygon;
mod smoke;
#[cfg(feature = "vdb")]
mod vdb;
#[cfg(feature = "vol")]
mod vol;
#[cfg(any(feature = "nvdb", feature = "vdb"))]
mod voxels;
#[cfg(any(feature = "hair", feature = "vol", feature = "nvdb", feature = "vdb"))]
mod words;
#[cfg(any(feature = "nvdb", feature = "vdb"))]
mod zip;

use std::path::Path;

pub use error::{LoadError, printable};
#[cfg(feature = "gltf")]
pub use gltf::gltf_from_slice;
#[cfg(feature = "hair")]
pub use hair::hair_from_slice;
pub use limits::{MAX_DECODED_BYTES, MAX_FILE_BYTES, read_regular};
#[cfg(feature = "nvdb")]
pub use nvdb::nvdb_from_slice;
#[cfg(feature = "obj")]
pub use obj::obj_from_slice;
pub use options::{LoadOptions, UpAxis};
#[cfg(feature = "ply")]
pub use ply::ply_from_slice;
pub use smoke::SmokeColours;
#[cfg(feature = "vdb")]
pub use vdb::vdb_from_slice;
#[cfg(feature = "vol")]
pub use vol::{VolColours, vol_colours_from_slice, vol_from_slice};

use glam::DVec3;

use self::limits::Folder;
use crate::Scene;

/// Returns the contents of a file that a scene file refers to, given its path
/// relative to it, which has been decoded but not checked.
pub type OpenFile<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, LoadError>;

/// A scene, and what the user should know about how it was read.
#[derive(Debug, Clone, Default)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What was ignored or assumed, a sentence each.
    pub notes: Vec<String>,
    /// By how much the scene was moved to the origin, m: a point of the scene
    /// is where it was in the file, in metres and with +Y up, less this.
    pub offset: DVec3,
}

/// Reads a glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB file, told apart by their first
/// bytes, and the files that it refers to, relative to its folder. OBJ files,
/// which begin with anything, are told by their name. The scene is named like
/// the file.
///
/// # Errors
/// Any [`LoadError`]. A format whose feature is off is
/// [`LoadError::Unsupported`].
pub fn scene_from_path(path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    smoke_from_path(path, options).map(|(loaded, _)| loaded)
}

/// [`scene_from_path`] of a file of smoke, with the axis that points up in files of its
/// colours, as [`SmokeColours::apply`] takes it: [`LoadOptions::up`] for VOL, whose samples
/// are put into the order of the scene's axes; [`UpAxis::Y`] for NanoVDB and OpenVDB, whose
/// samples stay in the order of the file, and whose transform is turned.
///
/// # Errors
/// Those of [`scene_from_path`].
pub fn smoke_from_path(path: &Path, options: &LoadOptions) -> Result<(Loaded, UpAxis), LoadError> {
    options.check()?;
    let bytes = limits::read_file(path)?;
    let folder = Folder::of(path, options.assets.as_deref());
    let open = &mut |uri: &str| folder.read(uri);
    let format = Format::of(&bytes, path)?;
    let samples_up = match format {
        Format::Vol => options.up,
        _ => UpAxis::Y,
    };
    let mut loaded = match format {
        Format::Gltf => from_gltf(&bytes, options, open)?,
        Format::Ply => from_ply(&bytes, options)?,
        Format::Obj => from_obj(&bytes, options, open)?,
        Format::Hair => from_hair(&bytes, options)?,
        Format::Vol => from_vol(&bytes, options)?,
        Format::Nvdb => from_nvdb(&bytes, options)?,
        Format::Vdb => from_vdb(&bytes, options)?,
    };
    if let Some(stem) = path.file_stem() {
        loaded.scene.name = stem.to_string_lossy().into_owned();
    }
    Ok((loaded, samples_up))
}

/// A reader, or in its place the error that its feature is off.
macro_rules! reader {
    ($feature:literal, $name:literal, $from:ident, $read:ident, ($($open:ident)?)) => {
        #[cfg(feature = $feature)]
        fn $from(
            bytes: &[u8],
            options: &LoadOptions,
            $($open: OpenFile<'_>,)?
        ) -> Result<Loaded, LoadError> {
            $read(bytes, options, $($open)?)
        }

        #[cfg(not(feature = $feature))]
        fn $from(
            _: &[u8],
            _: &LoadOptions,
            $($open: OpenFile<'_>,)?
        ) -> Result<Loaded, LoadError> {
            $(let _ = $open;)?
            Err(LoadError::Unsupported(
                concat!($name, " (feature `", $feature, "` is off in this build)").into(),
            ))
        }
    };
}

reader!("gltf", "glTF", from_gltf, gltf_from_slice, (open));
reader!("ply", "PLY", from_ply, ply_from_slice, ());
reader!("obj", "OBJ", from_obj, obj_from_slice, (open));
reader!("hair", "HAIR", from_hair, hair_from_slice, ());
reader!("vol", "VOL", from_vol, vol_from_slice, ());
reader!("nvdb", "NanoVDB", from_nvdb, nvdb_from_slice, ());
reader!("vdb", "OpenVDB", from_vdb, vdb_from_slice, ());

/// The number that OpenVDB files begin with, 0x56444220 in 64 bits.
const OPEN_VDB: [u8; 8] = *b" BDV\0\0\0\0";

enum Format {
    Gltf,
    Ply,
    Obj,
    Hair,
    Vol,
    Nvdb,
    Vdb,
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
        if bytes.starts_with(b"NanoVDB") {
            return Ok(Self::Nvdb);
        }
        if bytes.starts_with(&OPEN_VDB) {
            return Ok(Self::Vdb);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("gltf" | "glb") => Ok(Self::Gltf),
            Some("ply") => Ok(Self::Ply),
            Some("obj") => Ok(Self::Obj),
            Some("hair") => Ok(Self::Hair),
            Some("vol") => Ok(Self::Vol),
            Some("nvdb") => Ok(Self::Nvdb),
            Some("vdb") => Ok(Self::Vdb),
            _ => Err(LoadError::Unsupported(
                "a file that is neither glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB nor OpenVDB".into(),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_scene_file_is_told_apart() {
        let of = |bytes: &[u8], name: &str| Format::of(bytes, Path::new(name));
        assert!(matches!(
            of(b" BDV\0\0\0\0\xe0\0\0\0", "smoke"),
            Ok(Format::Vdb)
        ));
        assert!(matches!(of(b" BDV", "smoke.vdb"), Ok(Format::Vdb)));
        let other = of(b" BDV", "smoke").err().map(|error| error.to_string());
        assert!(other.is_some_and(|error| error.contains("neither glTF")));
    }
}
