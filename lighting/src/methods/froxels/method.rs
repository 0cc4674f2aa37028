//! Froxels of a frame, with the shadow map of every light.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use gpu_backend::{Backend, BufferOf, Memory};

use super::{
    FroxelAirlight, FroxelError, FroxelGrid, FroxelHistory, FroxelLight, FroxelSteps, FroxelVolume,
    InjectFroxels, Jitter, MOST_SLICES, lit_depths,
};
use crate::methods::{
    About, Entry, Frame, FrameInputs, Method, MethodError, Role, RunOn, Verdict, Work,
};
use crate::scene::{AreaEmitters, Emission};
use crate::shadow_map::{RenderShadowMap, ShadowMap};
use crate::{Emitter, Watch};

const UNIT: &str = "depth slices";

/// Frames of a still camera that make a picture with a history.
const FRAMES: u32 = 16;

/// The share of earlier frames.
const SHARE: f32 = 0.95;

/// Froxels of some kind.
#[derive(Debug, Clone, Copy)]
struct Froxels {
    name: &'static str,
    title: &'static str,
    purpose: &'static str,
    paper: &'static str,
    qualities: &'static [u32],
    quick: &'static [u32],
    /// Whether the medium dims lights on their way to the froxels.
    extinction: bool,
    /// Frames that are blended, each with a jitter of its own; one has none.
    frames: u32,
}

/// A light as froxels take it, and its shadow map.
type Tap<M> = (Emitter, Arc<ShadowMap<M>>);

/// The shadow map of an area light's centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfArea {
    /// The number of its first emitter.
    first: usize,
    resolution: u32,
}

/// The key of froxels with a number of slices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfSlices(u32);

/// The key of the earlier frames of a still camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfHistory {
    slices: u32,
    map: u32,
    extinction: bool,
}

/// Memory that all kinds with as many slices use in turn.
#[derive(Debug)]
struct Kept<M: Memory>(Mutex<Option<(FroxelVolume<M>, FroxelAirlight<M>)>>);

/// The frames before that of a still camera, and the froxels that they are of.
#[derive(Debug)]
struct Earlier<M: Memory>(Mutex<Option<(FroxelGrid, FroxelHistory<M>)>>);

/// The frames of a film so far, for each kind of froxels: what stays when lights move.
#[derive(Debug)]
struct Film<M: Memory>(Mutex<HashMap<OfHistory, FroxelHistory<M>>>);

fn froxel_error(error: FroxelError) -> MethodError {
    match error {
        FroxelError::Slices { slices } => MethodError::Quality {
            value: slices,
            unit: UNIT,
            expected: format!("1 to {MOST_SLICES}"),
        },
        other => MethodError::resource("froxels")(other),
    }
}

/// The froxels of a frame; `None` if there is no light in the air.
fn grid(inputs: &FrameInputs<'_>, slices: u32) -> Result<Option<FroxelGrid>, MethodError> {
    let FrameInputs {
        camera,
        size,
        rays,
        medium,
        emitters,
        ..
    } = *inputs;
    let depths = lit_depths(camera.eye(), rays, medium, emitters);
    let tile = FroxelGrid::usual_tile(size);
    match FroxelGrid::new(camera, size, tile, slices, depths) {
        Ok(grid) => Ok(Some(grid).filter(|_| !medium.scatters_nothing())),
        Err(FroxelError::Depths { .. }) => Ok(None),
        Err(error) => Err(froxel_error(error)),
    }
}

/// An area light as one point at its centre, with all of its power.
fn centre(inputs: &FrameInputs<'_>, area: &AreaEmitters) -> Result<Option<Emitter>, MethodError> {
    let own = inputs
        .emitters
        .get(area.emitters.clone())
        .unwrap_or_default();
    let Some(Emitter::Point(first)) = own.first() else {
        return Ok(None);
    };
    let intensity: Vec3 = own.iter().map(Emitter::intensity).sum();
    // As far in front of the light as the points that stand for it.
    let [u, v] = area.light.edges;
    let normal = u.cross(v).normalize_or_zero();
    let lift = (first.position() - area.light.corner).dot(normal) * normal;
    let position = area.light.corner + 0.5 * (u + v) + lift;
    let emission = match first.emission() {
        Emission::Cosine { normal } => Emission::Cosine { normal: *normal },
        _ => Emission::Isotropic,
    };
    let emitter = Emitter::point(position, intensity, first.range(), emission);
    Ok(Some(emitter.map_err(MethodError::resource(
        "the centre of an area light",
    ))?))
}

