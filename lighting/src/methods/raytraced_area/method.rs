//! Traced area lights as methods, which take the other lights by exact visibility.

use gpu_backend::Cpu;

use super::{PixelRay, TracedArea};
use crate::airlight::EquiAngular;
use crate::methods::evaluators::Gauss;
use crate::methods::{
    About, Entry, Evaluators, Frame, FrameInputs, Method, MethodError, Role, RunOn, Verdict, Work,
};
use crate::visibility::Exact;
use crate::{EyePanes, Gather, LitRays};

/// Samples of a ray, at most.
const MOST: u32 = 1 << 20;

/// Nodes of a lit part; as many as the virtual lights of [`crate::area`] take.
const NODES: u32 = 4;

/// What is drawn at random.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drawn {
    /// A point of the light and one on the ray.
    Points,
    /// A point of the light.
    Runs,
}

#[derive(Debug, Clone, Copy)]
struct TracedAreas {
    drawn: Drawn,
}

impl TracedAreas {
    fn check(self, count: u32) -> Result<(), MethodError> {
        if (1..=MOST).contains(&count) {
            return Ok(());
        }
        Err(MethodError::Quality {
            value: count,
            unit: self.about().quality,
            expected: format!("1 to {MOST}"),
        })
    }
}

impl Method for TracedAreas {
    fn about(&self) -> About {
        let paper = "Kulla and Fajardo, EGSR 2012, with the cosine of the light as Villeneuve \
            et al., EGSR 2021, have it";
        let (name, title, purpose, quality, paper) = match self.drawn {
            Drawn::Points => (
                "area-rays",
                "area lights by shadow rays",
                "the careful ray tracer that methods for area lights are measured against",
                "shadow rays per pixel",
                paper,
            ),
            Drawn::Runs => (
                "area-traced-runs",
                "area lights by traced lit runs",
                "the same with the light along the ray integrated, not drawn: less noise, more \
                 work a sample",
                "points per pixel",
                "Kulla and Fajardo, EGSR 2012, for the points; the shadow-volume half of Wyman \
                 and Ramsey, RT 2008, for the runs",
            ),
        };
        About {
            name: name.into(),
            title,
            purpose,
            paper,
            quality,
            qualities: match self.drawn {
                Drawn::Points => &[16, 64, 256, 1024],
                Drawn::Runs => &[4, 16, 64, 256],
            },
            quick: match self.drawn {
                Drawn::Points => &[16, 64],
                Drawn::Runs => &[4, 16],
            },
            pictured: match self.drawn {
                Drawn::Points => 256,
                Drawn::Runs => 64,
            },
            usual: match self.drawn {
                Drawn::Points => 256,
                Drawn::Runs => 64,
            },
            role: Role::Variant,
            uses_shadow_map: false,
        }
    }

    fn sees_cover(&self) -> bool {
        true
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if inputs.areas.is_empty() {
            return Verdict::Impossible("no light has an area".into());
        }
        if !inputs.translucent.is_empty() {
            return Verdict::Pointless("it does not see hair and smoke".into());
        }
        Verdict::Applies
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        match inputs.translucent {
            [] => Vec::new(),
            _ => vec![format!(
                "hair and smoke cast no shadow with {}",
                self.about().name
            )],
        }
    }

    fn work(&self, inputs: &FrameInputs<'_>, count: u32) -> Work {
        let triangles = inputs.geometry.triangles().len() as f64;
        let spread: usize = inputs.areas.iter().map(|area| area.emitters.len()).sum();
        let others = inputs.emitters.len().saturating_sub(spread) as f64;
        let samples = inputs.areas.len() as f64 * f64::from(count);
        // A walk along a planar triangle; a shadow ray goes down one branch.
        let walk = 8.0 + triangles.sqrt();
        let sample = match self.drawn {
            Drawn::Points => 8.0 + (1.0 + triangles).log2(),
            Drawn::Runs => walk + f64::from(NODES),
        };
        Work {
            once: triangles,
            per_ray: samples * sample + others * (walk + 8.0),
            ..Work::default()
        }
    }
}

impl RunOn<Cpu> for TracedAreas {
    fn prepare(&self, frame: &Frame<'_, Cpu>, count: u32) -> Result<(), MethodError> {
        self.check(count)?;
        Gauss.kept(frame, NODES)?;
        frame.inputs.tracer().map(|_| ())
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, Cpu>,
        count: u32,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        self.check(count)?;
        let inputs = &frame.inputs;
        let tracer = inputs.tracer()?;
        let airlight = Gauss.kept(frame, NODES)?;
        let panes = inputs.panes()?;
        let total = inputs.emitters.len();
        let mut next = 0;
        for area in inputs.areas {
            let range = area.emitters.clone();
            if !inputs.watch.goes_on(next, total) {
                return Err(MethodError::Stopped { done: next, total });
            }
            self.others(frame, next..range.start, panes.as_ref(), radiance)?;
            next = range.end;
            let light = TracedArea::new(&area.light, &*tracer, inputs.medium)
                .map_err(MethodError::resource("an area light"))?;
            frame.pass("trace", || {
                self.trace(frame, &light, count, panes.as_ref(), &airlight, radiance);
                Ok(())
            })?;
            inputs.watch.gathered(inputs.rays.len() * range.len());
        }
        self.others(frame, next..total, panes.as_ref(), radiance)
    }
}

impl TracedAreas {
    fn trace(
        self,
        frame: &Frame<'_, Cpu>,
        light: &TracedArea<'_, &crate::scene::trace::Tracer>,
        count: u32,
        panes: Option<&EyePanes>,
        airlight: &EquiAngular,
        radiance: &mut [[f32; 4]],
    ) {
        let rays = frame.inputs.rays;
        frame.backend.for_each_chunk(radiance, 16, |first, chunk| {
            let mut parts = Vec::new();
            for (i, sum) in (first..).zip(chunk) {
                let pixel = PixelRay {
                    ray: &rays[i],
                    // More rays than a u32 counts do not fit into memory.
                    index: i as u32,
                    panes,
                };
                let found = match self.drawn {
                    Drawn::Points => light.by_points(pixel, count),
                    Drawn::Runs => light.by_runs(pixel, count, airlight, &mut parts),
                };
                for channel in 0..3 {
                    sum[channel] += found[channel];
                }
            }
        });
    }

    /// The lights that have no area.
    fn others(
        self,
        frame: &Frame<'_, Cpu>,
        lights: std::ops::Range<usize>,
        panes: Option<&EyePanes>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), MethodError> {
        let inputs = &frame.inputs;
        let airlight = Gauss.kept(frame, 8)?;
        let source = Exact::new(inputs.tracer()?);
        for emitter in inputs.emitters.get(lights).unwrap_or_default() {
            let lit = LitRays {
                panes,
                watch: inputs.watch,
                ..LitRays::new(&frame.rays, emitter, inputs.medium)
            };
            frame.pass("gather", || {
                Ok((frame.backend).gather(&lit, &source, &*airlight, radiance)?)
            })?;
        }
        Ok(())
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    [Drawn::Points, Drawn::Runs]
        .map(|drawn| Entry::on_cpu(TracedAreas { drawn }))
        .into()
}
