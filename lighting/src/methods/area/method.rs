//! Area lights as many virtual lights. Voxels are made anew in every frame, from shadow maps
//! that are kept.

use std::sync::{Mutex, PoisonError};

use gpu_backend::{BufferOf, Memory};

use super::groups::{Groups, MakeMaps, Maps, POINTS_PER_MAP, SIDE, UNIT, resolution};
use super::{
    BuildLightVolumes, GatherMany, LightManySurfaces, LightVolumes, ManyLights, ManyOnSurfaces,
    SurfaceLookup,
};
use crate::airlight::EquiAngular;
use crate::methods::evaluators::Gauss;
use crate::methods::reduced::{Reduced, Reduction, ShownAs};
use crate::methods::{
    About, Entry, Evaluators, Frame, FrameInputs, LightFrameSurfaces, Method, MethodError, Role,
    RunOn, Verdict, Work,
};
use crate::voxelized::{Detail, Eye};
use crate::{Emitter, Ray, SurfacePoint};

/// Levels of the pyramid that fills holes. With more levels false shadow grows faster than
/// false light shrinks.
const HOLE_LEVELS: u32 = 2;

/// A method that gathers the voxels of virtual lights in some detail.
#[derive(Debug, Clone, Copy)]
struct AreaLights {
    name: &'static str,
    title: &'static str,
    purpose: &'static str,
    paper: &'static str,
    role: Role,
    maps: Maps,
    detail: Detail,
    nodes: u32,
    /// Whether comparisons show it; if not, it is for those who ask for it by name.
    is_compared: bool,
}

/// Voxels that are kept from frame to frame; all groups use them in turn.
#[derive(Debug)]
struct Kept<M: Memory>(Mutex<Option<LightVolumes<M>>>);

/// The key of the voxels of so many lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct OfLights(usize);

impl Method for AreaLights {
    fn about(&self) -> About {
        About {
            name: self.name.into(),
            title: self.title,
            purpose: self.purpose,
            paper: self.paper,
            quality: UNIT,
            qualities: if self.is_compared {
                &[16, 64, 256, 1024]
            } else {
                &[]
            },
            quick: if self.is_compared { &[16, 64] } else { &[] },
            pictured: 256,
            usual: 256,
            role: self.role,
            // Its shadow maps have a size of their own.
            uses_shadow_map: false,
        }
    }

    fn applies(&self, inputs: &FrameInputs<'_>) -> Verdict {
        if inputs.areas.is_empty() {
            return Verdict::Impossible("no light has an area".into());
        }
        if !inputs.translucent.is_empty() {
            return Verdict::Pointless("it does not see hair and smoke".into());
        }
        if inputs.geometry.coatings().any_see_through() {
            return Verdict::Pointless("it does not see what is see-through".into());
        }
        Verdict::Applies
    }

    /// The lights of each group are shared.
    fn interleaves(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }

    fn notes(&self, inputs: &FrameInputs<'_>) -> Vec<String> {
        let mut notes = Vec::new();
        if !inputs.translucent.is_empty() {
            notes.push(format!("hair and smoke cast no shadow with {}", self.name));
        }
        if inputs.geometry.coatings().any_see_through() {
            notes.push(format!(
                "see-through surfaces neither shade the air nor dim what is behind them with {}",
                self.name
            ));
        }
        notes
    }

    fn work(&self, inputs: &FrameInputs<'_>, points: u32) -> Work {
        let spread: usize = inputs.areas.iter().map(|area| area.emitters.len()).sum();
        let others = inputs.emitters.len().saturating_sub(spread);
        let lights = others as f64 + inputs.areas.len() as f64 * f64::from(points);
        let side = f64::from(SIDE);
        // At most five faces of a cube can be lit.
        let (pictures, casters) = match self.maps {
            Maps::Exact => (5.0, 5.0 * inputs.geometry.triangles().len() as f64),
            Maps::Imperfect { .. } => (1.0, f64::from(POINTS_PER_MAP)),
        };
        let texels = pictures * lights * side.powi(2);
        Work {
            once: texels + lights * casters,
            // A lookup for each light ray, and a bit for each voxel, of which 32 are processed
            // at a time.
            per_frame: lights * (side.powi(2) + side.powi(3) / 32.0),
            per_ray: lights * (side / 32.0 + f64::from(self.nodes)),
            bytes: (4.0 * texels + lights * (side.powi(3) / 8.0 + 4.0 * side.powi(2))) as u64,
        }
    }
}