/// The lights as froxels take them: area lights by their centres. `watch` is asked
/// before each whether to go on.
fn taps<B: RenderShadowMap>(
    frame: &Frame<'_, B>,
    watch: &dyn Watch,
) -> Result<Vec<Tap<B::Memory>>, MethodError> {
    let inputs = &frame.inputs;
    let mut taps = Vec::new();
    let total = inputs.emitters.len();
    let mut light = 0;
    while light < total {
        if !watch.goes_on(light, total) {
            return Err(MethodError::Stopped { done: light, total });
        }
        let area = inputs.areas.iter().find(|a| a.emitters.start == light);
        let tap = match area {
            Some(area) => centre(inputs, area)?.map(|emitter| (area, emitter)),
            None => None,
        };
        let Some((area, emitter)) = tap else {
            taps.push((inputs.emitters[light].clone(), frame.shadow_map(light)?));
            light += 1;
            continue;
        };
        let resolution = inputs.map;
        let key = OfArea {
            first: light,
            resolution,
        };
        let map = frame.store.get("shadow map", key, ShadowMap::bytes, || {
            let casters = frame.casters()?;
            (frame.backend)
                .shadow_map(&casters, &emitter, resolution)
                .map_err(MethodError::resource("a shadow map"))
        })?;
        taps.push((emitter, map));
        light = area.emitters.end.max(light + 1);
    }
    Ok(taps)
}

impl Froxels {
    /// Injects all lights.
    fn inject<B>(
        &self,
        frame: &Frame<'_, B>,
        taps: &[Tap<B::Memory>],
        volume: &mut FroxelVolume<B::Memory>,
    ) -> Result<(), MethodError>
    where
        B: RenderShadowMap + InjectFroxels<Arc<ShadowMap<<B as Backend>::Memory>>>,
    {
        for (emitter, map) in taps {
            let light = FroxelLight {
                emitter,
                medium: frame.inputs.medium,
                extinction: self.extinction,
            };
            frame.backend.inject(&light, map, volume)?;
        }
        Ok(())
    }

    fn history<B: Backend>(&self, frame: &Frame<'_, B>, grid: FroxelGrid) -> OfHistory {
        let [_, _, slices] = grid.counts();
        OfHistory {
            slices,
            map: frame.inputs.map,
            extinction: self.extinction,
        }
    }

    /// Frames of a still camera, all but the last.
    fn still_frames<B>(
        &self,
        frame: &Frame<'_, B>,
        grid: FroxelGrid,
        taps: &[Tap<B::Memory>],
    ) -> Result<FroxelHistory<B::Memory>, MethodError>
    where
        B: RenderShadowMap + InjectFroxels<Arc<ShadowMap<<B as Backend>::Memory>>> + FroxelSteps,
    {
        let mut history = FroxelHistory::new(SHARE).map_err(froxel_error)?;
        for _ in 1..self.frames {
            let mut volume = history.begin(frame.backend, grid)?;
            self.inject(frame, taps, &mut volume)?;
            history.finish(frame.backend, volume)?;
        }
        Ok(history)
    }

