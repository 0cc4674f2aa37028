//! The gather whose shadows of triangles are exact, in the list of methods.

use std::sync::Arc;

use gpu_backend::{Cpu, Host};
use transmittance::Packed;

use super::PartsAndPoints;
use super::method::{
    ByArea, Named, Panes, STEPS, about, bytes_of_curves, check, gather_lights, needs_media,
};
use crate::methods::translucent::TransmittanceMap;
use crate::methods::{About, Frame, FrameInputs, Method, MethodError, Role, RunOn, Verdict, Work};
use crate::scene::trace::Tracer;
use crate::visibility::Exact;

/// Lit parts of rays from the triangles themselves, and curves of smoke and hair with `N` nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExactTriangles<const N: usize>(Named);

/// With 8 nodes.
pub(super) const EIGHT_NODES: ExactTriangles<8> = ExactTriangles(Named {
    name: "media-exact-area-8",
    title: "exact triangles, AVSM by least area",
    purpose: "smoke among things: shadows of triangles end where they end, with few steps",
    paper: "Salvi et al., EGSR 2010, and the shadow volumes of Wyman and Ramsey, RT 2008",
    role: Role::Variant,
    quick: &[16, 64],
});

/// With 16 nodes.
pub(super) const SIXTEEN_NODES: ExactTriangles<16> = ExactTriangles(Named {
    name: "media-exact-area-16",
    title: "exact triangles, AVSM, 16 nodes",
    purpose: "the same with 16 nodes: less error where the eye looks at a lamp in smoke",
    ..EIGHT_NODES.0
});

impl<const N: usize> Method for ExactTriangles<N> {
    fn about(&self) -> About {
        About {
            // Steps need not find the edges of shadows.
            usual: 64,
            ..about(self.0, STEPS)
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        needs_media(inputs)
    }

    fn sees_heterogeneous_media(&self) -> bool {
        true
    }

    fn sees_cover(&self) -> bool {
        true
    }

    fn work(&self, inputs: &FrameInputs<'_>, steps: u32) -> Work {
        let triangles = inputs.geometry.triangles().len() as f64;
        let curves = bytes_of_curves(inputs, Panes::Apart, size_of::<Packed<N>>() as u64);
        let of_ray = 32.0 + 2.0 * triangles.sqrt() + 4.0 * f64::from(steps);
        Work {
            once: triangles + (curves / 4) as f64,
            per_ray: inputs.emitters.len() as f64 * of_ray,
            bytes: curves,
            ..Work::default()
        }
    }
}

/// What blocks a light: triangles, and all else.
type Visibility<const N: usize> =
    PartsAndPoints<Exact<Arc<Tracer>>, Arc<TransmittanceMap<Host, Packed<N>>>>;

fn visibility<const N: usize>(
    inputs: &FrameInputs<'_>,
    light: usize,
) -> Result<Visibility<N>, MethodError> {
    Ok(PartsAndPoints {
        parts: Exact::new(inputs.tracer()?),
        points: ByArea::<N>::on_host(inputs, light, Panes::Apart)?,
    })
}

impl<const N: usize> RunOn<Cpu> for ExactTriangles<N> {
    fn prepare(&self, frame: &Frame<'_, Cpu>, steps: u32) -> Result<(), MethodError> {
        check(steps, STEPS)?;
        (0..frame.inputs.emitters.len()).try_for_each(|light| {
            frame.inputs.go_on(light)?;
            visibility::<N>(&frame.inputs, light).map(|_| ())
        })
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        steps: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        check(steps, STEPS)?;
        gather_lights(frame, steps, radiance, |light| {
            visibility::<N>(&frame.inputs, light)
        })
    }
}
