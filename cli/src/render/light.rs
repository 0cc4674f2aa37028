//! The light of a picture that methods compute: airlight, and light on surfaces from area lights.

use std::sync::{Arc, Mutex, PoisonError};

use gpu_backend::gpu::Gpu;
use gpu_backend::{Buffer, Cpu, Download, Host};
use indicatif::ProgressBar;
use lighting::methods::heterogeneous::{
    AddEmission, EmittingRays, MediaMemory, MediaOf, UploadedMedia,
};
use lighting::methods::{
    Entry, Frame, FrameInputs, Method, MethodBackend, Selection, Store, Verdict, Work,
};
use lighting::plan::Plan;
use lighting::scene::view::View;
use lighting::scene::{AreaEmitters, Camera, Medium};
use lighting::surface;
use lighting::translucent::TransmittanceMap;
use lighting::{Emitter, EyePanes, Ray, SurfacePoint, Watch};

use crate::args::Render;
use crate::devices::Device;
use crate::failure::Failure;
use crate::input::Input;
use crate::parse::Size;
use crate::picture::Picture;
use crate::shadow_files::Shadow;
use crate::{maps, progress};

/// The light that smoke emits along the rays of a view, one RGB0 per ray; `None` if it is dark.
pub(crate) fn of_media(
    input: &Input,
    view: &View,
    device: &Device,
) -> Result<Option<Vec<[f32; 4]>>, Failure> {
    let media = input.media();
    if !media.emits() {
        return Ok(None);
    }
    let (cpu, rays) = (Cpu::new(), view.rays());
    let panes = EyePanes::new(&cpu, &input.tracer, rays);
    let panes = EyePanes::with_cover(panes, view.cover(), rays.len(), |ray| ray);
    let radiance = match &device.context {
        None => emitted(&cpu, rays, &media, panes.as_ref()),
        Some(context) => {
            let gpu = Gpu::new(context.clone());
            let media = UploadedMedia::new(&gpu, &media)?;
            emitted(&gpu, rays, &media, panes.as_ref())
        }
    };
    Ok(Some(radiance?))
}

fn emitted<B: AddEmission + Download>(
    backend: &B,
    rays: &[Ray],
    media: &MediaOf<'_, B::Memory>,
    panes: Option<&EyePanes>,
) -> Result<Vec<[f32; 4]>, Failure>
where
    B::Memory: MediaMemory,
{
    let mut radiance = backend.zeros::<[f32; 4]>(rays.len())?;
    let rays = &backend.upload(rays)?;
    backend.add_emission(&EmittingRays { rays, media, panes }, &mut radiance)?;
    Ok(backend.download(&radiance)?)
}

/// Everything that is the same for all lights of a picture.
pub(crate) struct Job<'a> {
    pub(crate) args: &'a Render,
    /// Size of the picture of all rays.
    pub(crate) size: Size,
    pub(crate) camera: &'a Camera,
    pub(crate) view: &'a View,
    pub(crate) medium: &'a Medium,
    pub(crate) device: &'a Device,
    /// The light of each emitter that translucent casters let through, if that is known.
    pub(crate) maps: &'a [Arc<TransmittanceMap>],
}

