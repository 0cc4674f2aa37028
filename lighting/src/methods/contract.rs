//! What a method is.

use std::borrow::Cow;
use std::fmt::Debug;

use gpu_backend::{Backend, BufferOf};

use super::{Frame, FrameInputs};
use crate::SurfacePoint;
use crate::scene::Geometry;

/// What a method says of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct About {
    /// How it is asked for: `march x midpoint`. No two methods share a name.
    pub name: Cow<'static, str>,
    /// What it is, in a few words.
    pub title: &'static str,
    /// What it is for.
    pub purpose: &'static str,
    /// Who described it.
    pub paper: &'static str,
    /// What its quality is a number of: `steps`.
    pub quality: &'static str,
    /// The qualities worth comparing, in rising order; none if only those who ask
    /// for it by name want it.
    pub qualities: &'static [u32],
    /// Those of a quick comparison.
    pub quick: &'static [u32],
    /// The quality whose picture a comparison shows.
    pub pictured: u32,
    /// The quality of a picture for which no other is asked.
    pub usual: u32,
    /// What it is to a comparison.
    pub role: Role,
    /// Whether it looks into shadow maps or maps of transmittance, whose resolution
    /// limits it.
    pub uses_shadow_map: bool,
}

/// What a method is to a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It leaves the shadows out, which tells what they are worth.
    Unshadowed,
    /// What all others are compared with: plain ray marching.
    Baseline,
    /// The method of a paper.
    Paper,
    /// What engines do, which a comparison shows beside the best in its time. It is
    /// dropped with the variants when time is short.
    Engine,
    /// Another way to do it, the first to be dropped when time is short.
    Variant,
}

/// Whether a method applies to a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Applies,
    /// It runs, but a comparison need not show it; the reason.
    Pointless(Cow<'static, str>),
    /// It cannot run, or would not do what its name says; the reason.
    Impossible(Cow<'static, str>),
}

impl Verdict {
    /// The worse of two.
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

    /// Why not, unless it applies.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Self::Applies => None,
            Self::Pointless(reason) | Self::Impossible(reason) => Some(reason),
        }
    }
}

/// Counted work, which does not depend on the machine: what a method expects to do.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Work {
    /// Texels, voxels and the like that are made before the first frame.
    pub once: f64,
    /// The same for each frame.
    pub per_frame: f64,
    /// Lookups and evaluations along each ray.
    pub per_ray: f64,
    /// Memory for what is kept, bytes.
    pub bytes: u64,
}

/// A way of making an image of the light in the air.
pub trait Method: Send + Sync + Debug {
    /// What it is.
    fn about(&self) -> About;

    /// Whether it applies to a frame.
    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict;

    /// Whether it looks into shadow maps of these casters. If
    /// [it says so](About::uses_shadow_map), it does of any.
    fn uses_maps_of(&self, _geometry: &Geometry) -> bool {
        self.about().uses_shadow_map
    }

    /// Those of `qualities`, in rising order, that differ on this frame; why the
    /// others do not, if there are others.
    fn distinct<'q>(
        &self,
        _inputs: &FrameInputs<'_>,
        qualities: &'q [u32],
    ) -> (&'q [u32], Option<&'static str>) {
        (qualities, None)
    }

    /// Whether it sees heterogeneous media, which vary along the rays: smoke, and
    /// fog that thins out with altitude. To one that does not, smoke is a caster of
    /// shadows.
    fn sees_heterogeneous_media(&self) -> bool {
        false
    }

    /// Whether [what covers the rays](FrameInputs::panes), be it glass or hair, dims the
    /// light of the air behind it.
    fn sees_cover(&self) -> bool {
        false
    }

    /// Whether its rays can [share its work](super::Selection::interleaving): it then
    /// takes the parts that belong to each ray and weighs them. Lights and steps are
    /// such parts; what is made for the whole frame is made once for all of them.
    fn interleaves(&self, _inputs: &FrameInputs<'_>) -> Verdict {
        Verdict::Impossible("its rays cannot share its work".into())
    }

    /// Whether it does what its name says where the rays are those of
    /// [some pixels](super::Selection::pixels) alone, which is what
    /// [reductions](super::reduced) of the pixels ask of it.
    fn takes_some_pixels(&self) -> Verdict {
        Verdict::Applies
    }

    /// Whether its picture of a frame of a [film](super::share_film_frame) depends on the
    /// frames before.
    fn remembers_frames(&self) -> bool {
        false
    }

    /// What it promises of the light of each ray, if it promises anything: a relative error
    /// that rounding alone adds to, as far as the scene has nothing but what blocks light and
    /// what lets it pass.
    fn tolerance(&self, _quality: u32) -> Option<f64> {
        None
    }

    /// What should be said of its picture of a frame: what it leaves out, or does in
    /// another way than its name says.
    fn notes(&self, _inputs: &FrameInputs<'_>) -> Vec<String> {
        Vec::new()
    }

    /// What it expects to do for a frame.
    fn work(&self, _inputs: &FrameInputs<'_>, _quality: u32) -> Work {
        Work::default()
    }
}

/// A method on a backend.
pub trait RunOn<B: Backend>: Send + Sync {
    /// Puts into the store what is the same in every frame, as long as the scene
    /// stays the same. Without it, the first frame does.
    ///
    /// # Errors
    /// [`MethodError`], among others for a quality that is out of range.
    fn prepare(&self, _frame: &Frame<'_, B>, _quality: u32) -> Result<(), MethodError> {
        Ok(())
    }

    /// Adds the airlight of the ray `frame.inputs.rays[i]`, due to all lights, to
    /// the first three components of `radiance[i]`.
    ///
    /// # Errors
    /// [`MethodError`]; what has been added by then stays.
    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError>;

    /// How it lights surfaces with the shadows that it knows, if it does.
    fn surfaces(&self) -> Option<&dyn LightFrameSurfaces<B>> {
        None
    }
}

/// What lights the surfaces of a frame with the shadows of its method.
pub trait LightFrameSurfaces<B: Backend> {
    /// Adds to the first three components of `radiance[i]` what `surfaces[i]` reflects
    /// to the eye of the light that comes straight from all lights of the frame. The
    /// points are seen by the camera of the frame, in any order.
    ///
    /// Shadows are looked up at the nearest place that is known, or interpolated
    /// between those around. A method of area lights does what its
    /// `LightManySurfaces` says, with voxels from the nearest to the farthest surface.
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

/// Why there is no image.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MethodError {
    /// The backend failed.
    #[error(transparent)]
    Backend(#[from] gpu_backend::Error),
    /// Something that the method needs cannot be made.
    #[error("{what}: {source}")]
    Resource {
        /// What.
        what: &'static str,
        /// Why not.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A quality that the method does not have.
    #[error("{value} {unit} were asked for, expected {expected}")]
    Quality {
        /// What was asked for.
        value: u32,
        /// What it is a number of.
        unit: &'static str,
        /// What it may be.
        expected: String,
    },
    /// A method was asked for on a backend on which it does not run.
    #[error("{name} does not run on this backend")]
    UnsupportedBackend {
        /// The method.
        name: String,
    },
    /// The [`Watch`](crate::Watch) wanted no more.
    #[error("stopped after {done} of {total} lights")]
    Stopped {
        /// Lights that are ready.
        done: usize,
        /// All lights.
        total: usize,
    },
}

impl MethodError {
    /// The error of something that could not be made.
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
