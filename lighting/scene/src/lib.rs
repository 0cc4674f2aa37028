//! Scenes: meshes and their instances, hair and smoke, a camera, lights, the media in the air,
//! and everything that can be said about these without light transport.
//!
//! The package is `crepuscular-scene` and the library `scene`: `Cargo.toml` has the first name, and
//! `use` the second.
//!
//! The fields of a [`Scene`] are plain data. Algorithms take two checked forms of it:
//! [`Geometry`] has its triangles in world space, and [`Emitter`]s are its lights. Light
//! transport is in the crate `lighting`, which re-exports this crate as `lighting::scene`.
//!
//! ```
//! use glam::Vec3;
//! use scene::{Geometry, Light, Mesh, PointLight, Scene};
//!
//! let mut scene = Scene::from(Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! });
//! let geometry = Geometry::new(&scene)?;
//! scene.complete(geometry.bounds())?;
//! assert_eq!(geometry.triangles().len(), 1);
//! assert!(scene.camera.is_some() && !scene.lights.is_empty());
//! # Ok::<(), scene::SceneError>(())
//! ```
//!
//! # Modules and features
//!
//! | module | feature | what |
//! |---|---|---|
//! | [`raster`] | | scan conversion of triangles as a light sees them |
//! | [`statistics`] | | what makes a scene hard for a shadow map, in numbers |
//! | `trace` | `trace` | a BVH: the first surface along a ray, and whether there is any |
//! | `gpu` | `wgsl` | what media take from a ray, for shaders |
//! | `view` | `trace` | the rays of a picture and what they meet |
//! | `procedural` | `procedural` | scenes that need no file |
//! | `load` | `gltf`, `ply`, `obj`, `hair`, `vol`, `nvdb`, `vdb` | scene files |
//!
//! # Conventions
//!
//! Coordinates are right-handed, in metres, with +Y up, and lie within 1e9 m. Cameras and
//! lights look along their local −Z. Light is linear RGB radiance.

mod area_surface;
mod camera;
mod caster;
mod coating_line;
mod coatings;
mod complete;
mod cubic;
mod emitter;
mod geometry;
#[cfg(feature = "wgsl")]
pub mod gpu;
mod height_fog;
mod light;
#[cfg(any(
    feature = "gltf",
    feature = "ply",
    feature = "obj",
    feature = "hair",
    feature = "vol",
    feature = "nvdb",
    feature = "vdb"
))]
pub mod load;
mod media;
mod medium;
#[cfg(feature = "procedural")]
pub mod procedural;
pub mod raster;
mod ray;
pub mod statistics;
mod texture;
#[cfg(feature = "trace")]
pub mod trace;
mod translucent;
#[cfg(feature = "trace")]
pub mod view;
mod virtual_lights;

pub use area_surface::AreaSurface;
pub use camera::Camera;
pub use caster::{Caster, Coating};
pub use coating_line::Passing;
pub use coatings::Coatings;
pub use complete::Placement;
pub use emitter::{
    DirectionalEmitter, Emission, Emitter, Falloff, MOST_COOKIE_LINES, PointEmitter, SpotEmission,
};
pub use geometry::{Appearance, Geometry, MAX_TRIANGLES, Source};
pub use height_fog::HeightFog;
pub use light::{AreaLight, AreaShape, Cone, DirectionalLight, Light, PointLight, SpotLight};
pub use media::{Media, MediaPart, MediaPiece, MediaPieces, Scattering};
pub use medium::{Bounds, Medium, PhaseFunction, ScatteringAngle};
pub use ray::{Interval, Ray};
pub use texture::{Filter, Sampler, Texture, Wrap};
pub use translucent::{
    CellSpan, CellWalk, DensityGrid, Interpolation, MAX_SAMPLES, OccupiedCells, Particle,
    Particles, Piece, Profile, StrandPoint, Strands, Translucent,
};
pub use virtual_lights::{AreaEmitters, Pattern};

use glam::{Affine3A, Vec2, Vec3, Vec4};

