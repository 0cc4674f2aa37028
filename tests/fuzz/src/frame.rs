//! Tiny pictures.

use std::sync::LazyLock;

use gpu_backend::{Cpu, Host};
use lighting::methods::{Entry, Frame, FrameInputs, MethodError, Registry, Selection, Store};
use lighting::scene::view::View;
use lighting::scene::{Camera, Emitter, Geometry, HeightFog, Medium, Translucent};

/// All methods.
pub(super) static METHODS: LazyLock<Registry> = LazyLock::new(Registry::standard);

/// The least quality of comparisons by a method.
pub(super) fn least(method: &Entry) -> u32 {
    let about = method.about();
    about.quick.first().copied().unwrap_or(about.usual)
}

/// Texels per side of shadow maps.
const MAP: u32 = 16;

/// A picture of a few pixels, before it is computed.
#[derive(Debug)]
pub(super) struct Tiny<'a> {
    /// Opaque casters.
    pub(super) geometry: &'a Geometry,
    /// Whence it is seen.
    pub(super) camera: &'a Camera,
    /// Its rays.
    pub(super) view: &'a View,
    /// What fills the air.
    pub(super) medium: &'a Medium,
    /// Fog that thins out, besides.
    pub(super) height_fog: Option<&'a HeightFog>,
    /// Hair and smoke.
    pub(super) translucent: &'a [Translucent],
}

impl Tiny<'_> {
    /// Calls `use_of` with the frame of these lights.
    pub(super) fn with_inputs<T>(
        &self,
        emitters: &[Emitter],
        use_of: impl FnOnce(FrameInputs<'_>) -> T,
    ) -> T {
        let host = Store::<Host>::new();
        use_of(FrameInputs {
            emitters,
            areas: &[],
            medium: self.medium,
            height_fog: self.height_fog,
            geometry: self.geometry,
            translucent: self.translucent,
            camera: self.camera,
            size: [self.view.width(), self.view.height()],
            rays: self.view.rays(),
            hits: self.view.hits(),
            map: MAP,
            host: &host,
            selection: Selection::default(),
            watch: &(),
        })
    }

    /// The light of these lights by a method.
    ///
    /// # Errors
    /// Those of the method.
    pub(super) fn image(
        &self,
        emitters: &[Emitter],
        method: &Entry,
        quality: u32,
    ) -> Result<Vec<[f32; 4]>, MethodError> {
        self.with_inputs(emitters, |inputs| {
            let (cpu, store) = (Cpu::single_threaded(), Store::new());
            let frame = Frame::new(&cpu, inputs, &store)?;
            let mut radiance = vec![[0.0; 4]; self.view.rays().len()];
            let runs = method.on::<Cpu>().expect("all methods run on the CPU");
            runs.add_radiance(&frame, quality, &mut radiance)?;
            Ok(radiance)
        })
    }
}
