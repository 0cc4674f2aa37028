//! What several methods share, each made once.

use std::any::TypeId;
use std::sync::Arc;

use gpu_backend::{Backend, Cpu, Host, Memory};

use super::{Frame, FrameInputs, MethodError, Store, Work};
use crate::EyePanes;
use crate::scene::trace::Tracer;
use crate::scene::view::Cover;
use crate::scene::{Bounds, Emitter, Geometry};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap, face_count, reached};

/// The only one of its kind in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfScene;

/// That of a light, with so many texels a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfLight {
    /// Index of the light.
    pub light: usize,
    /// Texels or voxels a side.
    pub resolution: u32,
}

/// Of static casters alone, what has the key `K` of all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfStatic<K>(pub K);

/// Of dynamic casters alone, what has the key `K` of all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfDynamic<K>(pub K);

/// The hierarchy of the triangles, which a store on the host keeps.
///
/// # Errors
/// None; the result is that of the store.
pub fn tracer(host: &Store<Host>, geometry: &Geometry) -> Result<Arc<Tracer>, MethodError> {
    host.get("BVH", OfScene, |_| 0, || Ok(Tracer::new(geometry)))
}

/// Gives a store the hierarchy of another one.
pub fn share_tracer(host: &Store<Host>, tracer: &Arc<Tracer>) {
    host.insert("BVH", OfScene, tracer.clone(), 0);
}

/// Tells the methods of frames of a view what covers it, through the store on the host.
pub fn share_cover(host: &Store<Host>, cover: &Arc<Cover>) {
    host.insert("cover", OfScene, cover.clone(), 0);
}

/// The place of a frame in a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FilmFrame(u32);

/// Tells the methods of a frame, through the store on the host, that it is the frame of
/// this number in a film: those that
/// [remember frames](super::Method::remembers_frames) keep theirs from one to the next, and
/// begin with frames of a still camera. Each frame is made once, in order.
///
/// Without it every frame is one of a still camera.
pub fn share_film_frame(host: &Store<Host>, frame: u32) {
    host.insert("frame of a film", OfScene, Arc::new(FilmFrame(frame)), 0);
}

/// Forgets what may depend on the lights of a scene, so that they can move: keeps what is known by
/// [`OfScene`], or by a plain `u32`, as evaluators and memory that is used again are.
///
/// A camera can move without it.
///
/// ```
/// use gpu_backend::Host;
/// use lighting::methods::{OfLight, OfScene, Store, forget_lights};
///
/// let store = Store::<Host>::new();
/// let light = OfLight { light: 0, resolution: 64 };
/// let made = |value| {
///     let of_light = store.get("map", light, |_| 0, || Ok(value))?;
///     let of_scene = store.get("BVH", OfScene, |_| 0, || Ok(value))?;
///     Ok::<_, lighting::methods::MethodError>((*of_light, *of_scene))
/// };
/// assert_eq!(made(1)?, (1, 1));
/// assert_eq!(made(2)?, (1, 1));
/// forget_lights(&store);
/// assert_eq!(made(3)?, (3, 1));
/// # Ok::<(), lighting::methods::MethodError>(())
/// ```
pub fn forget_lights<M: Memory>(store: &Store<M>) {
    store.keep_only(&[TypeId::of::<OfScene>(), TypeId::of::<u32>()]);
}

/// Forgets what may depend on where the [dynamic](crate::scene::Instance::dynamic) casters
/// of a scene are, so that they can move: shadow maps, the hierarchy of the triangles, what
/// [covers](share_cover) the rays. Keeps what is known by [`OfStatic`], as precomputed shadows
/// are, or by a plain `u32`.
///
/// Both stores of a frame have to forget, that on the host and that of the backend. What
/// frames are told through the store on the host, they are told again.
///
/// ```
/// use gpu_backend::Host;
/// use lighting::methods::{OfDynamic, OfLight, OfStatic, Store, forget_dynamic};
///
/// let store = Store::<Host>::new();
/// let light = OfLight { light: 0, resolution: 64 };
/// let made = |value| {
///     let baked = store.get("bake", OfStatic(light), |_| 0, || Ok(value))?;
///     let map = store.get("map", OfDynamic(light), |_| 0, || Ok(value))?;
///     Ok::<_, lighting::methods::MethodError>((*baked, *map))
/// };
/// assert_eq!(made(1)?, (1, 1));
/// assert_eq!(made(2)?, (1, 1));
/// forget_dynamic(&store);
/// assert_eq!(made(3)?, (1, 3));
/// # Ok::<(), lighting::methods::MethodError>(())
/// ```
pub fn forget_dynamic<M: Memory>(store: &Store<M>) {
    let (of_light, of_all) = (
        TypeId::of::<OfStatic<OfLight>>(),
        TypeId::of::<OfStatic<u32>>(),
    );
    store.keep_only(&[of_light, of_all, TypeId::of::<u32>()]);
}