impl Job<'_> {
    /// The airlight of some emitters by a method; `given` are shadows from files.
    pub(crate) fn airlight(
        &self,
        input: &mut Input,
        indices: &[usize],
        entry: &Entry,
        quality: u32,
        given: &[Option<Shadow>],
    ) -> Result<Picture, Failure> {
        // Lights are numbered anew.
        let host = Store::new();
        for (light, shadow) in given.iter().enumerate() {
            if let Some(shadow) = shadow {
                lighting::methods::share_precomputed(&host, light, shadow);
            }
        }
        // Surfaces leave see-through triangles to rays.
        if !input.geometry.coatings().any_see_through() {
            for (light, index) in indices.iter().enumerate() {
                if let Some(map) = self.maps.get(*index) {
                    lighting::methods::share_transmittance_map(&host, light, map);
                }
            }
        }
        let (radiance, notes) = self.with_inputs(
            "airlight",
            input,
            indices,
            entry,
            &host,
            |inputs| match &self.device.context {
                None => run_on(&Cpu::new(), &host, inputs, entry, quality),
                Some(context) => {
                    let gpu = Gpu::new(context.clone());
                    run_on(&gpu, &Store::new(), inputs, entry, quality)
                }
            },
        )?;
        input.notes.extend(notes);
        Ok(Picture::new(self.size, &radiance))
    }

    /// The light of some emitters on surfaces, with the shadows that a method knows.
    pub(crate) fn on_surfaces(
        &self,
        input: &mut Input,
        indices: &[usize],
        (entry, quality): (&Entry, u32),
        interpolate: bool,
    ) -> Result<Vec<[f32; 4]>, Failure> {
        let host = Store::new();
        let cpu = Cpu::new();
        let (scene, geometry) = (&input.scene, &input.geometry);
        let medium = Some(self.medium);
        let mut points = surface::points(&cpu, self.view, scene, geometry, medium);
        // The points of see-through surfaces come behind all others.
        let panes = surface::points_of_panes(&cpu, self.view, scene, geometry, medium);
        points.extend(panes.iter().map(|(_, point)| *point));
        let (mut radiance, _) =
            self.with_inputs("surfaces", input, indices, entry, &host, |inputs| {
                let way = (quality, interpolate);
                match &self.device.context {
                    None => light_on(&cpu, &host, inputs, entry, way, &points),
                    Some(context) => {
                        let gpu = Gpu::new(context.clone());
                        light_on(&gpu, &Store::new(), inputs, entry, way, &points)
                    }
                }
            })?;
        let of_panes = radiance.split_off(self.view.rays().len());
        for ((pixel, _), light) in panes.iter().zip(of_panes) {
            for channel in 0..3 {
                radiance[*pixel][channel] += light[channel];
            }
        }
        Ok(radiance)
    }

    /// The plan, which takes casters into account, and the lights that it takes out of a method's
    /// hands: those that are unshadowed, if the method can draw the others.
    pub(crate) fn planned(
        &self,
        plan: Plan,
        input: &Input,
        entry: &Entry,
    ) -> Result<(Plan, Vec<usize>), Failure> {
        let host = Store::new();
        let all: Vec<usize> = (0..input.emitters.len()).collect();
        let areas = input.areas(&all);
        let map = self.args.options.map();
        let inputs = self.inputs(input, (&input.emitters, &areas), map, &host);
        let plan = plan.with_casters(&inputs)?;
        let runs = match &self.device.context {
            None => entry.on::<Cpu>().is_some(),
            Some(_) => entry.runs_on_gpus(),
        };
        let kept = FrameInputs {
            emitters: &input.picked(plan.emitters()),
            areas: &input.areas(plan.emitters()),
            ..inputs
        };
        let is_possible = !matches!(entry.applies(&kept), Verdict::Impossible(_));
        let sees_all = entry.sees_cover() || !inputs.is_covered()?;
        let mut unshadowed = match runs && is_possible && sees_all {
            true => plan.unshadowed().to_vec(),
            false => Vec::new(),
        };
        if entry.halves().is_none() {
            // Methods for area lights choose their own points, which these are not.
            let has_area = |index: &usize| areas.iter().any(|area| area.emitters.contains(index));
            unshadowed.retain(|index| !has_area(index));
        }
        Ok((plan, unshadowed))
    }

    /// The work that a method expects for the airlight of some emitters.
    pub(crate) fn work(
        &self,
        input: &Input,
        indices: &[usize],
        (entry, quality): (&Entry, u32),
    ) -> Work {
        let host = Store::new();
        let (emitters, areas) = (&input.picked(indices), &input.areas(indices));
        let map = self.args.options.map();
        let inputs = self.inputs(input, (emitters, areas), map, &host);
        entry.method().work(&inputs, quality)
    }

    /// The inputs of a frame of some emitters and the area lights among them.
    fn inputs<'b>(
        &'b self,
        input: &'b Input,
        (emitters, areas): (&'b [Emitter], &'b [AreaEmitters]),
        map: u32,
        host: &'b Store<Host>,
    ) -> FrameInputs<'b> {
        lighting::methods::share_tracer(host, &input.tracer);
        lighting::methods::share_cover(host, self.view.cover());
        FrameInputs {
            emitters,
            areas,
            medium: self.medium,
            height_fog: input.scene.height_fog.as_ref(),
            geometry: &input.geometry,
            translucent: &input.scene.translucent,
            camera: self.camera,
            size: [self.size.width, self.size.height],
            rays: self.view.rays(),
            hits: self.view.hits(),
            map,
            host,
            selection: Selection::default(),
            watch: &(),
        }
    }

    /// The radiance of a frame of some emitters, and notes about it.
    fn with_inputs<R>(
        &self,
        what: &'static str,
        input: &mut Input,
        indices: &[usize],
        entry: &Entry,
        host: &Store<Host>,
        run: impl FnOnce(FrameInputs<'_>) -> Result<R, Failure>,
    ) -> Result<(R, Vec<String>), Failure> {
        let emitters = &input.picked(indices);
        let areas = &input.areas(indices);
        let asked = self.args.options.map();
        let has_maps = entry.uses_maps_of(&input.geometry);
        let map = if has_maps {
            maps::affordable(asked, &input.geometry, emitters, &mut input.notes)
        } else {
            asked
        };
        let rays = self.view.rays().len() * emitters.len();
        let bar = Bar {
            bar: progress::bar(what, rays as u64),
            told: Mutex::default(),
        };
        let inputs = FrameInputs {
            watch: &bar,
            ..self.inputs(input, (emitters, areas), map, host)
        };
        match entry.applies(&inputs) {
            Verdict::Impossible(why) => {
                let name = entry.about().name;
                return Err(Failure::new(format!("{name}: {why}")));
            }
            Verdict::Applies | Verdict::Pointless(_) => {}
        }
        let mut notes = entry.method().notes(&inputs);
        let result = run(inputs)?;
        bar.bar.finish_and_clear();
        notes.extend(
            bar.told
                .into_inner()
                .unwrap_or_else(PoisonError::into_inner),
        );
        Ok((result, notes))
    }
}