/// At coordinates beyond this an f32 has no digits left for light transport.
pub(crate) const MAX_COORDINATE: f32 = 1e9;

/// True if no coordinate is NaN or beyond [`MAX_COORDINATE`].
pub(crate) fn is_near(point: Vec3) -> bool {
    // `max_element` could ignore a NaN.
    point.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()
}

/// A scene as it was loaded or generated.
///
/// The fields are plain data and may hold anything; [`Geometry::new`] and
/// [`Light::emitters`] check what they take over. A scene without a camera or
/// without lights can be given sensible ones by [`Scene::complete`].
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// A name for reports.
    pub name: String,
    /// Triangle meshes in their own space.
    pub meshes: Vec<Mesh>,
    /// Surface materials that meshes refer to.
    pub materials: Vec<Material>,
    /// Meshes placed in the world.
    pub instances: Vec<Instance>,
    /// Hair and smoke, which let a share of the light through.
    pub translucent: Vec<Translucent>,
    /// The camera, if the scene has one.
    pub camera: Option<Camera>,
    /// The lights, possibly none.
    pub lights: Vec<Light>,
    /// The homogeneous medium; `None` is a vacuum.
    pub medium: Option<Medium>,
    /// Fog that thins out with altitude, in addition to everything else; see [`Media`].
    /// Functions that take a [`Medium`] alone ignore it.
    pub height_fog: Option<HeightFog>,
}

impl Scene {
    /// Sets whether everything called `name` casts a shadow: instances with this name,
    /// instances of a mesh with this name, and instances of a mesh whose material has this
    /// name. Returns the number of these instances; 0 means that nothing has the name. Nothing
    /// matches an empty name.
    pub fn set_casts_shadow(&mut self, name: &str, casts_shadow: bool) -> usize {
        self.for_each_called(name, |instance| instance.no_shadow = !casts_shadow)
    }

    /// Sets whether everything called `name` is [dynamic](Instance::dynamic); names mean the
    /// same as for [`Scene::set_casts_shadow`]. Returns the number of instances.
    pub fn set_dynamic(&mut self, name: &str, dynamic: bool) -> usize {
        self.for_each_called(name, |instance| instance.dynamic = dynamic)
    }

    /// Changes the instances that `name` stands for, and counts them.
    fn for_each_called(&mut self, name: &str, change: impl Fn(&mut Instance)) -> usize {
        if name.is_empty() {
            return 0;
        }
        let is_of_the_name = |mesh: &Mesh| {
            let material = mesh.material.and_then(|index| self.materials.get(index));
            mesh.name == name || material.is_some_and(|material| material.name == name)
        };
        let mut meant = 0;
        for instance in &mut self.instances {
            let mesh = self.meshes.get(instance.mesh);
            if instance.name == name || mesh.is_some_and(is_of_the_name) {
                change(instance);
                meant += 1;
            }
        }
        meant
    }
}

/// A scene with a single mesh, at its own place.
impl From<Mesh> for Scene {
    fn from(mesh: Mesh) -> Self {
        Self {
            meshes: vec![mesh],
            instances: vec![Instance::default()],
            ..Self::default()
        }
    }
}

