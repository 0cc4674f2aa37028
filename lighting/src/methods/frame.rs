//! What a method is told of a frame.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use gpu_backend::{Backend, BufferOf, Host};

use super::{MethodError, Store};
use crate::scene::trace::Hit;
use crate::scene::{
    AreaEmitters, Camera, Emitter, Geometry, HeightFog, Media, Medium, Translucent,
};
use crate::{Interleaving, Ray, Watch};

/// A frame as every method sees it, whatever the backend.
#[derive(Debug, Clone, Copy)]
pub struct FrameInputs<'a> {
    /// The lights whose airlight is wanted. An area light is here as the points that stand for
    /// it.
    pub emitters: &'a [Emitter],
    /// The area lights among them, for methods that choose their own points.
    pub areas: &'a [AreaEmitters],
    /// The homogeneous medium, which fills all of space or a box.
    pub medium: &'a Medium,
    /// Fog that thins out with altitude, in addition to the medium.
    pub height_fog: Option<&'a HeightFog>,
    /// Opaque casters.
    pub geometry: &'a Geometry,
    /// Hair and smoke.
    pub translucent: &'a [Translucent],
    /// The camera that the rays start from.
    pub camera: &'a Camera,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The rays of all pixels, row by row from the top; or those of the pixels that the
    /// [selection](FrameInputs::selection) names.
    pub rays: &'a [Ray],
    /// What each ray ends on; `None` where it ends in the sky.
    pub hits: &'a [Option<Hit>],
    /// Texels along each side of a shadow map.
    pub map: u32,
    /// The store of what is made on the host, whatever the backend. On the CPU it may be the
    /// store of the frame itself.
    pub host: &'a Store<Host>,
    /// Which pixels the rays belong to, and which share of the lights or steps each ray takes.
    /// The default, all pixels and all of the work for each ray, holds unless a method runs
    /// inside [another](super::reduced).
    pub selection: Selection<'a>,
    /// Is told of progress, and is asked between lights whether to go on.
    pub watch: &'a dyn Watch,
}

impl<'a> FrameInputs<'a> {
    /// Asks the watch whether to go on after the first `done` lights.
    ///
    /// # Errors
    /// [`MethodError::Stopped`] if the watch says no.
    pub(super) fn go_on(&self, done: usize) -> Result<(), MethodError> {
        let total = self.emitters.len();
        match self.watch.goes_on(done, total) {
            true => Ok(()),
            false => Err(MethodError::Stopped { done, total }),
        }
    }

    /// The media of the scene together: the medium, the fog that thins out, and smoke.
    pub fn media(&self) -> Media<'a> {
        Media::new(Some(self.medium), self.height_fog, self.translucent)
    }
}

/// Which rays of a picture a frame has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Selection<'a> {
    /// The pixel of each ray, counted row by row from the top; `None` if the rays are those of
    /// all pixels in this order. The same pixel may occur more than once.
    pub pixels: Option<&'a [u32]>,
    /// The share of the lights or steps that each ray takes. A method that [cannot
    /// interleave](super::Method::interleaves) gives each ray all of its light, which is right
    /// too.
    pub interleaving: Interleaving,
}

/// A frame on a backend: the inputs, with the rays in the memory of the backend.
#[derive(Debug)]
pub struct Frame<'a, B: Backend> {
    /// The backend that makes the image.
    pub backend: &'a B,
    /// What it shows.
    pub inputs: FrameInputs<'a>,
    /// The rays, in the memory of the backend.
    pub rays: BufferOf<B, Ray>,
    /// What is kept between frames, in the memory of the backend.
    pub store: &'a Store<B::Memory>,
    passes: Option<Arc<Passes>>,
}

/// A pass that ran, with its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// What it did.
    pub what: &'static str,
    /// Its time over all runs, seconds.
    pub seconds: f64,
    /// Number of runs.
    pub times: usize,
}

/// The passes of a frame so far.
#[derive(Debug, Default)]
struct Passes(Mutex<Vec<Pass>>);

impl Passes {
    fn all(&self) -> MutexGuard<'_, Vec<Pass>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, what: &'static str, seconds: f64) {
        let mut passes = self.all();
        match passes.iter_mut().find(|pass| pass.what == what) {
            Some(pass) => {
                pass.seconds += seconds;
                pass.times += 1;
            }
            None => passes.push(Pass {
                what,
                seconds,
                times: 1,
            }),
        }
    }
}

impl<'a, B: Backend> Frame<'a, B> {
    /// A frame, whose rays are copied to the backend.
    ///
    /// # Errors
    /// Those of [`Backend::upload`].
    pub fn new(
        backend: &'a B,
        inputs: FrameInputs<'a>,
        store: &'a Store<B::Memory>,
    ) -> Result<Self, MethodError> {
        Ok(Self {
            rays: backend.upload(inputs.rays)?,
            backend,
            inputs,
            store,
            passes: None,
        })
    }

    /// The same frame, with the time of each pass measured. On a GPU this means waiting for
    /// each pass; see [`Store::waiting`].
    #[must_use]
    pub fn timed(self) -> Self {
        Self {
            passes: Some(Arc::default()),
            ..self
        }
    }

    /// The same frame with other inputs, for a method that runs another one inside. The passes
    /// of the inner method count as passes of this frame.
    ///
    /// # Errors
    /// Those of [`Backend::upload`].
    pub fn with_inputs<'b>(&'b self, inputs: FrameInputs<'b>) -> Result<Frame<'b, B>, MethodError> {
        Ok(Frame {
            backend: self.backend,
            rays: self.backend.upload(inputs.rays)?,
            inputs,
            store: self.store,
            passes: self.passes.clone(),
        })
    }

    /// Runs a pass under a name, and measures it if the frame is [`timed`](Frame::timed).
    ///
    /// # Errors
    /// Those of `run`, and those of the work that is waited for.
    pub fn pass<R>(
        &self,
        what: &'static str,
        run: impl FnOnce() -> Result<R, MethodError>,
    ) -> Result<R, MethodError> {
        let Some(passes) = &self.passes else {
            return run();
        };
        let clock = Instant::now();
        let result = run()?;
        self.store.wait()?;
        let seconds = clock.elapsed().as_secs_f64();
        passes.add(what, seconds);
        Ok(result)
    }

    /// The passes that ran, in the order in which each ran first; none unless the frame is
    /// [`timed`](Frame::timed).
    pub fn passes(&self) -> Vec<Pass> {
        let passes = self.passes.as_ref();
        passes.map_or_else(Vec::new, |passes| passes.all().clone())
    }
}
