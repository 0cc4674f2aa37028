//! Textured spotlights in the list of methods.

use std::borrow::Cow;
use std::sync::Arc;

use super::{MipCookie, Placement, ShadowSpans, Textured, bare, blurred};
use crate::methods::evaluators::Daylights;
use crate::methods::hybrid::volumes_of;
use crate::methods::registry::pairs;
use crate::methods::{
    Compared, Entry, Frame, FrameInputs, LightSources, MethodError, Role, SourceAbout, SourceOn,
    SourceQuality, Verdict, Work,
};
use crate::shadow_map::{RenderShadowMap, ShadowMap};
use crate::{Emitter, Touching};

/// The quality: steps across the beam for colours.
const STEPS: SourceQuality = SourceQuality {
    unit: "steps across the beam",
    qualities: &[8, 16, 32, 64, 128, 256],
    quick: &[16, 64],
    pictured: 64,
    usual: 64,
};

/// Number of steps for shadows for each step for colours; see the [module](super).
const SHADOW_STEPS: u32 = 2;

/// Why the method is pointless without cookies.
const NO_COOKIE: &str = "no light has a cookie, whose colours it would step through";

/// Textured spotlights; other lights are gathered by the same steps.
#[derive(Debug, Clone, Copy)]
struct TexturedLights {
    name: &'static str,
    title: &'static str,
    /// The standard deviation of a blur, as a share of the sides of a cookie.
    blur: f32,
}

/// The key of a light's cookie, with the bits of its blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct CookieOf {
    light: usize,
    blur: u32,
}

impl TexturedLights {
    /// The cookie of a light, in the memory of the backend.
    fn cookie<B: RenderShadowMap>(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
    ) -> Result<Option<Arc<MipCookie<B::Memory>>>, MethodError> {
        let spot = frame.inputs.emitters[light].spot();
        let Some(texture) = spot.and_then(|spot| spot.texture()) else {
            return Ok(None);
        };
        let blur = self.blur.to_bits();
        let key = CookieOf { light, blur };
        let cookie = frame.store.get("cookie", key, MipCookie::bytes, || {
            let texture = match self.blur > 0.0 {
                true => &blurred(texture, self.blur).map_err(MethodError::resource("a cookie"))?,
                false => texture,
            };
            Ok(MipCookie::new(texture).upload(frame.backend)?)
        })?;
        Ok(Some(cookie))
    }
}

impl LightSources for TexturedLights {
    fn about(&self) -> SourceAbout {
        SourceAbout {
            name: self.name,
            title: self.title,
            quality: Some(STEPS),
            touching: Touching::Apart,
            is_sampled: true,
            sees_translucent: false,
            sees_panes: false,
            uses_shadow_map: true,
        }
    }

    fn evaluated<'a>(&self, emitter: &'a Emitter) -> Cow<'a, Emitter> {
        bare(emitter)
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        match inputs.has_cookies() {
            true => Verdict::Applies,
            false => Verdict::Pointless(NO_COOKIE.into()),
        }
    }

    fn notes(&self, _: &FrameInputs<'_>) -> Vec<String> {
        match self.blur > 0.0 {
            true => {
                vec!["cookies are blurred, in place of light that scatters more than once".into()]
            }
            false => Vec::new(),
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        let map = inputs.map_work();
        let texels = inputs.emitters.iter().filter_map(|light| {
            let cookie = light.spot()?.texture()?;
            Some(f64::from(cookie.width()) * f64::from(cookie.height()))
        });
        let texels = 4.0 / 3.0 * texels.sum::<f64>();
        Work {
            per_ray: inputs.emitters.len() as f64 * f64::from(steps) * f64::from(1 + SHADOW_STEPS),
            // Volumes visit the triangles once more, and a cell covers 64 texels.
            once: 1.25 * map.once + texels,
            bytes: map.bytes + map.bytes / 48 + 12 * texels as u64,
            ..map
        }
    }
}

impl<B: RenderShadowMap> SourceOn<B> for TexturedLights {
    type Source = Textured<ShadowSpans<Arc<ShadowMap<B::Memory>>, B::Memory>, B::Memory>;

    fn prepare(&self, frame: &Frame<'_, B>, light: usize, _: u32) -> Result<(), MethodError> {
        volumes_of(frame, light)?;
        self.cookie(frame, light)?;
        frame.shadow_map(light).map(|_| ())
    }

    fn source(
        &self,
        frame: &Frame<'_, B>,
        light: usize,
        steps: u32,
    ) -> Result<Self::Source, MethodError> {
        let emitter = &frame.inputs.emitters[light];
        let placement = Placement::Angle;
        let shadows = ShadowSpans::new(
            frame.shadow_map(light)?,
            Some(volumes_of(frame, light)?),
            emitter,
            steps.saturating_mul(SHADOW_STEPS),
            placement,
        )?;
        let cookie = self.cookie(frame, light)?;
        Ok(Textured::new(shadows, emitter, cookie, steps, placement))
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let compared = |role, airlight, detail, title, purpose| Compared {
        airlight,
        detail: Some(detail),
        title,
        purpose,
        paper: "Wyman and Ramsey, Interactive Volumetric Shadows, RT 2008, section 3.2",
        qualities: (&[], &[], 0),
        role,
        is_baseline: false,
    };
    let textured = TexturedLights {
        name: "textured",
        title: "textured spotlights",
        blur: 0.0,
    };
    let blurred = TexturedLights {
        name: "textured-blurred",
        title: "textured spotlights, blurred",
        blur: 1.0 / 32.0,
    };
    let mut all = pairs!(
        textured,
        &[
            compared(
                Role::Paper,
                "gauss",
                1,
                "textured spotlights",
                "spotlights with a cookie: few steps, of colours that are as blurred as they",
            ),
            compared(
                Role::Variant,
                "table",
                64,
                "textured spotlights, airlight table",
                "the same with the airlight of a point light in closed form",
            ),
        ]
    );
    all.push(pairs!(@one everywhere, textured, &[], Daylights));
    all.extend(pairs!(blurred, &[]));
    all.push(pairs!(@one everywhere, blurred, &[], Daylights));
    all
}
