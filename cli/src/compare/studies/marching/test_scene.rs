//! A mesh above a floor, two lights behind it, and the view of them.

use std::time::Instant;

use glam::Vec3;
use gpu_backend::{Cpu, Host};
use lighting::Emitter;
use lighting::methods::reduced::{Choice, Reduction};
use lighting::methods::{Frame, FrameInputs, Registry, RunOn, Selection, Store};
use lighting::scene::procedural::{Embedded, StandIn};
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{Camera, Emission, Geometry, Medium, Scene};
use reference::metrics::{Reference, image_error};
use reference::oracle::image::{Options, reference};

use super::{Measured, Variant};
use crate::failure::Failure;

/// About how many rays errors are measured on.
const RAYS: usize = 1500;

/// Distance of the floor below the lights, m.
const LOOKS_AT: Vec3 = Vec3::new(0.0, 0.9, 0.0);

/// Relative tolerance of the truth, below the errors that are measured.
const TOLERANCE: f64 = 1e-4;

pub(super) struct TestScene {
    geometry: Geometry,
    camera: Camera,
    medium: Medium,
    view: View,
    size: [u32; 2],
    /// Texels per side of a shadow map.
    map: u32,
    /// A light that shines alike in all directions, and one with a cookie.
    lights: [Emitter; 2],
    /// Pixels on which errors are measured, and their true radiance from each light.
    checked: Vec<usize>,
    truths: [Reference; 2],
}

impl TestScene {
    /// The lights, the fog and the eye of the embedded scene `textured-spot`, which looks
    /// down so far that the lights are out of view, with another mesh in place of its ball.
    pub(super) fn new(stand_in: StandIn, size: [u32; 2], map: u32) -> Result<Self, Failure> {
        let mut scene = Embedded::TexturedSpot.build(1);
        let spot = scene.lights[0].emitters(1)?.remove(0);
        let Emitter::Point(point) = &spot else {
            return Err(Failure::new("the light of textured-spot is at no point"));
        };
        let lamp = Emitter::point(
            point.position(),
            point.intensity(),
            f32::INFINITY,
            Emission::Isotropic,
        )?;
        let (Some(camera), Some(medium)) = (scene.camera.take(), scene.medium.take()) else {
            return Err(Failure::new("textured-spot has no eye or no fog"));
        };
        // If a light were in view, nearly all of the error would come from the few pixels around
        // it.
        let camera = Camera::look_at(camera.eye(), LOOKS_AT, camera.vertical_fov())?;
        let geometry = Geometry::new(&Scene::from(stand_in.above_a_floor()))?;
        let tracer = Tracer::new(&geometry);
        let view = View::new(&Cpu::new(), &camera, &tracer, size[0], size[1])?;
        let stride = (view.rays().len() / RAYS).max(1) | 1;
        let checked: Vec<usize> = (0..view.rays().len()).step_by(stride).collect();
        let rays: Vec<_> = checked.iter().map(|pixel| view.rays()[*pixel]).collect();
        let options = || Options {
            tolerance: TOLERANCE,
            ..Options::default()
        };
        let lights = [lamp, spot];
        let truths = lights.each_ref().map(|light| {
            let light = std::slice::from_ref(light);
            reference(&rays, light, &medium, &geometry, options())
        });
        Ok(Self {
            geometry,
            camera,
            medium,
            view,
            size,
            map,
            lights,
            checked,
            truths,
        })
    }

    pub(super) fn triangles(&self) -> usize {
        self.geometry.triangles().len()
    }

    /// A frame with a number of steps, at all pixels or some.
    pub(super) fn frame(
        &self,
        registry: &Registry,
        variant: Variant,
        steps: u32,
        reduction: Reduction,
    ) -> Result<Measured, Failure> {
        let whole = registry.find(variant.method);
        let whole = whole.ok_or_else(|| Failure::new(format!("no method {}", variant.method)))?;
        let method = whole.reduced(reduction);
        let (cpu, store) = (Cpu::new(), Store::<Host>::new());
        let light = usize::from(variant.textured);
        let inputs = FrameInputs {
            emitters: std::slice::from_ref(&self.lights[light]),
            areas: &[],
            medium: &self.medium,
            height_fog: None,
            geometry: &self.geometry,
            translucent: &[],
            camera: &self.camera,
            size: self.size,
            rays: self.view.rays(),
            hits: self.view.hits(),
            map: self.map,
            host: &store,
            selection: Selection::default(),
            watch: &(),
        };
        let frame = Frame::new(&cpu, inputs, &store)?;
        let clock = Instant::now();
        method.prepare(&frame, steps)?;
        let prepared = clock.elapsed().as_secs_f64();
        // The first frame still puts things into the store, and the second one is measured.
        let (mut radiance, mut least) = (Vec::new(), f64::INFINITY);
        for _ in 0..2 {
            radiance = vec![[0.0; 4]; self.view.rays().len()];
            let clock = Instant::now();
            method.add_radiance(&frame, steps, &mut radiance)?;
            least = least.min(clock.elapsed().as_secs_f64());
        }
        let found: Vec<[f32; 4]> = self.checked.iter().map(|pixel| radiance[*pixel]).collect();
        let in_full = match reduction.is_none() {
            true => 1.0,
            false => Choice::new(&cpu, &inputs, reduction)?.in_full(),
        };
        Ok(Measured {
            seconds: [prepared, least],
            rmse: image_error(&found, &self.truths[light]).rmse,
            in_full,
        })
    }
}
