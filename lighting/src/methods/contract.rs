//! What a method promises: the traits that every method implements.

use std::borrow::Cow;
use std::fmt::Debug;

use gpu_backend::{Backend, BufferOf};

use super::{Frame, FrameInputs};
use crate::SurfacePoint;
use crate::scene::Geometry;

/// How a method describes itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// The name by which it is asked for, such as `march x midpoint`. No two methods share a
    /// name.
    pub name: Cow<'static, str>,
    /// What it is, in a few words, for tables and plots.
    pub title: &'static str,
    /// What it is good for, in one line.
    pub purpose: &'static str,
    /// The paper that describes it.
    pub paper: &'static str,
    /// The unit of its quality, such as `steps`.
    pub quality: &'static str,
    /// The qualities worth comparing, in rising order. None if comparisons leave the method
    /// out, because only those who ask for it by name want it.
    pub qualities: &'static [u32],
    /// The qualities of a quick comparison.
    pub quick: &'static [u32],
    /// The quality whose picture a comparison shows.
    pub pictured: u32,
    /// The quality that is used unless another is asked for.
    pub usual: u32,
    /// The part that it plays in a comparison.
    pub role: Role,
    /// Whether it looks into shadow maps or transmittance maps, whose resolution limits its
    /// accuracy.
    pub uses_shadow_map: bool,
}

/// The part that a method plays in a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It leaves the shadows out, which shows how much they matter.
    Unshadowed,
    /// Plain ray marching, with which all others are compared.
    Baseline,
    /// The method of a paper. It stays when time is short.
    Paper,
    /// What game engines do. A comparison shows it beside the best method that takes no more
    /// time. It is dropped with the variants when time is short.
    Engine,
    /// Another way to do the same, the first to be dropped when time is short.
    Variant,
}

/// Whether a method applies to a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// It does what its name says.
    Applies,
    /// It runs, but a comparison need not show it, for this reason.
    Pointless(Cow<'static, str>),
    /// It cannot run, or would not do what its name says, for this reason.
    Impossible(Cow<'static, str>),
}

impl Verdict {
    /// The worse of two verdicts; of two equally bad ones, the first.
    #[must_use]
    pub fn and(self, other: impl FnOnce() -> Self) -> Self {
        match self {
            Self::Applies => other(),
            Self::Impossible(_) => self,
            Self::Pointless(_) => match other() {
                worse @ Self::Impossible(_) => worse,
                _ => self,
            },
        }
    }

    /// The reason, unless the method applies.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Applies => None,
            Self::Pointless(reason) | Self::Impossible(reason) => Some(reason),
        }
    }
}

/// The work that a method expects, counted in operations that do not depend on the machine.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Work {
    /// Texels, voxels and the like that are made before the first frame.
    pub once: f64,
    /// Texels, voxels and the like that are made in every frame.
    pub per_frame: f64,
    /// Lookups and evaluations along each ray.
    pub per_ray: f64,
    /// Memory that is kept between frames, bytes.
    pub bytes: u64,
}

/// A way of making an image of the airlight.
pub trait Method: Send + Sync + Debug {
    /// What it says of itself.
    fn about(&self) -> About;

    /// Whether it applies to a frame.
    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict;

    /// Whether it looks into shadow maps of these casters. The default is
    /// [`About::uses_shadow_map`], whatever the casters.
    fn uses_maps_of(&self, _geometry: &Geometry) -> bool {
        self.about().uses_shadow_map
    }

    /// Those of `qualities`, in rising order, that make a difference on this frame, and, if
    /// there are others, why they do not.
    fn distinct<'q>(
        &self,
        _inputs: &FrameInputs<'_>,
        qualities: &'q [u32],
    ) -> (&'q [u32], Option<&'static str>) {
        (qualities, None)
    }

    /// Whether it sees heterogeneous media, which vary along the rays: smoke, and fog that
    /// thins out with altitude. To a method that does not, smoke only casts shadows.
    fn sees_heterogeneous_media(&self) -> bool {
        false
    }

    /// Whether glass and hair [in front of the rays](FrameInputs::panes) dim the airlight
    /// behind them.
    fn sees_cover(&self) -> bool {
        false
    }

    /// Whether rays can [share its work](super::Selection::interleaving): each ray then takes
    /// some of the lights or steps and weights them. What is made for the whole frame is made
    /// once for all rays.
    fn interleaves(&self, _inputs: &FrameInputs<'_>) -> Verdict {
        Verdict::Impossible("its rays cannot share its work".into())
    }

    /// Whether it does what its name says if the rays are those of [some
    /// pixels](super::Selection::pixels) only, as they are in a [reduction](super::reduced) of
    /// the pixels.
    fn takes_some_pixels(&self) -> Verdict {
        Verdict::Applies
    }

    /// Whether its image of a frame of a [film](super::share_film_frame) depends on the frames
    /// before.
    fn remembers_frames(&self) -> bool {
        false
    }

    /// The relative error that it promises for the light of each ray, beside rounding; `None`
    /// if it promises none. The promise holds for scenes in which everything either blocks
    /// light or lets it pass.
    fn tolerance(&self, _quality: u32) -> Option<f64> {
        None
    }

    /// Remarks on its image of a frame: what it leaves out, or does in another way than its
    /// name says.
    fn notes(&self, _inputs: &FrameInputs<'_>) -> Vec<String> {
        Vec::new()
    }

    /// The work that it expects for a frame.
    fn work(&self, _inputs: &FrameInputs<'_>, _quality: u32) -> Work {
        Work::default()
    }
}

