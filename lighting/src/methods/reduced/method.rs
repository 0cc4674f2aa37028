//! A method with less work.

use gpu_backend::{BufferOf, Cpu};

use super::{Choice, FillPicture, Filling, Reduction};
use crate::methods::{
    About, Frame, FrameInputs, LightFrameSurfaces, Method, MethodError, Role, RunOn, Verdict, Work,
};
use crate::scene::Geometry;

/// A method whose picture is made from fewer rays, or from rays that share its work; see the
/// [module](super).
///
/// Its quality is that of the method. With [`Reduction::NONE`] it is the method itself, bit for
/// bit. In a frame that is already [part](crate::methods::Selection) of a picture, the
/// neighbours of a ray are not known, and the method runs unchanged. So use one `Reduced` with
/// both reductions, and not two around each other.
#[derive(Debug, Clone, Copy)]
pub struct Reduced<M> {
    inner: M,
    reduction: Reduction,
    shown: Option<ShownAs>,
}

/// How comparisons show a reduced method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShownAs {
    /// See [`About::name`].
    pub name: &'static str,
    /// See [`About::title`].
    pub title: &'static str,
    /// See [`About::purpose`].
    pub purpose: &'static str,
    /// See [`About::paper`].
    pub paper: &'static str,
    /// See [`About::qualities`]; none for what comparisons leave out.
    pub qualities: &'static [u32],
    /// See [`About::quick`].
    pub quick: &'static [u32],
    /// See [`About::pictured`].
    pub pictured: u32,
}

/// Neighbours that are compared with a pixel, as a share of a lookup of a method.
const TAP: f64 = 0.1;

impl<M: Method> Reduced<M> {
    /// The method with less work, which comparisons do not show. Its name is that of
    /// the method and of the reduction: `area-runs 3x3 quarter`.
    pub fn new(inner: M, reduction: Reduction) -> Self {
        Self {
            inner,
            reduction,
            shown: None,
        }
    }

    /// The same under another name, and for comparisons to show.
    #[must_use]
    pub fn shown_as(self, shown: ShownAs) -> Self {
        Self {
            shown: Some(shown),
            ..self
        }
    }

    /// The method.
    pub fn inner(&self) -> &M {
        &self.inner
    }

    /// How much less work it is.
    pub fn reduction(&self) -> Reduction {
        self.reduction
    }

    /// The share of the pixels of a frame that are gathered in full because they
    /// resemble none of the samples around them.
    ///
    /// # Errors
    /// Those of [`Choice::new`].
    pub fn in_full(&self, inputs: &FrameInputs<'_>) -> Result<f64, MethodError> {
        if self.runs_as_it_is(inputs) {
            return Ok(1.0);
        }
        Ok(Choice::new(&Cpu::new(), inputs, self.reduction)?.in_full())
    }

    fn runs_as_it_is(&self, inputs: &FrameInputs<'_>) -> bool {
        self.reduction.is_none() || inputs.selection.pixels.is_some() || inputs.rays.is_empty()
    }
}

impl<M: Method> Method for Reduced<M> {
    fn about(&self) -> About {
        let inner = self.inner.about();
        match self.shown {
            Some(shown) => About {
                name: shown.name.into(),
                title: shown.title,
                purpose: shown.purpose,
                paper: shown.paper,
                qualities: shown.qualities,
                quick: shown.quick,
                pictured: shown.pictured,
                role: Role::Variant,
                ..inner
            },
            None => About {
                name: format!("{} {}", inner.name, self.reduction).into(),
                purpose: "a reduction of one's own",
                qualities: &[],
                quick: &[],
                role: Role::Variant,
                ..inner
            },
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        self.inner
            .applies(inputs)
            .and(|| match self.reduction.is_none() {
                true => Verdict::Applies,
                false => self.inner.takes_some_pixels(),
            })
            .and(|| match self.reduction.window() {
                1 => Verdict::Applies,
                _ => self.inner.interleaves(inputs),
            })
    }

    fn sees_cover(&self) -> bool {
        self.inner.sees_cover()
    }

    fn remembers_frames(&self) -> bool {
        self.inner.remembers_frames()
    }

    fn takes_some_pixels(&self) -> Verdict {
        match self.reduction.is_none() {
            true => self.inner.takes_some_pixels(),
            false => Verdict::Impossible("the neighbours of a pixel are not known then".into()),
        }
    }

    fn uses_maps_of(&self, geometry: &Geometry) -> bool {
        self.inner.uses_maps_of(geometry)
    }

    fn distinct<'q>(
        &self,
        inputs: &FrameInputs<'_>,
        qualities: &'q [u32],
    ) -> (&'q [u32], Option<&'static str>) {
        self.inner.distinct(inputs, qualities)
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = self.inner.notes(inputs);
        if let (false, Ok(share)) = (self.runs_as_it_is(inputs), self.in_full(inputs)) {
            notes.push(format!(
                "{:.1} % of the pixels resemble no sample around them and are gathered in full \
                 with {}",
                100.0 * share,
                self.about().name
            ));
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, quality: u32) -> Work {
        let mut work = self.inner.work(inputs, quality);
        let (block, window) = (self.reduction.block(), self.reduction.window());
        if !self.reduction.is_none() {
            let beside = (2 * window - 1).pow(2) / block.pow(2);
            let between = if block > 1 { 4 } else { 0 };
            work.per_ray *= self.reduction.share();
            work.per_ray += TAP * f64::from(beside + between);
        }
        work
    }
}

impl<B: FillPicture, M: Method + RunOn<B>> RunOn<B> for Reduced<M> {
    fn prepare(&self, frame: &Frame<'_, B>, quality: u32) -> Result<(), MethodError> {
        self.inner.prepare(frame, quality)
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        if self.runs_as_it_is(&frame.inputs) {
            return self.inner.add_radiance(frame, quality, radiance);
        }
        let backend: &B = frame.backend;
        let choice = frame.pass("choice of pixels", || {
            Ok(Choice::new(&Cpu::new(), &frame.inputs, self.reduction)?)
        })?;
        let mut gathered = backend.zeros::<[f32; 4]>(choice.rays().len())?;
        let part = frame.with_inputs(choice.inputs(&frame.inputs))?;
        self.inner.add_radiance(&part, quality, &mut gathered)?;
        frame.pass("filling", || {
            let filling = Filling::upload(backend, &choice, &frame.rays)?;
            Ok(backend.fill_picture(&filling, &gathered, radiance)?)
        })
    }

    /// Those of the method that it reduces, all of them.
    fn surfaces(&self) -> Option<&dyn LightFrameSurfaces<B>> {
        self.inner.surfaces()
    }
}
