//! What several methods share; each thing is made once.

use std::any::TypeId;
use std::sync::Arc;

use gpu_backend::{Backend, Cpu, Host, Memory};

use super::{Frame, FrameInputs, MethodError, Store, Work};
use crate::EyePanes;
use crate::scene::trace::Tracer;
use crate::scene::view::Cover;
use crate::scene::{Bounds, Emitter, Geometry};
use crate::shadow_map::{Casters, RenderShadowMap, ShadowMap, face_count, reached};

/// The key of something of which a scene has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfScene;

/// The key of something that belongs to a light and has a resolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfLight {
    /// Index of the light.
    pub light: usize,
    /// Texels or voxels along each side.
    pub resolution: u32,
}

/// The key of something made from static casters alone; `K` is the key of the same made from
/// all casters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfStatic<K>(pub K);

/// The key of something made from dynamic casters alone; `K` is the key of the same made from
/// all casters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct OfDynamic<K>(pub K);

/// The BVH of the triangles, which a store on the host keeps.
///
/// # Errors
/// Those of [`Tracer::try_new`].
pub fn tracer(host: &Store<Host>, geometry: &Geometry) -> Result<Arc<Tracer>, MethodError> {
    let make = || Tracer::try_new(geometry).map_err(MethodError::resource("exact visibility"));
    host.get("BVH", OfScene, |_| 0, make)
}

/// Puts a BVH that was made elsewhere into a store.
pub fn share_tracer(host: &Store<Host>, tracer: &Arc<Tracer>) {
    host.insert("BVH", OfScene, tracer.clone(), 0);
}

/// Tells methods, through the store on the host, which hair covers the pixels of a view.
pub fn share_cover(host: &Store<Host>, cover: &Arc<Cover>) {
    host.insert("cover", OfScene, cover.clone(), 0);
}

/// The number of a frame in its film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FilmFrame(u32);

/// Tells the methods of a frame, through the store on the host, which number the frame has in a
/// film. Methods that [remember frames](super::Method::remembers_frames) then keep what they
/// need from one frame to the next; before the first they run a few frames of a still camera.
/// Each frame must be made once, and in order.
///
/// Without this call every frame counts as one of a still camera.
pub fn share_film_frame(host: &Store<Host>, frame: u32) {
    host.insert("frame of a film", OfScene, Arc::new(FilmFrame(frame)), 0);
}

/// Forgets everything that may depend on the lights of a scene, so that they can move. Things
/// whose key is [`OfScene`] or a plain `u32` stay: the BVH, evaluators, and memory that is used
/// again.
///
/// A camera can move without this call.
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

/// Forgets everything that may depend on where the [dynamic](crate::scene::Instance::dynamic)
/// casters of a scene are, so that they can move: shadow maps, the BVH of the triangles, what
/// [covers](share_cover) the rays. Things whose key is [`OfStatic`], such as precomputed
/// shadows, or a plain `u32` stay.
///
/// Call it for both stores of a frame, that on the host and that of the backend. What frames
/// are told through the store on the host has to be told again.
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
    /// The number of the frame in its film, if [`share_film_frame`] gave one.
    pub fn film_frame(&self) -> Option<u32> {
        self.host
            .find::<_, FilmFrame>(&OfScene)
            .map(|frame| frame.0)
    }

    /// The hair that [`share_cover`] told of.
    fn cover(&self) -> Result<Arc<Cover>, MethodError> {
        let clear = || Ok(Cover::default());
        self.host.get("cover", OfScene, |_| 0, clear)
    }

    /// Whether there is hair, smoke or a see-through surface, which let a share of the light
    /// through.
    pub fn has_translucent_casters(&self) -> bool {
        !self.translucent.is_empty() || self.geometry.coatings().any_see_through()
    }

    /// Whether any light has a cookie.
    pub fn has_cookies(&self) -> bool {
        let cookie = |light: &Emitter| light.spot()?.texture().map(|_| ());
        self.emitters.iter().any(|light| cookie(light).is_some())
    }

    /// Whether see-through surfaces or hair may cover the rays.
    ///
    /// # Errors
    /// Those of the store.
    pub fn is_covered(&self) -> Result<bool, MethodError> {
        Ok(self.geometry.coatings().any_see_through() || !self.cover()?.is_clear())
    }

    /// What is in front of the ends of the rays: see-through surfaces, and the hair that
    /// [`share_cover`] told of for the pixels of the picture; `None` if there is nothing.
    ///
    /// # Errors
    /// Those of the store and of the BVH.
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

    /// The BVH of the triangles, on the host.
    ///
    /// # Errors
    /// Making it cannot fail; the type of the result is that of the store.
    pub fn tracer(&self) -> Result<Arc<Tracer>, MethodError> {
        tracer(self.host, self.geometry)
    }

    /// The part of the box around all dynamic casters whose shadows can fall on something that
    /// the light lights; `None` if there is no such part.
    pub fn dynamic_reached(&self, light: usize) -> Option<Bounds> {
        let dynamic = self.geometry.dynamic_part()?;
        reached(dynamic.bounds(), &self.emitters[light])
    }

    /// Number of faces that the shadow maps of some lights have together.
    pub(crate) fn map_faces<'e>(&self, emitters: impl IntoIterator<Item = &'e Emitter>) -> usize {
        let faces = emitters.into_iter();
        faces.map(|e| face_count(self.geometry, e)).sum()
    }

    /// The work of rendering the shadow maps of all lights.
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
    /// The opaque casters, in the memory of the backend that renders them.
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

    /// The shadow map of a light with the dynamic casters alone; `None` if their shadows fall
    /// on nothing that the light lights.
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