    /// The next frame of a film, blended with those before it. The first one comes after
    /// frames of a still camera.
    fn add_film_frame<B>(
        &self,
        frame: &Frame<'_, B>,
        grid: FroxelGrid,
        taps: &[Tap<B::Memory>],
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError>
    where
        B: RenderShadowMap + InjectFroxels<Arc<ShadowMap<<B as Backend>::Memory>>> + FroxelSteps,
    {
        let backend = frame.backend;
        let bytes = |_: &Film<B::Memory>| 32 * grid.froxels() as u64;
        let film = frame.store.get("froxels of a film", 0_u32, bytes, || {
            Ok(Film::<B::Memory>(Mutex::default()))
        })?;
        let mut film = film.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = self.history(frame, grid);
        let before = film.remove(&key).map_or_else(
            || self.still_frames(frame, grid, taps),
            Ok::<_, MethodError>,
        )?;
        let history = film.entry(key).or_insert(before);
        let mut volume = history.begin(backend, grid)?;
        frame.pass("inject", || self.inject(frame, taps, &mut volume))?;
        let volume = frame.pass("blend", || Ok(history.finish(backend, volume)?))?;
        let mut airlight = FroxelAirlight::new(backend, grid)?;
        frame.pass("integrate", || {
            Ok(backend.integrate(frame.inputs.medium, volume, &mut airlight)?)
        })?;
        frame.pass("look up", || {
            Ok(backend.look_up(&airlight, &frame.rays, radiance)?)
        })
    }

    /// The frames before that of a still camera; from the store, if they are of the
    /// same view. Others are forgotten: there is never more than one.
    fn earlier<B>(
        &self,
        frame: &Frame<'_, B>,
        grid: FroxelGrid,
        taps: &[Tap<B::Memory>],
    ) -> Result<Arc<Earlier<B::Memory>>, MethodError>
    where
        B: RenderShadowMap + InjectFroxels<Arc<ShadowMap<<B as Backend>::Memory>>> + FroxelSteps,
    {
        let key = self.history(frame, grid);
        let made = || Ok::<_, MethodError>((grid, self.still_frames(frame, grid, taps)?));
        // Two volumes, the last and one to be used again.
        let bytes = |_: &Earlier<B::Memory>| 32 * grid.froxels() as u64;
        let kept = frame.store.get("earlier froxels", key, bytes, || {
            Ok(Earlier(Mutex::new(Some(made()?))))
        })?;
        let mut last = kept.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !matches!(&*last, Some((of, _)) if *of == grid) {
            *last = None;
            *last = Some(made()?);
        }
        drop(last);
        Ok(kept)
    }
}

impl Method for Froxels {
    fn about(&self) -> About {
        About {
            name: self.name.into(),
            title: self.title,
            purpose: self.purpose,
            paper: self.paper,
            quality: UNIT,
            qualities: self.qualities,
            quick: self.quick,
            pictured: 64,
            usual: 64,
            role: Role::Engine,
            uses_shadow_map: true,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        let eye = inputs.camera.eye();
        if inputs.rays.iter().any(|ray| ray.origin() != eye) {
            return Verdict::Impossible("rays do not start at the camera".into());
        }
        if !inputs.translucent.is_empty() {
            return Verdict::Pointless("it does not see hair and smoke".into());
        }
        if inputs.geometry.coatings().any_see_through() {
            return Verdict::Pointless("it does not see what is see-through".into());
        }
        Verdict::Applies
    }

    fn remembers_frames(&self) -> bool {
        self.frames > 1
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        if !inputs.areas.is_empty() {
            notes.push(format!(
                "an area light is one point at its centre, with all of its power and one shadow, with {}",
                self.name
            ));
        }
        if !inputs.translucent.is_empty() {
            notes.push(format!("hair and smoke cast no shadow with {}", self.name));
        }
        if inputs.geometry.coatings().any_see_through() {
            notes.push(format!(
                "see-through surfaces neither shade the air nor dim what is behind them with {}",
                self.name
            ));
        }
        if self.frames > 1 {
            notes.push(format!(
                "{} shows the last of {} frames of a still camera; its time is that of one frame, \
                 and the others count as preparation",
                self.name, self.frames
            ));
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, slices: u32) -> Work {
        let tile = FroxelGrid::usual_tile(inputs.size);
        let [columns, rows] = inputs.size.map(|side| f64::from(side.div_ceil(tile)));
        let froxels = columns * rows * f64::from(slices);
        let spread: usize = inputs.areas.iter().map(|area| area.emitters.len()).sum();
        let lights = inputs.emitters.len().saturating_sub(spread) + inputs.areas.len();
        let passes = if self.frames > 1 { 2.0 } else { 1.0 };
        let per_frame = froxels * (lights as f64 + passes);
        let volumes = if self.frames > 1 { 64.0 } else { 32.0 };
        let map = inputs.map_work();
        Work {
            once: map.once + f64::from(self.frames - 1) * per_frame,
            per_frame,
            per_ray: 8.0,
            bytes: map.bytes + (volumes * froxels) as u64,
        }
    }
}

impl<B> RunOn<B> for Froxels
where
    B: RenderShadowMap + InjectFroxels<Arc<ShadowMap<<B as Backend>::Memory>>> + FroxelSteps,
{
    fn prepare(&self, frame: &Frame<'_, B>, slices: u32) -> Result<(), MethodError> {
        let Some(grid) = grid(&frame.inputs, slices)? else {
            return Ok(());
        };
        let taps = taps(frame, frame.inputs.watch)?;
        if self.frames > 1 && frame.inputs.film_frame().is_none() {
            self.earlier(frame, grid, &taps)?;
        }
        Ok(())
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        slices: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let FrameInputs {
            medium,
            rays,
            emitters,
            watch,
            ..
        } = frame.inputs;
        let Some(grid) = grid(&frame.inputs, slices)? else {
            return Ok(());
        };
        // Frames are not stopped halfway.
        let taps = taps(frame, &())?;
        if self.frames > 1 && frame.inputs.film_frame().is_some() {
            self.add_film_frame(frame, grid, &taps, radiance)?;
            watch.gathered(rays.len() * emitters.len());
            return Ok(());
        }
        let earlier = match self.frames {
            ..=1 => None,
            _ => Some(self.earlier(frame, grid, &taps)?),
        };
        let backend = frame.backend;
        let jitter = match &earlier {
            Some(_) => Jitter::of_frame(self.frames - 1),
            None => Jitter::MIDDLE,
        };
        let kept = kept(frame, grid)?;
        let taken = kept.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let (mut volume, mut airlight) = match taken {
            Some((volume, airlight)) => (volume.again(backend, grid, jitter)?, airlight),
            None => (
                FroxelVolume::new(backend, grid, jitter)?,
                FroxelAirlight::new(backend, grid)?,
            ),
        };
        frame.pass("inject", || self.inject(frame, &taps, &mut volume))?;
        if let Some(earlier) = &earlier {
            let earlier = earlier.0.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, history)) = &*earlier {
                frame.pass("blend", || Ok(history.blend(backend, &mut volume)?))?;
            }
        }
        frame.pass("integrate", || {
            Ok(backend.integrate(medium, &mut volume, &mut airlight)?)
        })?;
        frame.pass("look up", || {
            Ok(backend.look_up(&airlight, &frame.rays, radiance)?)
        })?;
        watch.gathered(rays.len() * emitters.len());
        // Its memory is used again in the order of the commands.
        *kept.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((volume, airlight));
        Ok(())
    }
}

/// The memory for so many slices.
fn kept<B: Backend>(
    frame: &Frame<'_, B>,
    grid: FroxelGrid,
) -> Result<Arc<Kept<B::Memory>>, MethodError> {
    let [_, _, slices] = grid.counts();
    let bytes = |_: &Kept<B::Memory>| 32 * grid.froxels() as u64;
    frame.store.get("froxels", OfSlices(slices), bytes, || {
        let volume = FroxelVolume::new(frame.backend, grid, Jitter::MIDDLE)?;
        let airlight = FroxelAirlight::new(frame.backend, grid)?;
        Ok(Kept(Mutex::new(Some((volume, airlight)))))
    })
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let paper = "Wronski, SIGGRAPH 2014 course; Hillaire, SIGGRAPH 2015 course";
    vec![
        Entry::everywhere(Froxels {
            name: "froxels",
            title: "froxels",
            purpose: "a cost that pixels do not raise: lights in cells of the view, each with \
                one shadow; with the extinction between light and air that engines leave out",
            paper,
            qualities: &[32, 64, 128, 256],
            quick: &[32, 128],
            extinction: true,
            frames: 1,
        }),
        Entry::everywhere(Froxels {
            name: "froxels-engine",
            title: "froxels as engines have them",
            purpose: "what users of an engine see: no extinction between light and air",
            paper,
            qualities: &[64],
            quick: &[64],
            extinction: false,
            frames: 1,
        }),
        Entry::everywhere(Froxels {
            name: "froxels-history",
            title: "froxels with jitter and history",
            purpose: "froxels blended over frames, each sampled at another place: sixteen of a \
                still camera",
            paper,
            qualities: &[64],
            quick: &[64],
            extinction: true,
            frames: FRAMES,
        }),
    ]
}