/// A method that runs another one in a way of its own, and says of itself what that one says.
pub trait Wraps: Send + Sync + Debug {
    /// The other method.
    type Wrapped: Method + ?Sized;

    /// The other method.
    fn wrapped(&self) -> &Self::Wrapped;
}

impl<W: Wraps> Method for W {
    fn about(&self) -> About {
        self.wrapped().about()
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        self.wrapped().applies(inputs)
    }

    fn uses_maps_of(&self, geometry: &Geometry) -> bool {
        self.wrapped().uses_maps_of(geometry)
    }

    fn distinct<'q>(
        &self,
        inputs: &FrameInputs<'_>,
        qualities: &'q [u32],
    ) -> (&'q [u32], Option<&'static str>) {
        self.wrapped().distinct(inputs, qualities)
    }

    fn sees_heterogeneous_media(&self) -> bool {
        self.wrapped().sees_heterogeneous_media()
    }

    fn sees_cover(&self) -> bool {
        self.wrapped().sees_cover()
    }

    fn interleaves(&self, inputs: &FrameInputs<'_>) -> Verdict {
        self.wrapped().interleaves(inputs)
    }

    fn takes_some_pixels(&self) -> Verdict {
        self.wrapped().takes_some_pixels()
    }

    fn remembers_frames(&self) -> bool {
        self.wrapped().remembers_frames()
    }

    fn tolerance(&self, quality: u32) -> Option<f64> {
        self.wrapped().tolerance(quality)
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        self.wrapped().notes(inputs)
    }

    fn work(&self, inputs: &FrameInputs<'_>, quality: u32) -> Work {
        self.wrapped().work(inputs, quality)
    }
}

/// A method on a backend.
pub trait RunOn<B: Backend>: Send + Sync {
    /// Puts into the store what stays the same as long as the scene does. Without this call the
    /// first frame makes it.
    ///
    /// # Errors
    /// [`MethodError`], for example for a quality that is out of range.
    fn prepare(&self, _frame: &Frame<'_, B>, _quality: u32) -> Result<(), MethodError> {
        Ok(())
    }

    /// Adds the airlight of the ray `frame.inputs.rays[i]`, from all lights, to the first three
    /// components of `radiance[i]`.
    ///
    /// # Errors
    /// [`MethodError`]; what was added before the error remains.
    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError>;

    /// The method's way to light surfaces with its own shadows, if it has one.
    fn surfaces(&self) -> Option<&dyn LightFrameSurfaces<B>> {
        None
    }
}

/// Lights the surfaces of a frame with the shadows that a method knows.
pub trait LightFrameSurfaces<B: Backend> {
    /// Adds to the first three components of `radiance[i]` the light that comes directly from
    /// all lights of the frame and that `surfaces[i]` reflects to the eye. The camera of the
    /// frame sees all points; they may be in any order.
    ///
    /// With `interpolate`, the shadow of a point is interpolated between the places around it
    /// for which shadows are known; without, it is that of the nearest place. A method of area
    /// lights does what its `LightManySurfaces` says, with voxels from the nearest to the
    /// farthest surface.
    ///
    /// # Errors
    /// As for [`RunOn::add_radiance`].
    fn add_surface_light(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        surfaces: &BufferOf<B, SurfacePoint>,
        interpolate: bool,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError>;
}

/// Why a method made no image.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MethodError {
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
    /// Something that the method needs cannot be made.
    #[error("{what}: {source}")]
    Resource {
        /// What could not be made.
        what: &'static str,
        /// Why it could not be made.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The method does not have the quality that was asked for.
    #[error("{value} {unit} were asked for, expected {expected}")]
    Quality {
        /// The quality that was asked for.
        value: u32,
        /// The unit of the quality.
        unit: &'static str,
        /// The range of qualities that the method has.
        expected: String,
    },
    /// A method was asked for on a backend on which it does not run.
    #[error("{name} does not run on this backend")]
    UnsupportedBackend {
        /// The name of the method.
        name: String,
    },
    /// The [`Watch`](crate::Watch) said to stop.
    #[error("stopped after {done} of {total} lights")]
    Stopped {
        /// Number of lights that are ready.
        done: usize,
        /// Number of all lights.
        total: usize,
    },
}

impl MethodError {
    /// An error that says that `what` could not be made, and why.
    pub fn resource<E>(what: &'static str) -> impl FnOnce(E) -> Self
    where
        E: std::error::Error + Send + Sync + 'static,
    {
        move |source| Self::Resource {
            what,
            source: Box::new(source),
        }
    }
}
