//! What a scene is: meshes and their instances, hair and smoke, a camera,
//! lights, what fills the air; and what can be said about it without any light
//! transport.
//!
//! The fields of a [`Scene`] are plain data. [`Geometry`] is the checked
//! world-space form of its triangles, [`Emitter`] the checked form of its
//! lights; algorithms take these two. How light travels is the business of the
//! crate `lighting`, which re-exports this one as `lighting::scene`.
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
//! | `load` | `gltf`, `ply`, `obj`, `hair`, `vol`, `nvdb` | scene files |
//!
//! # Conventions
//!
//! Right-handed, +Y up, metres; cameras and lights look along their local −Z.
//! Light is linear RGB radiance. Coordinates lie within 1e9 m.

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
    feature = "nvdb"
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
    CellSpan, CellWalk, DensityGrid, Interpolation, MAX_SAMPLES, Particle, Particles, Piece,
    Profile, StrandPoint, Strands, Translucent,
};
pub use virtual_lights::{AreaEmitters, Pattern};

use glam::{Affine3A, Vec2, Vec3, Vec4};

/// Coordinates farther out than this leave f32 no digits for light transport.
pub(crate) const MAX_COORDINATE: f32 = 1e9;

/// True if no coordinate is NaN or beyond [`MAX_COORDINATE`].
pub(crate) fn is_near(point: Vec3) -> bool {
    // The largest element of a vector would pass over a NaN.
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
    /// What lets a part of the light through.
    pub translucent: Vec<Translucent>,
    /// The view, if the scene brings one.
    pub camera: Option<Camera>,
    /// The lights, possibly none.
    pub lights: Vec<Light>,
    /// What fills the air; `None` is a vacuum.
    pub medium: Option<Medium>,
    /// Fog that thins out with altitude, on top of all else: part of [`Media`].
    /// Whatever takes a [`Medium`] alone passes over it.
    pub height_fog: Option<HeightFog>,
}

impl Scene {
    /// Says of everything called `name` whether it casts a shadow: instances of
    /// that name, of a mesh of that name, or of a mesh whose material has that
    /// name. Returns how many instances were meant; 0 tells that there is
    /// nothing of that name. Names that are empty are never meant.
    pub fn set_casts_shadow(&mut self, name: &str, casts_shadow: bool) -> usize {
        self.for_each_called(name, |instance| instance.no_shadow = !casts_shadow)
    }

    /// Says of everything called `name`, as [`Scene::set_casts_shadow`] does, whether it is
    /// [dynamic](Instance::dynamic). Returns how many instances were meant.
    pub fn set_dynamic(&mut self, name: &str, dynamic: bool) -> usize {
        self.for_each_called(name, |instance| instance.dynamic = dynamic)
    }

    /// Changes the instances that `name` means, and tells how many there are.
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

/// One mesh, where it is.
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
    /// The name it is chosen by, and called in error messages.
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
    /// The name it is chosen by; empty if it has none.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// From the mesh's space to the world's.
    pub transform: Affine3A,
    /// It is seen and lit, but light passes through it as if it were not there.
    pub no_shadow: bool,
    /// It may move from one frame to the next: shadows that are computed once and stored
    /// leave it out, and a shadow map of every frame has its shadow.
    pub dynamic: bool,
}

/// A Lambertian surface, the same from both sides except for what it emits.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The name it is chosen by; empty if it has none.
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
    /// Nothing: all of the surface is there.
    #[default]
    Opaque,
    /// The surface is there where the opacity is at least `cutoff`, and a hole
    /// elsewhere.
    Mask {
        /// Finite; above 1 there is nothing but a hole.
        cutoff: f32,
    },
    /// The surface covers that share of what is behind it.
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

/// Why a scene cannot be used. Every message names the offending value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// No triangle is left to look at.
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
    /// Two arrays that belong together differ in length.
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
    /// A number outside its domain, NaN and infinity included.
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
    /// A phase function that is none.
    #[error("medium: {0}")]
    PhaseFunction(#[from] airlight::Error),
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