/// A triangle mesh in its own space, metres.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// The name that selects it and that error messages use.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Texture coordinates, one per position, or empty. (0, 0) is the upper
    /// left corner of the image.
    pub texture_coordinates: Vec<Vec2>,
    /// Coordinates of the material's transmission texture, one per position, or
    /// empty.
    pub transmission_coordinates: Vec<Vec2>,
    /// Linear red, green, blue and opacity, one per position, or empty. They
    /// are interpolated over each triangle and multiply the colour and the
    /// opacity of the material.
    pub colors: Vec<Vec4>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`]; `None` is [`Material::default`].
    pub material: Option<usize>,
}

/// A mesh placed in the world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Instance {
    /// The name that selects it; may be empty.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// From the mesh's space to the world's.
    pub transform: Affine3A,
    /// It is seen and lit, but light passes through it as if it were not there.
    pub no_shadow: bool,
    /// It may move from one frame to the next. Shadows that are computed once and stored leave
    /// it out; a shadow map that is made in every frame has its shadow.
    pub dynamic: bool,
}

/// A Lambertian surface, the same from both sides except for what it emits.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name that selects it; may be empty.
    pub name: String,
    /// Diffuse albedo in linear RGB, multiplied by the texture.
    pub base_color: Vec3,
    /// Diffuse albedo over the surface, and its opacity if it has an alpha
    /// channel.
    pub base_color_texture: Option<Texture>,
    /// Radiance that leaves the front in linear RGB; the back too if the
    /// surface is double-sided.
    pub emitted: Vec3,
    /// Opacity from 0 to 1, multiplied by the alpha channel of the texture and
    /// by that of the vertex colours. Without effect if `alpha` is
    /// [`AlphaMode::Opaque`].
    pub opacity: f32,
    /// What the opacity means.
    pub alpha: AlphaMode,
    /// Share from 0 to 1 of the light that is neither reflected nor absorbed
    /// but goes straight through, coloured by the base colour: thin glass.
    pub transmission: f32,
    /// Its red, at most 1, multiplies the transmission.
    pub transmission_texture: Option<Texture>,
    /// Whether the back emits as the front does.
    pub double_sided: bool,
}

/// What the opacity of a surface means.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AlphaMode {
    /// Nothing: the whole surface is there.
    #[default]
    Opaque,
    /// The surface is there where the opacity is at least `cutoff`, and a hole
    /// elsewhere.
    Mask {
        /// The cutoff, a finite number; if it is above 1 the whole surface is a hole.
        cutoff: f32,
    },
    /// The surface covers a share of what is behind it: its opacity.
    Blend,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec3::splat(0.8),
            base_color_texture: None,
            emitted: Vec3::ZERO,
            opacity: 1.0,
            alpha: AlphaMode::Opaque,
            transmission: 0.0,
            transmission_texture: None,
            double_sided: false,
        }
    }
}

/// Why a scene cannot be used. Every message names the wrong value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// No triangle is left.
    #[error("the scene has no triangles")]
    Empty,
    /// Too many triangles for one scene once instances are expanded.
    #[error("the scene has {triangles} triangles after instancing, the limit is {limit}")]
    TooManyTriangles {
        /// Triangles after instancing.
        triangles: u64,
        /// [`MAX_TRIANGLES`].
        limit: u64,
    },
    /// An index points past the end of what it indexes.
    #[error("{owner}: {what} index {index} is out of range, there are {count}")]
    IndexOutOfRange {
        /// The object that holds the index.
        owner: String,
        /// What is indexed.
        what: &'static str,
        /// The index.
        index: u64,
        /// Number of things it could point to.
        count: u64,
    },
    /// Two arrays that belong together have different lengths.
    #[error("{owner}: {what} has {actual} entries, but {expected} were expected")]
    LengthMismatch {
        /// The object that holds the arrays.
        owner: String,
        /// The array at fault.
        what: &'static str,
        /// Entries it has.
        actual: usize,
        /// Entries it should have.
        expected: usize,
    },
    /// A number is outside of its domain; NaN and infinity always are.
    #[error("{owner}: {what} is {value}, expected {expected}")]
    BadValue {
        /// The object that holds the number.
        owner: String,
        /// Which number.
        what: &'static str,
        /// The number as text.
        value: String,
        /// Its domain in words.
        expected: &'static str,
    },
    /// The phase function has invalid parameters.
    #[error("medium: {0}")]
    PhaseFunction(#[from] airlight::Error),
    /// The machine has less memory than something takes.
    #[error("there is no memory for {what}, which takes {bytes} bytes")]
    OutOfMemory {
        /// What would have been made.
        what: &'static str,
        /// The memory that it takes while it is made.
        bytes: u64,
    },
}

impl SceneError {
    pub(crate) fn bad_value(
        owner: impl Into<String>,
        what: &'static str,
        value: impl ToString,
        expected: &'static str,
    ) -> Self {
        Self::BadValue {
            owner: owner.into(),
            what,
            value: value.to_string(),
            expected,
        }
    }
}

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