/// The distances between which the surfaces of a frame lie.
fn surface_depths(inputs: &FrameInputs<'_>) -> [f32; 2] {
    // Panes are in front of what rays end on, and in front of the sky.
    if inputs.geometry.coatings().any_see_through() {
        let (eye, bounds) = (inputs.camera.eye(), inputs.geometry.bounds());
        let far = (bounds.min() - eye).abs().max((bounds.max() - eye).abs());
        return [0.0, far.length()];
    }
    let lengths = inputs.rays.iter().map(Ray::length);
    let hits = lengths.filter(|length| length.is_finite());
    let [nearest, farthest] = hits.fold([f32::INFINITY, 0.0], |[near, far], length| {
        [length.min(near), length.max(far)]
    });
    [nearest.min(farthest), farthest]
}

impl AreaLights {
    /// Makes the voxels of one group after the other, and calls a step to read them.
    fn for_each_group<B>(
        &self,
        frame: &Frame<'_, B>,
        points: u32,
        eye: &Eye,
        mut step: impl FnMut(&[Emitter], &LightVolumes<B::Memory>) -> Result<(), MethodError>,
    ) -> Result<(), MethodError>
    where
        B: MakeMaps + BuildLightVolumes,
    {
        let all = Groups::of(frame, points, self.maps)?;
        let new = || {
            LightVolumes::new(frame.backend, resolution()?, all.lights())
                .map_err(MethodError::resource("voxels of many lights"))
        };
        let what = "voxels of many lights";
        let bytes = |kept: &Kept<B::Memory>| {
            let kept = kept.0.lock().unwrap_or_else(PoisonError::into_inner);
            kept.as_ref().map_or(0, LightVolumes::bytes)
        };
        let kept = frame.store.get(what, OfLights(all.lights()), bytes, || {
            Ok(Kept(Mutex::new(Some(new()?))))
        })?;
        let taken = kept.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut volumes = taken.map_or_else(new, Ok)?;
        for (emitters, maps) in &all.0 {
            frame.pass("voxels", || {
                volumes
                    .update(frame.backend, emitters, eye, maps)
                    .map_err(MethodError::resource(what))
            })?;
            step(emitters, &volumes)?;
        }
        // Commands run in order, so the memory can be used again before they have run.
        *kept.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(volumes);
        Ok(())
    }
}

impl<B> RunOn<B> for AreaLights
where
    B: MakeMaps + BuildLightVolumes + GatherMany<EquiAngular> + LightManySurfaces,
{
    fn prepare(&self, frame: &Frame<'_, B>, points: u32) -> Result<(), MethodError> {
        Gauss.kept(frame, self.nodes)?;
        Groups::of(frame, points, self.maps).map(|_| ())
    }

    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        points: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let airlight = Gauss.kept(frame, self.nodes)?;
        let FrameInputs {
            medium,
            camera,
            size,
            rays,
            ..
        } = frame.inputs;
        let eye = Eye::of_camera(camera, size, rays, medium);
        self.for_each_group(frame, points, &eye, |emitters, volumes| {
            let lights = ManyLights {
                rays: &frame.rays,
                emitters,
                medium: frame.inputs.medium,
                detail: self.detail,
                interleaving: frame.inputs.selection.interleaving,
            };
            frame.pass("gather", || {
                Ok((frame.backend).gather_many(&lights, volumes, &*airlight, radiance)?)
            })
        })?;
        let inputs = &frame.inputs;
        (inputs.watch).gathered(inputs.rays.len() * inputs.emitters.len());
        Ok(())
    }

    fn surfaces(&self) -> Option<&dyn LightFrameSurfaces<B>> {
        Some(self)
    }
}