impl FrameInputs<'_> {
    /// The number of the frame in its film, if [`share_film_frame`] told of one.
    pub fn film_frame(&self) -> Option<u32> {
        self.host
            .find::<_, FilmFrame>(&OfScene)
            .map(|frame| frame.0)
    }

    /// What [`share_cover`] told.
    fn cover(&self) -> Result<Arc<Cover>, MethodError> {
        let clear = || Ok(Cover::default());
        self.host.get("cover", OfScene, |_| 0, clear)
    }

    /// Whether there are hair, smoke or see-through surfaces, which let a share of light
    /// through.
    pub fn has_translucent_casters(&self) -> bool {
        !self.translucent.is_empty() || self.geometry.coatings().any_see_through()
    }

    /// Whether a light has a cookie.
    pub fn has_cookies(&self) -> bool {
        let cookie = |light: &Emitter| light.spot()?.texture().map(|_| ());
        self.emitters.iter().any(|light| cookie(light).is_some())
    }

    /// Whether anything may cover parts of the rays.
    ///
    /// # Errors
    /// Those of the store.
    pub fn is_covered(&self) -> Result<bool, MethodError> {
        Ok(self.geometry.coatings().any_see_through() || !self.cover()?.is_clear())
    }

    /// What covers parts of the rays: see-through surfaces, and what
    /// [`share_cover`] told of the pixels of the picture; `None` if nothing does.
    ///
    /// # Errors
    /// Those of the store and of the hierarchy of triangles.
    pub fn panes(&self) -> Result<Option<EyePanes>, MethodError> {
        let panes = match self.geometry.coatings().any_see_through() {
            true => EyePanes::new(&Cpu::new(), &*self.tracer()?, self.rays),
            false => None,
        };
        let cover = self.cover()?;
        let pixels = self.selection.pixels;
        let pixel = |ray: usize| pixels.map_or(ray, |pixels| pixels[ray] as usize);
        Ok(EyePanes::with_cover(panes, &cover, self.rays.len(), pixel))
    }

    /// The hierarchy of the triangles, on the host.
    ///
    /// # Errors
    /// None; the result is that of the store.
    pub fn tracer(&self) -> Result<Arc<Tracer>, MethodError> {
        tracer(self.host, self.geometry)
    }

    /// The part of the box around all dynamic casters that can shade what a light lights;
    /// `None` if they can shade nothing.
    pub fn dynamic_reached(&self, light: usize) -> Option<Bounds> {
        let dynamic = self.geometry.dynamic_part()?;
        reached(dynamic.bounds(), &self.emitters[light])
    }

    /// The faces of the shadow maps of some lights.
    pub(crate) fn map_faces<'e>(&self, emitters: impl IntoIterator<Item = &'e Emitter>) -> usize {
        let faces = emitters.into_iter();
        faces.map(|e| face_count(self.geometry, e)).sum()
    }

    /// What shadow maps of all lights cost.
    pub(super) fn map_work(&self) -> Work {
        let faces = self.map_faces(self.emitters);
        let texels = faces as f64 * f64::from(self.map).powi(2);
        Work {
            once: texels + (faces * self.geometry.triangles().len()) as f64,
            bytes: 4 * texels as u64,
            ..Work::default()
        }
    }
}

impl<B: Backend> Frame<'_, B> {
    /// The opaque casters where the backend renders them.
    pub(super) fn casters(&self) -> Result<Arc<Casters<B::Memory>>, MethodError> {
        self.store.get(
            "casters",
            OfScene,
            |_| 0,
            || Ok(Casters::upload(self.backend, self.inputs.geometry)?),
        )
    }

    /// The shadow map of a light.
    ///
    /// # Errors
    /// [`MethodError`] if it cannot be rendered.
    pub fn shadow_map(&self, light: usize) -> Result<Arc<ShadowMap<B::Memory>>, MethodError>
    where
        B: RenderShadowMap,
    {
        let resolution = self.inputs.map;
        let key = OfLight { light, resolution };
        self.store.get("shadow map", key, ShadowMap::bytes, || {
            let casters = self.casters()?;
            self.backend
                .shadow_map(&casters, &self.inputs.emitters[light], resolution)
                .map_err(MethodError::resource("a shadow map"))
        })
    }

    /// The shadow map of a light with the dynamic casters alone; `None` if they can shade
    /// nothing that it lights.
    ///
    /// # Errors
    /// [`MethodError`] if it cannot be rendered.
    pub fn dynamic_map(
        &self,
        light: usize,
    ) -> Result<Option<Arc<ShadowMap<B::Memory>>>, MethodError>
    where
        B: RenderShadowMap,
    {
        let inputs = &self.inputs;
        let reached = inputs.dynamic_reached(light);
        let Some((within, dynamic)) = reached.zip(inputs.geometry.dynamic_part()) else {
            return Ok(None);
        };
        let resolution = inputs.map;
        let key = OfDynamic(OfLight { light, resolution });
        let what = "shadow map of dynamic casters";
        let map = self.store.get(what, key, ShadowMap::bytes, || {
            let casters = self.store.get(
                "dynamic casters",
                OfDynamic(OfScene),
                |_| 0,
                || Ok(Casters::upload(self.backend, dynamic)?),
            )?;
            self.backend
                .shadow_map_within(&casters, within, &inputs.emitters[light], resolution)
                .map_err(MethodError::resource("a shadow map"))
        })?;
        Ok(Some(map))
    }
}