/// A progress bar that counts rays, and the messages meanwhile.
struct Bar {
    bar: ProgressBar,
    told: Mutex<Vec<String>>,
}

impl Watch for Bar {
    fn gathered(&self, rays: usize) {
        self.bar.inc(rays as u64);
    }

    fn told(&self, what: &str) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        told.push(what.into());
    }
}

fn run_on<B: MethodBackend + Download>(
    backend: &B,
    store: &Store<B::Memory>,
    inputs: FrameInputs<'_>,
    entry: &Entry,
    quality: u32,
) -> Result<Vec<[f32; 4]>, Failure> {
    let method = entry.on::<B>().ok_or_else(|| {
        let name = entry.about().name;
        Failure::new(format!("{name} has no shader; it runs with --backend cpu"))
    })?;
    let frame = Frame::new(backend, inputs, store)?;
    let mut radiance = backend.zeros::<[f32; 4]>(inputs.rays.len())?;
    method.add_radiance(&frame, quality, &mut radiance)?;
    Ok(backend.download(&radiance)?)
}

/// The light on points of surfaces.
fn light_on<B: MethodBackend + Download>(
    backend: &B,
    store: &Store<B::Memory>,
    inputs: FrameInputs<'_>,
    entry: &Entry,
    (quality, interpolate): (u32, bool),
    points: &[SurfacePoint],
) -> Result<Vec<[f32; 4]>, Failure> {
    let method = entry.on::<B>().and_then(|method| method.surfaces());
    let method = method.ok_or_else(|| {
        let name = entry.about().name;
        let why = format!("{name} has no shadows on surfaces; methods for area lights do");
        Failure::new(why).about("--surface-shadows")
    })?;
    let frame = Frame::new(backend, inputs, store)?;
    let points = backend.upload(points)?;
    let mut radiance = backend.zeros::<[f32; 4]>(points.len())?;
    method.add_surface_light(&frame, quality, &points, interpolate, &mut radiance)?;
    Ok(backend.download(&radiance)?)
}