impl<B> LightFrameSurfaces<B> for AreaLights
where
    B: MakeMaps + BuildLightVolumes + LightManySurfaces,
{
    /// With voxels like those for the airlight, from the nearest surface to the farthest.
    fn add_surface_light(
        &self,
        frame: &Frame<'_, B>,
        points: u32,
        surfaces: &BufferOf<B, SurfacePoint>,
        interpolate: bool,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let lookup = match interpolate {
            true => SurfaceLookup::Interpolated,
            false => SurfaceLookup::Nearest,
        };
        let inputs = &frame.inputs;
        let eye = Eye::of_surfaces(inputs.camera, inputs.size, surface_depths(inputs));
        self.for_each_group(frame, points, &eye, |emitters, volumes| {
            let lit = ManyOnSurfaces {
                points: surfaces,
                emitters,
                medium: frame.inputs.medium,
                lookup,
            };
            frame.pass("surfaces", || {
                Ok((frame.backend).light_many_surfaces(&lit, volumes, radiance)?)
            })
        })
    }
}

pub(in crate::methods) fn methods() -> Vec<Entry> {
    let bits = "Wyman and Dai, HPG 2013, for the bits";
    let imperfect = AreaLights {
        name: "area-imperfect",
        title: "imperfect voxelized shadow volumes",
        purpose: "soft shadows of area lights at a cost that triangles do not raise; \
            its error has a floor",
        paper: "Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013",
        role: Role::Paper,
        maps: Maps::Imperfect { levels: 0 },
        detail: Detail::Average,
        nodes: 8,
        is_compared: true,
    };
    let filled = AreaLights {
        name: "area-imperfect filled",
        title: "imperfect voxelized shadow volumes, holes filled",
        purpose: "the same with pull-push in the holes of its maps",
        role: Role::Variant,
        maps: Maps::Imperfect {
            levels: HOLE_LEVELS,
        },
        is_compared: false,
        ..imperfect
    };
    let runs = AreaLights {
        name: "area-runs",
        title: "area lights by many shadow volumes, lit runs",
        purpose: "the same bits by runs: soft shadows of area lights that converge",
        paper: bits,
        role: Role::Variant,
        maps: Maps::Exact,
        detail: Detail::Runs,
        nodes: 4,
        is_compared: true,
    };
    let reduced = |name, title, purpose| ShownAs {
        name,
        title,
        purpose,
        paper: "Wyman and Dai, Imperfect Voxelized Shadow Volumes, HPG 2013, section 3.4",
        qualities: &[64, 256],
        quick: &[64],
        pictured: 256,
    };
    vec![
        Entry::everywhere(imperfect),
        Entry::everywhere(AreaLights {
            name: "area-average",
            title: "area lights by many shadow volumes, averaged",
            purpose: "the same with exact shadow maps: the floor of the average alone",
            paper: bits,
            role: Role::Variant,
            maps: Maps::Exact,
            detail: Detail::Average,
            nodes: 8,
            is_compared: true,
        }),
        Entry::everywhere(AreaLights {
            name: "area-voxels",
            title: "area lights by many shadow volumes, per voxel",
            purpose: "the same bits with a weight each: no floor but that of the voxels",
            paper: "Wyman and Dai, HPG 2013: the weighted average that they mention",
            role: Role::Variant,
            maps: Maps::Exact,
            detail: Detail::Voxels,
            nodes: 1,
            is_compared: true,
        }),
        Entry::everywhere(runs),
        Entry::everywhere(
            Reduced::new(runs, Reduction::WINDOWS_OF_3).shown_as(reduced(
                "area-runs 3x3",
                "area lights by many shadow volumes, 3 x 3 interleaved",
                "many points: a ninth of them at each pixel, put together over its neighbours",
            )),
        ),
        Entry::everywhere(
            Reduced::new(runs, Reduction::WINDOWS_OF_3.and_a_quarter()).shown_as(reduced(
                "area-runs 3x3 quarter",
                "area lights by many shadow volumes, 3 x 3, quarter",
                "a ninth of the points at a quarter of the pixels: the least work for soft light",
            )),
        ),
        // The paper's own way, for those who ask for it.
        Entry::everywhere(filled),
    ]
}

#[cfg(test)]
#[path = "method_tests.rs"]
mod tests;
